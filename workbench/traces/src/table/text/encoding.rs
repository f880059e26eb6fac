//! Bytes of a text file → text: unpacked within the limit of the file, and decoded.

use std::borrow::Cow;
use std::path::Path;

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

/// The text, and the name of its encoding if that is guessed: Windows-1252, of which Latin-1 is a part, of bytes that
/// are no UTF-8.
pub(super) fn text(bytes: Vec<u8>) -> (String, Option<&'static str>) {
    let (text, guessed) = decoded(bytes);
    // Lines of old systems end with a carriage return alone.
    let is_old = text.contains('\r') && !text.contains('\n');
    (if is_old { text.replace('\r', "\n") } else { text }, guessed)
}

fn decoded(bytes: Vec<u8>) -> (String, Option<&'static str>) {
    if let Some((encoding, mark)) = Encoding::for_bom(&bytes)
        && (encoding == UTF_16LE || encoding == UTF_16BE)
    {
        return (encoding.decode_without_bom_handling(&bytes[mark..]).0.into_owned(), None);
    }
    // ASCII as UTF-16 without its mark: every other byte is zero.
    let zeros = |from: usize| bytes.iter().skip(from).step_by(2).take(64).filter(|byte| **byte == 0).count();
    if bytes.len() > 8 {
        for (encoding, from) in [(UTF_16LE, 1), (UTF_16BE, 0)] {
            let looked_at = (bytes.len() / 2).min(64);
            if zeros(from) == looked_at && zeros(1 - from) == 0 {
                return (encoding.decode_without_bom_handling(&bytes).0.into_owned(), Some("UTF-16"));
            }
        }
    }
    match String::from_utf8(bytes) {
        Ok(text) => (text, None),
        Err(error) => {
            let text: Cow<'_, str> = WINDOWS_1252.decode_without_bom_handling(error.as_bytes()).0;
            (text.into_owned(), Some("Windows-1252 (Latin-1)"))
        }
    }
}

/// The bytes of a compressed file as they were before; none of another file.
///
/// # Errors
/// Damaged bytes, or a program that was built without compression.
pub(super) fn unpacked(packed: &[u8]) -> Result<Option<Vec<u8>>, String> {
    let (gzip, zstd) = (packed.starts_with(&[0x1f, 0x8b]), packed.starts_with(&[0x28, 0xb5, 0x2f, 0xfd]));
    if !gzip && !zstd {
        return Ok(None);
    }
    #[cfg(feature = "compressed")]
    {
        let mut limit = crate::table::limit::Limit::of(packed.len() as u64);
        if gzip {
            return limit.unpack(flate2::read::MultiGzDecoder::new(packed)).map(Some);
        }
        let decoder = zstd::Decoder::with_buffer(packed).map_err(|error| error.to_string())?;
        limit.unpack(decoder).map(Some)
    }
    #[cfg(not(feature = "compressed"))]
    Err("this program was built without compressed files (feature `compressed`)".into())
}

/// A text, compressed as the name of its file says.
///
/// # Errors
/// A program that was built without compression.
pub(in crate::table) fn packed(path: &Path, text: &str) -> std::io::Result<Vec<u8>> {
    #[cfg(feature = "compressed")]
    {
        use std::io::Write as _;
        if !path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gz")) {
            return zstd::encode_all(text.as_bytes(), 0);
        }
        let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        writer.write_all(text.as_bytes()).and_then(|()| writer.finish())
    }
    #[cfg(not(feature = "compressed"))]
    {
        let _unused = (path, text);
        Err(std::io::Error::other("this program was built without compressed files (feature `compressed`)"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_other_systems_are_decoded() {
        let utf_16 = |mark: &[u8], bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            mark.iter().copied().chain("t,°C\n1,2\n".encode_utf16().flat_map(bytes)).collect()
        };
        assert_eq!(text(utf_16(&[0xFF, 0xFE], u16::to_le_bytes)), ("t,°C\n1,2\n".into(), None));
        assert_eq!(text(utf_16(&[0xFE, 0xFF], u16::to_be_bytes)), ("t,°C\n1,2\n".into(), None));
        let plain: Vec<u8> = "t,i\n1,2\n".encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(text(plain), ("t,i\n1,2\n".into(), Some("UTF-16")));
        assert_eq!(text(b"t,\xb0C\n1,2\n".to_vec()), ("t,°C\n1,2\n".into(), Some("Windows-1252 (Latin-1)")));
        assert_eq!(text(b"t,i\n".to_vec()), ("t,i\n".into(), None));
        assert_eq!(text(b"t,i\r1,2\r".to_vec()).0, "t,i\n1,2\n");
        assert_eq!(text(b"t,i\r\n1,2\r\n".to_vec()).0, "t,i\r\n1,2\r\n");
    }
}
