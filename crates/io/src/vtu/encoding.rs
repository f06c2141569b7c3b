//! XML in other encodings than UTF-8.

use tetrascope_core::Error;

use super::document::find;
use crate::source::{Source, reserve};

/// The windows-1252 characters of bytes 80 to 9F, by their code points; 0 where there is
/// none. All other bytes are those of ISO-8859-1, and so the code points.
const WINDOWS_1252: [u16; 32] = [
    0x20ac, 0, 0x201a, 0x0192, 0x201e, 0x2026, 0x2020, 0x2021, 0x02c6, 0x2030, 0x0160, 0x2039,
    0x0152, 0, 0x017d, 0, 0, 0x2018, 0x2019, 0x201c, 0x201d, 0x2022, 0x2013, 0x2014, 0x02dc,
    0x2122, 0x0161, 0x203a, 0x0153, 0, 0x017e, 0x0178,
];

/// The same file with its XML in UTF-8; appended data stay what they are.
///
/// # Errors
/// XML that is neither UTF-8 nor in an encoding that it declares and that is known here.
pub(crate) fn to_utf8(source: Source) -> Result<Source, Error> {
    let bytes = source.bytes.as_slice();
    let (head, tail) = bytes.split_at(find(bytes, b"<AppendedData").unwrap_or(bytes.len()));
    let Err(error) = std::str::from_utf8(head) else {
        return Ok(source);
    };
    let declared = declared(head);
    let windows = match declared.as_deref().map(str::to_ascii_lowercase).as_deref() {
        Some("iso-8859-1" | "iso8859-1" | "iso_8859-1" | "latin1" | "latin-1") => false,
        Some("windows-1252" | "cp1252") => true,
        _ => {
            let what = match declared {
                Some(name) => format!("the XML says that it is '{name}', which is not read"),
                None => "the XML is not UTF-8 text and does not name its encoding".into(),
            };
            return Err(source.error_with_help(
                format!("byte {}", error.valid_up_to()),
                what,
                "save the file as UTF-8; ISO-8859-1 and windows-1252 are read where <?xml encoding=\"…\"?> says so",
            ));
        }
    };
    let mut converted = Vec::new();
    reserve(&mut converted, bytes.len())?;
    for &byte in head {
        let code = match byte {
            0x80..0xa0 if windows => WINDOWS_1252[usize::from(byte - 0x80)],
            _ => u16::from(byte),
        };
        let letter = char::from_u32(code.into()).unwrap_or(char::REPLACEMENT_CHARACTER);
        converted.extend_from_slice(letter.encode_utf8(&mut [0; 4]).as_bytes());
    }
    converted.extend_from_slice(tail);
    Ok(Source {
        path: source.path,
        bytes: converted,
    })
}

/// The encoding that `<?xml … encoding="…"?>` declares.
fn declared(head: &[u8]) -> Option<String> {
    let declaration = head.trim_ascii_start().strip_prefix(b"<?xml")?;
    let end = find(declaration, b"?>")?;
    let rest = &declaration[find(&declaration[..end], b"encoding")? + "encoding".len()..end];
    let rest = rest
        .trim_ascii_start()
        .strip_prefix(b"=")?
        .trim_ascii_start();
    let (&quote, rest) = rest.split_first()?;
    let name = &rest[..rest.iter().position(|&b| b == quote)?];
    Some(String::from_utf8_lossy(&name[..name.len().min(40)]).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn converted(bytes: &[u8]) -> Result<Vec<u8>, Error> {
        let source = Source {
            path: "a.vtu".into(),
            bytes: bytes.into(),
        };
        Ok(to_utf8(source)?.bytes)
    }

    #[test]
    fn declared_encodings_become_utf8() {
        let latin = converted(b"<?xml version='1.0' encoding = 'ISO-8859-1' ?><a n=\"\xb0\"/>");
        let text = "<?xml version='1.0' encoding = 'ISO-8859-1' ?><a n=\"°\"/>";
        assert_eq!(latin.expect("it is known"), text.as_bytes());
        let windows =
            converted(b"<?xml encoding=\"Windows-1252\"?>\x80\x81\xe9<AppendedData>_\xff");
        let mut text = "<?xml encoding=\"Windows-1252\"?>€\0é<AppendedData>_"
            .as_bytes()
            .to_vec();
        text.push(0xff);
        assert_eq!(windows.expect("it is known"), text);
        // What is UTF-8 is left alone, whatever it says.
        let plain = "<?xml encoding=\"EBCDIC\"?>é".as_bytes();
        assert_eq!(converted(plain).expect("it is UTF-8"), plain);
    }

    #[test]
    fn others_are_refused_by_name() {
        for (bytes, words) in [
            (
                b"<?xml encoding=\"US-ASCII\"?>\xe9".as_slice(),
                "'US-ASCII'",
            ),
            (b"<?xml encoding=\"Shift_JIS\"?>\x83\x41", "'Shift_JIS'"),
            (b"<a>\xe9</a>", "does not name its encoding"),
            (
                b"<?xml encoding=\"ISO-8859-1?>\xe9",
                "does not name its encoding",
            ),
            (b"<?xml \xe9", "does not name its encoding"),
        ] {
            let error = converted(bytes).expect_err(words).to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
