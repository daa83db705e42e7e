//! Ground truth in a file: a JSON line for each frame.

use std::io::Write;

use nalgebra::{Point3, Vector3};
use serde::{Deserialize, Serialize};

use super::limb::SurfacePoint;
use super::press::{TrueContact, TruthFrame};
use crate::error::RigError;

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct Line {
    boot_id: u32,
    seq: u32,
    t_device_us: u64,
    t_s: f64,
    contacts: Vec<LineContact>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    loads: Vec<f64>,
}

#[derive(Deserialize, Serialize)]
#[serde(deny_unknown_fields)]
struct LineContact {
    id: u32,
    position_m: [f64; 3],
    normal: [f64; 3],
    force_n: f64,
    shear_n: [f64; 3],
    face: u32,
    bary: [f64; 3],
}

impl TruthFrame {
    /// Writes the frame as a JSON line: `boot_id`, `seq`, `t_device_us`, `t_s`, and for each of the
    /// `contacts` `id`, `position_m`, `normal`, `force_n`, `shear_n`, `face`, `bary`; `loads` where the limb has some.
    ///
    /// # Errors
    /// What the writer says.
    pub fn write_json_line(&self, out: &mut impl Write) -> std::io::Result<()> {
        let contact = |c: &TrueContact| LineContact {
            id: c.id,
            position_m: c.position_m.coords.into(),
            normal: c.normal.into(),
            force_n: c.force_n,
            shear_n: c.shear_n.into(),
            face: c.point.face,
            bary: c.point.bary,
        };
        let line = Line {
            boot_id: self.boot_id,
            seq: self.seq,
            t_device_us: self.t_device_us,
            t_s: self.t_s,
            contacts: self.contacts.iter().map(contact).collect(),
            loads: self.loads.clone(),
        };
        serde_json::to_writer(&mut *out, &line)?;
        out.write_all(b"\n")
    }

    /// Reads such a line; every number comes back as it was.
    ///
    /// # Errors
    /// [`RigError::ScriptForm`] with the JSON path of what is wrong.
    pub fn from_json_line(text: &str) -> Result<Self, RigError> {
        let mut json = serde_json::Deserializer::from_str(text);
        let line: Line = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            RigError::ScriptForm { path: error.path().to_string(), source: error.into_inner() }
        })?;
        let contact = |c: LineContact| TrueContact {
            id: c.id,
            point: SurfacePoint { face: c.face, bary: c.bary },
            position_m: Point3::from(c.position_m),
            normal: Vector3::from(c.normal),
            force_n: c.force_n,
            shear_n: Vector3::from(c.shear_n),
        };
        Ok(Self {
            boot_id: line.boot_id,
            seq: line.seq,
            t_device_us: line.t_device_us,
            t_s: line.t_s,
            contacts: line.contacts.into_iter().map(contact).collect(),
            loads: line.loads,
        })
    }
}
