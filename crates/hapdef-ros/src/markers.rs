//! Contacts drawn: an arrow as long as the force is strong, its newtons, and the ellipse that the
//! contact is in with 95 %.

use crate::frames::{frame_of, plus, scaled};
use crate::input::{Contact, Uncertainty};
use crate::msg::{Color, Header, Marker, MarkerArray, Pose, Vector3};
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
        let tail = plus(contact.position_m, scaled(contact.normal, length_m));
        into.push(Marker {
            points: vec![tail.into(), contact.position_m.into()],
            scale: [SHAFT_M, HEAD_M, 0.0].into(),
            color: ARROW_COLOR,
            ..self.marker("force", ARROW)
        });
        into.push(Marker {
            text: format!("{:.2} N", contact.force_n),
            pose: at(plus(tail, scaled(contact.normal, TEXT_M))),
            scale: [0.0, 0.0, TEXT_M].into(),
            color: TEXT_COLOR,
            ..self.marker("newtons", TEXT)
        });
        into.push(match &contact.uncertainty {
            Some(uncertainty) => self.ellipse(contact, uncertainty),
            None => self.gone("ellipse"),
        });
    }

    fn ellipse(&self, contact: &Contact, uncertainty: &Uncertainty) -> Marker {
        let [a, b, _, _, d, ..] = uncertainty.covariance;
        let (variances, angle) = principal(a, b, d);
        let [t1, t2] = uncertainty.tangents;
        let major = plus(scaled(t1, angle.cos()), scaled(t2, angle.sin()));
        let axes = frame_of(contact.normal, Some(major));
        let diameter = |variance: f64| (2.0 * ELLIPSE_SD * variance.max(0.0).sqrt()).max(THIN_M);
        let scale = [diameter(variances[0]), diameter(variances[1]), THIN_M];
        Marker {
            pose: Pose { orientation: axes.rotation(), ..at(contact.position_m) },
            scale: scale.into(),
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

/// Eigenvalues of [[a, b], [b, d]], the larger first, and the angle of its eigenvector.
fn principal(a: f64, b: f64, d: f64) -> ([f64; 2], f64) {
    let mean = 0.5 * (a + d);
    let half = 0.5 * (a - d);
    let radius = half.hypot(b);
    ([mean + radius, mean - radius], 0.5 * b.atan2(half))
}

fn at(position_m: [f64; 3]) -> Pose {
    Pose { position: Vector3::from(position_m), ..Pose::default() }
}

const fn color(r: f32, g: f32, b: f32, a: f32) -> Color {
    Color { r, g, b, a }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn the_quantile_is_that_of_two_degrees_of_freedom() {
        let closed_form = (-2.0 * 0.05f64.ln()).sqrt();
        assert!((ELLIPSE_SD - closed_form).abs() < 1e-14, "{closed_form}");
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn principal_axes_give_the_matrix_back(
            l in prop::array::uniform2(0.1..5.0f64),
            t in -3.0..3.0f64,
        ) {
            let (c, s) = (t.cos(), t.sin());
            let (a, d) = (l[0] * c * c + l[1] * s * s, l[0] * s * s + l[1] * c * c);
            let b = (l[0] - l[1]) * c * s;
            let (v, angle) = principal(a, b, d);
            let (c, s) = (angle.cos(), angle.sin());
            prop_assert!(v[0] >= v[1]);
            prop_assert!((v[0] * c * c + v[1] * s * s - a).abs() < 1e-12);
            prop_assert!((v[0] * s * s + v[1] * c * c - d).abs() < 1e-12);
            prop_assert!(((v[0] - v[1]) * c * s - b).abs() < 1e-12);
        }
    }

    #[test]
    fn an_arrow_ends_at_the_contact_and_goes_when_it_goes() {
        let contact = Contact {
            id: 3,
            position_m: [0.1, 0.0, 0.0],
            normal: [1.0, 0.0, 0.0],
            force_n: 2.0,
            uncertainty: Some(Uncertainty {
                tangents: [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                covariance: [1e-6, 0.0, 0.0, 0.0, 4e-6, 0.0, 0.0, 0.0, 0.01],
            }),
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
