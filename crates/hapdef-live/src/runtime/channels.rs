//! Which channels of a device are the gauges.

use hapdef_daq::hdp1::Channel;

use crate::error::LiveError;

/// Letters of a gauge's name that a device reports.
const N_LETTERS: usize = 4;

/// Channels of the gauges called `names`, in their order: by name if each has a bridge of its own that
/// is called so, in capitals or not, by the first four letters; else the bridges as they come.
/// `n_gauges` is how many there must be, as many as bridges if `None`.
///
/// # Errors
/// [`LiveError::Channels`] if neither gives as many.
pub fn gauge_channels<'a>(
    channels: &[Channel],
    names: impl IntoIterator<Item = &'a str>,
    n_gauges: Option<usize>,
) -> Result<Vec<usize>, LiveError> {
    let bridges: Vec<usize> =
        (0..channels.len()).filter(|&i| channels[i].kind.is_bridge()).collect();
    let expected = n_gauges.unwrap_or(bridges.len());
    let named = |name: &str| {
        let short: String = name.chars().take(N_LETTERS).collect();
        let is_it = |&i: &usize| channels[i].name_text().eq_ignore_ascii_case(&short);
        bridges.iter().copied().find(is_it)
    };
    let by_name: Option<Vec<usize>> = names.into_iter().map(named).collect();
    let is_whole = |places: &Vec<usize>| {
        let is_own = |(i, place): (usize, &usize)| !places[..i].contains(place);
        places.len() == expected && places.iter().enumerate().all(is_own)
    };
    let places = by_name.filter(is_whole).unwrap_or(bridges);
    let found = places.len();
    if found != expected {
        return Err(LiveError::Channels { expected, found });
    }
    Ok(places)
}

#[cfg(test)]
mod tests {
    use hapdef_daq::hdp1::{ChannelKind, Hello, SampleFormat};

    use super::*;

    #[test]
    fn names_that_a_device_can_not_tell_apart_go_by_order() {
        let mut channels = Hello::plain(3, SampleFormat::I16, 500).channels;
        let found = |channels: &[Channel], names: [&str; 3]| {
            gauge_channels(channels, names, Some(3)).unwrap()
        };
        assert_eq!(found(&channels, ["g2", "g0", "g1"]), [2, 0, 1]);
        assert_eq!(found(&channels, ["g2", "g0", "toe"]), [0, 1, 2]);
        for channel in &mut channels {
            channel.name = *b"gaug";
        }
        let names = ["gauge_c", "gauge_a", "gauge_b"];
        assert_eq!(found(&channels, names), [0, 1, 2]);
    }

    #[test]
    fn channels_that_are_no_bridges_are_passed_over() {
        let mut channels = Hello::plain(4, SampleFormat::I16, 500).channels;
        channels[1].kind = ChannelKind::Temperature;
        let gauges = |n| gauge_channels(&channels, [], n);
        assert_eq!(gauges(None).unwrap(), [0, 2, 3]);
        let (expected, found) = (4, 3);
        assert!(matches!(gauges(Some(4)), Err(LiveError::Channels { expected: 4, found: 3 })));
        let text = LiveError::Channels { expected, found }.to_string();
        assert!(text.contains("expected 4 gauges, the device has 3"), "{text}");
    }
}
