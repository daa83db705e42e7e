//! Text from outside, as it is shown.

/// Text that came from a device, a file or its name, as it may be printed or drawn: what is not plainly
/// printable, such as a terminal's commands, ends of lines and marks that turn the direction of writing, becomes
/// its escape. What is shown so once is the same when it is shown again.
#[must_use]
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '"' | '\'' | '\\' => shown.push(letter),
            _ => shown.extend(letter.escape_debug()),
        }
    }
    shown
}

/// The same for a text of several lines, which stay.
#[must_use]
pub fn printable_lines(text: &str) -> String {
    text.split('\n').map(printable).collect::<Vec<_>>().join("\n")
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn words_stay_and_commands_do_not() {
        let words = "g0: 1.5 µε → \"ok\" · −3 °C, C:\\x";
        assert_eq!(printable(words), words);
        assert_eq!(printable("\x1b[2Jhe\r\nllo\u{202e}"), "\\u{1b}[2Jhe\\r\\nllo\\u{202e}");
    }

    proptest! {
        #[test]
        fn nothing_shown_commands_a_terminal_or_turns_the_writing(
            text in "(?s)(.|[\u{0}-\u{1f}\u{7f}-\u{9f}\u{200b}-\u{200f}\u{2028}-\u{202e}\u{2066}-\u{2069}\u{feff}]){0,60}"
        ) {
            let shown = printable(&text);
            let is_bidi = |c: char| "\u{61c}\u{200e}\u{200f}".contains(c)
                || ('\u{202a}'..='\u{202e}').contains(&c)
                || ('\u{2066}'..='\u{2069}').contains(&c);
            prop_assert!(!shown.chars().any(|c| c.is_control() || is_bidi(c)), "{shown:?}");
            let ends_a_line = shown.contains(['\u{2028}', '\u{2029}', '\u{200b}', '\u{feff}']);
            prop_assert!(!ends_a_line);
            prop_assert_eq!(&printable(&shown), &shown);
            let lines = printable_lines(&format!("{text}\n{text}"));
            prop_assert_eq!(lines.replace('\n', ""), printable(&text.replace('\n', "")).repeat(2));
        }
    }
}
