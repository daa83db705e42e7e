//! Displacements that another program printed for a deck.

use std::path::Path;

use nalgebra::Vector3;

use super::{DeckParams, source};
use crate::MeshError;

/// Displacements by rising node label, m.
pub type LabelledDisplacements = Vec<(u32, Vector3<f64>)>;

/// Rows `node vx vy vz` of the first displacement block of a CalculiX `.dat`, plain or with `.gz`, by
/// rising node, m; none where the file has no such row.
///
/// # Errors
/// [`MeshError::Io`] if the file can't be read, [`MeshError::Deck`] if it is too long.
pub fn read_displacements(path: &Path) -> Result<LabelledDisplacements, MeshError> {
    let bytes = source::read(path, DeckParams::default().max_bytes)?;
    Ok(displacement_rows(&source::text(&bytes)))
}

/// How many nodes of `found` the reference names, and the largest difference of their displacements
/// over the largest one found; none where it names no node.
#[must_use]
pub fn largest_difference(
    found: impl IntoIterator<Item = (u32, Vector3<f64>)>,
    reference: &[(u32, Vector3<f64>)],
) -> Option<(usize, f64)> {
    let (mut n_compared, mut worst, mut largest) = (0, 0.0_f64, 0.0_f64);
    for (label, u) in found {
        largest = largest.max(u.norm());
        if let Ok(place) = reference.binary_search_by_key(&label, |entry| entry.0) {
            worst = worst.max((u - reference[place].1).norm());
            n_compared += 1;
        }
    }
    (n_compared > 0).then_some((n_compared, worst / largest))
}

fn displacement_rows(text: &str) -> LabelledDisplacements {
    let row = |line: &str| {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [label, x, y, z] = words.as_slice() else {
            return None;
        };
        let number = |word: &str| word.parse::<f64>().ok();
        Some((label.parse().ok()?, Vector3::new(number(x)?, number(y)?, number(z)?)))
    };
    // a later block, such as forces, starts with a heading after rows have been read
    let lines = text.lines().filter(|line| !line.trim().is_empty()).map(row);
    let mut rows: LabelledDisplacements =
        lines.skip_while(Option::is_none).map_while(|row| row).collect();
    rows.sort_unstable_by_key(|entry| entry.0);
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_first_block_is_read() {
        let text = "\n S T E P 1\n\n displacements (vx,vy,vz) for set N and time 0.1E+01\n\n \
            2  1.0E-03 0.0E+00 2.0E-03\n 1  0.0E+00 0.0E+00 5.0E-01\n\n forces (fx,fy,fz)\n\n 1 9 9 9\n";
        let rows = displacement_rows(text);
        assert_eq!(rows.len(), 2);
        assert_eq!(rows[0], (1, Vector3::new(0.0, 0.0, 0.5)));
        assert_eq!(rows[1], (2, Vector3::new(1e-3, 0.0, 2e-3)));
    }
}
