//! Contacts drawn: an arrow as long as the force is strong, its newtons, and the ellipse that the
//! contact is in with 95 %.

use hapdef_contact::{Contact, Uncertainty};
use nalgebra::{Point3, Vector3};

use crate::frames::frame_of;
use crate::msg::{Color, Header, Marker, MarkerArray, Pose};
use crate::slots::Slot;
use crate::topics::RosParams;

const ARROW: i32 = 0;
const CYLINDER: i32 = 3;
const TEXT: i32 = 9;
const ADD: i32 = 0;
const DELETE: i32 = 2;

/// √ of the 95 % quantile of χ² with two degrees of freedom, √(−2 ln 0.05): axes of the ellipse in
/// standard deviations.
const ELLIPSE_SD: f64 = 2.447_746_830_680_816;
/// Thickness of the ellipse and least length of what is drawn: RViz refuses 0.
const THIN_M: f64 = 5e-4;
const SHAFT_M: f64 = 3e-3;
const HEAD_M: f64 = 6e-3;
const TEXT_M: f64 = 8e-3;

const ARROW_COLOR: Color = color(0.84, 0.15, 0.16, 1.0);
const TEXT_COLOR: Color = color(0.95, 0.95, 0.95, 1.0);
const ELLIPSE_COLOR: Color = color(0.12, 0.47, 0.71, 0.5);

/// Markers of all slots; those of a contact that is gone are taken away.
pub(crate) fn markers(params: &RosParams, header: &Header, placed: &[Slot<'_>]) -> MarkerArray {
    let mut markers = Vec::new();
    for (slot, held) in placed.iter().enumerate() {
        let drawing = Drawing { params, header, id: i32::try_from(slot).unwrap_or(i32::MAX) };
        match held {
            Slot::Held(contact) => drawing.contact(contact, &mut markers),
            Slot::Left => {
                markers.extend(["force", "newtons", "ellipse"].map(|ns| drawing.gone(ns)));
            }
            Slot::Free => {}
        }
    }
    MarkerArray { markers }
}

struct Drawing<'a> {
    params: &'a RosParams,
    header: &'a Header,
    id: i32,
}

impl Drawing<'_> {
    fn contact(&self, contact: &Contact, into: &mut Vec<Marker>) {
        let length_m = (contact.force_n * self.params.arrow_m_per_n).max(THIN_M);
        let normal = contact.normal().unwrap_or_default();
        let tail = contact.position_m + normal * length_m;
        into.push(Marker {
            points: vec![tail.coords.into(), contact.position_m.coords.into()],
            scale: [SHAFT_M, HEAD_M, 0.0].into(),
            color: ARROW_COLOR,
            ..self.marker("force", ARROW)
        });
        into.push(Marker {
            text: format!("{:.2} N", contact.force_n),
            pose: at(tail + normal * TEXT_M),
            scale: [0.0, 0.0, TEXT_M].into(),
            color: TEXT_COLOR,
            ..self.marker("newtons", TEXT)
        });
        into.push(match &contact.uncertainty {
            Some(uncertainty) => self.ellipse(contact.position_m, normal, uncertainty),
            None => self.gone("ellipse"),
        });
    }

    fn ellipse(
        &self,
        centre: Point3<f64>,
        normal: Vector3<f64>,
        uncertainty: &Uncertainty,
    ) -> Marker {
        let (sds_m, angle) = uncertainty.principal_sds_m();
        let [t1, t2] = uncertainty.tangents;
        let axes = frame_of(normal, Some(t1 * angle.cos() + t2 * angle.sin()));
        let [large, small] = sds_m.map(|sd_m| (2.0 * ELLIPSE_SD * sd_m).max(THIN_M));
        Marker {
            pose: Pose { orientation: axes.rotation(), ..at(centre) },
            scale: [large, small, THIN_M].into(),
            color: ELLIPSE_COLOR,
            ..self.marker("ellipse", CYLINDER)
        }
    }

    fn gone(&self, ns: &str) -> Marker {
        Marker { action: DELETE, ..self.marker(ns, ARROW) }
    }

    fn marker(&self, ns: &str, kind: i32) -> Marker {
        Marker {
            header: self.header.clone(),
            ns: ns.to_owned(),
            id: self.id,
            kind,
            action: ADD,
            frame_locked: true,
            ..Marker::default()
        }
    }
}

fn at(position_m: Point3<f64>) -> Pose {
    Pose { position: position_m.coords.into(), ..Pose::default() }
}

const fn color(r: f32, g: f32, b: f32, a: f32) -> Color {
    Color { r, g, b, a }
}

#[cfg(test)]
mod tests {
    use nalgebra::Matrix3;

    use super::*;

    #[test]
    fn the_quantile_is_that_of_two_degrees_of_freedom() {
        let closed_form = (-2.0 * 0.05f64.ln()).sqrt();
        assert!((ELLIPSE_SD - closed_form).abs() < 1e-14, "{closed_form}");
    }

    #[test]
    fn an_arrow_ends_at_the_contact_and_goes_when_it_goes() {
        let contact = Contact {
            id: Some(3),
            direction: Some(-Vector3::x()),
            uncertainty: Some(Uncertainty {
                tangents: [Vector3::y(), Vector3::z()],
                covariance: Matrix3::from_diagonal(&Vector3::new(1e-6, 4e-6, 0.01)),
            }),
            ..Contact::new(Point3::new(0.1, 0.0, 0.0), 2.0)
        };
        let (params, header) = (RosParams::default(), Header::default());
        let drawn = markers(&params, &header, &[Slot::Held(&contact), Slot::Free]).markers;
        assert_eq!(drawn[0].points[1], [0.1, 0.0, 0.0].into());
        assert!((drawn[0].points[0].x - 0.12).abs() < 1e-15);
        assert_eq!(drawn[1].text, "2.00 N");
        let diameter = 2.0 * ELLIPSE_SD * 2e-3;
        assert!((drawn[2].scale.x - diameter).abs() < 1e-15);
        assert!((drawn[2].scale.y - 0.5 * diameter).abs() < 1e-15);
        let gone = markers(&params, &header, &[Slot::Left]).markers;
        assert_eq!(gone.len(), 3);
        assert!(gone.iter().all(|marker| marker.action == DELETE));
    }
}
