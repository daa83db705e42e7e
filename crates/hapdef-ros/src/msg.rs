//! The messages, field by field as their definitions in `msg/` have them; the names are ROS's.

use serde::{Deserialize, Serialize};

/// builtin_interfaces/Time, and Duration, which has the same fields.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Time {
    /// Seconds since 1970 UTC.
    pub sec: i32,
    /// Nanoseconds after them.
    pub nanosec: u32,
}

/// std_msgs/Header.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Header {
    /// When.
    pub stamp: Time,
    /// In which frame.
    pub frame_id: String,
}

/// geometry_msgs/Point and geometry_msgs/Vector3.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Vector3 {
    /// Along x.
    pub x: f64,
    /// Along y.
    pub y: f64,
    /// Along z.
    pub z: f64,
}

/// geometry_msgs/Quaternion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quaternion {
    /// i.
    pub x: f64,
    /// j.
    pub y: f64,
    /// k.
    pub z: f64,
    /// Real part.
    pub w: f64,
}

/// geometry_msgs/Transform.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Origin of the child frame in the parent.
    pub translation: Vector3,
    /// Rotation of the child frame.
    pub rotation: Quaternion,
}

/// geometry_msgs/Wrench.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wrench {
    /// Force, N.
    pub force: Vector3,
    /// Torque, N m.
    pub torque: Vector3,
}

/// geometry_msgs/Pose.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Origin of the posed frame.
    pub position: Vector3,
    /// Rotation of the posed frame.
    pub orientation: Quaternion,
}

/// geometry_msgs/TransformStamped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TransformStamped {
    /// When, and the parent frame.
    pub header: Header,
    /// The child frame.
    pub child_frame_id: String,
    /// The child's origin and rotation in the parent.
    pub transform: Transform,
}

/// tf2_msgs/TFMessage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TfMessage {
    /// The transforms.
    pub transforms: Vec<TransformStamped>,
}

/// geometry_msgs/WrenchStamped.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WrenchStamped {
    /// When, and the frame in which and at whose origin it acts.
    pub header: Header,
    /// Force and torque.
    pub wrench: Wrench,
}

/// hapdef_msgs/Gauges.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Gauges {
    /// Sample instant and frame.
    pub header: Header,
    /// Number of the packet.
    pub seq: u32,
    /// Packets missing directly before.
    pub lost_before: u32,
    /// One a gauge, tared, µε.
    pub microstrain: Vec<f64>,
}

/// hapdef_msgs/Contact.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Stays the same while the contact lasts.
    pub id: u32,
    /// On the skin, m.
    pub position: Vector3,
    /// Unit normal, outwards.
    pub normal: Vector3,
    /// Normal force, N.
    pub force: f64,
    /// Whether the covariance is known.
    pub has_covariance: bool,
    /// Unit tangents at right angles.
    pub tangents: [Vector3; 2],
    /// Covariance of (tangent 1, tangent 2, force), m and N, row by row.
    pub covariance: [f64; 9],
}

/// hapdef_msgs/Contacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contacts {
    /// Sample instant and frame.
    pub header: Header,
    /// Number of the reading's packet.
    pub seq: u32,
    /// Whether the quality is known.
    pub has_quality: bool,
    /// Whether the reading decides for these contacts.
    pub is_identified: bool,
    /// Probability of a residual as large.
    pub p_value: f64,
    /// The contacts, the strongest first.
    pub contacts: Vec<Contact>,
    /// Other explanations of the reading, the best first.
    pub alternatives: Vec<Alternative>,
}

/// hapdef_msgs/RobotContacts.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RobotContacts {
    /// Instant of the newest reading, without a frame.
    pub header: Header,
    /// What each limb said last, in its own frame.
    pub limbs: Vec<Contacts>,
}

/// hapdef_msgs/Status.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Status {
    /// When, and the frame of the limb.
    pub header: Header,
    /// Whether a controller may act on the contacts, or on there being none.
    pub is_known: bool,
    /// The phase's word.
    pub phase: String,
    /// Empty, or the word for why it is unknown.
    pub why_unknown: String,
    /// The contacts are those of an earlier time.
    pub is_stale: bool,
    /// Contacts of the last reading.
    pub contacts: u32,
    /// Smallest force that would show wherever it pressed, N.
    pub smallest_seen_force: f64,
}

/// hapdef_msgs/Alternative.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Alternative {
    /// −2 ln evidence less that of the reported contacts.
    pub delta_evidence: f64,
    /// Its contacts on the skin, m.
    pub positions: Vec<Vector3>,
    /// Their normal forces, N.
    pub forces: Vec<f64>,
}

/// diagnostic_msgs/KeyValue.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct KeyValue {
    /// Name of a figure.
    pub key: String,
    /// The figure.
    pub value: String,
}

/// diagnostic_msgs/DiagnosticStatus.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticStatus {
    /// 0 ok, 1 warn, 2 error, 3 stale.
    pub level: u8,
    /// Which part.
    pub name: String,
    /// In a few words.
    pub message: String,
    /// Which hardware.
    pub hardware_id: String,
    /// Its values.
    pub values: Vec<KeyValue>,
}

/// diagnostic_msgs/DiagnosticArray.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct DiagnosticArray {
    /// When.
    pub header: Header,
    /// The parts.
    pub status: Vec<DiagnosticStatus>,
}

/// std_msgs/ColorRGBA.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Color {
    /// Red, 0 to 1.
    pub r: f32,
    /// Green.
    pub g: f32,
    /// Blue.
    pub b: f32,
    /// Opacity.
    pub a: f32,
}

/// sensor_msgs/CompressedImage; always empty here.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct CompressedImage {
    /// When.
    pub header: Header,
    /// Of the data.
    pub format: String,
    /// The image.
    pub data: Vec<u8>,
}

/// visualization_msgs/UVCoordinate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct UvCoordinate {
    /// Across.
    pub u: f32,
    /// Up.
    pub v: f32,
}

/// visualization_msgs/MeshFile; always empty here.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct MeshFile {
    /// Its name.
    pub filename: String,
    /// What is in it.
    pub data: Vec<u8>,
}

/// visualization_msgs/Marker.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Marker {
    /// When and in which frame.
    pub header: Header,
    /// Which kind of marker of ours it is.
    pub ns: String,
    /// Number within the kind.
    pub id: i32,
    /// 0 arrow, 3 cylinder, 9 text.
    #[serde(rename = "type")]
    pub kind: i32,
    /// 0 show, 2 take away.
    pub action: i32,
    /// Where.
    pub pose: Pose,
    /// How large, m.
    pub scale: Vector3,
    /// Colour.
    pub color: Color,
    /// 0: until it is taken away.
    pub lifetime: Time,
    /// Whether it moves with its frame.
    pub frame_locked: bool,
    /// An arrow's tail and tip.
    pub points: Vec<Vector3>,
    /// Unused.
    pub colors: Vec<Color>,
    /// Unused.
    pub texture_resource: String,
    /// Unused.
    pub texture: CompressedImage,
    /// Unused.
    pub uv_coordinates: Vec<UvCoordinate>,
    /// A text marker's text.
    pub text: String,
    /// Unused.
    pub mesh_resource: String,
    /// Unused.
    pub mesh_file: MeshFile,
    /// Unused.
    pub mesh_use_embedded_materials: bool,
}

/// visualization_msgs/MarkerArray.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MarkerArray {
    /// The markers.
    pub markers: Vec<Marker>,
}

impl Time {
    /// A time of a file or message.
    #[must_use]
    pub fn from_ns(ns: u64) -> Self {
        Self {
            sec: i32::try_from(ns / 1_000_000_000).unwrap_or(i32::MAX),
            nanosec: (ns % 1_000_000_000) as u32,
        }
    }
}

impl Contact {
    /// The contact at a place of the list.
    pub(crate) fn of((place, contact): (usize, &hapdef_contact::Contact)) -> Self {
        let uncertainty = contact.uncertainty;
        Self {
            id: contact.number(place),
            position: contact.position_m.coords.into(),
            normal: contact.normal().unwrap_or_default().into(),
            force: contact.force_n,
            has_covariance: uncertainty.is_some(),
            tangents: uncertainty.map_or_else(Default::default, |u| u.tangents.map(Vector3::from)),
            // Row by row; nalgebra keeps columns.
            covariance: uncertainty
                .map_or([0.0; 9], |u| std::array::from_fn(|k| u.covariance[(k / 3, k % 3)])),
        }
    }
}

impl From<&hapdef_contact::Alternative> for Alternative {
    fn from(other: &hapdef_contact::Alternative) -> Self {
        Self {
            delta_evidence: other.delta_cost,
            positions: other.contacts().map(|(place, _)| place.coords.into()).collect(),
            forces: other.contacts().map(|(_, force_n)| force_n).collect(),
        }
    }
}

impl From<hapdef_contact::Wrench> for Wrench {
    fn from(wrench: hapdef_contact::Wrench) -> Self {
        Self { force: wrench.force_n.into(), torque: wrench.moment_nm.into() }
    }
}

impl From<nalgebra::Vector3<f64>> for Vector3 {
    fn from(vector: nalgebra::Vector3<f64>) -> Self {
        <[f64; 3]>::from(vector).into()
    }
}

impl From<[f64; 3]> for Vector3 {
    fn from([x, y, z]: [f64; 3]) -> Self {
        Self { x, y, z }
    }
}

impl Default for Quaternion {
    /// No rotation.
    fn default() -> Self {
        let [x, y, z, w] = [0.0, 0.0, 0.0, 1.0];
        Self { x, y, z, w }
    }
}
