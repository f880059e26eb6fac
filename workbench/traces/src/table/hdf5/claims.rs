//! What a MATLAB file of format 7.3 claims, added up before a reader takes it, which reserves what each array claims.
//!
//! Chunks that were never written take no space in a file, and references to one array can be many: both make a file of
//! two kilobytes as large as its header says.

use hdf5_pure::{DType, Dataset, Error, File, Group, Object};

use crate::table::limit::{Limit, NUMBER, VALUE};

/// Deepest group or reference; structures of recordings have a handful.
const DEEPEST: usize = 64;

/// Adds up all that is read of a file.
///
/// # Errors
/// More than the limit, in words; nothing is said of a file that cannot be read, which its reader says.
pub(in crate::table) fn check(bytes: &[u8]) -> Result<(), String> {
    let file = File::from_bytes(bytes.to_vec());
    file.map_or(Ok(()), |file| check_open(&file, bytes.len() as u64))
}

/// Adds up all that is read of an open file of this size.
///
/// # Errors
/// More than the limit, in words.
pub(in crate::table) fn check_open(file: &File, size: u64) -> Result<(), String> {
    let mut claims = Claims { limit: Limit::of(size), size, refused: None };
    let _unreadable = claims.group(&file.root(), 0);
    claims.refused.map_or(Ok(()), Err)
}

struct Claims {
    limit: Limit,
    /// Bytes of the file.
    size: u64,
    refused: Option<String>,
}

/// Why the sum ends: it is refused, or the reader will refuse the file.
struct Ended;

impl From<Error> for Ended {
    fn from(_unreadable: Error) -> Self {
        Self
    }
}

impl Claims {
    fn add(&mut self, counts: impl IntoIterator<Item = u64>, bytes: u64) -> Result<(), Ended> {
        let claimed = self.limit.claim(counts.into_iter().fold(bytes, u64::saturating_mul));
        claimed.and_then(|()| self.limit.claim(VALUE)).map_err(|problem| {
            self.refused.get_or_insert(problem);
            Ended
        })
    }

    fn group(&mut self, group: &Group, depth: usize) -> Result<(), Ended> {
        if depth > DEEPEST {
            self.refused.get_or_insert_with(|| "its groups are nested too deeply, or in a circle".into());
            return Err(Ended);
        }
        self.add([], 0)?;
        for name in group.datasets()? {
            // One that cannot be opened is left to the reader.
            if let Ok(dataset) = group.dataset(&name) {
                self.go_on(|claims| claims.dataset(&dataset, depth))?;
            }
        }
        for name in group.groups()? {
            if let Ok(inner) = group.group(&name) {
                self.go_on(|claims| claims.group(&inner, depth + 1))?;
            }
        }
        Ok(())
    }

    /// Adds a part; one that cannot be read does not end the sum.
    fn go_on(&mut self, part: impl FnOnce(&mut Self) -> Result<(), Ended>) -> Result<(), Ended> {
        let _unreadable = part(self);
        if self.refused.is_some() { Err(Ended) } else { Ok(()) }
    }

    /// Each chunk is a part of the file; a reader takes memory for what the index says of its size.
    fn chunks(&mut self, dataset: &Dataset) -> Result<(), Ended> {
        // Only chunks of an index that is followed are read.
        let sizes = dataset.chunks().unwrap_or_default().into_iter().map(|chunk| chunk.storage_size);
        if sizes.fold(0, u64::saturating_add) <= self.size {
            return Ok(());
        }
        let problem = "the chunks of an array claim more bytes than the file has: it is damaged; write it again";
        self.refused.get_or_insert_with(|| problem.into());
        Err(Ended)
    }

    fn dataset(&mut self, dataset: &Dataset, depth: usize) -> Result<(), Ended> {
        let size = dataset.element_size()?;
        let kind = dataset.dtype()?;
        // Small numbers become doubles.
        let element = size.max(NUMBER);
        self.add(dataset.shape()?, element)?;
        // One chunk is unpacked whole, however small the array is.
        self.add(dataset.chunk_shape()?.unwrap_or_default(), size)?;
        self.chunks(dataset)?;
        if matches!(kind, DType::VariableLengthString) {
            // Many elements may be one long text.
            self.add([], dataset.vlen_string_payload_size()?)?;
        }
        if matches!(kind, DType::ObjectReference) {
            for object in dataset.dereference()? {
                self.go_on(|claims| match &object {
                    Object::Dataset(inner) if depth < DEEPEST => claims.dataset(inner, depth + 1),
                    Object::Group(inner) => claims.group(inner, depth + 1),
                    _ => claims.add([], 0),
                })?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::{Duration, Instant};

    use super::*;

    /// Files of h5py, packed by zlib, as hexadecimal digits. An array `a` of 2³¹ doubles in chunks, none of them
    /// written.
    const CHUNKS: &str = "78daebf47071e3e592e26200010e0e061606010664f01f0a2a5851f930f90428cd08a53ba0f40a26983823584e022a2e\
         08351f5d5d4890ab2b48f57f3400b3c780054273308c8291083c5c1d03407404940f4ba5279850d525a2a5470f0aed65\
         64608598c508e34352322323cc068606649a19280f921154b087a6550706136e0693ffcc1045ac4051903c1333132324\
         3d43cc636662822779169464de31a8e221d8cfdf0594a3610e54601e4d9be4000079f43717";
    /// The same without chunks.
    const CONTIGUOUS: &str = "78daebf47071e3e592e26200010e0e061606010664f01f0a2a5851f930f90428cd08a53ba0f40a26983823584e022a2e\
         08351f5d5d4890ab2b48f57f3400b3c780054273308c8291083c5c1d03407404940f4ba5279850d525a2a5470f0aed65\
         64608598c508e34352322323cc068606649a19280f921154b087a6550706136e0693ffcc1045ac4051903c1313132324\
         3d43cc6366444ef12c482ee81854f110ece7ef02cad1b07ca8c03c9a36c901006b12370b";
    /// Three arrays of 96 MiB, of which none is written; the sum ends with the first one.
    const MANY: &str = "78daebf47071e3e592e26200010e0e061606010664f01f0a66b0a3f261f209509a114a7740e9154c307146b09c04545c\
         106a3ebaba9020575790eaff6800668f010b8496601805231178b83a0680e808285f014a9f6042559708a593a074325a\
         fab420d15e460656885e46181f9202191961261e40a19981f2201941057b060eb0880383093783c97f66882a56a02848\
         9e8999096c0007d43c66262678926761806a45c929830304fbf9bb30027d0973a002337ef5b0d2a48215bf3a58beee60\
         1b19e979345d8d86073e0000c740532f";
    /// A cell with 2000 references to an array of 2²⁰ bytes.
    const REFERENCES: &str = "78daebf47071e3e592e26200010e0e061606010664f01f0abe08a1f261f209509a114a7740e9154c307146b09c04545c\
         106a3ebaba9020575790eaff680066cf0356088deaba5130528087ab6300888e80f261e9e90413aa3ae5a2d4b4626506\
         86e4d49c1ce474e940a6bdb8d2af0733849fc14a5cfab5e080d01ca351399a7e91cab10e5654754999e928e5a90785f6\
         06fbf9bb303230c1d39d02336a798d9e8e61ee6ae01c8d33d472801512668c303ea444606464448b5108cd0ca419a13c\
         46a49ccf0aa4417c262626468828c41c66464489815ac74d1894e10149578cf074a5c13e9a46c84b57ec78d3d50568b8\
         c2686668fa1187a628787a6286a4276e0605309f116e1e07b8064b494dcb492c4905b6ef60f51034dd31314de0425801\
         af9e78180ca0fa7981821c0cbe8e213e8e4ef1c93989c5c5207161a0f92c48e508acbe05d674148507a81e65c4528f9a\
         e0507f4008950f0ba7d17a76148c8251300a46c12818bea022eeed51435e607dcf6c60b7e6ccfe43aa3716d4ce9a2b7c\
         7b5b2e16f4ed3537636abe0300204c8cee";

    fn file(packed: &str) -> Vec<u8> {
        use std::io::Read as _;
        let digit = |at: usize| u8::from_str_radix(&packed[at..at + 2], 16).expect("digits");
        let packed: Vec<u8> = (0..packed.len()).step_by(2).map(digit).collect();
        let mut plain = Vec::new();
        flate2::read::ZlibDecoder::new(&packed[..]).read_to_end(&mut plain).expect("packed");
        plain
    }

    #[test]
    fn what_a_small_file_claims_is_refused_at_once() {
        for (packed, claimed) in [(CHUNKS, 16 << 30), (CONTIGUOUS, 16 << 30), (MANY, 96 << 20), (REFERENCES, 64 << 20)]
        {
            let bytes = file(packed);
            assert!(bytes.len() < 5000, "{} bytes", bytes.len());
            let start = Instant::now();
            let refused = check(&bytes).expect_err("too large");
            // Far above the few milliseconds that it takes, far below those of 16 GB.
            assert!(start.elapsed() < Duration::from_secs(1), "{:?}", start.elapsed());
            let said = refused.strip_prefix("it claims ").and_then(|rest| rest.split(' ').next());
            let said: u64 = said.and_then(|number| number.parse().ok()).expect("a number");
            // Beside numbers it counts references, and a kilobyte for each value.
            assert!((claimed..claimed + (9 << 20)).contains(&said), "{said}");
            let whole = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file");
            std::fs::write(whole.path(), bytes).expect("written");
            let refused = crate::table::Table::open(whole.path()).expect_err("too large").to_string();
            assert!(refused.contains(", content: it claims") && refused.contains("READ_LIMIT"), "{refused}");
        }
    }

    #[test]
    fn a_file_of_usual_arrays_is_within_the_limit() {
        let mut writer = hdf5_pure::FileBuilder::new();
        writer.create_dataset("a").with_f64_data(&[1.0, 2.0, 3.0]);
        assert_eq!(check(&writer.finish().expect("written")), Ok(()));
        assert_eq!(check(b"no file"), Ok(()), "its reader says so");
    }
}
