//! The class of each trace, and the selection of traces.

use std::borrow::Cow;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use super::{Recorded, Trace, TraceNames, composed, trace_name};
use crate::Error;
use crate::near::{among, did_you_mean, list};

/// A condition on a column of the labels: `load_kgf=20`, `run<=4`, `class_name!=backlash1`.
///
/// Compared as numbers if both sides are numbers, otherwise as text (`=` and `!=` only).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Condition {
    column: String,
    operator: &'static str,
    value: String,
}

impl std::str::FromStr for Condition {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        // The longer operators first, so that `<=` is not parsed as `<`.
        for operator in ["<=", ">=", "!=", "=", "<", ">"] {
            if let Some((column, value)) = text.split_once(operator) {
                let [column, value] = [column, value].map(|text| composed(text.trim()).into_owned());
                let value = if column == "trace" { trace_name(&value).into_owned() } else { value };
                if column.is_empty() || value.is_empty() {
                    break;
                }
                return Ok(Self { column, operator, value });
            }
        }
        Err(format!("\"{text}\" is no condition; write column, one of = != <= >= < >, value, e.g. 'run<=4'"))
    }
}

impl serde::Serialize for Condition {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> serde::Deserialize<'de> for Condition {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

impl std::fmt::Display for Condition {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}{}", self.column, self.operator, self.value)
    }
}

impl Condition {
    /// The column.
    #[must_use]
    pub fn column(&self) -> &str {
        &self.column
    }

    /// Whether its value is to be filled in.
    #[must_use]
    pub fn is_question(&self) -> bool {
        self.value == "?"
    }

    /// Whether it holds for a cell of the column.
    ///
    /// # Errors
    /// An order of texts, which have none.
    pub fn holds(&self, cell: &str) -> Result<bool, String> {
        use std::cmp::Ordering::{Equal, Greater, Less};
        let ordering = match (cell.parse::<f64>(), self.value.parse::<f64>()) {
            (Ok(cell), Ok(value)) => cell.partial_cmp(&value),
            _ if matches!(self.operator, "=" | "!=") => Some(cell.cmp(self.value.as_str())),
            _ => None,
        };
        let ordering = ordering
            .ok_or_else(|| format!("\"{cell}\" {} \"{}\" compares text; use = or !=", self.operator, self.value))?;
        Ok(match self.operator {
            "=" => ordering == Equal,
            "!=" => ordering != Equal,
            "<=" => ordering != Greater,
            ">=" => ordering != Less,
            "<" => ordering == Less,
            _ => ordering == Greater,
        })
    }
}

/// The rows of `labels.csv`: `trace,class_name` and any other columns.
#[derive(Clone, Debug)]
pub struct Labels {
    path: PathBuf,
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
    /// The name of the trace of each row, as names are compared.
    ids: Vec<String>,
}

/// A trace with the index of its class.
#[derive(Clone, Debug)]
pub struct LabelledTrace {
    /// Its signals.
    pub trace: Trace,
    /// Index into the class names.
    pub class: usize,
}

impl Labels {
    /// The different cells of a column, sorted; none if there is no such column.
    #[must_use]
    pub fn distinct(&self, column: &str) -> Vec<String> {
        let place = self.columns.iter().position(|own| own == column);
        let cells = place.into_iter().flat_map(|place| self.rows.iter().map(move |row| row[place].as_str()));
        cells.collect::<std::collections::BTreeSet<_>>().into_iter().map(String::from).collect()
    }

    /// Whether two traces of one class have the same cell of a column, as those of one run do.
    #[must_use]
    pub fn joins(&self, column: &str) -> bool {
        let place = |name: &str| self.columns.iter().position(|own| own == name);
        let (Some(class), Some(column)) = (place("class_name"), place(column)) else { return false };
        let mut seen = std::collections::HashSet::new();
        self.rows.iter().any(|row| !row[column].is_empty() && !seen.insert((&row[class], &row[column])))
    }

    /// The names of the traces.
    #[must_use]
    pub fn names(&self) -> TraceNames {
        TraceNames::of(self.ids.iter().cloned())
    }

    /// The number of rows of a class.
    #[must_use]
    pub fn count(&self, class: &str) -> usize {
        let place = self.columns.iter().position(|own| own == "class_name");
        place.map_or(0, |place| self.rows.iter().filter(|row| row[place] == class).count())
    }

    /// The names of the columns.
    #[must_use]
    pub fn columns(&self) -> &[String] {
        &self.columns
    }

    /// The names of the columns, and the rows.
    #[must_use]
    pub fn table(&self) -> Vec<Vec<String>> {
        std::iter::once(&self.columns).chain(&self.rows).cloned().collect()
    }

    /// Takes the cells of a file.
    ///
    /// # Errors
    /// Missing `trace` or `class_name`, a trace that occurs twice, a name that no class can have.
    pub fn of_cells(path: &Path, columns: Vec<String>, rows: Vec<Vec<String>>) -> Result<Self, Error> {
        Self { path: path.into(), columns, rows, ids: vec![] }.checked()
    }

    /// Takes the labels of a table in memory.
    ///
    /// # Errors
    /// As [`Labels::of_cells`], and a column of neither numbers nor text.
    pub fn of(table: &Recorded) -> Result<Self, Error> {
        let columns = table.names().map(|name| name.trim().to_string()).collect();
        Self { path: table.name().into(), columns, rows: table.rows()?, ids: vec![] }.checked()
    }

    fn checked(mut self) -> Result<Self, Error> {
        for text in self.columns.iter_mut().chain(self.rows.iter_mut().flatten()) {
            if let Cow::Owned(changed) = composed(text) {
                *text = changed;
            }
        }
        let trace = self.column("trace")?;
        self.ids = self.rows.iter().map(|row| trace_name(&row[trace]).into_owned()).collect();
        let (labels, path) = (&self, &self.path);
        let class = labels.column("class_name")?;
        let mut seen = HashMap::new();
        for (k, (row, id)) in labels.rows.iter().zip(&labels.ids).enumerate() {
            if let Some(first) = seen.insert(id, k) {
                let problem = format!("{} is labelled already in line {}", row[trace], first + 2);
                return Err(Error::content(path, format!("line {}", k + 2), problem));
            }
            let name = &row[class];
            if name.is_empty() || name == "undetermined" || name.contains(char::is_control) {
                let problem = format!("\"{}\" is no class name; choose another", name.escape_debug());
                return Err(Error::content(path, format!("line {}, column class_name", k + 2), problem));
            }
        }
        Ok(self)
    }

    fn column(&self, name: &str) -> Result<usize, Error> {
        self.columns.iter().position(|column| column == name).ok_or_else(|| {
            let near = among(name, &self.columns);
            Error::content(&self.path, "header", format!("no column {name}{near}"))
        })
    }

    /// Names of traces, as they are compared, and class names of the rows that satisfy every condition.
    ///
    /// # Errors
    /// An unknown column, an order comparison of text, or no remaining row.
    pub fn select(&self, conditions: &[Condition]) -> Result<Vec<(String, String)>, Error> {
        let class = self.column("class_name")?;
        let columns = conditions.iter().map(|c| self.column(&c.column)).collect::<Result<Vec<_>, _>>()?;
        if let Some(asked) = conditions.iter().find(|condition| condition.is_question()) {
            let all = list(&self.distinct(&asked.column));
            let problem = format!("where {asked} is a question: write one of {all}, or leave it out if they are alike");
            return Err(Error::content(&self.path, "selection", problem));
        }
        let mut chosen = Vec::new();
        for (k, (row, id)) in self.rows.iter().zip(&self.ids).enumerate() {
            let mut all = true;
            for (condition, &column) in conditions.iter().zip(&columns) {
                let place = || format!("line {}, column {}", k + 2, condition.column);
                let cell = if condition.column == "trace" { id } else { &row[column] };
                all &= condition.holds(cell).map_err(|p| Error::content(&self.path, place(), p))?;
            }
            if all {
                chosen.push((id.clone(), row[class].clone()));
            }
        }
        if chosen.is_empty() {
            let asked: Vec<_> = conditions.iter().map(ToString::to_string).collect();
            let problem = if asked.is_empty() { "no rows".into() } else { format!("no row with {}", asked.join(", ")) };
            return Err(Error::content(&self.path, "selection", problem));
        }
        Ok(chosen)
    }

    /// The cell of a column for each of these traces; empty for a trace without a row.
    ///
    /// # Errors
    /// An unknown column.
    pub fn cells<'a>(&self, column: &str, ids: impl Iterator<Item = &'a str>) -> Result<Vec<String>, Error> {
        let column = self.column(&composed(column))?;
        let rows = self.ids.iter().zip(&self.rows);
        let by_id: HashMap<&str, &String> = rows.map(|(id, row)| (id.as_str(), &row[column])).collect();
        Ok(ids.map(|id| by_id.get(&*trace_name(id)).map_or_else(String::new, ToString::to_string)).collect())
    }

    /// The class names of a selection: the requested ones in the requested order, or all in order of first occurrence.
    ///
    /// # Errors
    /// A requested class that no selected row has.
    pub fn classes(&self, chosen: &[(String, String)], asked: &[String]) -> Result<Vec<String>, Error> {
        let mut present: Vec<String> = Vec::new();
        for (_, class) in chosen {
            if !present.contains(class) {
                present.push(class.clone());
            }
        }
        let asked: Vec<String> = asked.iter().map(|class| composed(class).into_owned()).collect();
        for (k, class) in asked.iter().enumerate() {
            if asked[..k].contains(class) {
                return Err(Error::Usage(format!("--classes names {class} twice")));
            }
            if !present.contains(class) {
                let near = among(class, &present);
                let problem = format!("unknown class {class} in this selection{near}");
                return Err(Error::content(&self.path, "column class_name", problem));
            }
        }
        Ok(if asked.is_empty() { present } else { asked })
    }

    /// Joins a selection with its traces; rows of classes that are not in `classes` are omitted.
    ///
    /// # Errors
    /// A labelled trace that is not in `traces`.
    pub fn join(
        &self,
        chosen: &[(String, String)],
        classes: &[String],
        traces: &[Trace],
    ) -> Result<Vec<LabelledTrace>, Error> {
        let by_id: HashMap<Cow<'_, str>, &Trace> = traces.iter().map(|trace| (trace_name(&trace.id), trace)).collect();
        let wanted = chosen.iter().filter_map(|(id, name)| Some((id, classes.iter().position(|c| c == name)?)));
        wanted
            .map(|(id, class)| {
                let trace = by_id.get(id.as_str()).ok_or_else(|| {
                    let near = did_you_mean(id, traces.iter().map(|trace| trace.id.as_str()));
                    let problem =
                        format!("{id} is labelled, but there is no such trace; give its file or folder{near}");
                    Error::content(&self.path, "column trace", problem)
                })?;
                Ok(LabelledTrace { trace: (*trace).clone(), class })
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn conditions_compare_numbers_as_numbers() {
        let c: Condition = "run<=4".parse().expect("condition");
        assert!(c.holds("4").expect("numbers") && !c.holds("10").expect("numbers"));
        let c: Condition = "load_kgf=20".parse().expect("condition");
        assert!(c.holds("20.0").expect("numbers") && !c.holds("-20").expect("numbers"));
        let c: Condition = "class_name!=normal".parse().expect("condition");
        assert!(!c.holds("normal").expect("text"));
        assert!("run<4".parse::<Condition>().expect("condition").holds("x").is_err());
        assert!("run".parse::<Condition>().is_err() && "=4".parse::<Condition>().is_err());
    }

    #[test]
    fn unknown_classes_and_duplicates_are_refused() {
        let of = |rows: [[&str; 2]; 2]| {
            let texts = |cells: [&str; 2]| cells.map(String::from).to_vec();
            Labels::of_cells(Path::new("labels.csv"), texts(["trace", "class_name"]), rows.map(texts).to_vec())
        };
        let labels = of([["x.csv", "a"], ["y", "b"]]).expect("good labels");
        let chosen = labels.select(&[]).expect("rows");
        assert_eq!(chosen[0], ("x".to_string(), "a".to_string()));
        assert_eq!(labels.classes(&chosen, &[]).expect("classes"), ["a", "b"]);
        let error = labels.classes(&chosen, &["c".into()]).expect_err("unknown").to_string();
        assert!(error.contains("unknown class c") && error.contains("a, b"), "{error}");
        let twice = of([["x.csv", "a"], ["x", "b"]]).expect_err("twice").to_string();
        assert!(twice.contains("line 3: x is labelled already"), "{twice}");
    }

    #[test]
    fn names_are_compared_with_folders_without_extension_and_in_one_form_of_unicode() {
        let texts = |cells: &[&str]| cells.iter().map(ToString::to_string).collect::<Vec<_>>();
        let rows = [
            ["class_a\\run_1\\x.csv", "u\u{308}bel", "1"],
            ["./class_a/run_2/x", "gut", "2"],
            ["pru\u{308}f.mat", "gut", "2"],
        ];
        let columns = texts(&["trace", "class_name", "la\u{308}uft"]);
        let labels = Labels::of_cells(Path::new("labels.csv"), columns, rows.iter().map(|row| texts(row)).collect());
        let labels = labels.expect("good labels");
        let ids: Vec<String> = labels.select(&[]).expect("rows").into_iter().map(|(id, _)| id).collect();
        assert_eq!(ids, ["class_a/run_1/x", "class_a/run_2/x", "pr\u{fc}f"]);
        for condition in ["l\u{e4}uft=1", "la\u{308}uft=1", "class_name=\u{fc}bel", "trace=class_a/run_1/x.parquet"] {
            let one = labels.select(&[condition.parse().expect("condition")]).expect(condition);
            assert_eq!(one.len(), 1, "{condition}");
        }
        let chosen = labels.select(&[]).expect("rows");
        assert_eq!(labels.classes(&chosen, &["u\u{308}bel".into()]).expect("the class"), ["\u{fc}bel"]);
        let cells = labels.cells("l\u{e4}uft", ["class_a/run_2/x.csv", "x"].into_iter()).expect("cells");
        assert_eq!(cells, ["2", ""]);
        assert!(labels.names().has("pr\u{fc}f") && labels.joins("l\u{e4}uft") && !labels.joins("trace"));
        let twice = [["a/x.csv", "b", "1"], ["a\\x", "b", "1"]].map(|row| texts(&row)).to_vec();
        assert!(Labels::of_cells(Path::new("l"), texts(&["trace", "class_name", "n"]), twice).is_err());
    }
}
