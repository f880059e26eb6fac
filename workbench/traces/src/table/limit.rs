//! How much a file may become in memory: a few bytes can claim, or unpack to, more than any memory holds.
//!
//! ```text
//! limit = max(64 MiB, 100 × size of the file)         or BEARING_WATCH_READ_LIMIT, such as 4G
//! ```
//!
//! What a file claims is compared before memory is reserved; what a stream unpacks to, while it comes out. A number
//! counts eight bytes, since it becomes a double. Text that is not packed needs no limit: it is as long as its file.

use std::fs::File;
use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use model::Error;

/// The environment variable with another limit.
const VARIABLE: &str = "BEARING_WATCH_READ_LIMIT";
/// Bytes that any file may become; beyond them, how many times its size.
const LEAST: u64 = 64 << 20;
const RATIO: u64 = 100;
/// Bytes of a number in memory.
#[cfg(any(feature = "matlab", feature = "numpy", feature = "parquet"))]
pub(crate) const NUMBER: u64 = size_of::<f64>() as u64;
/// Bytes that any value, field or column costs beside its content: its name, its place, its list.
#[cfg(any(feature = "matlab", feature = "numpy"))]
pub(crate) const VALUE: u64 = 1 << 10;

/// The limit of one file, and what of it is used.
#[derive(Clone, Debug)]
pub(crate) struct Limit {
    most: u64,
    used: u64,
}

impl Limit {
    /// The limit of a file of this size.
    pub(crate) fn of(size: u64) -> Self {
        static SET: OnceLock<Option<u64>> = OnceLock::new();
        let set = SET.get_or_init(|| std::env::var(VARIABLE).ok().and_then(|text| parsed(&text)));
        Self { most: set.unwrap_or_else(|| LEAST.max(RATIO.saturating_mul(size))), used: 0 }
    }

    /// The limit of a file.
    #[cfg(any(feature = "matlab", feature = "numpy", feature = "parquet"))]
    pub(crate) fn of_file(path: &Path) -> Result<Self, Error> {
        Ok(Self::of(path.metadata().map_err(Error::io(path))?.len()))
    }

    /// Adds bytes that the file claims.
    ///
    /// # Errors
    /// More than the limit, in words.
    #[cfg(any(feature = "matlab", feature = "numpy", feature = "parquet"))]
    pub(crate) fn claim(&mut self, bytes: u64) -> Result<(), String> {
        self.used = self.used.saturating_add(bytes);
        if self.used > self.most { Err(beyond(&format!("it claims {} bytes", self.used), self.most)) } else { Ok(()) }
    }

    /// Adds numbers that the file claims: the product of these counts.
    #[cfg(any(feature = "matlab", feature = "numpy", feature = "parquet"))]
    pub(crate) fn claim_numbers(&mut self, counts: impl IntoIterator<Item = u64>) -> Result<(), String> {
        self.claim(counts.into_iter().fold(NUMBER, u64::saturating_mul))
    }

    /// Reads all that comes out of a stream.
    ///
    /// # Errors
    /// Damaged bytes, or more than the limit.
    pub(crate) fn unpack(&mut self, reader: impl Read) -> Result<Vec<u8>, String> {
        let left = self.most.saturating_sub(self.used);
        let mut plain = Vec::new();
        reader.take(left.saturating_add(1)).read_to_end(&mut plain).map_err(|error| error.to_string())?;
        self.used = self.used.saturating_add(plain.len() as u64);
        if plain.len() as u64 > left { Err(beyond("more comes out", self.most)) } else { Ok(plain) }
    }

    /// What is left of it.
    #[cfg(test)]
    pub(crate) const fn left(&self) -> u64 {
        self.most.saturating_sub(self.used)
    }
}

/// The words of a file that is too large.
fn beyond(what: &str, most: u64) -> String {
    format!(
        "{what}, more than the limit of {most}, which is {RATIO} times the size of the file and at least {LEAST}; if the \
         file is right, set {VARIABLE} to a larger number of bytes, e.g. 16G"
    )
}

/// A number of bytes, with k, M, G or T for powers of 1024.
fn parsed(text: &str) -> Option<u64> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let power = match &*text[digits.len()..].to_ascii_lowercase() {
        "" | "b" => 0,
        "k" => 10,
        "m" => 20,
        "g" => 30,
        "t" => 40,
        _ => return None,
    };
    digits.trim().parse::<u64>().ok()?.checked_mul(1 << power).filter(|bytes| *bytes > 0)
}

/// All bytes of a file. One that is no regular file, such as a pipe or a device, may have no end.
pub(crate) fn whole(path: &Path) -> Result<Vec<u8>, Error> {
    let file = File::open(path).map_err(Error::io(path))?;
    let about = file.metadata().map_err(Error::io(path))?;
    if about.is_file() {
        return std::fs::read(path).map_err(Error::io(path));
    }
    if about.is_dir() {
        return Err(Error::io(path)(std::io::ErrorKind::IsADirectory.into()));
    }
    Limit::of(0).unpack(file).map_err(|problem| Error::content(path, "content", problem))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_unpacks_without_end_is_refused() {
        let limit = |most| Limit { most, used: 0 };
        let text = [b'1'; 1000];
        assert_eq!(limit(1000).unpack(&text[..]), Ok(text.to_vec()));
        let refused = limit(999).unpack(&text[..]).expect_err("one more");
        assert!(refused.starts_with("more comes out, more than the limit of 999"), "{refused}");
        assert!(limit(1 << 16).unpack(std::io::repeat(0)).is_err());
        // The second stream has what the first one left.
        let mut both = limit(1500);
        assert!(both.unpack(&text[..]).is_ok() && both.unpack(&text[..]).is_err());
    }

    #[test]
    fn claims_add_up_without_overflow() {
        let mut limit = Limit::of(1);
        assert_eq!(limit.claim(LEAST), Ok(()));
        let refused = limit.claim(1).expect_err("one more");
        assert!(refused.starts_with(&format!("it claims {} bytes, more than the limit of {LEAST}", LEAST + 1)));
        assert!(refused.contains("BEARING_WATCH_READ_LIMIT"), "{refused}");
        assert!(Limit::of(0).claim_numbers([u64::MAX, u64::MAX]).is_err());
        assert!(Limit::of(0).claim_numbers([u64::MAX, 0]).is_ok());
        assert_eq!(Limit::of(1 << 30).left(), 100 << 30);
    }

    #[test]
    fn the_limit_may_be_set() {
        assert_eq!(["16G", " 3 m ", "7", "1T"].map(parsed), [Some(16 << 30), Some(3 << 20), Some(7), Some(1 << 40)]);
        assert_eq!(["", "0", "x", "-1", "1X", "99999999T", "1.5G"].map(parsed), [None; 7]);
    }

    #[cfg(unix)]
    #[test]
    fn a_device_without_end_is_refused() {
        let refused = whole(Path::new("/dev/zero")).expect_err("no end").to_string();
        assert!(refused.contains("/dev/zero, content: more comes out"), "{refused}");
    }
}
