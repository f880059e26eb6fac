//! Columns of numbers to a file of any of the formats that can be read.

use std::path::Path;

use model::Error;
use model::outputs::cell;
use model::trace::{extensions, file_name};

/// Writes columns of equal lengths by the extension of the name.
///
/// # Errors
/// An unknown extension, a format that this program was built without, a name that MATLAB does not allow, or a file
/// that cannot be written.
pub fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let name = file_name(path);
    let known = extensions(&name).filter(|(own, _)| !super::formats::is_read_only(own));
    let Some((extension, compressed)) = known else {
        let problem =
            format!("{}: give a name that ends with .csv, .tsv, .mat, .parquet, .arrow or .npz", path.display());
        return Err(Error::Usage(problem));
    };
    match extension.as_str() {
        #[cfg(feature = "parquet")]
        "parquet" => super::arrow_writer::parquet(path, names, columns),
        #[cfg(feature = "parquet")]
        "arrow" | "feather" => super::arrow_writer::ipc(path, names, columns),
        #[cfg(feature = "numpy")]
        "npz" => super::numpy::write(path, names, columns).map_err(Error::io(path)),
        #[cfg(feature = "matlab")]
        "mat" => super::matlab::write(path, names, columns),
        binary if super::formats::is_binary(binary) => Err(super::formats::left_out(path, binary)),
        _ => {
            let text = text(names, columns, if extension == "tsv" { '\t' } else { ',' });
            let packed = match compressed {
                false => Ok(text.into_bytes()),
                true => super::unpack::packed(path, &text)?,
            };
            packed.and_then(|bytes| std::fs::write(path, bytes)).map_err(Error::io(path))
        }
    }
}

/// A number in the shortest form that is read back as the same bits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-4..1e15).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn text(names: &[String], columns: &[Vec<f64>], separator: char) -> String {
    let quoted = |name: &String| {
        let name = cell(name);
        match name.contains([separator, '"', '\n', '\r', '\t']) {
            true => format!("\"{}\"", name.replace('"', "\"\"")),
            false => name.into_owned(),
        }
    };
    let mut text = names.iter().map(quoted).collect::<Vec<_>>().join(&separator.to_string());
    text.push('\n');
    for row in 0..columns.first().map_or(0, Vec::len) {
        for (k, column) in columns.iter().enumerate() {
            if k > 0 {
                text.push(separator);
            }
            text.push_str(&number(column[row]));
        }
        text.push('\n');
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::table::{Table, Wanted};

    #[test]
    fn every_format_gives_back_the_same_bits() {
        let names = ["t_s".to_string(), "current_a".into()];
        let columns = [vec![0.0, 0.1, 0.2, 1e-7], vec![-0.1, 1.0 / 3.0, f64::MIN_POSITIVE, 1e14 + 0.015_625]];
        let folder = tempfile::tempdir().expect("a folder");
        for name in ["a.csv", "a.tsv", "a.csv.gz", "a.txt.zst", "a.mat", "a.parquet", "a.arrow", "a.npz"] {
            let path = folder.path().join(name);
            write(&path, &names, &columns).expect(name);
            let table = Table::open(&path).expect(name);
            // Archives may order their arrays.
            let places: Vec<usize> =
                names.iter().map(|own| table.names().iter().position(|other| other == own).expect(name)).collect();
            let read = table.read(Wanted { numbers: &places, text: None, row: &|_| true }).expect(name);
            assert_eq!(read.numbers, columns, "{name}");
        }
        // A name that a spreadsheet would compute is written as text, and read as it was.
        let formula = ["=1+1".to_string(), "-x".into()];
        let path = folder.path().join("f.csv");
        write(&path, &formula, &columns).expect("written");
        let text = std::fs::read_to_string(&path).expect("text");
        assert!(text.starts_with("'=1+1,'-x\n0,-0.1\n"), "{text}");
        assert_eq!(Table::open(&path).expect("read").names(), formula);
        assert!(write(&folder.path().join("a.xls"), &names, &columns).is_err());
        let wrong = write(&folder.path().join("a.mat"), &["i [A]".into()], &columns[..1]).expect_err("a bracket");
        assert!(wrong.to_string().contains("MATLAB allows no such name"), "{wrong}");
    }
}
