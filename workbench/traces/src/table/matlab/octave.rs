//! Text of Octave's `save`: variables one after the other, each under lines that tell its name, type and sides.
//!
//! ```text
//! # name: i               # name: fs           # name: run
//! # type: matrix          # type: scalar       # type: scalar struct
//! # rows: 3               1000                 # ndims: 2
//! # columns: 1                                  1 1
//!  0.5                                         # length: 1
//!  1.5                                         # name: speed
//!  2.5                                         # type: matrix …
//! ```
//!
//! The values become columns as those of MATLAB's files do.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::table::arrays::records::Arrays;
use crate::table::columns::About;
use crate::table::limit;
use crate::table::matlab::value::{SPARSE, Value};
use crate::table::matlab::variables::columns_of_variables;
use model::Error;

/// Bytes in which the first variable begins.
const HEAD: usize = 4 << 10;
/// Deepest structure or cell.
const DEEPEST: usize = 64;

/// Reads a file, if it is one of Octave's text.
///
/// # Errors
/// A file that cannot be read, ends early or has no arrays of numbers.
pub(in crate::table) fn read(path: &Path, about: &mut About) -> Result<Option<Arrays>, Error> {
    let mut head = Vec::new();
    File::open(path).map_err(Error::io(path))?.take(HEAD as u64).read_to_end(&mut head).map_err(Error::io(path))?;
    if !is_header(&String::from_utf8_lossy(&head)) {
        return Ok(None);
    }
    let bytes = limit::whole(path)?;
    let text = String::from_utf8_lossy(&bytes);
    let variables = variables(&text).map_err(|(line, problem)| {
        Error::content(path, format!("line {line}"), format!("not readable as Octave's text: {problem}"))
    })?;
    columns_of_variables(path, &variables, about).map(Some)
}

/// Whether a text begins as Octave's.
fn is_header(head: &str) -> bool {
    let lines: Vec<&str> = head.lines().collect();
    let ends = ["matrix", "scalar", "struct", "string", "cell", "range", "bool"];
    let is_type = |line: &str| told(line, "type").is_some_and(|kind| ends.iter().any(|end| kind.ends_with(end)));
    lines.windows(2).any(|pair| told(pair[0], "name").is_some() && is_type(pair[1]))
}

/// What a line such as `# rows: 3` tells.
fn told<'a>(line: &'a str, key: &str) -> Option<&'a str> {
    let rest = line.strip_prefix(['#', '%'])?.trim_start();
    Some(rest.strip_prefix(key)?.strip_prefix(':')?.trim())
}

/// A line and what is wrong there.
type Wrong = (usize, String);

fn variables(text: &str) -> Result<Vec<(String, Value)>, Wrong> {
    let mut lines = Lines { all: text.lines().collect(), at: 0 };
    let mut variables = Vec::new();
    while let Some(name) = lines.name() {
        variables.push((name, lines.value(0)?));
    }
    Ok(variables)
}

struct Lines<'a> {
    all: Vec<&'a str>,
    at: usize,
}

impl<'a> Lines<'a> {
    /// The next line that is not empty.
    fn next(&mut self) -> Option<&'a str> {
        while let Some(line) = self.all.get(self.at) {
            self.at += 1;
            if !line.trim().is_empty() {
                return Some(line);
            }
        }
        None
    }

    /// What the next line tells, if it has this key.
    fn told(&mut self, key: &str) -> Option<&'a str> {
        let before = self.at;
        let found = self.next().and_then(|line| told(line, key));
        if found.is_none() {
            self.at = before;
        }
        found
    }

    /// The name of the next variable; what is before it is left out.
    fn name(&mut self) -> Option<String> {
        while let Some(line) = self.next() {
            if let Some(name) = told(line, "name") {
                return Some(name.to_string());
            }
        }
        None
    }

    fn wrong<T>(&self, problem: &str) -> Result<T, Wrong> {
        Err((self.at, format!("{problem}; save it again, e.g. with -v7")))
    }

    /// A number that a line with this key tells.
    fn count(&mut self, key: &str) -> Result<usize, Wrong> {
        match self.told(key).and_then(|number| number.parse().ok()) {
            Some(number) => Ok(number),
            None => self.wrong(&format!("no number of {key}")),
        }
    }

    fn value(&mut self, depth: usize) -> Result<Value, Wrong> {
        let Some(kind) = self.told("type").filter(|_| depth < DEEPEST) else { return self.wrong("no type") };
        let kind = kind.strip_prefix("global ").unwrap_or(kind);
        let is_complex = kind.contains("complex");
        match kind {
            "string" | "sq_string" => self.text(),
            "range" | "double_range" => self.range(),
            "cell" => self.cells(depth),
            "scalar struct" => self.sides().and_then(|_| self.fields(depth)).map(Value::Fields),
            "struct" => self.structures(depth),
            _ if kind.contains("sparse") || kind.contains("diagonal") => Ok(Value::Other(SPARSE)),
            _ if kind.ends_with("matrix") => self.matrix(is_complex),
            _ if kind.ends_with("scalar") || kind == "bool" => {
                let numbers = self.numbers(1, is_complex)?;
                Ok(value(&[1, 1], numbers, false))
            }
            _ => Ok(Value::Other("of a type that is not read: save it as a matrix")),
        }
    }

    /// Sides, if a line tells their number.
    fn sides(&mut self) -> Result<Vec<usize>, Wrong> {
        if self.told("ndims").is_none() {
            return Ok(vec![]);
        }
        let sides = self.next().map(|line| line.split_whitespace().map(str::parse).collect::<Result<_, _>>());
        match sides {
            Some(Ok(sides)) => Ok(sides),
            _ => self.wrong("no sides"),
        }
    }

    fn matrix(&mut self, is_complex: bool) -> Result<Value, Wrong> {
        let sides = self.sides()?;
        let by_rows = sides.is_empty();
        let sides = if by_rows { vec![self.count("rows")?, self.count("columns")?] } else { sides };
        let numbers = self.numbers(sides.iter().fold(1, |count, side| count.saturating_mul(*side)), is_complex)?;
        Ok(value(&sides, numbers, by_rows))
    }

    /// Real and imaginary parts of as many numbers.
    fn numbers(&mut self, count: usize, is_complex: bool) -> Result<[Vec<f64>; 2], Wrong> {
        let (mut re, mut im) = (Vec::new(), Vec::new());
        while re.len() < count {
            let Some(line) = self.next().filter(|line| !line.starts_with(['#', '%'])) else {
                return self.wrong(&format!("{} of {count} values", re.len()));
            };
            for cell in line.split_whitespace() {
                let parts = cell.strip_prefix('(').and_then(|rest| rest.strip_suffix(')')?.split_once(','));
                let (one, other) = parts.unwrap_or((cell, "0"));
                let (Some(one), Some(other)) = (number(one), number(other)) else {
                    return self.wrong(&format!("\"{cell}\" is not a number"));
                };
                re.push(one);
                im.extend(is_complex.then_some(other));
            }
        }
        if re.len() == count { Ok([re, im]) } else { self.wrong(&format!("{} of {count} values", re.len())) }
    }

    /// Base, limit and increment.
    fn range(&mut self) -> Result<Value, Wrong> {
        let line = std::iter::from_fn(|| self.next()).find(|line| !line.starts_with(['#', '%']));
        let parts: Option<Vec<f64>> = line.and_then(|line| line.split_whitespace().map(number).collect());
        match parts.as_deref() {
            Some([base, limit, step]) if *step != 0.0 && (limit - base) / step < 1e9 => {
                let count = ((limit - base) / step * (1.0 + f64::EPSILON) + 1e-9).floor();
                let values: Vec<f64> = (0..=count.max(-1.0) as i64).map(|k| base + k as f64 * step).collect();
                Ok(Value::array(&[values.len(), 1], if count < 0.0 { vec![] } else { values }))
            }
            _ => self.wrong("no base, limit and increment"),
        }
    }

    fn text(&mut self) -> Result<Value, Wrong> {
        let mut text = String::new();
        for _ in 0..self.count("elements")? {
            if self.count("length")? > 0 {
                text += self.all.get(self.at).copied().unwrap_or_default();
                self.at += 1;
            }
        }
        Ok(Value::Text(text))
    }

    fn cells(&mut self, depth: usize) -> Result<Value, Wrong> {
        let sides = self.sides()?;
        let sides = if sides.is_empty() { vec![self.count("rows")?, self.count("columns")?] } else { sides };
        let mut cells = Vec::new();
        for _ in 0..sides.iter().fold(1, |count: usize, side| count.saturating_mul(*side)) {
            if self.name().is_none() {
                return self.wrong("cells are missing");
            }
            cells.push(self.value(depth + 1)?);
        }
        Ok(Value::List(cells))
    }

    fn fields(&mut self, depth: usize) -> Result<Vec<(String, Value)>, Wrong> {
        let mut fields = Vec::new();
        for _ in 0..self.count("length")? {
            let Some(name) = self.name() else { return self.wrong("fields are missing") };
            fields.push((name, self.value(depth + 1)?));
        }
        Ok(fields)
    }

    /// Structures, of which each field has a list of the values in all of them.
    fn structures(&mut self, depth: usize) -> Result<Value, Wrong> {
        let count = self.sides()?.iter().fold(1, |count: usize, side| count.saturating_mul(*side));
        let fields = self.fields(depth)?;
        let of_field = |k: usize, (name, value): &(String, Value)| {
            let Value::List(all) = value else { return None };
            Some((name.clone(), all.get(k)?.clone()))
        };
        let longest = fields.iter().map(|(_, own)| if let Value::List(all) = own { all.len() } else { 0 }).max();
        let each = (0..count.min(longest.unwrap_or(0)))
            .map(|k| Value::Fields(fields.iter().filter_map(|field| of_field(k, field)).collect()));
        Ok(Value::List(each.collect()))
    }
}

fn number(text: &str) -> Option<f64> {
    if text == "NA" { Some(f64::NAN) } else { text.parse().ok() }
}

/// An array of these sides, whose values are row by row or column by column.
fn value(sides: &[usize], [re, im]: [Vec<f64>; 2], by_rows: bool) -> Value {
    let by_columns = |values: Vec<f64>| match *sides {
        [rows, columns] if by_rows && rows > 1 && columns > 1 => {
            (0..values.len()).map(|k| values[k % rows * columns + k / rows]).collect()
        }
        _ => values,
    };
    let is_complex = !im.is_empty();
    match Value::array(sides, by_columns(re)) {
        Value::Numbers { rows, values: re } if is_complex => Value::Complex { rows, re, im: by_columns(im) },
        other => other,
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use crate::table::Table;

    fn open(name: &str, text: &str) -> Result<(Table, Vec<Vec<f64>>), String> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(name);
        std::fs::write(&path, text).expect("writable");
        let table = Table::open(&path).map_err(|error| error.to_string())?;
        let columns =
            table.read_each(&(0..table.names().len()).collect::<Vec<_>>()).map_err(|error| error.to_string())?;
        let columns = columns.into_iter().map(|column| column.unwrap_or_default()).collect();
        Ok((table, columns))
    }

    fn matrix(name: &str, kind: &str, rows: &[&str], columns: usize) -> String {
        let mut text = format!("# name: {name}\n# type: {kind}\n# rows: {}\n# columns: {columns}\n", rows.len());
        rows.iter().for_each(|row| writeln!(text, " {row}").expect("a text"));
        text + "\n\n"
    }

    const CREATED: &str = "# Created by Octave 8.4.0, Thu Mar 05 10:00:00 2026 UTC <u@h>\n";

    #[test]
    fn matrices_numbers_and_ranges_are_columns() {
        let text = [
            CREATED.into(),
            matrix("time", "matrix", &["0", "0.5", "1"], 1),
            matrix("m", "float matrix", &["1 2", "3 NA", "5 -Inf"], 2),
            matrix("w", "matrix", &["7 8 9"], 3),
            matrix("z", "complex matrix", &["(1,2)", "(3,4)", "(5,-6)"], 1),
            "# name: k\n# type: int16 matrix\n# ndims: 2\n 3 1\n  4\n  5\n  6\n\n".into(),
            "# name: fs\n# type: scalar\n1000\n\n\n# name: r\n# type: range\n# base, limit, increment\n0 1 0.5\n\n"
                .into(),
            "# name: note\n# type: string\n# elements: 1\n# length: 5\n# new\n\n\n".into(),
        ];
        for name in ["m.txt", "m.mat", "m.dat"] {
            let (table, columns) = open(name, &text.concat()).expect("Octave's text");
            assert_eq!(table.names(), ["time", "m_1", "m_2", "w", "z_re", "z_im", "k", "fs", "r"]);
            assert_eq!((&columns[0], &columns[1]), (&vec![0.0, 0.5, 1.0], &vec![1.0, 3.0, 5.0]));
            assert_eq!((columns[2][0], columns[2][1].is_nan()), (2.0, true));
            assert_eq!((&columns[3], &columns[5]), (&vec![7.0, 8.0, 9.0], &vec![2.0, 4.0, -6.0]));
            assert_eq!((&columns[6], &columns[8]), (&vec![4.0, 5.0, 6.0], &vec![0.0, 0.5, 1.0]));
            assert_eq!(table.about().omitted.iter().map(|own| own.place.as_str()).collect::<Vec<_>>(), ["array note"]);
        }
    }

    #[test]
    fn structures_are_columns_and_those_of_an_array_are_traces() {
        let inner = matrix("t", "matrix", &["0", "1", "2"], 1) + &matrix("i", "matrix", &["3", "4", "5"], 1);
        let one = format!("# name: run\n# type: scalar struct\n# ndims: 2\n 1 1\n# length: 2\n{inner}");
        let (table, columns) = open("s.txt", &format!("{CREATED}{one}")).expect("a structure");
        assert_eq!((table.names().join(" "), &columns[1]), ("t i".into(), &vec![3.0, 4.0, 5.0]));
        let cell = |name: &str| {
            let cells = matrix("<cell-element>", "matrix", &["0", "1", "2"], 1)
                + &matrix("<cell-element>", "matrix", &["4", "5"], 1);
            format!("# name: {name}\n# type: cell\n# rows: 1\n# columns: 2\n{cells}\n")
        };
        let two = format!("# name: run\n# type: struct\n# ndims: 2\n 1 2\n# length: 2\n{}{}", cell("t"), cell("i"));
        let (table, columns) = open("s.txt", &format!("{CREATED}{two}")).expect("two structures");
        assert_eq!(table.names(), ["trace", "t", "i"]);
        assert_eq!(columns[2], [0.0, 1.0, 2.0, 4.0, 5.0]);
    }

    #[test]
    fn a_cut_or_odd_file_is_refused_and_other_comments_are_no_octave() {
        let text = format!("{CREATED}{}", matrix("t", "matrix", &["0", "1", "2"], 1));
        let cut = open("m.txt", text.trim_end().trim_end_matches('2')).map(|_| ()).expect_err("cut");
        assert!(cut.contains("line 8") && cut.contains("2 of 3 values") && cut.contains("save it again"), "{cut}");
        let odd = open("m.txt", &text.replace("\n 1\n", "\n x\n")).map(|_| ()).expect_err("a word");
        assert!(odd.contains("line 7: not readable as Octave's text: \"x\" is not a number"), "{odd}");
        for head in ["# name: rig 7\n# t, i\n", "# name: rig 7\n# type: servo\nt,i\n"] {
            let other = open("m.txt", &format!("{head}0.5,1\n1.5,2\n")).expect("a text of columns");
            assert_eq!(other.0.names(), ["t", "i"]);
        }
    }
}
