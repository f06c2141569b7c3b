//! Text from files, fit for messages: on one line, without control characters, and short.

use std::borrow::Cow;
use std::fmt::{self, Display, Write as _};

/// The most characters of a name in a message.
pub const LONGEST_NAME: usize = 80;

/// `text` with everything that a terminal would obey or hide written as `\u{1b}` is in Rust:
/// control characters, line ends among them, and what changes the direction of text.
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(is_unprintable) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        match is_unprintable(c) {
            true => plain.extend(c.escape_default()),
            false => plain.push(c),
        }
    }
    Cow::Owned(plain)
}

/// Whether [`printable`] writes `c` as something else.
pub fn is_unprintable(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{ad}' // soft hyphen
            | '\u{200b}'..='\u{200f}' // of no width, and marks of direction
            | '\u{2028}'..='\u{202e}' // line and paragraph ends, embeddings and overrides
            | '\u{2060}'..='\u{206f}'
            | '\u{feff}')
}

/// A printable form of `text` with at most `most` of its characters; one that is longer ends
/// in "…" and its length.
pub fn clip(text: &str, most: usize) -> Cow<'_, str> {
    let Some((end, _)) = text.char_indices().nth(most) else {
        return printable(text);
    };
    let count = text.chars().count();
    Cow::Owned(format!("{}… ({count} characters)", printable(&text[..end])))
}

/// [`clip`] to [`LONGEST_NAME`], for names of fields, keys and files.
pub fn name(text: &str) -> Cow<'_, str> {
    clip(text, LONGEST_NAME)
}

/// The text of `value`, clipped to `most` characters.
pub(crate) fn clipped(value: impl Display, most: usize) -> String {
    let mut start = Start {
        text: String::new(),
        room: most,
        length: 0,
    };
    // Writing to memory does not fail.
    let _ = write!(start, "{value}");
    let Start { text, length, .. } = start;
    if length > most {
        return format!("{}… ({length} characters)", printable(&text));
    }
    printable(&text).into_owned()
}

/// Keeps the first characters that are written.
struct Start {
    text: String,
    room: usize,
    length: usize,
}

impl fmt::Write for Start {
    fn write_str(&mut self, more: &str) -> fmt::Result {
        let count = more.chars().count();
        self.length += count;
        self.text.extend(more.chars().take(self.room));
        self.room = self.room.saturating_sub(count);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(printable("σ ≤ ½"), "σ ≤ ½");
        assert_eq!(printable("a\x1b[31mb"), "a\\u{1b}[31mb");
        assert_eq!(printable("a\nb\t\u{9b}c"), "a\\nb\\t\\u{9b}c");
        assert_eq!(printable("\u{202e}txt"), "\\u{202e}txt");
    }

    #[test]
    fn long_names_end_in_their_length() {
        assert_eq!(clip("abc", 3), "abc");
        assert_eq!(clip("abcd", 3), "abc… (4 characters)");
        assert_eq!(clip("σσσσ\x07", 3), "σσσ… (5 characters)");
        for text in ["abc", "abcd", "σσσσ\x07"] {
            assert_eq!(clipped(text, 3), clip(text, 3), "{text}");
        }
    }
}
