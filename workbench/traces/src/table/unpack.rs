//! Compressed text, unpacked within the limit of its file.

use std::path::Path;

use model::Error;

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
