//! Unpacking with a limit: a few bytes can unpack to more than any memory holds.

use std::io::Read;

/// Bytes to which any file may be unpacked; beyond them, how many times its size.
const MOST_BYTES: u64 = 1 << 30;
const MOST_RATIO: u64 = 100;

/// Largest number of bytes that a file of this size may be unpacked to.
pub(super) fn most(packed: usize) -> u64 {
    MOST_BYTES.max(MOST_RATIO.saturating_mul(packed as u64))
}

/// Unpacks at most so many bytes.
///
/// # Errors
/// Damaged bytes, or more than that.
pub(super) fn unpack(reader: impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut plain = Vec::new();
    reader.take(most.saturating_add(1)).read_to_end(&mut plain).map_err(|error| error.to_string())?;
    if plain.len() as u64 > most { Err(format!("more than {most} bytes come out")) } else { Ok(plain) }
}

#[cfg(test)]
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
