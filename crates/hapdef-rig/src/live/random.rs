//! Scripts drawn at random: several contacts that arrive, hold, slide, press harder, leave, hit.

use hapdef_mesh::tri6;
use nalgebra::Point3;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::limb::{LiveLimb, SurfacePoint};
use super::script::{PressEvent, PressScript, ScriptedContact};

/// Draws for one place before a contact is left out.
const N_TRIES: usize = 200;
/// Distance of the corners of a slide, m, and the farthest that one may lie off the skin.
const SLIDE_STEP_M: f64 = 2e-3;
const SLIDE_OFF_M: f64 = 1e-3;

/// What a random script is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RandomScriptParams {
    /// Contacts at a time, at most.
    pub max_contacts: usize,
    /// Least distance of two contacts that are there at a time, m.
    pub spacing_m: f64,
    /// Forces are uniform in this range, N.
    pub force_range_n: (f64, f64),
    /// Length of the script, s.
    pub duration_s: f64,
    /// Untouched time at the beginning, for the tare, s.
    pub quiet_s: f64,
    /// Share of the contacts that are impacts.
    pub impact_share: f64,
    /// Share of the others that slide.
    pub slide_share: f64,
    /// Slides are at most that long, m.
    pub slide_m: f64,
    /// Seed.
    pub seed: u64,
}

/// One contact drawn: its events and the places that it touches.
struct Drawn {
    events: Vec<PressEvent>,
    places: Vec<Point3<f64>>,
    span_s: (f64, f64),
}

impl RandomScriptParams {
    /// Up to `max_contacts` at a time for a minute, a second untouched at first; one in eight hits, two
    /// in five of the others slide by up to 30 mm.
    #[must_use]
    pub fn new(max_contacts: usize, spacing_m: f64, force_range_n: (f64, f64), seed: u64) -> Self {
        Self {
            max_contacts,
            spacing_m,
            force_range_n,
            duration_s: 60.0,
            quiet_s: 1.0,
            impact_share: 0.125,
            slide_share: 0.4,
            slide_m: 0.03,
            seed,
        }
    }
}

/// Draws a script on `limb`. Contacts that find no place at the spacing are left out.
#[must_use]
pub fn random_script(limb: &LiveLimb, params: &RandomScriptParams) -> PressScript {
    let mut rng = ChaCha8Rng::seed_from_u64(params.seed);
    let areas = Areas::new(limb);
    let mut drawn: Vec<Drawn> = Vec::new();
    for _ in 0..params.max_contacts {
        let mut free_s = params.quiet_s;
        loop {
            let at_s = free_s + rng.random_range(0.3..2.0);
            let tries = (0..N_TRIES).map(|_| draw(limb, &areas, params, at_s, &mut rng));
            let fits = |new: &Drawn| drawn.iter().all(|old| old.leaves_room_for(new, params));
            let found = tries.into_iter().find(fits);
            free_s = found.as_ref().map_or(at_s, |new| new.span_s.1);
            if free_s >= params.duration_s {
                break;
            }
            drawn.extend(found);
        }
    }
    drawn.sort_by(|a, b| a.span_s.0.total_cmp(&b.span_s.0));
    let contacts = (1..).zip(drawn).map(|(id, drawn)| ScriptedContact { id, events: drawn.events });
    PressScript { repeat_s: Some(params.duration_s), ..PressScript::new(contacts.collect()) }
}

impl Drawn {
    fn leaves_room_for(&self, new: &Self, params: &RandomScriptParams) -> bool {
        let is_apart_in_time = self.span_s.1 < new.span_s.0 || new.span_s.1 < self.span_s.0;
        let mut pairs =
            self.places.iter().flat_map(|a| new.places.iter().map(move |b| (a - b).norm()));
        is_apart_in_time || pairs.all(|distance_m| distance_m >= params.spacing_m)
    }
}

/// Running sum of the faces' areas, m².
struct Areas(Vec<f64>);

impl Areas {
    fn new(limb: &LiveLimb) -> Self {
        let surface = limb.surface();
        let mut sum = 0.0;
        let sums = surface.faces.iter().map(|face| {
            sum += tri6::area(&face.map(|node| surface.nodes[node as usize]));
            sum
        });
        Self(sums.collect())
    }

    /// A point anywhere on the surface, by area.
    fn draw(&self, limb: &LiveLimb, rng: &mut ChaCha8Rng) -> Point3<f64> {
        let whole = self.0.last().copied().unwrap_or(0.0);
        let at = rng.random::<f64>() * whole;
        let face = self.0.partition_point(|sum| *sum <= at).min(self.0.len() - 1);
        let (u, v): (f64, f64) = (rng.random(), rng.random());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        limb.position_m(&SurfacePoint { face: face as u32, bary: [1.0 - u - v, u, v] })
    }
}

fn draw(
    limb: &LiveLimb,
    areas: &Areas,
    params: &RandomScriptParams,
    at_s: f64,
    rng: &mut ChaCha8Rng,
) -> Drawn {
    let (low, high) = params.force_range_n;
    let force = |rng: &mut ChaCha8Rng| high - (high - low) * rng.random::<f64>();
    let place = areas.draw(limb, rng);
    let position_m = place.coords.into();
    if rng.random_bool(params.impact_share) {
        let for_s = rng.random_range(0.008..0.03);
        return Drawn {
            events: vec![PressEvent::Impact { at_s, for_s, position_m, force_n: force(rng) }],
            places: vec![place],
            span_s: (at_s, at_s + for_s),
        };
    }
    let mut drawn = Drawn {
        events: vec![PressEvent::Arrive {
            at_s,
            for_s: rng.random_range(0.03..0.3),
            position_m,
            force_n: force(rng),
            shear_n: [0.0; 3],
        }],
        places: vec![place],
        span_s: (at_s, at_s),
    };
    drawn.hold(rng);
    if rng.random_bool(params.slide_share) {
        drawn.slide(limb, areas, params, rng);
    }
    if rng.random_bool(0.5) {
        drawn.press(force(rng), rng);
    }
    drawn.leave(rng);
    drawn
}

impl Drawn {
    fn end_s(&self) -> f64 {
        self.events.last().map_or(0.0, PressEvent::end_s)
    }

    fn hold(&mut self, rng: &mut ChaCha8Rng) {
        self.span_s.1 = self.end_s() + rng.random_range(0.3..1.5);
    }

    fn press(&mut self, force_n: f64, rng: &mut ChaCha8Rng) {
        self.events.push(PressEvent::Press {
            at_s: self.span_s.1,
            for_s: rng.random_range(0.05..0.3),
            force_n,
            shear_n: [0.0; 3],
        });
        self.hold(rng);
    }

    fn leave(&mut self, rng: &mut ChaCha8Rng) {
        self.events
            .push(PressEvent::Leave { at_s: self.span_s.1, for_s: rng.random_range(0.03..0.2) });
        self.span_s.1 = self.end_s();
    }

    /// Slides towards another place, as far as the way stays on the skin.
    fn slide(
        &mut self,
        limb: &LiveLimb,
        areas: &Areas,
        params: &RandomScriptParams,
        rng: &mut ChaCha8Rng,
    ) {
        let start = self.places[0];
        let towards = areas.draw(limb, rng) - start;
        let speed_m_s = rng.random_range(0.02..0.06);
        let Some(direction) = towards.try_normalize(1e-6) else {
            return;
        };
        let mut position = start;
        let mut length_m = 0.0;
        while length_m + SLIDE_STEP_M <= params.slide_m {
            let ahead = position + direction * SLIDE_STEP_M;
            let Some((point, off_m)) = limb.nearest(&ahead) else {
                break;
            };
            let next = limb.position_m(&point);
            let step_m = (next - position).norm();
            if off_m > SLIDE_OFF_M || step_m < 0.5 * SLIDE_STEP_M {
                break;
            }
            length_m += step_m;
            position = next;
            self.places.push(position);
        }
        if self.places.len() < 2 {
            return;
        }
        self.events.push(PressEvent::Slide {
            at_s: self.span_s.1,
            for_s: length_m / speed_m_s,
            path_m: self.places[1..].iter().map(|x| x.coords.into()).collect(),
        });
        self.hold(rng);
    }
}
