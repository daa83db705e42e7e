//! The limb as it is drawn.

use crate::error::ViewError;

/// The limb as it is drawn: a surface with gauges.
#[derive(Clone, Debug, Default)]
pub struct LimbPicture {
    /// Heading of the page.
    pub title: String,
    /// Surface nodes `[n][3]`, m.
    pub vertices_m: Vec<[f32; 3]>,
    /// Outward unit normals `[n][3]`.
    pub normals: Vec<[f32; 3]>,
    /// Nodes of the triangles `[m][3]`, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The gauges, in the order of a frame's readings.
    pub gauges: Vec<GaugeSite>,
    /// Direction that is up on the screen at first; `None`: the limb's longest extent.
    pub up: Option<[f64; 3]>,
    /// Direction from the limb to the first viewpoint; `None`: the page chooses.
    pub view_from: Option<[f64; 3]>,
}

/// Where a gauge is.
#[derive(Clone, Debug, PartialEq)]
pub struct GaugeSite {
    /// Short name.
    pub name: String,
    /// Its middle, m.
    pub position_m: [f64; 3],
    /// Unit vector along its grid.
    pub axis: [f64; 3],
}

impl LimbPicture {
    pub(crate) fn check(&self) -> Result<(), ViewError> {
        let n = self.vertices_m.len();
        let wrong =
            |what, expected: String, found| Err(ViewError::Picture { what, expected, found });
        if n == 0 || self.triangles.is_empty() {
            return wrong("triangles", "a surface".to_owned(), self.triangles.len());
        }
        if self.normals.len() != n {
            return wrong("normals", format!("{n}, one for each node"), self.normals.len());
        }
        let beyond = self.triangles.iter().flatten().find(|&&node| node as usize >= n);
        if let Some(&node) = beyond {
            return wrong("as a triangle's node", format!("a node below {n}"), node as usize);
        }
        if self.gauges.len() > usize::from(u16::MAX) {
            return wrong("gauges", "65,535 at most".to_owned(), self.gauges.len());
        }
        finite("node", self.vertices_m.iter().map(|v| v.iter().all(|c| c.is_finite())))?;
        finite("normal", self.normals.iter().map(|v| v.iter().all(|c| c.is_finite())))?;
        let site =
            |gauge: &GaugeSite| gauge.position_m.iter().chain(&gauge.axis).all(|c| c.is_finite());
        finite("gauge", self.gauges.iter().map(site))?;
        let directions = [self.up, self.view_from].into_iter().flatten();
        finite("direction", directions.map(|v| v.iter().all(|c| c.is_finite())))
    }
}

fn finite(what: &'static str, mut are_finite: impl Iterator<Item = bool>) -> Result<(), ViewError> {
    match are_finite.position(|is_finite| !is_finite) {
        None => Ok(()),
        Some(index) => Err(ViewError::PictureNumber { what, index }),
    }
}

#[cfg(test)]
mod tests {
    use super::LimbPicture;

    fn triangle() -> LimbPicture {
        LimbPicture {
            vertices_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..LimbPicture::default()
        }
    }

    #[track_caller]
    fn refused(change: impl FnOnce(&mut LimbPicture), why: &str) {
        let mut picture = triangle();
        assert!(picture.check().is_ok());
        change(&mut picture);
        let text = picture.check().unwrap_err().to_string();
        assert!(text.contains(why), "{text}");
    }

    #[test]
    fn faults_are_named() {
        refused(|p| p.triangles.clear(), "expected a surface");
        refused(|p| p.normals.truncate(2), "2 normals, expected 3");
        refused(|p| p.triangles[0][1] = 3, "a node below 3");
        refused(|p| p.vertices_m[2][0] = f32::NAN, "node that is not finite, number 2");
        refused(|p| p.up = Some([f64::INFINITY; 3]), "direction that is not finite");
    }
}
