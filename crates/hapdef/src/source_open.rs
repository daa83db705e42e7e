//! Opens what `--source` names.

use hapdef_daq::record::{NumbersTopic, Recording};
use hapdef_daq::source::{
    FrameSource, Link, Protocol, ReplaySource, SerialLink, SerialParams, StreamParams,
    StreamSource, TcpLink,
};

use crate::error::HapdefError;
use crate::source_args::{BAUD, SourceArg, SourceArgError};

/// Integers in a line of the authors' sketch.
const N_SKETCH_CHANNELS: usize = 10;

impl SourceArg {
    /// The source. Ports and connections are opened when it is first polled, and again whenever
    /// they went away; only a recording is opened here, and a session of ROS 2. Lines have 10 integers where
    /// none are named.
    ///
    /// # Errors
    /// A recording that can't be opened, or a file that is none, or has no such topic; ROS 2 without a topic, or
    /// in a build without zenoh.
    pub fn open(&self) -> Result<Box<dyn FrameSource>, HapdefError> {
        self.open_with(None)
    }

    /// The source, with one integer a line for each of `n_gauges` where no number is named, and as many numbers in
    /// a message of ROS 2.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_for(&self, n_gauges: usize) -> Result<Box<dyn FrameSource>, HapdefError> {
        self.open_with(Some(n_gauges))
    }

    fn open_with(&self, n_gauges: Option<usize>) -> Result<Box<dyn FrameSource>, HapdefError> {
        Ok(match self {
            Self::Serial { device, baud } => stream(serial(device, *baud), Protocol::Hdp1),
            Self::Tcp { address } => stream(TcpLink::new(address), Protocol::Hdp1),
            Self::Csv { device, n_channels } => {
                let n_channels = n_channels.or(n_gauges).unwrap_or(N_SKETCH_CHANNELS);
                stream(serial(device, BAUD), Protocol::Csv { n_channels })
            }
            Self::Replay { file, speed, topic: None } => {
                let messages = Recording::open(file)?.with_first_chunk()?.messages();
                Box::new(ReplaySource::new(&self.to_string(), messages, *speed))
            }
            Self::Replay { file, speed, topic: Some(topic) } => {
                let messages = NumbersTopic::open(file, topic)?.messages()?;
                Box::new(ReplaySource::new(&self.to_string(), messages, *speed))
            }
            Self::Ros2 { topic: None, .. } => {
                return Err(SourceArgError::NoTopic { found: self.to_string() }.into());
            }
            Self::Ros2 { domain_id, router, topic: Some(topic) } => {
                self.ros2(*domain_id, router.as_deref(), topic, n_gauges)?
            }
        })
    }

    #[cfg(feature = "zenoh")]
    fn ros2(
        &self,
        domain_id: u32,
        router: Option<&str>,
        topic: &str,
        n_gauges: Option<usize>,
    ) -> Result<Box<dyn FrameSource>, HapdefError> {
        let mut params = hapdef_ros::ZenohSourceParams::new(domain_id, topic);
        params.n_gauges = n_gauges;
        if let Some(router) = router {
            params.connect = vec![format!("tcp/{router}")];
        }
        Ok(Box::new(hapdef_ros::ZenohSource::open(&params)?))
    }

    #[cfg(not(feature = "zenoh"))]
    fn ros2(
        &self,
        _: u32,
        _: Option<&str>,
        _: &str,
        _: Option<usize>,
    ) -> Result<Box<dyn FrameSource>, HapdefError> {
        Err(SourceArgError::NoZenoh { found: self.to_string() }.into())
    }
}

fn serial(device: &str, baud: u32) -> SerialLink {
    let low_latency = true;
    SerialLink::new(device, SerialParams { baud, low_latency })
}

fn stream(link: impl Link + 'static, protocol: Protocol) -> Box<dyn FrameSource> {
    let params = StreamParams { protocol, ..StreamParams::default() };
    Box::new(StreamSource::new(link, params))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ros_2_needs_a_topic() {
        let error = "ros2:3".parse::<SourceArg>().unwrap().open().err().unwrap();
        assert_eq!(
            error.to_string(),
            "ros2:3: expected the topic of the gauges' readings: --topic /strain"
        );
    }

    #[cfg(not(feature = "zenoh"))]
    #[test]
    fn a_build_without_zenoh_says_how_to_have_it() {
        let source = "ros2:3".parse::<SourceArg>().unwrap().of_topic("/strain").unwrap();
        let error = source.open().err().unwrap().to_string();
        assert!(error.contains("ros2:3, topic /strain: this build has no zenoh"), "{error}");
        assert!(error.contains("--features zenoh"), "{error}");
    }

    #[test]
    fn a_recording_that_is_not_there_is_named() {
        let source: SourceArg = "replay:/nowhere/a.mcap".parse().unwrap();
        let error = source.open().err().unwrap();
        assert!(error.to_string().contains("/nowhere/a.mcap"), "{error}");
    }
}
