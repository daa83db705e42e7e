//! Placed primitives to one surface.

use std::ops::Range;

use gltf::json::Root;
use gltf::json::mesh::Primitive;
use nalgebra::Point3;

use super::primitive::{self, Decoded, Triangles};
use super::scene::{self, Instance};
use super::source::Source;
use super::{GltfFault, GltfInfo, GltfParams, GltfPart};
use crate::surface::triangles::{affine, linear_part};

/// The surface while it is put together.
pub(super) struct Assembly<'a> {
    params: &'a GltfParams,
    pub vertices: Vec<Point3<f64>>,
    pub triangles: Vec<[u32; 3]>,
    pub parts: Vec<GltfPart>,
    pub info: GltfInfo,
    /// Vertices decoded so far, used or not; with the next count, what bounds the work.
    n_decoded_vertices: usize,
    /// Primitives placed so far, skipped ones too.
    n_primitives: usize,
}

impl<'a> Assembly<'a> {
    pub fn new(params: &'a GltfParams) -> Self {
        Self {
            params,
            vertices: Vec::new(),
            triangles: Vec::new(),
            parts: Vec::new(),
            info: GltfInfo::default(),
            n_decoded_vertices: 0,
            n_primitives: 0,
        }
    }

    /// Adds every placed primitive of the scene; at least one triangle must result.
    pub fn add_scene(&mut self, source: &Source<'_>) -> Result<(), GltfFault> {
        let root = source.root;
        let instances = scene::instances(root)?;
        let mut is_used = vec![false; root.meshes.len()];
        for instance in &instances {
            is_used[instance.mesh] = true;
            self.info.n_skinned_nodes += usize::from(instance.is_skinned);
            for (i, primitive) in root.meshes[instance.mesh].primitives.iter().enumerate() {
                let place = format!("meshes[{}].primitives[{i}]", instance.mesh);
                self.add_primitive(source, instance, primitive, &place)?;
            }
        }
        self.info.n_mesh_nodes = instances.len();
        self.info.n_unused_meshes = is_used.iter().filter(|used| !**used).count();
        self.info.extensions_ignored = root.extensions_used.clone();
        if self.triangles.is_empty() {
            return Err(self.no_triangles(root.meshes.len()));
        }
        Ok(())
    }

    fn add_primitive(
        &mut self,
        source: &Source<'_>,
        instance: &Instance,
        primitive: &Primitive,
        place: &str,
    ) -> Result<(), GltfFault> {
        self.n_primitives += 1;
        within("placed primitives", "max_triangles", self.n_primitives, self.params.max_triangles)?;
        self.info.n_morph_targets += primitive.targets.as_ref().map_or(0, Vec::len);
        match primitive::decode(source, primitive, place)? {
            Decoded::Points => self.info.n_point_primitives += 1,
            Decoded::Lines => self.info.n_line_primitives += 1,
            Decoded::NoPositions => self.info.n_without_position += 1,
            Decoded::Triangles(decoded) => {
                self.check_limits(&decoded)?;
                let first = self.triangles.len();
                self.add_triangles(&decoded, instance);
                let triangles = first..self.triangles.len();
                self.parts.push(part(source.root, instance, primitive, triangles));
            }
        }
        Ok(())
    }

    fn check_limits(&mut self, decoded: &Triangles) -> Result<(), GltfFault> {
        self.n_decoded_vertices += decoded.positions.len();
        within("vertices", "max_vertices", self.n_decoded_vertices, self.params.max_vertices)?;
        let n_triangles = self.triangles.len() + decoded.corners.len();
        within("triangles", "max_triangles", n_triangles, self.params.max_triangles)
    }

    /// Appends a primitive's triangles in world coordinates and metres, with the vertices they use.
    fn add_triangles(&mut self, decoded: &Triangles, instance: &Instance) {
        let metres = self.params.unit.metres();
        let mut is_used = vec![false; decoded.positions.len()];
        decoded.corners.iter().flatten().for_each(|&v| is_used[v as usize] = true);
        let mut new_index = vec![0; decoded.positions.len()];
        for (v, position) in decoded.positions.iter().enumerate().filter(|(v, _)| is_used[*v]) {
            let local = Point3::from(position.map(f64::from));
            new_index[v] = self.vertices.len() as u32;
            self.vertices.push(affine(&instance.world_from_mesh, &local) * metres);
        }
        let is_mirrored = linear_part(&instance.world_from_mesh).determinant() < 0.0;
        for corners in &decoded.corners {
            let [a, b, c] = corners.map(|v| new_index[v as usize]);
            self.triangles.push(if is_mirrored { [a, c, b] } else { [a, b, c] });
        }
        self.info.n_unused_vertices += is_used.iter().filter(|used| !**used).count();
        self.info.n_leftover_indices += decoded.n_leftover;
        self.info.n_outside_bounds += decoded.n_outside_bounds;
    }

    fn no_triangles(&self, n_meshes: usize) -> GltfFault {
        GltfFault::NoTriangles {
            n_meshes,
            n_mesh_nodes: self.info.n_mesh_nodes,
            n_point_primitives: self.info.n_point_primitives,
            n_line_primitives: self.info.n_line_primitives,
            n_without_position: self.info.n_without_position,
        }
    }
}

fn within(
    what: &'static str,
    param: &'static str,
    found: usize,
    limit: usize,
) -> Result<(), GltfFault> {
    let (found, limit) = (found as u64, limit as u64);
    if found > limit { Err(GltfFault::Limit { what, param, found, limit }) } else { Ok(()) }
}

fn part(
    root: &Root,
    instance: &Instance,
    primitive: &Primitive,
    triangles: Range<usize>,
) -> GltfPart {
    let material = primitive.material.and_then(|m| root.materials.get(m.value()));
    GltfPart {
        node_name: instance.node.and_then(|n| root.nodes[n].name.clone()),
        mesh_name: root.meshes[instance.mesh].name.clone(),
        material_name: material.and_then(|m| m.name.clone()),
        triangles,
    }
}
