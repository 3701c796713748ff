//! From a file's bytes to its text.

use thiserror::Error;

/// Why bytes are no text that can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum TextError {
    /// Nothing is in it.
    #[error("is empty")]
    Empty,
    /// UTF-16 or UTF-32, with a byte order mark or without.
    #[error(
        "is {encoding} text, and missions are UTF-8: save it as UTF-8 (in Notepad: Save as, Encoding), or type `iconv -f \
         {encoding} -t UTF-8 IN > OUT`"
    )]
    Wide {
        /// Which, in iconv's words.
        encoding: &'static str,
    },
    /// Bytes above 127 that are not UTF-8.
    #[error(
        "is not UTF-8: the byte 0x{byte:02X} in line {line}, column {column}{} looks like Latin-1 (Windows-1252). Save it as \
         UTF-8, or type `iconv -f WINDOWS-1252 -t UTF-8 IN > OUT`",
        latin1(*byte)
    )]
    Latin1 {
        /// The first such byte.
        byte: u8,
        /// Its line, from 1.
        line: usize,
        /// Its column in bytes, from 1.
        column: usize,
    },
    /// Zero bytes, as disks leave them after a power cut.
    #[error("is damaged: from line {line}, column {column} on it holds zero bytes. Take a copy that is whole")]
    Zeros {
        /// The first one's line, from 1.
        line: usize,
        /// Its column in bytes, from 1.
        column: usize,
    },
    /// A known kind of file that is no text.
    #[error("is {kind}: {advice}")]
    Binary {
        /// What it is.
        kind: &'static str,
        /// What to do.
        advice: &'static str,
    },
}

fn latin1(byte: u8) -> String {
    if byte >= 0xA0 { format!(" (`{}`?)", char::from(byte)) } else { String::new() }
}

/// Kinds of files that are handed over by mistake, by their first bytes.
const BINARY: [(&[u8], &str, &str); 8] = [
    (b"PK\x03\x04", "a ZIP archive (KMZ files are)", "unpack it, and take the KML or GeoJSON file inside"),
    (b"\x1f\x8b", "compressed by gzip", "unpack it with `gunzip`"),
    (b"SQLite format 3", "a database (GeoPackage files are)", EXPORT),
    (b"\x00\x00\x27\x0a", "a shapefile", EXPORT),
    (b"%PDF", "a PDF", EXPORT),
    (b"\x89PNG", "a picture", EXPORT),
    (b"\xff\xd8\xff", "a picture", EXPORT),
    (b"ULog", "a PX4 flight log", "name the mission file"),
];
const EXPORT: &str = "export points and fence as GeoJSON in EPSG:4326, for instance from QGIS";

/// The text of a file, without the mark that some editors put in front.
pub(super) fn decode(bytes: &[u8]) -> Result<&str, TextError> {
    for (magic, kind, advice) in BINARY {
        if bytes.starts_with(magic) {
            return Err(TextError::Binary { kind, advice });
        }
    }
    match bytes {
        [0xFF, 0xFE, 0, 0, ..] | [0, 0, 0xFE, 0xFF, ..] => return Err(TextError::Wide { encoding: "UTF-32" }),
        [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => return Err(TextError::Wide { encoding: "UTF-16" }),
        _ => {}
    }
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    if bytes.iter().all(u8::is_ascii_whitespace) {
        return Err(TextError::Empty);
    }
    if let Some(at) = bytes.iter().position(|&b| b == 0) {
        // Latin text in UTF-16 has a zero in every second byte from its beginning.
        return Err(match bytes {
            [0, low, 0, ..] if *low != 0 => TextError::Wide { encoding: "UTF-16BE" },
            [low, 0, high, 0, ..] if *low != 0 && *high != 0 => TextError::Wide { encoding: "UTF-16LE" },
            _ => {
                let (line, column) = place(bytes, at);
                TextError::Zeros { line, column }
            }
        });
    }
    std::str::from_utf8(bytes).map_err(|error| {
        let at = error.valid_up_to();
        let (line, column) = place(bytes, at);
        TextError::Latin1 { byte: bytes[at], line, column }
    })
}

/// Line and column of a byte, from 1.
pub(super) fn place(bytes: &[u8], at: usize) -> (usize, usize) {
    let before = &bytes[..at.min(bytes.len())];
    let line = before.iter().filter(|&&b| b == b'\n').count() + 1;
    let column = before.iter().rev().take_while(|&&b| b != b'\n').count() + 1;
    (line, column)
}

/// Lines by their offsets, for texts with many places to name.
pub(super) struct Lines(Vec<usize>);

impl Lines {
    pub(super) fn of(text: &str) -> Self {
        Self(text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(at, _)| at).collect())
    }

    /// The line of a byte, from 1.
    pub(super) fn line(&self, at: usize) -> usize {
        self.0.partition_point(|&end| end < at) + 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_lived_with_and_other_encodings_are_named() {
        assert_eq!(decode(b"\xEF\xBB\xBFa = 1"), Ok("a = 1"));
        let said = |bytes: &[u8]| decode(bytes).unwrap_err().to_string();
        let wide = |text: &str, big: bool| -> Vec<u8> {
            text.encode_utf16().flat_map(|u| if big { u.to_be_bytes() } else { u.to_le_bytes() }).collect()
        };
        for (bytes, encoding) in [
            ([&b"\xFF\xFE"[..], &wide("a = 1", false)].concat(), "UTF-16"),
            ([&b"\xFE\xFF"[..], &wide("a = 1", true)].concat(), "UTF-16"),
            (wide("a = 1", false), "UTF-16LE"),
            (wide("a = 1", true), "UTF-16BE"),
            (b"\xFF\xFE\0\0a\0\0\0".to_vec(), "UTF-32"),
        ] {
            let said = said(&bytes);
            assert!(said.contains(&format!("is {encoding} text")) && said.contains("save it as UTF-8"), "{said}");
        }
        let latin = said(b"# one\n# Z\xFCrich");
        assert!(latin.contains("0xFC in line 2, column 4 (`\u{fc}`?)") && latin.contains("WINDOWS-1252"), "{latin}");
        assert!(said(b"a = 1\n\0\0\0\0").contains("from line 2, column 1 on it holds zero bytes"));
        assert!(said(b"\xEF\xBB\xBF \r\n").contains("is empty"));
        assert!(said(b"PK\x03\x04....").contains("KMZ"));
    }
}
