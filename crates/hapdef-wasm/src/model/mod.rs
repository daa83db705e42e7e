//! The one file of a static page: the limb's bundle, its virtual rig, and how it is drawn.

mod header;
mod planes;
mod read;
mod write;

use hapdef_live::Bundle;
use hapdef_rig::live::{
    HandsParams, LiveElectronicsParams, LiveLimb, LiveSurface, RigDeviceParams,
};
use hapdef_view::{GaugeSite, LimbPicture, PressOffer};
use nalgebra::Vector3;

use crate::error::PageError;
pub use header::{ElectronicsHeader, RigHeader};

/// Everything about a limb and its virtual rig that a page shows.
#[derive(Clone, Debug)]
pub struct PageModel {
    bundle: Bundle,
    rig: RigHeader,
    /// Direction of a normal press at each node of the bundle's skin `[n_nodes]`, unit length, into the limb.
    inward: Vec<Vector3<f64>>,
    /// What the virtual limb's gauges read `[n_nodes, n_gauges]`, µε/N along x, y and z.
    columns_ue_per_n: Vec<Vector3<f64>>,
    picture: LimbPicture,
}

impl PageModel {
    /// Of a bundle, the virtual limb on the same skin, its device, who presses it, and how it is drawn.
    ///
    /// # Errors
    /// [`PageError::Part`] where they are not of one limb; [`PageError::Loads`].
    pub fn new(
        bundle: Bundle,
        limb: &LiveLimb,
        (electronics, device): (&LiveElectronicsParams, &RigDeviceParams),
        (press, hands): (PressOffer, &HandsParams),
        picture: LimbPicture,
    ) -> Result<Self, PageError> {
        if !limb.loads().loads().is_empty()
            || device.load_sensors.is_some()
            || !bundle.given.is_empty()
        {
            return Err(PageError::Loads);
        }
        let surface = limb.surface();
        same("nodes of the virtual limb", bundle.skin().nodes(), &surface.nodes)?;
        same("faces of the virtual limb", &six_node_faces(&bundle)?, &surface.faces)?;
        Ok(Self {
            rig: RigHeader::new(electronics, device, press, hands),
            inward: surface.inward.clone(),
            columns_ue_per_n: limb.columns_ue_per_n().to_vec(),
            bundle,
            picture,
        })
    }

    /// What finds contacts.
    #[must_use]
    pub fn bundle(&self) -> &Bundle {
        &self.bundle
    }

    /// How the limb is drawn.
    #[must_use]
    pub fn picture(&self) -> &LimbPicture {
        &self.picture
    }

    /// The virtual rig but its limb.
    #[must_use]
    pub fn rig(&self) -> &RigHeader {
        &self.rig
    }

    /// The virtual limb.
    ///
    /// # Errors
    /// [`PageError::Rig`] for numbers that can't be used.
    pub fn limb(&self) -> Result<LiveLimb, PageError> {
        let surface = LiveSurface {
            nodes: self.bundle.skin().nodes().to_vec(),
            faces: six_node_faces(&self.bundle)?,
            inward: self.inward.clone(),
        };
        let n_gauges = self.bundle.info.gauges.len();
        Ok(LiveLimb::new(surface, n_gauges, self.columns_ue_per_n.clone())?)
    }
}

/// The gauges of a bundle, as they are drawn.
fn sites(bundle: &Bundle) -> Vec<GaugeSite> {
    let site = |gauge: &hapdef_live::BundleGauge| GaugeSite {
        name: gauge.name.clone(),
        position_m: gauge.position_m,
        axis: gauge.axis,
    };
    bundle.info.gauges.iter().map(site).collect()
}

/// The faces of the skin, which must have six nodes each.
fn six_node_faces(bundle: &Bundle) -> Result<Vec<[u32; 6]>, PageError> {
    let skin = bundle.skin();
    let face = |face: usize| {
        <[u32; 6]>::try_from(skin.face_nodes(face)).map_err(|_| PageError::Part {
            part: "skin",
            expected: "six nodes a face".to_owned(),
            found: format!("{}", skin.face_nodes(face).len()),
        })
    };
    (0..skin.n_faces()).map(face).collect()
}

fn same<T: PartialEq>(part: &'static str, expected: &[T], found: &[T]) -> Result<(), PageError> {
    if expected == found {
        return Ok(());
    }
    let n = |items: &[T]| format!("{} of the bundle's skin", items.len());
    Err(PageError::Part { part, expected: n(expected), found: format!("{} others", found.len()) })
}
