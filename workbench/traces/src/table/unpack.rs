//! Unpacking with a limit: a few bytes can unpack to more than any memory holds.

#[cfg(any(feature = "compressed", feature = "matlab"))]
use std::io::Read;
use std::path::Path;

use model::Error;

#[cfg(any(feature = "compressed", feature = "matlab", feature = "parquet"))]
/// Bytes to which any file may be unpacked; beyond them, how many times its size.
const MOST_BYTES: u64 = 1 << 30;
#[cfg(any(feature = "compressed", feature = "matlab", feature = "parquet"))]
const MOST_RATIO: u64 = 100;

#[cfg(any(feature = "compressed", feature = "matlab", feature = "parquet"))]
/// Largest number of bytes that a file of this size may be unpacked to.
pub(super) fn most(packed: usize) -> u64 {
    MOST_BYTES.max(MOST_RATIO.saturating_mul(packed as u64))
}

#[cfg(any(feature = "compressed", feature = "matlab"))]
/// Unpacks at most so many bytes.
///
/// # Errors
/// Damaged bytes, or more than that.
pub(super) fn unpack(reader: impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut plain = Vec::new();
    reader.take(most.saturating_add(1)).read_to_end(&mut plain).map_err(|error| error.to_string())?;
    if plain.len() as u64 > most { Err(format!("more than {most} bytes come out")) } else { Ok(plain) }
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
        let most = most(packed.len());
        if gzip {
            return unpack(flate2::read::MultiGzDecoder::new(packed), most).map(Some);
        }
        let decoder = zstd::Decoder::with_buffer(packed).map_err(|error| error.to_string())?;
        unpack(decoder, most).map(Some)
    }
    #[cfg(not(feature = "compressed"))]
    Err("this program was built without compressed files (feature `compressed`)".into())
}

/// A text, compressed as the name of its file says.
///
/// # Errors
/// A program that was built without compression.
pub(super) fn packed(path: &Path, text: &str) -> Result<std::io::Result<Vec<u8>>, Error> {
    #[cfg(feature = "compressed")]
    {
        use std::io::Write as _;
        let gzip = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gz"));
        Ok(if gzip {
            let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
            writer.write_all(text.as_bytes()).and_then(|()| writer.finish())
        } else {
            zstd::encode_all(text.as_bytes(), 0)
        })
    }
    #[cfg(not(feature = "compressed"))]
    {
        let _unused = text;
        Err(super::formats::left_out(path, "gz and .zst"))
    }
}

#[cfg(all(test, any(feature = "compressed", feature = "matlab")))]
mod tests {
    use super::*;

    #[test]
    fn what_unpacks_without_end_is_refused() {
        let text = [b'1'; 1000];
        assert_eq!(unpack(&text[..], 1000), Ok(text.to_vec()));
        assert_eq!(unpack(&text[..], 999), Err("more than 999 bytes come out".into()));
        assert!(unpack(std::io::repeat(0), 1 << 16).is_err());
        assert_eq!((most(1), most(1 << 30)), (1 << 30, 100 << 30));
    }
}
