//! The bodies of a solid mesh: parts that share no node.

use crate::surface::topology::root;
use crate::{BoundingBox, Tet10Mesh};

/// A part of a solid mesh that shares no node with the rest.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidBody {
    /// Its elements, counted from 0, ascending.
    pub elements: Vec<usize>,
    /// The box around its nodes, m.
    pub bounding_box: BoundingBox,
}

impl Tet10Mesh {
    /// The bodies, in order of their first element.
    #[must_use]
    pub fn bodies(&self) -> Vec<SolidBody> {
        let mut parent: Vec<usize> = (0..self.nodes().len()).collect();
        for nodes in self.elements() {
            let first = root(&mut parent, nodes[0].index());
            for node in &nodes[1..] {
                let other = root(&mut parent, node.index());
                let first = root(&mut parent, first);
                parent[first.max(other)] = first.min(other);
            }
        }
        let mut number = vec![usize::MAX; parent.len()];
        let mut bodies: Vec<SolidBody> = Vec::new();
        for (element, nodes) in self.elements().iter().enumerate() {
            let first = root(&mut parent, nodes[0].index());
            let place = self.position(nodes[0]);
            if number[first] == usize::MAX {
                number[first] = bodies.len();
                let bounding_box = BoundingBox { min: place, max: place };
                bodies.push(SolidBody { elements: Vec::new(), bounding_box });
            }
            let body = &mut bodies[number[first]];
            body.elements.push(element);
            for node in nodes {
                let place = self.position(*node);
                body.bounding_box.min = body.bounding_box.min.inf(&place);
                body.bounding_box.max = body.bounding_box.max.sup(&place);
            }
        }
        bodies
    }
}
