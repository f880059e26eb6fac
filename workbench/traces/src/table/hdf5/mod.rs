//! HDF5 files, as h5py and laboratories write them: each dataset is a column by its path, a matrix several.
//!
//! ```text
//! /current        a vector                        column current
//! /run/speed      a vector in a group             column run/speed
//! /m              a matrix                        columns m_1, m_2, …, along its longer side
//! /z              complex numbers                 columns z_re, z_im
//! /log            a table: a compound of fields   columns log.a, log.b, …
//! ```
//!
//! Groups that are records become traces ([`crate::table::arrays::records`]); attributes scale values and name units
//! ([`attributes`]).

mod attributes;
pub(super) mod claims;
pub(super) mod links;

use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use hdf5_pure::{DType, Dataset, Datatype, DatatypeByteOrder, File, Group};

use crate::damaged::{DAMAGED, guarded};
use crate::table::arrays::columns::matrix;
use crate::table::arrays::groups::Named;
use crate::table::arrays::numbers::{self as cells, Kind};
use crate::table::arrays::records::{Arrays, columns_of};
use crate::table::columns::About;
use crate::table::limit;
use attributes::Attributes;
use model::Error;

/// The first bytes of a file, which may be behind a block of its user.
const MARK: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Where they may be.
const PLACES: [u64; 6] = [0, 512, 1024, 2048, 4096, 8192];
/// Deepest group.
const DEEPEST: usize = 64;

/// Returns names and columns, of one record or of several.
pub(super) fn read(path: &Path, about: &mut About) -> Result<Arrays, Error> {
    let wrong = |problem: String| Error::content(path, "content", format!("not readable as HDF5: {problem}"));
    if !is_marked(path).map_err(Error::io(path))? {
        return Err(wrong("it does not start as such a file; write it again, e.g. as Parquet".into()));
    }
    let size = path.metadata().map_err(Error::io(path))?.len();
    let datasets = guarded(|| {
        let file = File::open_streaming(path).map_err(|error| wrong(error.to_string()))?;
        claims::check_open(&file, size).map_err(wrong)?;
        let mut found = Found { columns: vec![], about };
        found.group(&file.root(), "", 0);
        Ok(found.columns)
    });
    let columns = datasets.unwrap_or_else(|| Err(wrong(DAMAGED.into())))?;
    if size <= links::LARGEST {
        links::links(&limit::whole(path)?).into_iter().for_each(|(place, reason)| about.omit(place, reason));
    }
    columns_of(path, columns, about)
}

fn is_marked(path: &Path) -> std::io::Result<bool> {
    let mut file = std::fs::File::open(path)?;
    for place in PLACES {
        let mut mark = Vec::new();
        file.seek(SeekFrom::Start(place))?;
        file.by_ref().take(MARK.len() as u64).read_to_end(&mut mark)?;
        if mark == MARK {
            return Ok(true);
        }
    }
    Ok(false)
}

struct Found<'a> {
    columns: Named,
    about: &'a mut About,
}

impl Found<'_> {
    /// Adds all below a group; a part that is not readable takes nothing from others.
    fn group(&mut self, group: &Group, path: &str, depth: usize) {
        let inner = |name: &str| if path.is_empty() { name.to_string() } else { format!("{path}/{name}") };
        match group.datasets() {
            Ok(names) => {
                for name in names {
                    let dataset = group.dataset(&name).map_err(unread);
                    let added = dataset.and_then(|dataset| self.dataset(&inner(&name), &dataset));
                    if let Err(reason) = added {
                        self.omit(&inner(&name), reason);
                    }
                }
            }
            // One link whose place is not known, for example.
            Err(error) => self
                .about
                .omit(format!("group /{path}"), format!("{error}; write its datasets without links, or as Parquet")),
        }
        for name in group.groups().unwrap_or_default() {
            match group.group(&name) {
                Ok(own) if depth < DEEPEST => self.group(&own, &inner(&name), depth + 1),
                Ok(_) => self.omit(&inner(&name), "it is nested too deeply".into()),
                Err(error) => self.omit(&inner(&name), error.to_string()),
            }
        }
    }

    /// Adds the columns of a dataset.
    ///
    /// # Errors
    /// Why it has none.
    fn dataset(&mut self, name: &str, dataset: &Dataset) -> Result<(), String> {
        let shape = dataset.shape().map_err(unread)?;
        let long: Vec<usize> = shape.iter().filter(|side| **side != 1).map(|side| *side as usize).collect();
        if long.contains(&0) {
            return Err("it is empty".into());
        }
        if long.len() > 2 {
            return Err("more than two dimensions: save it as a matrix".into());
        }
        let kind = dataset.dtype().map_err(unread)?;
        match kind {
            DType::String | DType::VariableLengthString => return Err("text".into()),
            DType::ObjectReference => return Err("references: save the arrays themselves".into()),
            _ => {}
        }
        let count = long.iter().fold(1, |count: usize, side| count.saturating_mul(*side));
        let attributes = Attributes::of(dataset)?;
        for (part, values) in parts(dataset, &kind)? {
            match values {
                Ok(values) if values.len() != count => {
                    self.omit(&format!("{name}{part}"), format!("it has {} of {count} values", values.len()));
                }
                Ok(mut values) => {
                    let name = format!("{name}{part}");
                    let missing = attributes.apply(&mut values);
                    self.about.notes.extend(attributes.told(&name, missing));
                    let columns = match long[..] {
                        [rows, across] => matrix(&name, [rows, across], true, &values),
                        _ => vec![(name, values)],
                    };
                    self.columns.extend(columns.into_iter().map(|(name, column)| (attributes.named(&name), column)));
                }
                Err(reason) => self.omit(&format!("{name}{part}"), reason),
            }
        }
        Ok(())
    }

    fn omit(&mut self, path: &str, reason: String) {
        self.about.omit(format!("dataset {path}"), reason);
    }
}

/// Why a dataset is not read, and what to do.
#[expect(clippy::needless_pass_by_value, reason = "for map_err")]
fn unread(error: hdf5_pure::Error) -> String {
    format!("{error}; write it again in the format of HDF5 1.10 and without other filters than deflate, or as Parquet")
}

/// What the name of a dataset gets, and the numbers, or why there are none.
type Part = (String, Result<Vec<f64>, String>);

fn is_whole(kind: &DType) -> bool {
    matches!(kind, DType::I8 | DType::I16 | DType::I32 | DType::I64 | DType::U8 | DType::U16 | DType::U32 | DType::U64)
}

/// The parts of each element: a number, fields, or parts of a complex number.
fn parts(dataset: &Dataset, kind: &DType) -> Result<Vec<Part>, String> {
    // The reader takes no half-precision numbers, flags and compounds.
    if matches!(kind, DType::F32 | DType::F64) || is_whole(kind) {
        let values = dataset.read_f64().map_err(unread)?;
        return Ok(vec![(String::new(), Ok(values))]);
    }
    let whole = dataset.datatype().map_err(unread)?;
    let bytes = dataset.read_raw().map_err(unread)?;
    let size = dataset.element_size().map_err(unread)? as usize;
    let part = |kind: &Datatype, at: u64| -> Option<Vec<f64>> {
        let (kind, own, is_big) = number(kind)?;
        let at = usize::try_from(at).ok()?;
        let elements = bytes.chunks_exact(size.max(1)).filter_map(|element| element.get(at..)?.get(..own));
        cells::numbers(kind, own, is_big, elements)
    };
    let Datatype::Compound { members, .. } = &whole else {
        let values = part(&whole, 0).ok_or_else(|| format!("no numbers but {kind}"))?;
        return Ok(vec![(String::new(), Ok(values))]);
    };
    let names: Vec<&str> = members.iter().map(|own| own.name.as_str()).collect();
    let is_complex = [["r", "i"], ["real", "imag"]].iter().any(|own| names == *own);
    let name = |k: usize| if is_complex { ["_re", "_im"][k].to_string() } else { format!(".{}", names[k]) };
    let each = members.iter().enumerate();
    let each = each.map(|(k, own)| (name(k), part(&own.datatype, own.byte_offset).ok_or("no numbers".into())));
    Ok(each.collect())
}

/// Kind, bytes and order of bytes of a type of numbers, also of those of an enumeration.
fn number(kind: &Datatype) -> Option<(Kind, usize, bool)> {
    let is_big = |order: &DatatypeByteOrder| match order {
        DatatypeByteOrder::LittleEndian => Some(false),
        DatatypeByteOrder::BigEndian => Some(true),
        _ => None,
    };
    Some(match kind {
        Datatype::FixedPoint { size, byte_order, layout } => {
            let kind = if layout.signed { Kind::Signed } else { Kind::Unsigned };
            let is_whole = layout.bit_offset == 0 && u32::from(layout.bit_precision) == 8 * size;
            (kind, *size as usize, is_big(byte_order).filter(|_| is_whole)?)
        }
        // Numbers of IEEE have 5, 8 or 11 bits of exponent.
        Datatype::FloatingPoint { size, byte_order, layout } => {
            let is_usual = [(2, 5), (4, 8), (8, 11)].contains(&(*size, layout.exponent_size));
            (Kind::Float, *size as usize, is_big(byte_order).filter(|_| is_usual)?)
        }
        Datatype::Enumeration { base_type, .. } => number(base_type)?,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use hdf5_pure::{AttrValue, FileBuilder};

    use super::*;

    /// Names, columns, and what was left out.
    type Parts = (Vec<String>, Vec<Vec<f64>>, About);

    fn read_file(builder: FileBuilder) -> Result<Parts, String> {
        let file = tempfile::Builder::new().suffix(".h5").tempfile().expect("a file");
        std::fs::write(file.path(), builder.finish().expect("written")).expect("writable");
        let mut about = About::default();
        let Arrays { names, columns, .. } = read(file.path(), &mut about).map_err(|error| error.to_string())?;
        Ok((names, columns, about))
    }

    #[test]
    fn datasets_are_columns_by_their_paths() {
        let mut builder = FileBuilder::new();
        builder.create_dataset("t").with_f64_data(&[0.0, 0.1, 0.2]);
        builder.create_dataset("k").with_i16_data(&[1, -2, 3]).with_shape(&[1, 3]);
        builder.create_dataset("wide").with_f32_data(&[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]).with_shape(&[2, 3]);
        builder.create_dataset("tall").with_u8_data(&[1, 2, 3, 4, 5, 6]).with_shape(&[3, 2]);
        builder.create_dataset("z").with_complex64_data(&[(1.0, -1.0), (2.0, -2.0), (3.0, 0.5)]);
        builder.create_dataset("rate").with_f64_data(&[16_000.0]);
        builder.create_dataset("short").with_f64_data(&[1.0, 2.0]);
        builder.create_dataset("cube").with_f64_data(&[0.0; 8]).with_shape(&[2, 2, 2]);
        builder.create_dataset("note").with_vlen_strings(&["a", "b", "c"]);
        let mut group = builder.create_group("run");
        group.create_dataset("speed").with_f64_data(&[7.0, 8.0, 9.0]);
        builder.add_group(group.finish());
        let (names, columns, about) = read_file(builder).expect("readable");
        let column = |name: &str| columns[names.iter().position(|own| own == name).expect(name)].clone();
        assert_eq!(names.len(), 10, "{names:?}");
        assert_eq!((column("t"), column("k")), (vec![0.0, 0.1, 0.2], vec![1.0, -2.0, 3.0]));
        assert_eq!((column("wide_2"), column("tall_2")), (vec![4.0, 5.0, 6.0], vec![2.0, 4.0, 6.0]));
        assert_eq!((column("z_re"), column("z_im")), (vec![1.0, 2.0, 3.0], vec![-1.0, -2.0, 0.5]));
        assert_eq!((column("run/speed"), column("rate")), (vec![7.0, 8.0, 9.0], vec![16_000.0; 3]));
        let left: Vec<&str> = about.omitted.iter().map(|own| own.place.as_str()).collect();
        assert_eq!(left, ["dataset cube", "dataset note", "array short"]);
    }

    #[test]
    fn attributes_scale_values_and_name_units() {
        let mut builder = FileBuilder::new();
        let number = |value: f64| AttrValue::F64(value);
        let text = |text: &str| AttrValue::String(text.into());
        let time = builder.create_dataset("time").with_i32_data(&[0, 10, 20]);
        time.set_attr("units", text("milliseconds since 2026-01-01"));
        let current = builder.create_dataset("i").with_i16_data(&[100, -32768, 300]);
        current.set_attr("scale_factor", number(0.01)).set_attr("add_offset", number(-1.0));
        current.set_attr("_FillValue", AttrValue::I16(-32768)).set_attr("units", text("A"));
        let speed = builder.create_dataset("w").with_f32_data(&[1.5, 1e20, -1.0]);
        speed.set_attr("missing_value", AttrValue::F32Array(vec![1e20, -1.0])).set_attr("units", text("rad s-1"));
        let odd = builder.create_dataset("odd").with_f64_data(&[1.0, 2.0, 3.0]);
        odd.set_attr("scale_factor", AttrValue::F64Array(vec![1.0, 2.0]));
        let (names, columns, about) = read_file(builder).expect("readable");
        let column = |name: &str| columns[names.iter().position(|own| own == name).expect(name)].clone();
        assert_eq!((names.len(), column("time [ms]")), (3, vec![0.0, 10.0, 20.0]));
        let current = column("i [A]");
        assert!((current[0], current[2]) == (0.0, 2.0) && current[1].is_nan(), "{current:?}");
        let speed = column("w [rad/s]");
        assert!(speed[0] == 1.5 && speed[1].is_nan() && speed[2].is_nan(), "{speed:?}");
        let told = about.notes.join("; ");
        assert!(told.contains("column i: with scale_factor 0.01, add_offset -1, 1 values"), "{told}");
        assert!(about.omitted[0].reason.contains("scale_factor is not a number"), "{about:?}");
    }

    /// The index of chunks is believed by the reader, which would take as much memory.
    #[test]
    fn chunks_that_are_larger_than_the_file_are_refused() {
        let values: Vec<f64> = (0..4000).map(f64::from).collect();
        for is_packed in [false, true] {
            let mut builder = FileBuilder::new();
            let dataset = builder.create_dataset("x").with_f64_data(&values).with_chunks(&[1000]);
            if is_packed {
                dataset.with_deflate(6);
            }
            let good = builder.finish().expect("written");
            let file = tempfile::Builder::new().suffix(".h5").tempfile().expect("a file");
            std::fs::write(file.path(), &good).expect("writable");
            let open = hdf5_pure::File::open(file.path()).expect("readable");
            let chunks = open.dataset("x").and_then(|own| own.chunks()).expect("chunks");
            let mut refused = 0;
            for chunk in chunks {
                // Wherever the index has the place of a chunk, its size follows or comes before.
                let (at, size) = (chunk.address.to_le_bytes(), chunk.storage_size);
                for place in memchr::memmem::find_iter(&good, &at) {
                    for own in place.saturating_sub(16)..place + 16 {
                        let is_size = good.get(own..own + 4) == Some(&(size as u32).to_le_bytes());
                        if !is_size {
                            continue;
                        }
                        let mut bytes = good.clone();
                        bytes[own..own + 4].copy_from_slice(&0x7000_0000_u32.to_le_bytes());
                        std::fs::write(file.path(), bytes).expect("writable");
                        refused += usize::from(read(file.path(), &mut About::default()).is_err());
                    }
                }
            }
            assert!(!is_packed || refused > 0, "{refused}");
        }
    }
}
