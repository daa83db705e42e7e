//! What a calibration session says to the person who presses.

use hapdef::Run;
use hapdef::session::{AskedPress, HeldPress, SessionEvent};

pub(super) fn say(run: &Run, event: &SessionEvent) {
    run.say(&match event {
        SessionEvent::Press(asked) => in_words(asked),
        SessionEvent::Touched => "  hold still".to_owned(),
        SessionEvent::LetGo => "  let go too early: press there again".to_owned(),
        SessionEvent::GaugeOut(gauge) => {
            format!("  gauge {gauge} is saturated, stuck or jumping: press less, check its wires")
        }
        SessionEvent::Held(held) => format!("  let go; {}", held_in_words(held)),
        SessionEvent::Done => "done".to_owned(),
    });
}

fn in_words(asked: &AskedPress) -> String {
    let [x, y, z] = (asked.position_m.coords * 1e3).into();
    let sd = asked
        .relative_sd
        .map_or(String::new(), |sd| format!(", where the map is known to {:.1} %", sd * 100.0));
    format!("press {}: {} N at ({x:.1}, {y:.1}, {z:.1}) mm{sd}", asked.index + 1, asked.force_n)
}

fn held_in_words(held: &HeldPress) -> String {
    let progress = &held.progress;
    let map = progress
        .relative_error
        .map_or(String::new(), |e| format!(", map good to {:.1} %", e * 100.0));
    format!(
        "residual {:.1} %, {:.0} % of the skin covered{map}",
        held.residual * 100.0,
        progress.coverage * 100.0
    )
}
