//! The skin as the pictures need it.

use anyhow::Result;
use hapdef::Limb;
use hapdef_report::{
    Figure, LimbMarker, LimbPicture, Mark, RenderParams, Unrolled, UnrolledMarker, unroll,
};
use nalgebra::Vector3;

/// One panel: a title, a value per node, the ends of its colours.
pub(super) struct Panel<'a> {
    pub(super) title: &'a str,
    /// Quantity and unit; empty for no colour bar.
    pub(super) label: &'a str,
    pub(super) values: &'a [f64],
    pub(super) range: Option<[f64; 2]>,
    pub(super) marks: &'a [LimbMarker],
}

/// Nodes and triangles of the skin.
pub(super) struct Surface {
    pub(super) positions: Vec<[f64; 3]>,
    triangles: Vec<[u32; 3]>,
    up_axis: usize,
}

impl Surface {
    pub(super) fn of(limb: &Limb) -> Result<Self> {
        let mesh = limb.skin.surface(&limb.mesh)?;
        let axis = Vector3::from(limb.axis.direction);
        Ok(Self {
            positions: mesh.vertices().iter().map(|p| p.coords.into()).collect(),
            triangles: mesh.triangles().to_vec(),
            up_axis: axis.iamax(),
        })
    }

    /// (angle, rad; height, m) of positions.
    pub(super) fn unroll(&self, positions: &[[f64; 3]]) -> Result<Vec<[f64; 2]>> {
        Ok(unroll(positions, &self.positions, self.up_axis)?)
    }

    /// Pictures side by side, each seen from its azimuth, rad.
    pub(super) fn renders(
        &self,
        file: &str,
        caption: &str,
        panels: &[(Panel<'_>, f64)],
    ) -> Result<Figure> {
        let pictures = panels.iter().map(|(panel, azimuth_rad)| {
            let picture = LimbPicture {
                title: panel.title,
                value_label: panel.label,
                positions: &self.positions,
                triangles: &self.triangles,
                values: panel.values,
                markers: panel.marks,
            };
            let params = RenderParams {
                up_axis: self.up_axis,
                azimuth_rad: *azimuth_rad,
                width_px: 520,
                height_px: 600,
                range: panel.range,
                ..RenderParams::default()
            };
            (picture, params)
        });
        let pictures: Vec<_> = pictures.collect();
        Ok(Figure::limbs(file, caption, &pictures)?)
    }

    /// Unrolled surfaces side by side.
    pub(super) fn unrolled(
        &self,
        file: &str,
        caption: &str,
        panels: &[Panel<'_>],
    ) -> Result<Figure> {
        let points = self.unroll(&self.positions)?;
        let markers: Vec<Vec<UnrolledMarker>> =
            panels.iter().map(|panel| self.unrolled_marks(panel.marks)).collect::<Result<_>>()?;
        let figures = panels.iter().zip(&markers).map(|(panel, markers)| Unrolled {
            title: panel.title,
            value_label: panel.label,
            points: &points,
            values: panel.values,
            range: panel.range,
            markers,
            arrows: &[],
            arrow_names: &[],
        });
        let figures: Vec<_> = figures.collect();
        Ok(Figure::unrolled(file, caption, &figures)?)
    }

    fn unrolled_marks(&self, marks: &[LimbMarker]) -> Result<Vec<UnrolledMarker>> {
        let at: Vec<[f64; 3]> = marks.iter().map(|mark| mark.position).collect();
        let at = self.unroll(&at)?;
        let marker = |(at, mark): ([f64; 2], &LimbMarker)| UnrolledMarker { at, mark: mark.mark };
        Ok(at.into_iter().zip(marks).map(marker).collect())
    }
}

/// Marks of one kind.
pub(super) fn marks(positions: impl Iterator<Item = [f64; 3]>, mark: Mark) -> Vec<LimbMarker> {
    positions.map(|position| LimbMarker { position, mark }).collect()
}
