//! Axis, mount, wall and the rest, each with its reason.

use nalgebra::{Point3, Unit, Vector3};
use serde_json::{Value, json};

use super::given::{Given, GivenShape, size_m};
use super::{Guess, NewLimbParams};
use crate::error::HapdefError;
use crate::limb_axis::{extent_m, longest_axis};
use crate::scene::{Axis, LimbEnd, MaterialSpec};
use crate::touch::to_micrometres;

/// The part of the length that is held where nothing else is stated.
pub(crate) const HELD_SHARE: f64 = 0.05;

/// A link's origin lies within this part of its length from the end at its parent joint: of 22 limbs of
/// robots 18 had theirs at most 0.18 from an end.
const ORIGIN_SHARE: f64 = 0.25;

/// The wall that sintered or printed limbs have, m; a limb shorter than 150 mm has a thinner one.
const WALL_M: f64 = 2e-3;
const LENGTH_PER_WALL: f64 = 75.0;

/// The long axis.
pub(super) fn axis(given: &Given, params: &NewLimbParams, guesses: &mut Vec<Guess>) -> Axis {
    let triangles = given.triangles();
    let longest = longest_axis(triangles.iter().copied());
    let child = given.joints.as_ref().and_then(|joints| joints.farthest_child());
    let (axis, why) = match (params.axis, child) {
        (Some(direction), _) => (Axis { direction, ..longest }, "as stated".into()),
        (None, Some((name, place))) => {
            let axis = Axis { point_m: [0.0; 3], direction: towards(place).into() };
            (axis, format!("from the link's origin to the joint {name}; --axis states another"))
        }
        (None, None) => {
            let side = size_m(&triangles).imax();
            let angle = Vector3::from(longest.direction)[side].abs().min(1.0).acos().to_degrees();
            let why = format!(
                "the longest principal axis, {angle:.0}° from the longest side of the box; --axis states \
                 another"
            );
            (longest, why)
        }
    };
    // what rounds to 0 has no sign
    let [x, y, z] = axis.direction.map(|x| (x * 100.0).round() / 100.0 + 0.0);
    guesses.push(Guess { what: "axis", value: format!("{x:.2},{y:.2},{z:.2}"), why });
    axis
}

/// A joint is off the link's origin, or it would be no child's that is looked at.
fn towards(place: &Point3<f64>) -> Vector3<f64> {
    place.coords.try_normalize(0.0).unwrap_or_else(Vector3::x)
}

/// Where the limb is held, as a scene has it.
pub(super) fn mount(
    given: &Given,
    axis: &Axis,
    params: &NewLimbParams,
    guesses: &mut Vec<Guess>,
) -> Result<Value, HapdefError> {
    let joint = params.mount_joint.as_deref().map(|name| joint(given, name)).transpose()?;
    if params.mount_end.is_none()
        && params.mount_m.is_none()
        && joint.is_none()
        && let GivenShape::Deck(deck, _) = &given.shape
        && let Some((mount, value, why)) = of_deck(deck)
    {
        guesses.push(Guess { what: "mount", value, why });
        return Ok(mount);
    }
    let along = Unit::new_normalize(Vector3::from(axis.direction));
    let points: Vec<_> = given.triangles().into_iter().flatten().collect();
    let [low, high] = extent_m(&points, &along);
    let length_m = params.mount_m.unwrap_or(HELD_SHARE * (high - low));
    let share = |place: &Point3<f64>| (place.coords.dot(&along) - low) / (high - low);
    let (end, why) = match (params.mount_end, joint) {
        (Some(end), _) => (end, "as stated".to_owned()),
        (None, Some(place)) => {
            let percent = (100.0 * share(&place)).round() + 0.0;
            (
                nearer_end(share(&place)),
                format!("the joint stated is at {percent:.0} % of the length"),
            )
        }
        (None, None) => likely_end(share(&Point3::origin()), given, params)?,
    };
    let name = match end {
        LimbEnd::Low => "low",
        LimbEnd::High => "high",
    };
    let value =
        format!("{name} end of the axis, {:.1} mm of {:.1}", length_m * 1e3, (high - low) * 1e3);
    guesses.push(Guess { what: "mount", value, why });
    Ok(json!({"kind": "end", "end": name, "length_m": to_micrometres(length_m)}))
}

/// Where the joint `name` of the link is, m.
fn joint(given: &Given, name: &str) -> Result<Point3<f64>, HapdefError> {
    let refused = |what: String| HapdefError::NewLimb { path: given.path.clone(), what };
    let Some(joints) = &given.joints else {
        return Err(refused("--mount-joint: only a .urdf has joints".to_owned()));
    };
    let place = joints.place(name);
    place.ok_or_else(|| refused(format!("--mount-joint {name}: the link has {}", joints.names())))
}

fn nearer_end(share: f64) -> LimbEnd {
    if share < 0.5 { LimbEnd::Low } else { LimbEnd::High }
}

/// The end that is held by where the frame's origin is, a share of the length from the low end.
fn likely_end(
    share: f64,
    given: &Given,
    params: &NewLimbParams,
) -> Result<(LimbEnd, String), HapdefError> {
    let end = nearer_end(share);
    let percent = (100.0 * share).round() + 0.0;
    let at = format!("the frame's origin is at {percent:.0} % of the length");
    if let Some(joints) = &given.joints {
        let joint = joints.parent.as_deref().unwrap_or("the base");
        return Ok((
            end,
            format!("{at}, at the joint to its parent ({joint}); --mount-joint states another"),
        ));
    }
    let is_sure = share <= ORIGIN_SHARE || share >= 1.0 - ORIGIN_SHARE;
    if is_sure || params.takes_likeliest {
        let sure = if is_sure { "links have theirs at the parent joint" } else { "the nearer end" };
        return Ok((end, format!("{at}, {sure}; --mount-end states another")));
    }
    Err(HapdefError::Unsure {
        what: "the end that is held",
        why: format!("{at}, near neither end"),
        flag: "--mount-end",
        choices: vec!["low".into(), "high".into()],
    })
}

/// What a deck itself says of its mount.
fn of_deck(deck: &hapdef_mesh::SolidDeck) -> Option<(Value, String, String)> {
    let n = deck.fixed_nodes.len();
    if n > 0 {
        let why = format!("the deck fixes {n} nodes; --mount-end holds an end instead");
        return Some((json!({"kind": "deck"}), "as the deck".into(), why));
    }
    let is_mount =
        |name: &&String| ["MOUNT", "FIX", "CLAMP", "BASE"].iter().any(|w| name.contains(w));
    let name = deck.node_sets.keys().find(is_mount)?;
    let why = "by its name; --mount-end holds an end instead".to_owned();
    Some((json!({"kind": "node_set", "name": name}), format!("the node set {name}"), why))
}

/// The thickness of a skin's wall, m; 0 for a deck, which has its own.
pub(super) fn wall(
    given: &Given,
    params: &NewLimbParams,
    guesses: &mut Vec<Guess>,
) -> Result<f64, HapdefError> {
    if given.is_deck() {
        guesses.push(Guess {
            what: "wall",
            value: "the solid's".into(),
            why: "a deck has it".into(),
        });
        return Ok(0.0);
    }
    let longest_m = size_m(&given.triangles()).max();
    let (wall_m, why) = match params.wall_m {
        Some(wall_m) if wall_m > 0.0 && wall_m.is_finite() => (wall_m, "as stated".to_owned()),
        Some(wall_m) => {
            let what = format!("--wall: expected millimetres above 0, found {}", wall_m * 1e3);
            return Err(HapdefError::NewLimb { path: given.path.clone(), what });
        }
        None => {
            let wall_m = WALL_M.min(longest_m / LENGTH_PER_WALL);
            let why = if wall_m < WALL_M {
                "a 75th of a short limb's length"
            } else {
                "what printed limbs have"
            };
            (wall_m, format!("{why}; the file has no wall; --wall states another"))
        }
    };
    let wall_m = to_micrometres(wall_m);
    guesses.push(Guess { what: "wall", value: format!("{:.2} mm inward", wall_m * 1e3), why });
    Ok(wall_m)
}

/// The skin that is felt begins so many walls from the mount: at the mount's very edge of the bundled skin 9.7 N would
/// go unseen by ten gauges and 9.3 N by 16, as the wall hands it on to the mount before it bends.
const GAP_WALLS: f64 = 2.0;

/// Where the limb may be touched, as a scene has it.
pub(super) fn contact(wall_m: f64, guesses: &mut Vec<Guess>) -> Value {
    let gap_m = to_micrometres(GAP_WALLS * if wall_m > 0.0 { wall_m } else { WALL_M });
    guesses.push(Guess {
        what: "contact",
        value: format!("the free skin, {:.1} mm off the mount", gap_m * 1e3),
        why: "what presses nearer goes into the mount; contact.region in the scene states another"
            .into(),
    });
    json!({"region": {"rule": "free_skin", "mount_gap_m": gap_m}})
}

/// What the scene's material is, for who wants another.
pub(super) fn material(given: &Given, guesses: &mut Vec<Guess>) {
    let of_deck = match &given.shape {
        GivenShape::Deck(deck, _) => deck.material.and_then(|m| m.density_kg_m3.map(|_| m)),
        GivenShape::Surface(_) => None,
    };
    let (value, why) = match of_deck {
        Some(m) => (format!("E = {:.3e} Pa", m.youngs_modulus_pa), "the deck's"),
        None => {
            let m = MaterialSpec::PA2200;
            let value =
                format!("PA2200, E = {:.1e} Pa, ν = {}", m.youngs_modulus_pa, m.poissons_ratio);
            (value, "sintered polyamide; forces are only as right as E: calibrate")
        }
    };
    let why = format!("{why}; material in the scene states another");
    guesses.push(Guess { what: "material", value, why });
}
