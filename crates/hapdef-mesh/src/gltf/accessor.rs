//! Accessors to positions and indices, sparse values included.

use gltf::json::Index;
use gltf::json::accessor::{Accessor, ComponentType, Type, sparse::Sparse};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::source::{Source, found};
use super::view::{Span, Use};

impl Source<'_> {
    /// The accessor a property refers to.
    pub fn accessor(&self, index: usize, place: &str) -> Result<&Accessor, GltfFault> {
        found(&self.root.accessors, index, place, "accessor")
    }

    /// The positions in accessor `index`, as written in the file.
    pub fn positions(&self, index: usize, place: &str) -> Result<Vec<[f32; 3]>, GltfFault> {
        let accessor = self.accessor(index, place)?;
        if format_of(accessor) != (Some(Type::Vec3), Some(ComponentType::F32)) {
            return Err(wrong_format(index, accessor, place, "VEC3 of FLOAT"));
        }
        let limit = ("vertices", "max_vertices", self.params.max_vertices as u64);
        let bytes = self.tight_bytes(index, accessor, Use::Vertices, place, limit)?;
        let number = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
        Ok(bytes
            .chunks_exact(12)
            .map(|b| [number(&b[0..4]), number(&b[4..8]), number(&b[8..12])])
            .collect())
    }

    /// The vertex indices in accessor `index`.
    pub fn indices(&self, index: usize, place: &str) -> Result<Vec<u32>, GltfFault> {
        let accessor = self.accessor(index, place)?;
        let component = match format_of(accessor) {
            (Some(Type::Scalar), Some(c)) if is_index_type(c) => c,
            _ => {
                return Err(wrong_format(index, accessor, place, "SCALAR of unsigned integers"));
            }
        };
        let most = (self.params.max_triangles as u64).saturating_mul(3);
        let limit = ("vertex indices", "max_triangles", most);
        let bytes = self.tight_bytes(index, accessor, Use::Indices, place, limit)?;
        Ok(integers(&bytes, component))
    }

    /// All elements of an accessor without gaps: its view's, then the sparse replacements.
    fn tight_bytes(
        &self,
        index: usize,
        accessor: &Accessor,
        used_for: Use,
        place: &str,
        (what, param, limit): (&'static str, &'static str, u64),
    ) -> Result<Vec<u8>, GltfFault> {
        let found = accessor.count.0;
        if found == 0 {
            return Err(GltfFault::AccessorEmpty { accessor: index });
        }
        if found > limit {
            return Err(GltfFault::Limit { what, param, found, limit });
        }
        let (n, component_bytes) = (found as usize, component_bytes(accessor));
        let element_bytes = component_bytes * components(accessor);
        let mut bytes = match accessor.buffer_view {
            Some(view) => {
                let offset = accessor.byte_offset.unwrap_or_default().0;
                let view = view.value();
                let span = Span { view, offset, n, element_bytes, component_bytes, used_for };
                self.gathered(&span, &format!("accessors[{index}] ({place})"))?
            }
            None if accessor.sparse.is_some() => vec![0; n * element_bytes],
            None => {
                return Err(GltfFault::AccessorNoData { accessor: index, place: place.to_owned() });
            }
        };
        if let Some(sparse) = &accessor.sparse {
            self.replace_sparse(index, sparse, element_bytes, component_bytes, &mut bytes)?;
        }
        Ok(bytes)
    }

    /// Overwrites the elements a sparse accessor names; their indices must increase.
    fn replace_sparse(
        &self,
        accessor: usize,
        sparse: &Sparse,
        element_bytes: usize,
        component_bytes: usize,
        bytes: &mut [u8],
    ) -> Result<(), GltfFault> {
        let count = bytes.len() / element_bytes;
        if sparse.count.0 == 0 || sparse.count.0 > count as u64 {
            return Err(GltfFault::SparseCount { accessor, found: sparse.count.0, count });
        }
        let n = sparse.count.0 as usize;
        let positions = self.sparse_indices(accessor, sparse, n)?;
        let place = format!("accessors[{accessor}].sparse.values");
        let view = sparse.values.buffer_view.value();
        let offset = sparse.values.byte_offset.0;
        let used_for = Use::SparsePart;
        let span = Span { view, offset, n, element_bytes, component_bytes, used_for };
        let values = self.gathered(&span, &place)?;
        let mut smallest = 0;
        for (position, &found) in positions.iter().enumerate() {
            if (found as usize) < smallest || found as usize >= count {
                return Err(GltfFault::SparseIndex { accessor, position, found, count });
            }
            smallest = found as usize + 1;
            let [to, from] = [found as usize, position].map(|i| i * element_bytes);
            bytes[to..to + element_bytes].copy_from_slice(&values[from..from + element_bytes]);
        }
        Ok(())
    }

    fn sparse_indices(
        &self,
        accessor: usize,
        sparse: &Sparse,
        n: usize,
    ) -> Result<Vec<u32>, GltfFault> {
        let place = format!("accessors[{accessor}].sparse.indices");
        let Checked::Valid(component) = sparse.indices.component_type else {
            let expected = "unsigned integers";
            let found = "an unknown componentType".to_owned();
            return Err(GltfFault::AccessorFormat { accessor, place, expected, found });
        };
        let component_bytes = component.0.size();
        let span = Span {
            view: sparse.indices.buffer_view.value(),
            offset: sparse.indices.byte_offset.0,
            n,
            element_bytes: component_bytes,
            component_bytes,
            used_for: Use::SparsePart,
        };
        Ok(integers(&self.gathered(&span, &place)?, component.0))
    }
}

/// The view an accessor reads from, if it has one.
pub(super) fn view_of(accessor: &Accessor) -> Option<usize> {
    accessor.buffer_view.as_ref().map(Index::value)
}

fn integers(bytes: &[u8], component: ComponentType) -> Vec<u32> {
    match component {
        ComponentType::U8 => bytes.iter().map(|&b| u32::from(b)).collect(),
        ComponentType::U16 => {
            bytes.chunks_exact(2).map(|b| u32::from(u16::from_le_bytes([b[0], b[1]]))).collect()
        }
        _ => bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect(),
    }
}

fn is_index_type(component: ComponentType) -> bool {
    matches!(component, ComponentType::U8 | ComponentType::U16 | ComponentType::U32)
}

fn format_of(accessor: &Accessor) -> (Option<Type>, Option<ComponentType>) {
    let kind = match accessor.type_ {
        Checked::Valid(kind) => Some(kind),
        Checked::Invalid => None,
    };
    let component = match accessor.component_type {
        Checked::Valid(component) => Some(component.0),
        Checked::Invalid => None,
    };
    (kind, component)
}

fn component_bytes(accessor: &Accessor) -> usize {
    format_of(accessor).1.map_or(1, |component| component.size())
}

fn components(accessor: &Accessor) -> usize {
    format_of(accessor).0.map_or(1, |kind| kind.multiplicity())
}

fn wrong_format(
    index: usize,
    accessor: &Accessor,
    place: &str,
    expected: &'static str,
) -> GltfFault {
    let (kind, component) = format_of(accessor);
    let kind = kind.map_or("an unknown type".to_owned(), |k| format!("{k:?}"));
    let component = component.map_or("an unknown componentType".to_owned(), |c| format!("{c:?}"));
    let found = format!("{kind} of {component}");
    GltfFault::AccessorFormat { accessor: index, place: place.to_owned(), expected, found }
}
