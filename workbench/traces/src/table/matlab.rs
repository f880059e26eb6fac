//! MATLAB files: variables of formats 4 to 7, and of format 7.3, which is HDF5.
//!
//! ```text
//! x, y            vectors of one length     columns x, y
//! m               a matrix                  columns m_1, m_2, …, along its longer side
//! s.a, s.b        fields of a structure     columns s.a, s.b; a, b if s is the only variable
//! s.signals(k)    "structure with time"     column of the signal's label, beside s.time
//! s.Y(k)          channels with Name, Data  column of the channel's name; those of s.X are times
//! r               a number                  a constant column
//! z               complex numbers           columns z_re, z_im
//! data(k).a       a structure array         traces, if these are records ([`super::records`])
//! ```
//!
//! The longest arrays are the columns; arrays of other lengths, text and objects are left out, and named.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use hdf5_pure::mat::MatError;
use matrw::{MatFile, MatVariable};

use crate::damaged::guarded;
use crate::table::about::About;
use crate::table::arrays::{along_longer, only_variable};
use crate::table::groups::Named;
use crate::table::matlab_value::{OBJECT, Value};
use crate::table::records::{Arrays, columns_of};
use crate::table::{hdf5_links, limit, matlab_4, matlab_arrays, matlab_elements, matlab_hdf5, time_name};
use model::Error;

/// What a file of format 7.3 has behind its text header.
const HDF5_AT: usize = 512;
const HDF5: &[u8] = b"\x89HDF";
/// Elements of a list of single numbers or texts that become constant columns, at most.
const FEW: usize = 64;

/// The formats of these files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Format {
    Four,
    Elements,
    Hdf5,
}

impl Format {
    /// By the first bytes of a file.
    fn of(head: &[u8]) -> Option<Self> {
        if head.starts_with(HDF5) || head.get(HDF5_AT..).is_some_and(|rest| rest.starts_with(HDF5)) {
            Some(Self::Hdf5)
        } else if matlab_elements::is_header(head) {
            Some(Self::Elements)
        } else {
            matlab_4::is_header(head).then_some(Self::Four)
        }
    }
}

/// Returns names and columns, of one record or of several.
pub(super) fn read(path: &Path, about: &mut About) -> Result<Arrays, Error> {
    let unreadable = || {
        let problem = "not readable as a MATLAB file of format 4 to 7.3; save it again, e.g. with -v7";
        Error::content(path, "content", problem)
    };
    let mut head = Vec::new();
    let file = File::open(path).map_err(Error::io(path))?;
    // A file that is something else may be large.
    file.take((HDF5_AT + HDF5.len()) as u64).read_to_end(&mut head).map_err(Error::io(path))?;
    let format = Format::of(&head).ok_or_else(unreadable)?;
    let bytes = limit::whole(path)?;
    let value = guarded(|| match format {
        Format::Hdf5 => of_hdf5(&bytes, about),
        Format::Elements => variables(&bytes),
        Format::Four => Ok(matlab_4::variables(&bytes)),
    });
    let value = value.unwrap_or(Ok(None)).map_err(|problem| Error::content(path, "content", problem))?;
    let Some(Value::Fields(variables)) = value else { return Err(unreadable()) };
    columns_of_variables(path, &variables, about)
}

/// The columns of variables, of one record or of several.
///
/// # Errors
/// No arrays of numbers, or more than the limit.
pub(super) fn columns_of_variables(
    path: &Path,
    variables: &[(String, Value)],
    about: &mut About,
) -> Result<Arrays, Error> {
    let mut found = Found { columns: Vec::new(), axes: Vec::new(), about };
    for (name, value) in variables {
        found.add(name, value);
    }
    let Found { mut columns, mut axes, about } = found;
    let objects = about.omitted.iter().filter(|own| own.reason == OBJECT);
    if let Some(first) = objects.clone().next().filter(|_| columns.is_empty()) {
        let problem = format!("nothing but {OBJECT}");
        return Err(Error::content(path, first.place.clone(), problem));
    }
    if let Some(alone) = only_variable(&columns) {
        columns.iter_mut().map(|(name, _)| name).chain(&mut axes).for_each(|name| *name = name[alone..].to_string());
    }
    let own = columns_of(path, columns, about)?;
    let is_axis = |place: &usize| axes.contains(&own.names[*place]) && time_name::rises(&own.columns[*place]);
    about.clocks.extend((0..own.names.len()).find(is_axis));
    Ok(own)
}

/// Reads the variables of format 7.3.
fn of_hdf5(bytes: &[u8], about: &mut About) -> Result<Option<Value>, String> {
    matlab_hdf5::check(bytes)?;
    let links = hdf5_links::links(bytes);
    let first = links.first().map(|(place, reason)| format!("{place} is {reason}; replace it by the array"));
    links.into_iter().for_each(|(place, reason)| about.omit(place, reason));
    let unreadable = |error: MatError| {
        let cause = first.unwrap_or_else(|| error.to_string());
        format!("not readable as a MATLAB file of format 7.3: {cause}, or save it with -v7")
    };
    hdf5_pure::mat::from_bytes(bytes).map(Some).map_err(unreadable)
}

/// Reads the variables of format 5 to 7.
fn variables(bytes: &[u8]) -> Result<Option<Value>, String> {
    let Some(plain) = matlab_elements::unpacked(bytes)? else { return Ok(None) };
    let Some((arrays, is_little)) = matlab_elements::outermost(&plain) else { return Ok(None) };
    let named = arrays.into_iter().map(|content| matlab_arrays::named(content, is_little));
    // Objects have their content in an array without a name.
    Ok(Some(Value::Fields(named.filter(|(name, _)| !name.is_empty()).collect())))
}

/// What is found of a file.
struct Found<'a> {
    columns: Named,
    /// Names of the columns that are channels of a field X, which are the times of those of Y.
    axes: Vec<String>,
    about: &'a mut About,
}

impl Found<'_> {
    /// Adds the columns of a value.
    fn add(&mut self, name: &str, value: &Value) {
        if let Some((label, data)) = channel(value) {
            // Beside its list, if no other column has its name there.
            let list = name.split_once('(').map_or(name, |(list, _)| list);
            let short = list.rsplit_once('.').map_or(label.to_string(), |(outer, _)| format!("{outer}.{label}"));
            let is_taken = self.columns.iter().any(|(own, _)| *own == short);
            let name = if is_taken { format!("{list}.{label}") } else { short };
            if list.ends_with(".X") {
                self.axes.push(name.clone());
            }
            return self.add(&name, data);
        }
        match value {
            Value::Numbers { rows, values } => self.columns.extend(arrays(name, *rows, values)),
            Value::Complex { rows, re, im } => {
                self.columns.extend(arrays(&format!("{name}_re"), *rows, re));
                self.columns.extend(arrays(&format!("{name}_im"), *rows, im));
            }
            Value::Fields(fields) => {
                for (field, value) in fields {
                    if field == "signals" {
                        self.signals(name, value);
                    } else {
                        self.add(&format!("{name}.{field}"), value);
                    }
                }
            }
            Value::List(elements) if elements.len() > FEW && elements.iter().all(is_single) => {
                self.omit(name, &format!("a list of {} single values: save it as a vector", elements.len()));
            }
            Value::List(elements) => {
                for (k, element) in elements.iter().enumerate() {
                    self.add(&format!("{name}({})", k + 1), element);
                }
            }
            Value::Text(_) => self.omit(name, "text"),
            Value::Other(reason) => self.omit(name, reason),
        }
    }

    fn omit(&mut self, name: &str, reason: &str) {
        self.about.omit(format!("array {name}"), reason);
    }

    /// The signals of a "structure with time", by their labels.
    fn signals(&mut self, name: &str, value: &Value) {
        let one = std::slice::from_ref(value);
        let list = if let Value::List(list) = value { list } else { one };
        for (k, signal) in list.iter().enumerate() {
            let Value::Fields(fields) = signal else { continue };
            let field = |wanted: &str| fields.iter().find(|(name, _)| name == wanted).map(|(_, value)| value);
            let label = match field("label") {
                Some(Value::Text(label)) if !label.trim().is_empty() => label.trim().to_string(),
                _ => format!("signal_{}", k + 1),
            };
            if let Some(values) = field("values") {
                self.add(&format!("{name}.{label}"), values);
            }
        }
    }
}

/// Name and data of a channel.
fn channel(value: &Value) -> Option<(&str, &Value)> {
    let Value::Fields(fields) = value else { return None };
    let field = |wanted: &str| fields.iter().find(|(name, _)| name.eq_ignore_ascii_case(wanted)).map(|(_, own)| own);
    match (field("name")?, field("data")?) {
        (Value::Text(label), data @ Value::Numbers { .. }) if !label.trim().is_empty() => Some((label.trim(), data)),
        _ => None,
    }
}

/// Whether a value has no array.
fn is_single(value: &Value) -> bool {
    match value {
        Value::Numbers { values, .. } => values.len() == 1,
        Value::Complex { re, .. } => re.len() == 1,
        Value::Fields(fields) => fields.iter().all(|(_, own)| is_single(own)),
        Value::List(_) => false,
        Value::Text(_) | Value::Other(_) => true,
    }
}

/// The columns of an array, along its longer side.
fn arrays(name: &str, rows: usize, values: &[f64]) -> Named {
    let across = values.len().checked_div(rows).unwrap_or(0);
    if rows <= 1 || across <= 1 {
        return if values.is_empty() { vec![] } else { vec![(name.to_string(), values.to_vec())] };
    }
    (1..).map(|k| format!("{name}_{k}")).zip(along_longer([rows, across], false, values)).collect()
}

/// Writes a file of format 7.
pub(super) fn write(path: &Path, names: &[String], columns: &[Vec<f64>]) -> Result<(), Error> {
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
    use serde::Serialize;

    use super::*;

    fn read_bytes(bytes: &[u8]) -> Result<(Vec<String>, Vec<Vec<f64>>), String> {
        let file = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file");
        std::fs::write(file.path(), bytes).expect("writable");
        let Arrays { names, columns, .. } =
            read(file.path(), &mut About::default()).map_err(|error| error.to_string())?;
        Ok((names, columns))
    }

    #[test]
    fn structures_with_time_and_plain_vectors_become_columns() {
        let signal = |label: &str, values: Vec<f64>| {
            let numbers = Value::Numbers { rows: values.len(), values };
            Value::Fields(vec![("values".into(), numbers), ("label".into(), Value::Text(label.into()))])
        };
        let with_time = Value::Fields(vec![
            ("time".into(), Value::Numbers { rows: 2, values: vec![0.0, 0.1] }),
            ("signals".into(), Value::List(vec![signal("i", vec![1.0, 2.0]), signal("", vec![3.0, 4.0])])),
            ("blockName".into(), Value::Text("model".into())),
        ]);
        let mut about = About::default();
        let mut found = Found { columns: vec![], axes: vec![], about: &mut about };
        found.add("log", &with_time);
        let found = found.columns;
        let names: Vec<&str> = found.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["log.time", "log.i", "log.signal_2"]);
        assert_eq!(only_variable(&found), Some(4));
        assert_eq!(about.omitted.iter().map(|own| own.place.as_str()).collect::<Vec<_>>(), ["array log.blockName"]);
        let mut found = arrays("m", 3, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        found.extend(arrays("w", 2, &[1.0, 4.0, 2.0, 5.0, 3.0, 6.0]));
        let columns = [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]].map(|column| column.to_vec());
        assert_eq!(
            found.iter().map(|(_, column)| column.clone()).collect::<Vec<_>>(),
            [columns.clone(), columns].concat()
        );
    }

    #[test]
    fn channels_of_a_structure_are_columns_of_their_names() {
        let channel = |name: &str, values: &[f64]| {
            let data = Value::Numbers { rows: values.len(), values: values.to_vec() };
            let text = |text: &str| Value::Text(text.into());
            Value::Fields(vec![("Name".into(), text(name)), ("Type".into(), text("f")), ("Data".into(), data)])
        };
        let fast = [channel("phase_current_1", &[1.0, 2.0]), channel("force", &[3.0]), channel("t", &[7.0, 8.0])];
        let run = Value::Fields(vec![
            ("X".into(), Value::List(vec![channel("t", &[0.0, 0.5])])),
            ("Y".into(), Value::List(fast.to_vec())),
        ]);
        let mut about = About::default();
        let mut found = Found { columns: vec![], axes: vec![], about: &mut about };
        found.add("N09_1", &run);
        let names: Vec<&str> = found.columns.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["N09_1.t", "N09_1.phase_current_1", "N09_1.force", "N09_1.Y.t"]);
        assert_eq!(found.axes, ["N09_1.t"]);
        assert_eq!((found.columns[1].1.clone(), about.omitted.len()), (vec![1.0, 2.0], 0));
    }

    #[derive(Serialize)]
    struct File {
        time: Vec<f64>,
        pair: Vec<Vec<f64>>,
        rpm: f64,
        note: String,
        log: Log,
    }

    #[derive(Serialize)]
    struct Log {
        current: Vec<f32>,
        short: Vec<i16>,
    }

    #[test]
    fn format_7_3_gives_the_same_columns() {
        let log = Log { current: vec![0.5, 1.5, 2.5], short: vec![1, 2] };
        let pair = vec![vec![1.0, 4.0], vec![2.0, 5.0], vec![3.0, 6.0]];
        let file = File { time: vec![0.0, 0.1, 0.2], pair, rpm: 1500.0, note: "x".into(), log };
        let (names, columns) = read_bytes(&hdf5_pure::mat::to_bytes(&file).expect("written")).expect("read");
        let column = |name: &str| names.iter().position(|own| own == name).map(|place| columns[place].clone());
        assert_eq!(column("time"), Some(vec![0.0, 0.1, 0.2]), "{names:?}");
        assert_eq!(column("pair_2"), Some(vec![4.0, 5.0, 6.0]), "{names:?}");
        assert_eq!(column("rpm"), Some(vec![1500.0; 3]));
        assert_eq!(column("log.current"), Some(vec![0.5, 1.5, 2.5]));
        assert_eq!((column("log.short"), column("note")), (None, None));
    }

    /// Each complex number comes as a structure.
    #[test]
    fn complex_numbers_and_lists_of_format_7_3_are_columns() {
        use hdf5_pure::mat::Complex64;

        #[derive(Serialize)]
        struct File {
            z: Vec<Complex64>,
            pair: Vec<Vec<Complex64>>,
            cells: (Vec<f64>, Vec<f64>, String),
        }
        let number = |k: usize| Complex64::new(k as f64, 0.5 - k as f64);
        let z: Vec<Complex64> = (0..20_000).map(number).collect();
        let pair = z.iter().map(|own| vec![*own, number(3)]).collect();
        let file = File { z, pair, cells: (vec![1.0; 20_000], vec![2.0, 3.0], "x".into()) };
        let (names, columns) = read_bytes(&hdf5_pure::mat::to_bytes(&file).expect("written")).expect("read");
        let column = |name: &str| &columns[names.iter().position(|own| own == name).expect("a column")];
        assert_eq!(names.len(), 7, "{names:?}");
        assert_eq!((column("z_re")[7], column("z_im")[7], column("pair_re_1")[7]), (7.0, -6.5, 7.0));
        assert_eq!((column("pair_im_2")[9], column("cells(1)")[3]), (-2.5, 1.0));
    }

    /// Only the first bytes are looked at.
    #[test]
    fn a_large_file_of_another_kind_is_refused_at_once() {
        let file = tempfile::Builder::new().suffix(".mat").tempfile().expect("a file");
        std::fs::write(file.path(), [0x5A; 600]).expect("writable");
        file.as_file().set_len(1 << 31).expect("without content");
        let refused = read(file.path(), &mut About::default()).expect_err("no file of MATLAB").to_string();
        assert!(refused.contains("not readable as a MATLAB file"), "{refused}");
    }

    #[test]
    fn damaged_files_are_refused() {
        let file = matrw::matfile!(x: matrw::matvar!([1.0, 2.0, 3.0]));
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("x.mat");
        matrw::save_matfile_v7(&path.to_string_lossy(), file, false).expect("written");
        let good = std::fs::read(&path).expect("read");
        assert_eq!(read_bytes(&good).expect("good").1, [[1.0, 2.0, 3.0]]);
        for length in [0, 5, 127, 130, good.len() - 7] {
            let problem = read_bytes(&good[..length]).expect_err("cut");
            assert!(problem.contains("not readable as a MATLAB file") || problem.contains("no arrays"), "{problem}");
        }
    }
}
