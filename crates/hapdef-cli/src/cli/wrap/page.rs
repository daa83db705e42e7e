//! What was lost and bridged, on the limb.

use std::path::Path;

use anyhow::Result;
use hapdef_cli::shown;
use hapdef_mesh::{MeshError, SurfaceMesh, WrapPlaces, Wrapped};
use hapdef_report::{Block, LimbMap, LimbView, Page, text_table};
use nalgebra::{Point3, Vector3};

use super::{Given, lines};
use crate::cli::pages::fact;

/// Places of each kind that are drawn.
const MOST_DOTS: usize = 3000;

/// The size of a place's dot, as a part of the limb's length.
const DOT: f64 = 0.004;

/// Values of lost and of bridged places: the two ends of the colours.
const LOST: f64 = 1.0;
const BRIDGED: f64 = 0.0;

/// Writes the page.
pub(super) fn write(
    path: &Path,
    given: &Given<'_>,
    result: &Result<Wrapped, MeshError>,
) -> Result<()> {
    let (drawn, places, mut blocks) = match result {
        Ok(wrapped) => {
            let text = "The skin is faithful.".to_owned();
            let rows = lines(wrapped, given.wall_m);
            let rows = rows.into_iter().map(|(name, text)| [name.to_owned(), text]);
            let blocks = vec![
                Block::Verdict { text, warns: false },
                Block::Table(text_table(["", ""], rows)),
            ];
            (&wrapped.skin, Some(&wrapped.info.places), blocks)
        }
        Err(error) => {
            let places = match error {
                MeshError::Wrap(fault) => fault.places(),
                _ => None,
            };
            (given.surface, places, vec![Block::Verdict { text: error.to_string(), warns: true }])
        }
    };
    let note = "Yellow: what the skin leaves out. Purple: where the skin is and no surface. Grey: the skin, or \
                the surface itself where there is no skin.";
    blocks.push(Block::Note(note.to_owned()));
    blocks.push(Block::Limb(view(drawn, places.unwrap_or(&WrapPlaces::default()))));
    let name = given.file.file_name().unwrap_or_default();
    let page = Page {
        title: format!("A skin of {}", shown(name)),
        facts: vec![fact("wall", format!("{:.2} mm", 1e3 * given.wall_m))],
        blocks,
    };
    Ok(page.write(path)?)
}

/// The surface in grey with a dot at each place.
fn view(surface: &SurfaceMesh, places: &WrapPlaces) -> LimbView {
    let size_m = DOT * surface.bounding_box().longest_m();
    let mut view = LimbView::new(surface, Vec::new(), Vec::new());
    let mut values = vec![f64::NAN; view.points_m.len()];
    for (points, value) in [(&places.lost, LOST), (&places.bridged, BRIDGED)] {
        let step = points.len().div_ceil(MOST_DOTS).max(1);
        for point in points.iter().step_by(step) {
            add_dot(&mut view, point, size_m);
            values.resize(view.points_m.len(), value);
        }
    }
    let title = "lost (1) and bridged (0)".to_owned();
    let unit = "places".to_owned();
    view.maps = vec![LimbMap { title, unit, factor: 1.0, values, range: [BRIDGED, LOST] }];
    view
}

/// A tetrahedron around `point`.
fn add_dot(view: &mut LimbView, point: &Point3<f64>, size_m: f64) {
    let first = view.points_m.len() as u32;
    let corners = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]];
    view.points_m
        .extend(corners.map(|c| <[f64; 3]>::from((point + size_m * Vector3::from(c)).coords)));
    let faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];
    view.triangles.extend(faces.map(|face: [u32; 3]| face.map(|v| first + v)));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dots_are_closed_face_outward_and_have_their_colours() {
        let corners = [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]].map(Point3::from).to_vec();
        let surface = SurfaceMesh::new(corners, vec![[0, 1, 2]]).unwrap();
        let lost: Vec<Point3<f64>> = (0..2 * MOST_DOTS).map(|_| Point3::origin()).collect();
        let places =
            WrapPlaces { lost, bridged: vec![Point3::new(0.2, 0.0, 0.0)], ..WrapPlaces::default() };
        let view = view(&surface, &places);
        assert_eq!(view.triangles.len(), 1 + 4 * (MOST_DOTS + 1));
        let values = &view.maps[0].values;
        assert_eq!(values.len(), view.points_m.len());
        assert!(values[0].is_nan());
        assert_eq!((values[3], *values.last().unwrap()), (LOST, BRIDGED));
        let points = view.points_m[3..7].iter().copied().map(Point3::from).collect();
        let triangles = view.triangles[1..5].iter().map(|t| t.map(|v| v - 3)).collect();
        assert!(SurfaceMesh::new(points, triangles).unwrap().signed_volume_m3() > 0.0);
    }
}
