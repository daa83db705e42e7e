//! What is said where: the topics, in the order in which sinks number them.

use hapdef_daq::record::TopicDef;

use crate::error::RosError;
use crate::schema::definition;

/// Contacts that can have a wrench and a frame of their own at most.
const MAX_SLOTS: usize = 16;

/// What [`is_topic_name`] takes.
pub(crate) const TOPIC_NAME: &str = "a topic's name like /left_arm/shin: parts of letters, digits and _, none that begins with a digit or has two _ in a row";

/// How messages are named and drawn.
#[derive(Clone, Debug, PartialEq)]
pub struct RosParams {
    /// Before the names of hapdef's own topics: `/hapdef`.
    pub prefix: String,
    /// Frame of the limb; positions are in it.
    pub frame_id: String,
    /// Where the limb is mounted, m: the net wrench is said about it, too.
    pub mount_m: Option<[f64; 3]>,
    /// Contacts that have a wrench and a frame of their own, 1 to 16.
    pub n_slots: usize,
    /// Markers a second at most; what is shown need not be drawn for every reading.
    pub marker_hz: f64,
    /// Length of the arrow of 1 N, m.
    pub arrow_m_per_n: f64,
    /// Of a robot of several limbs, what the topic of all of them begins with: `/biped`.
    pub robot: Option<String>,
}

/// A topic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TopicKind {
    /// hapdef_msgs/Gauges on `<prefix>/gauges`.
    Gauges,
    /// hapdef_msgs/Contacts on `<prefix>/contacts`.
    Contacts,
    /// hapdef_msgs/Contacts on `<prefix>/truth`: what is known to touch, from a simulated rig.
    Truth,
    /// visualization_msgs/MarkerArray on `<prefix>/markers`.
    Markers,
    /// tf2_msgs/TFMessage on `/tf`.
    Transforms,
    /// diagnostic_msgs/DiagnosticArray on `/diagnostics`.
    Diagnostics,
    /// hapdef_msgs/Status on `<prefix>/status`: whether contacts can be known.
    Status,
    /// geometry_msgs/WrenchStamped on `<prefix>/wrench`: of all contacts, about the origin of the limb's frame.
    NetWrench,
    /// geometry_msgs/WrenchStamped on `<prefix>/mount/wrench`: the same about the mount, in a frame of its own.
    MountWrench,
    /// geometry_msgs/WrenchStamped on `<prefix>/contact_<slot>/wrench`.
    Wrench(usize),
    /// hapdef_msgs/RobotContacts on `<robot>/contacts`, of all limbs; it comes after so many slots.
    RobotContacts(usize),
}

impl Default for RosParams {
    /// `/hapdef`, frame `limb`, four contacts, 30 Hz, 1 cm for 1 N.
    fn default() -> Self {
        Self {
            prefix: "/hapdef".to_owned(),
            frame_id: "limb".to_owned(),
            mount_m: None,
            n_slots: 4,
            marker_hz: 30.0,
            arrow_m_per_n: 0.01,
            robot: None,
        }
    }
}

impl RosParams {
    /// # Errors
    /// The parameter that is out of range.
    pub fn check(&self) -> Result<(), RosError> {
        let wrong = |name, expected, found: &dyn ToString| {
            Err(RosError::Parameter { name, expected, found: found.to_string() })
        };
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '/';
        if !is_topic_name(&self.prefix) {
            return wrong("prefix", TOPIC_NAME, &self.prefix);
        }
        if let Some(robot) = self.robot.as_ref().filter(|robot| !is_topic_name(robot)) {
            return wrong("robot", TOPIC_NAME, robot);
        }
        if self.frame_id.is_empty() || !self.frame_id.chars().all(is_word) {
            return wrong("frame_id", "letters, digits, _ and /", &self.frame_id);
        }
        if self.mount_m.is_some_and(|m| m.iter().any(|x| !x.is_finite())) {
            return wrong("mount_m", "three numbers", &format!("{:?}", self.mount_m));
        }
        if !(1..=MAX_SLOTS).contains(&self.n_slots) {
            return wrong("n_slots", "1 to 16", &self.n_slots);
        }
        if !(self.marker_hz > 0.0 && self.marker_hz.is_finite()) {
            return wrong("marker_hz", "a number above 0", &self.marker_hz);
        }
        if !(self.arrow_m_per_n > 0.0 && self.arrow_m_per_n.is_finite()) {
            return wrong("arrow_m_per_n", "a number above 0", &self.arrow_m_per_n);
        }
        Ok(())
    }

    /// Frame of the mount: in the mount's middle, its axes those of the limb's frame.
    #[must_use]
    pub fn mount_frame(&self) -> String {
        format!("{}/mount", self.frame_id)
    }

    /// What tells this limb from others among nodes, servers and diagnostics: the prefix as one word.
    #[must_use]
    pub fn name(&self) -> String {
        self.prefix.trim_start_matches('/').replace('/', "_")
    }

    /// Frame of a contact's slot.
    #[must_use]
    pub fn contact_frame(&self, slot: usize) -> String {
        format!("{}/contact_{slot}", self.frame_id)
    }
}

impl TopicKind {
    /// The topics, in the order of their numbers.
    pub fn all(params: &RosParams) -> impl Iterator<Item = Self> {
        let wrenches = (0..params.n_slots).map(Self::Wrench);
        let robot = params.robot.as_ref().map(|_| Self::RobotContacts(params.n_slots));
        [
            Self::Gauges,
            Self::Contacts,
            Self::Truth,
            Self::Markers,
            Self::Transforms,
            Self::Diagnostics,
            Self::Status,
            Self::NetWrench,
            Self::MountWrench,
        ]
        .into_iter()
        .chain(wrenches)
        .chain(robot)
    }

    /// Its number: its place among [`topics`].
    #[must_use]
    pub fn number(self) -> usize {
        match self {
            Self::Gauges => 0,
            Self::Contacts => 1,
            Self::Truth => 2,
            Self::Markers => 3,
            Self::Transforms => 4,
            Self::Diagnostics => 5,
            Self::Status => 6,
            Self::NetWrench => 7,
            Self::MountWrench => 8,
            Self::Wrench(slot) => 9 + slot,
            Self::RobotContacts(n_slots) => 9 + n_slots,
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self, params: &RosParams) -> String {
        let prefix = &params.prefix;
        match self {
            Self::Gauges => format!("{prefix}/gauges"),
            Self::Contacts => format!("{prefix}/contacts"),
            Self::Truth => format!("{prefix}/truth"),
            Self::Markers => format!("{prefix}/markers"),
            Self::Transforms => "/tf".to_owned(),
            Self::Diagnostics => "/diagnostics".to_owned(),
            Self::Status => format!("{prefix}/status"),
            Self::NetWrench => format!("{prefix}/wrench"),
            Self::MountWrench => format!("{prefix}/mount/wrench"),
            Self::Wrench(slot) => format!("{prefix}/contact_{slot}/wrench"),
            Self::RobotContacts(_) => {
                format!("{}/contacts", params.robot.as_deref().unwrap_or(prefix))
            }
        }
    }

    /// Package and name of its messages.
    #[must_use]
    pub fn message(self) -> &'static str {
        match self {
            Self::Gauges => "hapdef_msgs/Gauges",
            Self::Contacts | Self::Truth => "hapdef_msgs/Contacts",
            Self::Markers => "visualization_msgs/MarkerArray",
            Self::Transforms => "tf2_msgs/TFMessage",
            Self::Diagnostics => "diagnostic_msgs/DiagnosticArray",
            Self::Status => "hapdef_msgs/Status",
            Self::NetWrench | Self::MountWrench | Self::Wrench(_) => "geometry_msgs/WrenchStamped",
            Self::RobotContacts(_) => "hapdef_msgs/RobotContacts",
        }
    }
}

/// The topics' names and schemas, in the order of their numbers: what
/// [`hapdef_daq::record::RecordParams::topics`] takes.
///
/// # Errors
/// A parameter that is out of range.
pub fn topics(params: &RosParams) -> Result<Vec<TopicDef>, RosError> {
    params.check()?;
    let topic = |kind: TopicKind| TopicDef {
        name: kind.name(params),
        message_encoding: "cdr".to_owned(),
        schema_name: kind.message().replacen('/', "/msg/", 1),
        schema_encoding: "ros2msg".to_owned(),
        schema: definition(kind.message()).unwrap_or_default(),
    };
    Ok(TopicKind::all(params).map(topic).collect())
}

/// Whether ROS 2 takes this for the full name of a topic (design.ros2.org, Topic and Service name mapping to DDS).
pub(crate) fn is_topic_name(name: &str) -> bool {
    let is_part = |part: &str| {
        part.starts_with(|c: char| c.is_ascii_alphabetic() || c == '_')
            && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && !part.contains("__")
    };
    name.strip_prefix('/').is_some_and(|parts| parts.split('/').all(is_part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_places() {
        let of_robot = RosParams { robot: Some("/biped".to_owned()), ..RosParams::default() };
        for params in [RosParams::default(), of_robot.clone()] {
            for (i, kind) in TopicKind::all(&params).enumerate() {
                assert_eq!(kind.number(), i);
                assert!(crate::type_hash(kind.message()).is_some(), "{kind:?}");
            }
        }
        let of_all = topics(&of_robot).unwrap();
        assert_eq!(of_all.last().unwrap().name, "/biped/contacts");
        let params = RosParams::default();
        let topics = topics(&params).unwrap();
        assert!(topics.iter().all(|topic| !topic.schema.is_empty()));
        assert_eq!(topics[10].name, "/hapdef/contact_1/wrench");
    }

    #[test]
    fn names_that_ros_refuses_are_refused() {
        let with = |change: &dyn Fn(&mut RosParams)| {
            let mut params = RosParams::default();
            change(&mut params);
            topics(&params).is_err()
        };
        assert!(with(&|p| p.prefix = "hapdef".into()));
        assert!(with(&|p| p.prefix = "/a b".into()));
        assert!(with(&|p| p.robot = Some("biped".into())));
        assert!(with(&|p| p.frame_id = String::new()));
        assert!(with(&|p| p.n_slots = 17));
        assert!(with(&|p| p.marker_hz = f64::NAN));
        assert!(with(&|p| p.arrow_m_per_n = 0.0));
    }

    #[test]
    fn names_are_those_that_ros_takes() {
        for name in ["/hapdef", "/left_arm/shin", "/_a1", "/a_b/c2"] {
            assert!(is_topic_name(name), "{name}");
        }
        for name in [
            "", "/", "hapdef", "/a/", "//a", "/a//b", "/2nd", "/a/2", "/a__b", "/a-b", "/ä", "/a b",
        ] {
            let params = RosParams { prefix: name.to_owned(), ..RosParams::default() };
            let error = params.check().unwrap_err().to_string();
            assert!(error.contains("like /left_arm/shin"), "{name}: {error}");
        }
    }
}
