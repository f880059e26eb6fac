//! Columns of numbers to a file of any of the formats that can be read.

use std::fs::File;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use arrow_array::{ArrayRef, Float64Array, RecordBatch};
use arrow_ipc::writer::FileWriter;
use matrw::{MatFile, MatVariable};
use npyz::WriterBuilder as _;
use parquet::arrow::ArrowWriter;

use super::extensions;
use crate::Error;

/// Writes columns of equal lengths by the extension of the name.
///
/// # Errors
/// An unknown extension, a name that MATLAB does not allow, or a file that cannot be written.
pub(crate) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let wrong = |problem: String| Error::content(path, "content", problem);
    let Some((extension, compressed)) = extensions(&name) else {
        let problem =
            format!("{}: give a name that ends with .csv, .tsv, .mat, .parquet, .arrow or .npz", path.display());
        return Err(Error::Usage(problem));
    };
    match extension.as_str() {
        "parquet" => {
            let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
            let mut writer = ArrowWriter::try_new(file, batch.schema(), None).map_err(|e| wrong(e.to_string()))?;
            writer.write(&batch).and_then(|()| writer.close()).map(|_| ()).map_err(|e| wrong(e.to_string()))
        }
        "arrow" | "feather" => {
            let (file, batch) = (create(path)?, batch(names, columns).map_err(wrong)?);
            let mut writer = FileWriter::try_new(file, &batch.schema()).map_err(|e| wrong(e.to_string()))?;
            writer.write(&batch).and_then(|()| writer.finish()).map_err(|e| wrong(e.to_string()))
        }
        "npz" => numpy(path, names, columns).map_err(Error::io(path)),
        "mat" => matlab(path, names, columns),
        _ => {
            let text = text(names, columns, if extension == "tsv" { '\t' } else { ',' });
            let packed = match (compressed, name.to_ascii_lowercase().ends_with(".gz")) {
                (false, _) => Ok(text.into_bytes()),
                (true, true) => {
                    let mut writer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
                    writer.write_all(text.as_bytes()).and_then(|()| writer.finish())
                }
                (true, false) => zstd::encode_all(text.as_bytes(), 0),
            };
            packed.and_then(|bytes| std::fs::write(path, bytes)).map_err(Error::io(path))
        }
    }
}

fn create(path: &Path) -> Result<File, Error> {
    File::create(path).map_err(Error::io(path))
}

fn batch(names: &[String], columns: &[Vec<f64>]) -> Result<RecordBatch, String> {
    let array = |column: &Vec<f64>| Arc::new(Float64Array::from(column.clone())) as ArrayRef;
    RecordBatch::try_from_iter(names.iter().zip(columns.iter().map(array))).map_err(|error| error.to_string())
}

/// A number in the shortest form that is read back as the same bits.
fn number(x: f64) -> String {
    if x == 0.0 || (1e-4..1e15).contains(&x.abs()) { x.to_string() } else { format!("{x:e}") }
}

fn text(names: &[String], columns: &[Vec<f64>], separator: char) -> String {
    let quoted = |name: &String| match name.contains([separator, '"', '\n']) {
        true => format!("\"{}\"", name.replace('"', "\"\"")),
        false => name.clone(),
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

fn numpy(path: &Path, names: &[String], columns: &[Vec<f64>]) -> std::io::Result<()> {
    let mut archive = zip::ZipWriter::new(File::create(path)?);
    for (name, column) in names.iter().zip(columns) {
        archive.start_file(format!("{name}.npy"), zip::write::SimpleFileOptions::default())?;
        let mut writer =
            npyz::WriteOptions::new().default_dtype().shape(&[column.len() as u64]).writer(&mut archive).begin_nd()?;
        writer.extend(column)?;
        writer.finish()?;
    }
    archive.finish()?;
    Ok(())
}

fn matlab(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
    let mut file = MatFile::new();
    for (name, column) in names.iter().zip(columns) {
        let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(allowed) || name.len() > 63 {
            let problem = "MATLAB allows no such name; give another one with NAME=CHANNEL";
            return Err(Error::content(path, format!("column {name}"), problem));
        }
        file.insert(name, MatVariable::from(column.clone()));
    }
    let name = path.to_string_lossy();
    matrw::save_matfile_v7(&name, file, true).map_err(|error| Error::content(path, "content", error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::super::{Table, Wanted};
    use super::*;

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
        assert!(write(&folder.path().join("a.xls"), &names, &columns).is_err());
        let wrong = write(&folder.path().join("a.mat"), &["i [A]".into()], &columns[..1]).expect_err("a bracket");
        assert!(wrong.to_string().contains("MATLAB allows no such name"), "{wrong}");
    }
}
