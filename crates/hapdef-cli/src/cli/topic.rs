//! `--topic`: readings that another program wrote to an MCAP file, or publishes.

use clap::Args;
use hapdef::{SourceArg, SourceArgError};

/// Which numbers of an MCAP file, or of ROS 2, are the readings.
#[derive(Args, Clone, Debug, Default)]
pub(crate) struct TopicArgs {
    /// Read the numbers of this topic of an MCAP file, such as a bag of ROS 2, or of ROS 2 itself (ros2:DOMAIN):
    /// µε, JSON or messages with a list of numbers; of several lists name one behind the topic:
    /// /joint_states.effort.
    #[arg(long, value_name = "TOPIC")]
    pub(super) topic: Option<String>,
}

impl TopicArgs {
    /// The source, of the topic that is named.
    pub(super) fn of(&self, source: &SourceArg) -> Result<SourceArg, SourceArgError> {
        match &self.topic {
            Some(topic) => source.of_topic(topic),
            None => Ok(source.clone()),
        }
    }
}
