//! Loads on a whole limb that are no contacts: what the next joint passes on, weight, motion, temperature.

/// One unit of a load on the whole limb. Directions 0, 1, 2 are x, y, z of the limb's frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum LimbLoad {
    /// A newton along a direction on the flange, at the middle of it.
    FlangeForce(usize),
    /// A newton metre about a direction on the flange.
    FlangeMoment(usize),
    /// Weight less inertia of 1 m/s² along a direction: gravity g and the acceleration a of the limb's origin
    /// make the specific force g − a.
    SpecificForce(usize),
    /// An angular acceleration of 1 rad/s² about a direction through the limb's origin.
    AngularAcceleration(usize),
    /// A product ωᵢ ωⱼ of angular rates of 1 rad²/s², i ≤ j: what is centrifugal about the limb's origin.
    AngularRates(usize, usize),
    /// The whole limb warmer by 1 K.
    Temperature,
}

impl LimbLoad {
    /// All loads of a kind each: six through the flange, three of specific force, three of angular
    /// acceleration, six of angular rates, one of temperature.
    #[must_use]
    pub fn all() -> Vec<Self> {
        let each = |load: fn(usize) -> Self| (0..3).map(load);
        let rates = (0..3).flat_map(|i| (i..3).map(move |j| Self::AngularRates(i, j)));
        each(Self::FlangeForce)
            .chain(each(Self::FlangeMoment))
            .chain(each(Self::SpecificForce))
            .chain(each(Self::AngularAcceleration))
            .chain(rates)
            .chain([Self::Temperature])
            .collect()
    }
}
