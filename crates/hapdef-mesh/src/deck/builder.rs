//! What a reader has gathered so far, by the deck's own numbers, and its turning into a deck.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{Point3, Vector3};

use super::{DeckFault, DeckMaterial, DeckReading, FaceTraction, SolidDeck};
use crate::{
    FeNodeId, LengthUnit, SolidFault, TET10_EDGES, TET10_FACES, Tet10Mesh, face_positions, tri6,
};

/// Directions held at a node: bit 0 for x, 1 for y, 2 for z.
pub(super) const HELD_ALL: u8 = 0b111;

/// A surface load by the deck's own numbers.
#[derive(Clone, Debug)]
pub(super) enum SurfaceLoad {
    /// A constant force per area, Pa, on the face with these corner nodes.
    Traction { line: usize, corners: [u32; 3], traction_pa: Vector3<f64> },
    /// A pressure, Pa, positive into the solid, on face `face` (as [`TET10_FACES`]) of an element.
    Pressure { element: u32, face: usize, pressure_pa: f64 },
}

/// A deck under construction.
#[derive(Debug, Default)]
pub(super) struct DeckBuilder {
    pub(super) reading: DeckReading,
    nodes: Vec<(u32, Point3<f64>)>,
    elements: Vec<(u32, [u32; 10])>,
    /// Places of elements that have corners only so far.
    linear: BTreeSet<usize>,
    /// Nodes of elements that are no solids, by their numbers; none where they are no faces.
    pub(super) faces: BTreeMap<u32, Vec<u32>>,
    node_places: BTreeMap<u32, usize>,
    element_places: BTreeMap<u32, usize>,
    pub(super) node_sets: BTreeMap<String, BTreeSet<u32>>,
    pub(super) material: Option<DeckMaterial>,
    held: BTreeMap<u32, u8>,
    forces: BTreeMap<u32, (usize, Vector3<f64>)>,
    pub(super) surface_loads: Vec<SurfaceLoad>,
    /// The unit of length that the deck states.
    pub(super) unit: Option<LengthUnit>,
    /// Kinds of elements that are no solids, and how many of each.
    skipped: BTreeMap<String, usize>,
    /// Commands that a scene has no use for.
    passed_over: BTreeSet<String>,
    pub(super) notes: Vec<String>,
}

impl DeckBuilder {
    pub(super) fn new(reading: DeckReading) -> Self {
        Self { reading, ..Self::default() }
    }

    /// Is the whole model wanted?
    pub(super) fn is_whole(&self) -> bool {
        self.reading == DeckReading::Whole
    }

    /// Passes over `command`, for which a scene has no use.
    pub(super) fn pass_over(&mut self, command: &str) {
        self.passed_over.insert(command.to_owned());
    }

    /// Passes over an element that is no solid; `nodes` of those that are faces.
    pub(super) fn skip_element(&mut self, kind: &str, label: u32, nodes: Vec<u32>) {
        match self.skipped.get_mut(kind) {
            Some(count) => *count += 1,
            None => drop(self.skipped.insert(kind.to_owned(), 1)),
        }
        self.faces.insert(label, nodes);
    }

    /// The nodes of a group of faces; `None` where something else is in the group.
    pub(super) fn face_nodes(&self, members: &BTreeSet<u32>) -> Option<BTreeSet<u32>> {
        let nodes = members.iter().map(|label| self.faces.get(label).filter(|n| !n.is_empty()));
        let nodes: Vec<&Vec<u32>> = nodes.collect::<Option<_>>()?;
        (!nodes.is_empty()).then(|| nodes.into_iter().flatten().copied().collect())
    }

    /// A four-node tetrahedron, whose mid-edge nodes are made at the end.
    pub(super) fn add_linear(
        &mut self,
        line: usize,
        label: u32,
        corners: [u32; 4],
    ) -> Result<(), DeckFault> {
        let [a, b, c, d] = corners;
        self.linear.insert(self.elements.len());
        self.add_element(line, label, [a, b, c, d, a, a, a, a, a, a])
    }

    pub(super) fn add_node(
        &mut self,
        line: usize,
        label: u32,
        position: Point3<f64>,
    ) -> Result<(), DeckFault> {
        match self.node_places.insert(label, self.nodes.len()) {
            Some(_) => Err(duplicate(line, "node", label)),
            None => {
                self.nodes.push((label, position));
                Ok(())
            }
        }
    }

    pub(super) fn add_element(
        &mut self,
        line: usize,
        label: u32,
        nodes: [u32; 10],
    ) -> Result<(), DeckFault> {
        for node in nodes {
            self.require_node(line, node)?;
        }
        match self.element_places.insert(label, self.elements.len()) {
            Some(_) => Err(duplicate(line, "element", label)),
            None => {
                self.elements.push((label, nodes));
                Ok(())
            }
        }
    }

    pub(super) fn require_node(&self, line: usize, label: u32) -> Result<(), DeckFault> {
        require(&self.node_places, line, "node", label)
    }

    pub(super) fn require_element(&self, line: usize, label: u32) -> Result<(), DeckFault> {
        require(&self.element_places, line, "element", label)
    }

    pub(super) fn node_labels(&self) -> impl Iterator<Item = u32> + '_ {
        self.nodes.iter().map(|(label, _)| *label)
    }

    /// Puts every node where `place` moves it.
    pub(super) fn move_nodes(&mut self, place: impl Fn(Point3<f64>) -> Point3<f64>) {
        self.nodes.iter_mut().for_each(|(_, position)| *position = place(*position));
    }

    pub(super) fn hold(&mut self, label: u32, directions: u8) {
        *self.held.entry(label).or_default() |= directions;
    }

    /// Sets one component of a node's force.
    pub(super) fn set_force(&mut self, line: usize, label: u32, axis: usize, force_n: f64) {
        let entry = self.forces.entry(label).or_insert((line, Vector3::zeros()));
        entry.1[axis] = force_n;
    }

    /// The deck, checked.
    pub(super) fn finish(mut self) -> Result<SolidDeck, DeckFault> {
        self.say_what_was_skipped()?;
        self.add_mid_edge_nodes();
        self.scale_to_si();
        let ids = DenseIds::new(&self);
        let mesh = self.mesh(&ids)?;
        let fixed_nodes = self.fixed_nodes(&ids)?;
        let (nodal_forces, face_tractions) = self.loads(&mesh, &ids)?;
        let node_sets = self
            .node_sets
            .iter()
            .map(|(name, labels)| (name.clone(), ids.known(labels.iter().copied())))
            .collect();
        Ok(SolidDeck {
            mesh,
            node_labels: ids.labels,
            element_labels: self.elements.iter().map(|(label, _)| *label).collect(),
            node_sets,
            material: self.material,
            fixed_nodes,
            nodal_forces,
            face_tractions,
            unused_node_labels: ids.unused,
            unit: self.unit,
            notes: self.notes,
        })
    }

    fn say_what_was_skipped(&mut self) -> Result<(), DeckFault> {
        let kinds = self.skipped.iter().map(|(kind, count)| format!("{count} {kind}"));
        let skipped = kinds.collect::<Vec<_>>().join(", ");
        if self.elements.is_empty() && !skipped.is_empty() {
            return Err(DeckFault::NoSolid { skipped });
        }
        if !skipped.is_empty() {
            self.notes.push(format!("elements that are no solids are passed over: {skipped}"));
        }
        if !self.passed_over.is_empty() {
            let commands: Vec<&str> = self.passed_over.iter().map(String::as_str).collect();
            self.notes.push(format!(
                "what a scene has of its own is passed over: {}",
                commands.join(", ")
            ));
        }
        Ok(())
    }

    /// A node halfway between each two corners of four-node tetrahedra, the neighbour's where that
    /// has one. It joins the sets and supports that both ends are in.
    fn add_mid_edge_nodes(&mut self) {
        if self.linear.is_empty() {
            return;
        }
        let mut mids: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for (i, (_, nodes)) in self.elements.iter().enumerate() {
            if !self.linear.contains(&i) {
                let edges = TET10_EDGES.iter().zip(&nodes[4..]);
                mids.extend(edges.map(|(&ends, mid)| (ends_of(nodes, ends), *mid)));
            }
        }
        let mut made: BTreeMap<u32, Vec<[u32; 2]>> = BTreeMap::new();
        let top = self.node_places.last_key_value().map_or(1, |(label, _)| *label);
        let labels = (top..=u32::MAX).chain(1..top);
        let mut free = labels.filter(|label| !self.node_places.contains_key(label));
        let mut new_nodes = Vec::new();
        for &i in &self.linear {
            let nodes = self.elements[i].1;
            for (j, &ends) in TET10_EDGES.iter().enumerate() {
                let [a, b] = ends_of(&nodes, ends);
                let mid = *mids.entry([a, b]).or_insert_with(|| {
                    let mid = free.next().unwrap_or(0);
                    let ends = [a, b].map(|label| self.nodes[self.node_places[&label]].1);
                    new_nodes.push((mid, nalgebra::center(&ends[0], &ends[1])));
                    made.entry(a).or_default().push([b, mid]);
                    mid
                });
                self.elements[i].1[4 + j] = mid;
            }
        }
        for labels in self.node_sets.values_mut() {
            let of = |a: &u32| made.get(a).into_iter().flatten();
            let inside = labels.iter().flat_map(of).filter(|[b, _]| labels.contains(b));
            let inside: Vec<u32> = inside.map(|[_, mid]| *mid).collect();
            labels.extend(inside);
        }
        for (a, b, mid) in made.iter().flat_map(|(a, m)| m.iter().map(move |[b, mid]| (a, b, mid)))
        {
            if let (Some(a), Some(b)) = (self.held.get(a), self.held.get(b)) {
                let both = a & b;
                self.held.insert(*mid, both);
            }
        }
        self.held.retain(|_, held| *held != 0);
        self.notes.push(format!(
            "{} four-node tetrahedra became ten-node ones by {} straight mid-edge nodes",
            self.linear.len(),
            new_nodes.len()
        ));
        for (label, position) in new_nodes {
            self.node_places.insert(label, self.nodes.len());
            self.nodes.push((label, position));
        }
    }

    /// Brings mm, MPa and t/mm³ to SI; newtons are newtons in both.
    fn scale_to_si(&mut self) {
        if self.unit != Some(LengthUnit::Millimetre) {
            return;
        }
        self.nodes.iter_mut().for_each(|(_, position)| *position *= 1e-3);
        self.material.iter_mut().for_each(DeckMaterial::from_millimetres);
        for load in &mut self.surface_loads {
            match load {
                SurfaceLoad::Traction { traction_pa, .. } => *traction_pa *= 1e6,
                SurfaceLoad::Pressure { pressure_pa, .. } => *pressure_pa *= 1e6,
            }
        }
    }

    fn mesh(&self, ids: &DenseIds) -> Result<Tet10Mesh, DeckFault> {
        let positions =
            ids.labels.iter().map(|label| self.nodes[self.node_places[label]].1).collect();
        let elements =
            self.elements.iter().map(|(_, nodes)| nodes.map(|node| ids.by_label[&node])).collect();
        Tet10Mesh::checked(positions, elements).map_err(|fault| {
            let element_label = match fault {
                SolidFault::CornerVolume { element, .. }
                | SolidFault::NodeTwice { element, .. } => Some(self.elements[element].0),
                _ => None,
            };
            DeckFault::Mesh { fault, element_label }
        })
    }

    fn fixed_nodes(&mut self, ids: &DenseIds) -> Result<Vec<FeNodeId>, DeckFault> {
        let mut partial = self.held.iter().filter(|(_, held)| **held != HELD_ALL);
        if self.reading == DeckReading::Mesh {
            let n_partial = partial.count();
            if n_partial > 0 {
                self.notes.push(format!(
                    "supports in some directions only, at {n_partial} nodes, are passed over"
                ));
                self.held.retain(|_, held| *held == HELD_ALL);
            }
        } else if let Some((&first_node, &held)) = partial.next() {
            return Err(DeckFault::PartialSupport {
                n_nodes: 1 + partial.count(),
                first_node,
                held: direction_names(held),
            });
        }
        Ok(ids.known(self.held.keys().copied()))
    }

    fn loads(&self, mesh: &Tet10Mesh, ids: &DenseIds) -> Result<Loads, DeckFault> {
        let mut forces: BTreeMap<FeNodeId, Vector3<f64>> = BTreeMap::new();
        for (&node, &(line, force)) in &self.forces {
            let id = ids.by_label.get(&node).ok_or(DeckFault::ForceOnUnusedNode { line, node })?;
            forces.insert(*id, force);
        }
        let mut tractions = Vec::new();
        let boundary = BoundaryFaces::new(mesh);
        for load in &self.surface_loads {
            match *load {
                SurfaceLoad::Traction { line, corners, traction_pa } => {
                    let found = ids.of(corners).and_then(|corners| boundary.find(corners));
                    let nodes = found.ok_or(DeckFault::NotABoundaryFace { line, corners })?;
                    tractions.push(FaceTraction { nodes, traction_pa });
                }
                SurfaceLoad::Pressure { element, face, pressure_pa } => {
                    add_pressure(
                        mesh,
                        self.element_places[&element],
                        face,
                        pressure_pa,
                        &mut forces,
                    );
                }
            }
        }
        forces.retain(|_, force| force.iter().any(|component| *component != 0.0));
        Ok((forces.into_iter().collect(), tractions))
    }
}

type Loads = (Vec<(FeNodeId, Vector3<f64>)>, Vec<FaceTraction>);

/// Adds the consistent nodal forces fᵢ = −p ∫ Nᵢ n dA of a pressure on a curved face.
fn add_pressure(
    mesh: &Tet10Mesh,
    element: usize,
    face: usize,
    pressure_pa: f64,
    forces: &mut BTreeMap<FeNodeId, Vector3<f64>>,
) {
    let nodes = TET10_FACES[face].map(|local| mesh.elements()[element][local]);
    let positions = face_positions(mesh, &crate::Tri6Face { nodes, element });
    for q in tri6::QUADRATURE {
        let shape = tri6::shape(q.xi, q.eta);
        let area = tri6::area_vector(&positions, q.xi, q.eta) * q.weight;
        for (node, n) in nodes.iter().zip(shape) {
            *forces.entry(*node).or_insert_with(Vector3::zeros) -= area * (pressure_pa * n);
        }
    }
}

/// The boundary's faces by their corners.
struct BoundaryFaces(BTreeMap<[FeNodeId; 3], [FeNodeId; 6]>);

impl BoundaryFaces {
    fn new(mesh: &Tet10Mesh) -> Self {
        let key = |nodes: [FeNodeId; 6]| sorted([nodes[0], nodes[1], nodes[2]]);
        Self(mesh.boundary().faces.iter().map(|face| (key(face.nodes), face.nodes)).collect())
    }

    fn find(&self, corners: [FeNodeId; 3]) -> Option<[FeNodeId; 6]> {
        self.0.get(&sorted(corners)).copied()
    }
}

/// The labels of two corners, the lower first.
fn ends_of(nodes: &[u32; 10], [a, b]: [usize; 2]) -> [u32; 2] {
    [nodes[a].min(nodes[b]), nodes[a].max(nodes[b])]
}

fn sorted(mut corners: [FeNodeId; 3]) -> [FeNodeId; 3] {
    corners.sort_unstable();
    corners
}

/// Deck numbers to ids: nodes that elements use, in deck order.
struct DenseIds {
    labels: Vec<u32>,
    unused: Vec<u32>,
    by_label: BTreeMap<u32, FeNodeId>,
}

impl DenseIds {
    fn new(builder: &DeckBuilder) -> Self {
        let used: BTreeSet<u32> = builder.elements.iter().flat_map(|(_, nodes)| *nodes).collect();
        let (labels, unused): (Vec<u32>, Vec<u32>) =
            builder.node_labels().partition(|label| used.contains(label));
        let by_label =
            labels.iter().enumerate().map(|(i, &label)| (label, FeNodeId::from_index(i))).collect();
        Self { labels, unused, by_label }
    }

    fn known(&self, labels: impl Iterator<Item = u32>) -> Vec<FeNodeId> {
        let mut ids: Vec<_> =
            labels.filter_map(|label| self.by_label.get(&label).copied()).collect();
        ids.sort_unstable();
        ids
    }

    fn of(&self, labels: [u32; 3]) -> Option<[FeNodeId; 3]> {
        let [a, b, c] = labels.map(|label| self.by_label.get(&label).copied());
        Some([a?, b?, c?])
    }
}

fn require(
    places: &BTreeMap<u32, usize>,
    line: usize,
    kind: &'static str,
    label: u32,
) -> Result<(), DeckFault> {
    match places.contains_key(&label) {
        true => Ok(()),
        false => Err(DeckFault::Undefined { line, kind, name: label.to_string() }),
    }
}

fn duplicate(line: usize, kind: &'static str, label: u32) -> DeckFault {
    DeckFault::Duplicate { line, kind, name: label.to_string() }
}

fn direction_names(held: u8) -> String {
    let names: Vec<_> =
        ["x", "y", "z"].into_iter().enumerate().filter(|(i, _)| held & (1 << i) != 0).collect();
    names.iter().map(|(_, name)| *name).collect::<Vec<_>>().join(", ")
}
