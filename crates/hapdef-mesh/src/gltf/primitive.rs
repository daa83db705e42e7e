//! One primitive to triangles: modes, indices and what else its accessors must agree on.

use gltf::json::accessor::Accessor;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::accessor::view_of;
use super::source::{Source, found};

/// A coordinate may differ from the accessor's declared bounds by this part of the largest bound:
/// exporters round the numbers they print.
const BOUNDS_ROUNDING: f32 = 1e-4;

/// What a primitive holds.
pub(super) enum Decoded {
    /// A surface in the mesh's own frame.
    Triangles(Triangles),
    /// Points, which have no surface.
    Points,
    /// Lines, which have no surface.
    Lines,
    /// No `POSITION` attribute, which the format allows for extensions.
    NoPositions,
}

/// The triangles of one primitive.
pub(super) struct Triangles {
    pub positions: Vec<[f32; 3]>,
    pub corners: Vec<[u32; 3]>,
    /// Indices left after the last whole triangle.
    pub n_leftover: usize,
    /// Vertices outside the bounds the accessor declares.
    pub n_outside_bounds: usize,
}

/// Reads `primitive`, named `place` in errors.
pub(super) fn decode(
    source: &Source<'_>,
    primitive: &Primitive,
    place: &str,
) -> Result<Decoded, GltfFault> {
    let mode = match primitive.mode {
        Checked::Valid(mode) => mode,
        Checked::Invalid => {
            return Err(GltfFault::Mode { place: place.to_owned() });
        }
    };
    if let Some(material) = primitive.material {
        let place = format!("{place}.material");
        found(&source.root.materials, material.value(), &place, "material")?;
    }
    let Some(position) = primitive.attributes.get(&Checked::Valid(Semantic::Positions)) else {
        return Ok(Decoded::NoPositions);
    };
    match mode {
        Mode::Points => return Ok(Decoded::Points),
        Mode::Lines | Mode::LineLoop | Mode::LineStrip => return Ok(Decoded::Lines),
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => {}
    }
    check_attributes(source, primitive, position.value(), place)?;
    triangles(source, primitive, position.value(), mode, place).map(Decoded::Triangles)
}

fn triangles(
    source: &Source<'_>,
    primitive: &Primitive,
    position: usize,
    mode: Mode,
    place: &str,
) -> Result<Triangles, GltfFault> {
    let position_place = format!("{place}.attributes.POSITION");
    let accessor = source.accessor(position, &position_place)?;
    let positions = source.positions(position, &position_place)?;
    check_finite(&positions, place)?;
    let indices = match primitive.indices {
        Some(index) => source.indices(index.value(), &format!("{place}.indices"))?,
        None => (0..positions.len() as u32).collect(),
    };
    if let Some(at) = indices.iter().position(|&i| i as usize >= positions.len()) {
        let (index, n_vertices) = (indices[at], positions.len());
        return Err(GltfFault::VertexIndex {
            place: place.into(),
            position: at,
            index,
            n_vertices,
        });
    }
    let (corners, n_leftover) = assemble(&indices, mode);
    let n_outside_bounds = count_outside_bounds(&positions, accessor);
    Ok(Triangles { positions, corners, n_leftover, n_outside_bounds })
}

/// Triangles from indices: specification, section 3.7.2.1, "Topology types". Strips keep their
/// zero-area joints, which repeat a corner.
fn assemble(indices: &[u32], mode: Mode) -> (Vec<[u32; 3]>, usize) {
    if mode == Mode::Triangles {
        let whole = indices.chunks_exact(3);
        let n_leftover = whole.remainder().len();
        return (whole.map(|c| [c[0], c[1], c[2]]).collect(), n_leftover);
    }
    if indices.len() < 3 {
        return (Vec::new(), indices.len());
    }
    let corner = |i: usize| match mode {
        Mode::TriangleFan => [indices[i + 1], indices[i + 2], indices[0]],
        _ => [indices[i], indices[i + 1 + i % 2], indices[i + 2 - i % 2]],
    };
    ((0..indices.len() - 2).map(corner).collect(), 0)
}

/// Every attribute has one value per vertex, and no view serves as vertices and as indices.
fn check_attributes(
    source: &Source<'_>,
    primitive: &Primitive,
    position: usize,
    place: &str,
) -> Result<(), GltfFault> {
    let positions = source.accessor(position, &format!("{place}.attributes.POSITION"))?;
    let expected = positions.count.0;
    for (semantic, index) in &primitive.attributes {
        let attribute = semantic.to_string();
        let accessor =
            source.accessor(index.value(), &format!("{place}.attributes.{attribute}"))?;
        let found = accessor.count.0;
        if found != expected {
            let place = place.to_owned();
            return Err(GltfFault::AttributeCount { place, attribute, found, expected });
        }
    }
    let Some(index) = primitive.indices else {
        return Ok(());
    };
    let place = format!("{place}.indices");
    let indices = source.accessor(index.value(), &place)?;
    match (view_of(indices), view_of(positions)) {
        (Some(view), Some(other)) if view == other => {
            let why = "it also holds the positions";
            Err(GltfFault::ViewUse { view, place, why })
        }
        _ => Ok(()),
    }
}

fn check_finite(positions: &[[f32; 3]], place: &str) -> Result<(), GltfFault> {
    match positions.iter().position(|p| !p.iter().all(|x| x.is_finite())) {
        None => Ok(()),
        Some(vertex) => {
            let position = positions[vertex];
            Err(GltfFault::PositionNotFinite { place: place.to_owned(), vertex, position })
        }
    }
}

fn count_outside_bounds(positions: &[[f32; 3]], accessor: &Accessor) -> usize {
    let (Some(min), Some(max)) = (bound(&accessor.min), bound(&accessor.max)) else {
        return 0;
    };
    let largest = min.iter().chain(&max).fold(0.0, |a: f32, b| a.max(b.abs()));
    let slack = BOUNDS_ROUNDING * largest;
    let outside = |p: &[f32; 3]| (0..3).any(|i| p[i] < min[i] - slack || p[i] > max[i] + slack);
    positions.iter().filter(|p| outside(p)).count()
}

fn bound(value: &Option<gltf::json::Value>) -> Option<[f32; 3]> {
    let items = value.as_ref()?.as_array().filter(|items| items.len() == 3)?;
    let mut bound = [0.0; 3];
    for (slot, item) in bound.iter_mut().zip(items) {
        *slot = item.as_f64()? as f32;
    }
    Some(bound)
}
