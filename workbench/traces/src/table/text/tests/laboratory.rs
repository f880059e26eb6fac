//! Tests of texts as loggers of laboratories write them: several rates, ends of rows, quoted cells.

use std::fmt::Write as _;

use crate::reader::{Series, of_content};

fn read(text: &str) -> Result<(Vec<String>, Series, Vec<String>), String> {
    of_content("a.csv", text, None).map_err(|error| error.to_string())
}

/// Names and units of the channels of a group, its step in ms, and its rows.
type Group = (Vec<(&'static str, &'static str)>, f64, usize);

/// Groups of channels: their names and units, the steps in ms, and the rows of each.
struct Export {
    groups: Vec<Group>,
    separator: &'static str,
    comma: bool,
    /// What a cell has behind the end of its group; nothing if the row ends there.
    blank: Option<&'static str>,
    tells_steps: bool,
}

impl Export {
    fn number(&self, value: f64) -> String {
        let text = format!("{value}");
        if self.comma { text.replace('.', ",") } else { text }
    }

    fn line(&self, key: &str, cell: impl Fn(usize, usize) -> String) -> String {
        let group = |g: usize| {
            let cells = (0..self.groups[g].0.len()).map(|k| cell(g, k));
            std::iter::once(key.to_string()).chain(cells).collect::<Vec<_>>().join(self.separator)
        };
        (0..self.groups.len()).map(group).collect::<Vec<_>>().join(self.separator) + "\n"
    }

    /// A channel k of a group has at its row r the value 100 k plus the time of the row in ms.
    fn text(&self) -> String {
        let s = self.separator;
        let mut text = format!("Name{s}project\nFile{s}a.csv\n\n");
        text += &self.line("Name", |g, k| self.groups[g].0[k].0.into());
        text += &self.line("Data-Type", |_, _| "REAL32".into());
        if self.tells_steps {
            text += &self.line("SampleTime[ms]", |g, _| self.number(self.groups[g].1));
        }
        text += &self.line("Unit", |g, k| self.groups[g].0[k].1.into());
        text += "\n";
        for row in 0..self.groups.iter().map(|(.., rows)| *rows).max().unwrap_or(0) {
            let group = |(channels, step, rows): &(Vec<_>, f64, usize)| -> Vec<String> {
                let time = step * row as f64;
                let values = (0..channels.len()).map(|k| self.number(100.0 * k as f64 + time));
                match self.blank {
                    _ if row < *rows => std::iter::once(self.number(time)).chain(values).collect(),
                    Some(blank) => vec![blank.into(); channels.len() + 1],
                    None => vec![],
                }
            };
            let cells: Vec<String> = self.groups.iter().flat_map(group).collect();
            let _never_fails = writeln!(text, "{}", cells.join(s));
        }
        text
    }
}

#[test]
fn groups_of_several_rates_are_read_by_their_own_times() {
    let fast = || (vec![("Axis.Current", "A"), ("Axis.Speed", "rad/s")], 2.0, 1000);
    let slow = || (vec![("Axis.Temperature", "°C (Celsius)")], 10.0, 200);
    let usual =
        || Export { groups: vec![fast(), slow()], separator: "\t", comma: true, blank: None, tells_steps: true };
    let exports = [
        usual(),
        Export { groups: vec![slow(), fast()], blank: Some(" "), ..usual() },
        Export { separator: ";", blank: Some(""), comma: false, ..usual() },
        Export { groups: vec![fast(), (slow().0, 5.0, 40)], tells_steps: false, ..usual() },
    ];
    for export in exports {
        let slow_step = export.groups.iter().map(|(_, step, _)| *step).fold(0.0, f64::max);
        let (names, series, told) = read(&export.text()).expect("an export");
        let place = |name: &str| names.iter().position(|own| own == name).unwrap_or_else(|| panic!("{names:?}"));
        let column = |name: &str| &series.columns[place(name)];
        let times = series.times_s.as_ref().expect("a time");
        assert_eq!((times.len(), names.len()), (1000, 3));
        assert!((times[999] - 1.998).abs() < 1e-9, "{}", times[999]);
        assert!((0..1000).all(|row| column("Axis.Current [A]")[row] == 2.0 * row as f64));
        assert!((0..1000).all(|row| column("Axis.Speed [rad/s]")[row] == 100.0 + 2.0 * row as f64));
        let held = column("Axis.Temperature [°C]");
        let last = export.groups.iter().map(|(_, _, rows)| *rows).min().unwrap_or(0) as f64 * slow_step;
        for row in (0..1000).filter(|row| 2.0 * (*row as f64) < last) {
            assert_eq!(held[row], slow_step * (2.0 * row as f64 / slow_step).floor(), "row {row}");
        }
        // Behind its end a channel is not held for longer than its steps.
        let behind = (0..1000).filter(|row| 2.0 * (*row as f64) > last + slow_step);
        assert!(behind.clone().all(|row| held[row].is_nan()), "{last}");
        assert!(told.iter().any(|told| told.contains("several rates in one file") && told.contains("500 a second")));
    }
}

#[test]
fn groups_and_pairs_of_one_rate_are_one_table() {
    let channel = |name: &'static str, unit: &'static str| (vec![(name, unit)], 1.0, 50);
    let pairs = vec![channel("i", "A"), channel("w", "rpm"), channel("q", "(None)")];
    let alone = vec![(vec![("i", "A"), ("w", "rpm"), ("q", "(None)")], 1.0, 50)];
    for groups in [pairs, alone] {
        let export = Export { groups, separator: ";", comma: false, blank: None, tells_steps: true };
        // The first time of the first channel alone is written with its decimals.
        let text = export.text().replacen("\n0;", "\n0.0;", 1);
        let (names, series, told) = read(&text).expect("one rate");
        assert_eq!(names, ["i [A]", "w [rpm]", "q"]);
        assert_eq!(series.times_s.map(|times| (times.len(), times[49])), Some((50, 0.049)));
        assert!(!told.iter().any(|told| told.contains("several rates")), "{told:?}");
    }
}

fn rows(row: impl Fn(usize) -> String) -> String {
    (0..40).map(row).collect()
}

#[test]
fn semicolons_that_end_rows_separate_nothing() {
    let lost = |k: usize| if k == 9 { "nan,nan,nan;\r\n" } else { "" };
    let comma = rows(|k| format!("{}.0,{}.5,{}.25;\r\n{}", 11 + 43 * k + k % 3, k % 7, k % 5, lost(k)));
    let comments = "% data\r\n%Date:,29/04/2021\r\n\r\n%timestep (8Hz),voltage,velocity\r\n%[#],[V],[turns/s]\r\n";
    let (names, series, told) = read(&format!("{comments}{comma}")).expect("rows");
    assert_eq!(names, ["timestep (8Hz)", "voltage [V]", "velocity [turns/s]"]);
    assert!(series.columns[2][10].is_nan() && series.columns[2][6] == 1.25, "{:?}", series.columns[2]);
    assert!(
        told.iter().any(|told| told.contains("timestep (8Hz) counts up") && told.contains("not known")),
        "{told:?}"
    );
    let tab = rows(|k| format!("0,{k:03}\t{},5\t{};\n", k % 7, k % 5));
    let (names, series, _) = read(&format!("t [s]\ti [A]\tw [rpm];\n{tab}")).expect("tabs");
    assert_eq!((names.join("|"), series.columns[1][8]), ("i [A]|w [rpm]".into(), 3.0));
    let blank = rows(|k| format!("{}.5  {} {} ;\n", k, k % 7, k % 5));
    let (names, series, _) = read(&format!("# t i w\n{blank}")).expect("blanks");
    assert_eq!((names.join("|"), series.columns[1][8]), ("i|w".into(), 3.0));
}

#[test]
fn quoted_cells_of_several_lines_are_one_cell() {
    let inside = rows(|k| format!("{}.5,\"a, b\nc\",{}\n", k, k % 7));
    let last = rows(|k| format!("{}.5,{},\"a\nb\n\"\"c\"\"\"\n", k, k % 7));
    let first = rows(|k| format!("\"x;\r\ny\";{}.5;{}\r\n", k, k % 7));
    for text in [
        format!("t,note,i\n{inside}"),
        format!("t,i,note\n{last}"),
        format!("note;t;i\r\n{first}"),
        format!("t,note,i\n{inside}40.5,\"a, b\n"),
    ] {
        let (names, series, told) = read(&text).expect("quoted");
        assert_eq!((names.join("|"), series.columns[0].len(), series.columns[0][39]), ("i".into(), 40, 4.0));
        assert_eq!(told.len(), usize::from(text.contains("40.5")), "{told:?}");
    }
}

#[test]
fn logs_of_changes_are_held_and_lost_values_are_not() {
    let log = |separator: char| {
        let value = |k: usize, period: usize| (k / period % 9).to_string();
        let cell = |k: usize, period: usize| if k.is_multiple_of(period) { value(k, period) } else { String::new() };
        (0..400).fold(format!("t_s{separator}i{separator}w\n"), |mut text, k| {
            let _never_fails = writeln!(text, "0.{k:03}{separator}{}{separator}{}", cell(k, 2), cell(k, 5));
            text
        })
    };
    for separator in [',', ';', '\t'] {
        let (_, series, _) = read(&log(separator)).expect("a log");
        assert!(
            (0..400).all(|k| series.columns[0][k] == (k / 2 % 9) as f64 && series.columns[1][k] == (k / 5 % 9) as f64)
        );
    }
    let lost = (0..400).fold("t_s,i\n".to_string(), |mut text, k| {
        let value = if k % 3 == 0 { (k / 40).to_string() } else { String::new() };
        let _never_fails = writeln!(text, "0.{k:03},{value}");
        text
    });
    let (_, series, _) = read(&lost).expect("a slow channel");
    assert_eq!(series.columns[0].iter().filter(|value| value.is_nan()).count(), 266);
}
