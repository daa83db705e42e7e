//! The nodes where a field is the largest of its neighbourhood.

use crate::error::KMaxError;
use crate::graph::KMaxGraph;

/// A node where the field has a local maximum.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Peak {
    /// Index of the node.
    pub node: usize,
    /// Value of the field there, in the field's unit.
    pub value: f32,
}

impl KMaxGraph {
    /// Writes the peaks of `field` (`[n_nodes]`, any unit) into `out`, largest first, equal
    /// values by ascending node. `out` is cleared before.
    ///
    /// A node is a peak if its value lies above `floor` and none of its neighbours' values is
    /// larger (section 3.3 of the paper). A plateau, that is a connected set of equal values, is
    /// one peak, at its node of lowest index, if no member has a larger neighbour.
    ///
    /// A value that is NaN or infinite is taken as missing: that node is never a peak and is not
    /// compared with. So a field without any value above `floor` has no peak, and neither has a
    /// field of NaN alone. Fails only on a field of the wrong length.
    pub fn peaks(&self, field: &[f32], floor: f32, out: &mut Vec<Peak>) -> Result<(), KMaxError> {
        out.clear();
        if field.len() != self.n_nodes() {
            return Err(KMaxError::FieldLength { expected: self.n_nodes(), got: field.len() });
        }
        for (node, &value) in field.iter().enumerate() {
            if value.is_finite() && value > floor && self.is_peak(field, node) {
                out.push(Peak { node, value });
            }
        }
        out.sort_unstable_by(|a, b| b.value.total_cmp(&a.value).then(a.node.cmp(&b.node)));
        Ok(())
    }

    fn is_peak(&self, field: &[f32], node: usize) -> bool {
        if self.has_larger_neighbour(field, node) {
            return false;
        }
        let tied = |j: usize| field[j] == field[node];
        let is_tied = self.neighbours(node).any(tied) || self.compared_with(node).any(tied);
        !is_tied || self.leads_its_plateau(field, node)
    }

    fn has_larger_neighbour(&self, field: &[f32], node: usize) -> bool {
        self.neighbours(node).any(|j| field[j].is_finite() && field[j] > field[node])
    }

    /// Whether `node` has the lowest index of its plateau and the plateau has no larger neighbour.
    fn leads_its_plateau(&self, field: &[f32], node: usize) -> bool {
        let mut seen = vec![false; field.len()];
        let mut pending = vec![node];
        seen[node] = true;
        while let Some(member) = pending.pop() {
            if member < node || self.has_larger_neighbour(field, member) {
                return false;
            }
            for j in self.neighbours(member).chain(self.compared_with(member)) {
                if field[j] == field[node] && !seen[j] {
                    seen[j] = true;
                    pending.push(j);
                }
            }
        }
        true
    }
}
