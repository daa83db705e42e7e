//! What assembly needs to know of a mesh's elements, and the ten-node tetrahedra's answers.

use hapdef_mesh::{FeNodeId, Tet10Mesh};
use nalgebra::Point3;

use crate::elements::parts::face_connected;
use crate::elements::tet10::stiffness;
use crate::{IsotropicMaterial, MaterialRegion, SimError};

/// A mesh of elements with a stiffness each.
///
/// A node moves by one motion (its translation) or by two (translation, rotation); a motion is a
/// three-vector. An element's unknowns are the motions of its nodes, node by node, translation
/// first.
pub(crate) trait Elements: Sync {
    /// Node positions `[n_fe_nodes]`, m.
    fn positions(&self) -> &[Point3<f64>];

    /// Number of elements.
    fn n_elements(&self) -> usize;

    /// The nodes of an element.
    fn nodes(&self, element: usize) -> &[FeNodeId];

    /// Whether nodes have a rotation beside their translation.
    fn has_rotations(&self) -> bool;

    /// For each element, the first element of the part it moves with as long as nothing deforms.
    fn rigid_parts(&self) -> Vec<usize>;

    /// Writes the stiffness of an element, row-major `[n, n]` with n three times its motions.
    fn stiffness(&self, element: usize, k: &mut [f64]) -> Result<(), SimError>;

    /// Motions of a node: 1 or 2.
    fn motions_per_node(&self) -> usize {
        1 + usize::from(self.has_rotations())
    }
}

/// Ten-node tetrahedra of one or several materials.
pub(crate) struct SolidElements<'a> {
    mesh: &'a Tet10Mesh,
    /// The materials in use; the first is that of all elements that no region names.
    materials: Vec<IsotropicMaterial>,
    /// Place of each element's material `[n_elements]`; empty where there is one material.
    material_of: Vec<u32>,
    /// Factor on Young's modulus `[n_elements]`.
    scale: Option<&'a [f64]>,
}

impl<'a> SolidElements<'a> {
    /// # Errors
    /// [`SimError::Length`], [`SimError::StiffnessScale`] and [`SimError::ElementOutOfRange`].
    pub(crate) fn new(
        mesh: &'a Tet10Mesh,
        material: &IsotropicMaterial,
        regions: &[MaterialRegion],
        scale: Option<&'a [f64]>,
    ) -> Result<Self, SimError> {
        let n_elements = mesh.elements().len();
        check_scale(scale, n_elements)?;
        let mut materials = vec![*material];
        let mut material_of = Vec::new();
        for region in regions {
            material_of.resize(n_elements, 0);
            for &element in &region.elements {
                let slot = material_of.get_mut(element);
                *slot.ok_or(SimError::ElementOutOfRange {
                    what: "a material region",
                    element,
                    n_elements,
                })? = materials.len() as u32;
            }
            materials.push(region.material);
        }
        Ok(Self { mesh, materials, material_of, scale })
    }

    fn material(&self, element: usize) -> &IsotropicMaterial {
        let which = self.material_of.get(element).map_or(0, |&m| m as usize);
        &self.materials[which]
    }
}

impl Elements for SolidElements<'_> {
    fn positions(&self) -> &[Point3<f64>] {
        self.mesh.nodes()
    }

    fn n_elements(&self) -> usize {
        self.mesh.elements().len()
    }

    fn nodes(&self, element: usize) -> &[FeNodeId] {
        &self.mesh.elements()[element]
    }

    fn has_rotations(&self) -> bool {
        false
    }

    fn rigid_parts(&self) -> Vec<usize> {
        face_connected(self.mesh.elements())
    }

    fn stiffness(&self, element: usize, k: &mut [f64]) -> Result<(), SimError> {
        let nodes = self.mesh.element_positions(element);
        let unscaled = stiffness(&nodes, self.material(element)).map_err(|point| {
            SimError::ElementInverted { element, parent: point.parent, det_j_m3: point.det_j_m3 }
        })?;
        let scale = self.scale.map_or(1.0, |s| s[element]);
        for (value, unscaled) in k.iter_mut().zip(unscaled.as_flattened()) {
            *value = scale * unscaled;
        }
        Ok(())
    }
}

fn check_scale(scale: Option<&[f64]>, n_elements: usize) -> Result<(), SimError> {
    let Some(scale) = scale else { return Ok(()) };
    if scale.len() != n_elements {
        return Err(SimError::Length {
            what: "element_stiffness_scale",
            expected: n_elements,
            found: scale.len(),
        });
    }
    match scale.iter().position(|s| !(s.is_finite() && *s > 0.0)) {
        Some(element) => Err(SimError::StiffnessScale { element, value: scale[element] }),
        None => Ok(()),
    }
}
