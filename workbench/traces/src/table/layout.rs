//! How a text file separates cells, where its rows begin, and what its columns are called.
//!
//! ```text
//! Logger 3, serial 17             lines before the header: left out, but for a rate of samples
//! Sample Rate,2000
//! Time;Current;Speed              names: the line before the rows, if it has as many cells
//! [s];[A];[rpm]                   units: part of the names
//! 0,000;0,1;1000,2                rows
//! ```
//!
//! The rows tell the separator: it is the one by which most columns are numbers or times. They begin with the first of
//! two lines that have these columns. A comma is decimal where a cell can be nothing else.

use super::about::About;
use super::cells::{
    Line, clean, grouped, is_decimal_comma, lines, plain_number, plainly_grouped, row_ends, split, start_of_line,
    truth, without_end,
};
use super::clock::Clock;
use super::fraction;
use super::header::Head;
use super::preamble;
use super::rates::Rates;
use super::rows::Rows;
use super::time_name::{self, Guess};
use super::twins;
use model::trace::{Decimal, TextForm};

/// Lines that are looked at, and bytes of a text with long lines.
const LINES: usize = 200;
const BYTES: usize = 256 << 10;
/// Largest number of rows in which times are looked for.
const TIMES: usize = 64;
/// Lines that a text has to have before its layout is taken for settled.
const SETTLED: usize = 12;
/// Part of a rate by which another time has another one.
const OTHER_RATE: f64 = 0.1;
/// Least values of a time that are read relative to the first one: below it a double has enough digits.
const LARGE_TIME: f64 = 1e6;

/// The layout of a text file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Layout {
    /// Separator; a blank stands for any number of blanks and tabs.
    pub(super) separator: u8,
    pub(super) decimal_comma: bool,
    /// Whether the decimal mark is given, so that the other mark separates thousands.
    thousands: bool,
    /// The first character of lines that are skipped.
    pub(super) comment: Option<u8>,
    /// Whether a semicolon ends each row, and separates nothing.
    pub(super) row_ends: bool,
    /// The times of the columns, if they have several rates; a row of slower ones may end early.
    pub(super) rates: Option<Rates>,
    /// Names of the columns, and the cells of the line they are from.
    pub(super) names: Vec<String>,
    pub(super) header: Vec<String>,
    /// Number of lines before the first row.
    pub(super) first: usize,
    /// Columns that are times.
    pub(super) clocks: Vec<(usize, Clock)>,
    pub(super) about: About,
    /// The line before the rows of a text whose commas separate cells and decimals.
    pub(super) both_commas: Option<usize>,
}

impl Layout {
    /// Finds the parts of the layout of a text that are not given.
    pub(super) fn of(text: &str, form: &TextForm) -> Self {
        let skipped = form.skip.unwrap_or(0);
        let text = &text[start_of_line(text, skipped)..];
        let comment = text.lines().find(|line| !line.trim().is_empty()).and_then(|line| {
            let first = line.trim_start_matches('\u{feff}').bytes().next()?;
            matches!(first, b'#' | b'%' | b';').then_some(first)
        });
        let start = (0..=BYTES.min(text.len())).rev().find_map(|end| text.get(..end)).unwrap_or_default();
        let enough = start.bytes().filter(|byte| *byte == b'\n').count() > SETTLED;
        // Of very long lines a few are enough.
        let (looked_at, most) = if enough { (start, LINES) } else { (text, 2 * SETTLED) };
        let (mut content, mut comments) = lines(looked_at, comment, most);
        for line in content.iter_mut().chain(&mut comments) {
            line.before += skipped;
            line.end += skipped;
        }
        let usual = [b';', b'\t', b'|', b',', b' '];
        let given = form.separator.map(|own| [own.byte()]);
        let row_ends = given.is_none_or(|[own]| own != b';') && row_ends(&content);
        if row_ends {
            content.iter_mut().chain(&mut comments).for_each(|line| line.text = without_end(line.text));
        }
        let separators = given.as_ref().map_or(&usual[usize::from(row_ends)..], |own| own);
        let found = separators.iter().filter_map(|separator| Rows::of(&content, *separator, form));
        // The first of equals: with decimal commas, a comma may separate as many columns.
        let best = found.reduce(|best, other| {
            // Blanks also separate date and time: where another mark leaves nothing but numbers and times, it stands.
            let stands = other.separator == b' ' && best.separator != b',' && best.columns() == best.cells;
            if other.columns() > best.columns() && !stands { other } else { best }
        });
        match best {
            Some(rows) => Self { row_ends, ..Self::with(&rows, (&content, &comments), (comment, form)) },
            None => Self::without_rows(&content, (comment, separators)),
        }
    }

    /// Whether a text has all lines that are looked at.
    pub(super) fn is_settled_by(head: &str, form: &TextForm) -> bool {
        let lines = head.lines().skip(form.skip.unwrap_or(0));
        lines.filter(|line| !line.trim().is_empty() && !line.starts_with(['#', '%'])).count() > SETTLED
    }

    /// The number in a cell.
    pub(super) fn number(&self, cell: &str) -> Option<f64> {
        let word = || truth(cell).or_else(|| grouped(cell, self.decimal_comma).filter(|_| self.thousands));
        if let Some(number) = word().or_else(|| plainly_grouped(cell, self.decimal_comma)) {
            return Some(number);
        }
        if !self.decimal_comma {
            return plain_number(cell);
        }
        // A point beside decimal commas separates thousands.
        if cell.contains('.') { None } else { cell.replacen(',', ".", 1).parse().ok() }
    }

    /// Of a text without numbers: the first line has the names.
    fn without_rows(content: &[Line<'_>], (comment, separators): (Option<u8>, &[u8])) -> Self {
        let first = content.first();
        let text = first.map_or("", |line| line.text);
        let cells = |separator: &u8| split(text, *separator).len();
        let of_header = [b',', b';', b'\t', b'|'].into_iter().filter(|own| separators.contains(own));
        let separator = of_header.rev().max_by_key(cells).or_else(|| separators.first().copied()).unwrap_or(b',');
        let header: Vec<String> = split(text, separator).into_iter().map(clean).collect();
        let names = header.clone();
        let first = first.map_or(0, |line| line.end);
        Self { separator, comment, names, header, first, ..Self::default() }
    }

    fn with(
        rows: &Rows,
        (content, comments): (&[Line<'_>], &[Line<'_>]),
        (comment, form): (Option<u8>, &TextForm),
    ) -> Self {
        let Rows { separator, cells, first, .. } = *rows;
        let of_rows: Vec<Vec<&str>> =
            content[first..].iter().map(|line| split(line.text, separator)).filter(|row| row.len() == cells).collect();
        let any = |wanted: fn(&str) -> bool| of_rows.iter().flatten().any(|cell| wanted(cell));
        let decimal_comma = match form.decimal {
            Some(mark) => mark == Decimal::Comma,
            // Beside commas that separate cells, such a number is quoted, and no other one has a point.
            None if separator == b',' => {
                any(is_decimal_comma) && !any(|cell| cell.contains('.') && plain_number(cell).is_some())
            }
            None => any(is_decimal_comma),
        };
        let mut about = About::default();
        let is_empty = |k: &usize| of_rows.iter().all(|row| row[*k].is_empty());
        let used = (0..cells).rev().find(|k| !is_empty(k)).map_or(cells, |last| last + 1);
        let head = Head::of((content, comments), rows, used);
        head.doubts(content, first, &mut about);
        about.step_s = head.step_s;
        about.notes.extend(head.rates.as_ref().map(|rates| rates.told(&head.names)));
        let mut names = head.names;
        names.resize(cells, String::new());
        let own = Self {
            separator,
            decimal_comma,
            thousands: form.decimal.is_some(),
            comment,
            row_ends: false,
            rates: head.rates,
            names,
            header: head.cells,
            first: content[first].before,
            clocks: vec![],
            about,
            both_commas: both_commas(rows, (content, &of_rows)),
        };
        let mut own = own.with_clocks(&of_rows);
        let is_time = |k: usize| time_name::usual(&own.names[k]).is_some() && !own.about.counters.contains(&k);
        match (0..cells).find(|k| is_time(*k)).or_else(|| own.about.clocks.first().copied()) {
            Some(time) => {
                own.find_twins(&of_rows, time, content[first].before);
                own.about.fraction = fraction::of(&own.names, &of_rows, time, |cell| own.number(cell));
            }
            None => {
                if own.about.step_s.is_none() {
                    own.about.step_s = preamble::step_s(&content[..first], comments, &mut own.about);
                }
                own.doubt_counter(&of_rows);
            }
        }
        own
    }

    /// Says which column may be a time in steps of an unknown unit.
    fn doubt_counter(&mut self, rows: &[Vec<&str>]) {
        let place = self.names.iter().position(|name| time_name::may_count(name));
        let Some(place) = place.filter(|_| self.about.step_s.is_none() && !self.header.is_empty()) else { return };
        let values: Vec<f64> =
            rows.iter().filter_map(|row| self.number(row[place])).filter(|value| value.is_finite()).collect();
        let counts = values.iter().all(|value| value.fract() == 0.0) && values.len() >= SETTLED;
        if counts && time_name::rises(&values) {
            let name = &self.names[place];
            self.about.notes.push(format!(
                "column {name} counts up and may be the time, but the unit of its steps is not known: write the seconds \
                 with convert --time none --columns \"t_s={name}/RATE,…\", or give --time \"{name}\" if it counts seconds"
            ));
        }
    }

    /// Finds the columns that repeat the time for each channel, and those that have other times.
    fn find_twins(&mut self, rows: &[Vec<&str>], time: usize, before: usize) {
        // Names that are alike are times only if one of them says so.
        if time_name::usual(&self.names[time]).is_none() && time_name::seconds(&self.names[time]).is_none() {
            return;
        }
        for (place, differs) in twins::twins(&self.names, rows, time) {
            match differs {
                None => {
                    let again = format!("the same time as column {}", time + 1);
                    self.about.omit(format!("column {} {}", place + 1, self.names[place]), again);
                    self.about.twins.push(place);
                }
                Some(row) => {
                    self.about.other_times.get_or_insert((place, (before + row + 1) as u64));
                }
            }
        }
        if let Some(place) = self.other_rate(rows, time) {
            self.about.other_times.get_or_insert((place, (before + 2) as u64));
        }
    }

    /// A further column that begins with the same word for the time, and has another rate.
    fn other_rate(&self, rows: &[Vec<&str>], time: usize) -> Option<usize> {
        let word = |k: usize| self.names[k].split([' ', '_', '[', '(']).next().unwrap_or_default();
        let step = |k: usize| {
            let values: Vec<f64> = rows.iter().map_while(|row| self.number(row[k])).collect();
            let rises = values.len() >= SETTLED && values.is_sorted_by(|one, next| one < next);
            rises.then(|| (values[values.len() - 1] - values[0]) / (values.len() - 1) as f64)
        };
        let seconds = |k: usize| Some(step(k)? * time_name::seconds(&self.names[k])?);
        let own = seconds(time)?;
        (time + 1..self.names.len())
            .filter(|k| word(*k) == word(time))
            .find(|k| seconds(*k).is_some_and(|other| (other / own - 1.0).abs() > OTHER_RATE))
    }

    /// Finds the columns that are times.
    fn with_clocks(mut self, rows: &[Vec<&str>]) -> Self {
        let rows = &rows[..rows.len().min(TIMES)];
        let cells = |k: usize| rows.iter().map(move |row| row[k]).filter(|cell| !cell.is_empty());
        for k in 0..self.names.len() {
            if let Some(clock) = Clock::of_words(cells(k)) {
                self.clocks.push((k, clock));
            }
        }
        // A date beside a time of the day stands.
        let stands = |k: usize| cells(k).all(|cell| cells(k).next() == Some(cell));
        self.clocks.sort_by_key(|(k, _)| stands(*k));
        let named = (0..self.names.len()).find_map(|k| Some((k, time_name::usual(&self.names[k])?)));
        let place = named.or_else(|| self.unnamed_time(rows));
        let Some((place, unit)) = place.filter(|(place, _)| self.clocks.iter().all(|(k, _)| k != place)) else {
            return self.told();
        };
        let values: Vec<f64> = cells(place).filter_map(|cell| self.number(cell)).collect();
        if rows.len() >= SETTLED && cells(place).next().is_none() {
            // An empty column is no time.
            self.about.counters.push(place);
        }
        let Some(first) = cells(place).next().filter(|_| values.len() > 1) else { return self.told() };
        let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
        let step = model::trace::median(&steps);
        let integers = cells(place).all(|cell| cell.bytes().all(|byte| byte.is_ascii_digit() || byte == b'-'));
        let name = self.names[place].clone();
        let guess = match unit {
            Some(unit) => Guess::Other(unit, ""),
            None if step > 0.0 => time_name::unit(values[0], step, integers),
            None => Guess::Seconds,
        };
        match guess {
            Guess::Counter => self.about.counters.push(place),
            Guess::Seconds if values[0].abs() < LARGE_TIME && named.is_some() => {}
            Guess::Seconds => {
                self.clocks.extend(Clock::of_numbers(first, 1.0, self.decimal_comma).map(|own| (place, own)));
            }
            Guess::Other(_, "") if values[0].abs() < LARGE_TIME && named.is_some() => {}
            Guess::Other(unit, told) => {
                self.clocks.extend(Clock::of_numbers(first, unit, self.decimal_comma).map(|own| (place, own)));
                if !told.is_empty() {
                    let rate = 1.0 / (step * unit);
                    // Of days and ticks no name says that they are counted.
                    let settles = if unit < 1.0 && !told.contains(' ') {
                        format!("a name such as {name}_{told} settles it")
                    } else {
                        "--time none and --rate-hz settle it".into()
                    };
                    self.about.notes.push(format!(
                        "time {name} is taken in {told}, {rate:.6} rows a second: the unit is guessed by its values; \
                         {settles}"
                    ));
                }
            }
        }
        if named.is_none() {
            self.about.notes.push(match unit {
                Some(_) => time_name::by_unit(&name),
                None => time_name::by_rise("header", &name),
            });
        }
        self.told()
    }

    /// A time without the name of one, if no column has dates: the first column whose unit is one of the time, if it
    /// rises in each row; without a header the first column of numbers, if it also does not count the rows.
    fn unnamed_time(&self, rows: &[Vec<&str>]) -> Option<(usize, Option<f64>)> {
        if !self.clocks.is_empty() || rows.len() < SETTLED {
            return None;
        }
        let values = |k: usize| rows.iter().map(|row| self.number(row[k])).collect::<Option<Vec<f64>>>();
        let rises = |k: usize| values(k).is_some_and(|values| values.is_sorted_by(|one, next| one < next));
        let by_unit =
            (0..self.names.len()).find_map(|k| Some((k, time_name::seconds(&self.names[k]).filter(|_| rises(k))?)));
        let by_rise = || {
            let (k, values) = (0..self.names.len()).find_map(|k| Some((k, values(k)?)))?;
            (self.header.is_empty() && time_name::rises(&values)).then_some((k, None))
        };
        by_unit.map(|(k, unit)| (k, Some(unit))).or_else(by_rise)
    }

    fn told(mut self) -> Self {
        self.about.clocks = self.clocks.iter().map(|(place, _)| *place).collect();
        self.about.ticks_s = self.clocks.iter().filter_map(|(place, clock)| Some((*place, clock.unit_s()?))).collect();
        self
    }
}

/// The last line of half as many names as the rows have cells, if these are whole numbers between commas.
fn both_commas(rows: &Rows, (content, of_rows): (&[Line<'_>], &[Vec<&str>])) -> Option<usize> {
    let is_whole = |cell: &&str| cell.trim_start_matches('-').bytes().all(|byte| byte.is_ascii_digit());
    let last = content.get(rows.first.checked_sub(1)?)?;
    let names = split(last.text, b',');
    let fits = rows.separator == b',' && 2 * names.len() == rows.cells && names.iter().all(|name| !is_whole(name));
    (fits && of_rows.iter().flatten().all(is_whole)).then_some(last.end)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Layout {
        Layout::of(text, &TextForm::default())
    }

    fn layout(text: &str) -> (char, bool, Vec<String>, usize) {
        let Layout { separator, decimal_comma, names, first, .. } = of(text);
        (char::from(separator), decimal_comma, names, first)
    }

    fn expect(text: &str, (separator, decimal_comma, names, first): (char, bool, &str, usize)) {
        let names = names.split(' ').map(String::from).collect();
        assert_eq!(layout(text), (separator, decimal_comma, names, first), "{text}");
    }

    #[test]
    fn separators_and_decimal_commas_are_told_apart() {
        expect("t,i\n0.1,2.5\n", (',', false, "t i", 1));
        expect("t;i\n0,1;2,5\n0,2;1\n", (';', true, "t i", 1));
        expect("t;i\n0.1;2.5\n", (';', false, "t i", 1));
        expect("t\ti\n0,1\t2,5\n", ('\t', true, "t i", 1));
        expect("t  i\n0.1   2.5\n", (' ', false, "t i", 1));
        expect("t,i\n0,x\n1,2\n2,3\n", (',', false, "t i", 1));
        expect("t,i,late\n0,1,\n1,2,\n", (',', false, "t i late", 1));
        expect("\"a;b\",i\n1,2\n", (',', false, "a;b i", 1));
        expect("only\n1.5\n", (',', false, "only", 1));
        expect("t;n\n0,5;2,000\n1,5;3,000\n", (';', true, "t n", 1));
        expect("n;k\n2,000;1\n3,000;2\n", (';', false, "n k", 1));
        // A short row leaves the separator of the header.
        assert_eq!(layout("a,b,c\n1,2\n").0, ',');
        assert_eq!(layout("").0, ',');
    }

    #[test]
    fn headers_are_lines_comments_or_missing() {
        expect("# logger 3\n# t, i\n0.1,2\n0.2,3\n", (',', false, "t i", 2));
        expect("% logger 3\nt,i\n0.1,2\n", (',', false, "t i", 2));
        expect("# logger 3\n0.1 2 7\n0.2 3 8\n", (' ', false, "c1 c2 c3", 1));
        expect("1,2\n3,4\n", (',', false, "c1 c2", 0));
        expect("0,1,2\n0.5,2.5,7\n0.6,2.5,7\n", (',', false, "0 1 2", 1));
        expect("a b\n1 0.5 7\n2 0.6 8\n3 0.7 9\n", (' ', false, "row a b", 1));
        assert_eq!(layout("\"t\n(s)\",i\n1,2\n3,4\n"), (',', false, vec!["t (s)".to_string(), "i".into()], 2));
    }

    fn rows(row: impl Fn(usize) -> String) -> String {
        (0..40).map(row).collect()
    }

    #[test]
    fn a_time_may_be_told_by_its_unit_alone() {
        let data = rows(|k| format!("{},{}.5,{}\n", -0.02 + k as f64 / 1e3, k % 7, k % 5));
        for head in
            ["x-axis,1,2\nsecond,Volt,Ampere\n", "in s,C1 in V,C2 in A\n", "Source,CH1,CH2\nSecond,Value,Value\n"]
        {
            let found = of(&format!("{head}{data}"));
            assert_eq!(found.about.clocks, [0], "{head}");
            assert!(found.about.notes[0].contains("has a unit of time"), "{:?}", found.about.notes);
        }
        let falls = rows(|k| format!("{}.5,{}\n", 7 - k % 7, k % 5));
        assert!(of(&format!("delay [ms],i\n{falls}")).about.clocks.is_empty());
    }

    #[test]
    fn a_second_time_of_another_rate_is_found() {
        let slow = |name: &str| {
            let data = rows(|k| format!("{:.3};1,5;{:.2};20,1\n", k as f64 / 1e3, k as f64 / 1e2).replace('.', ","));
            of(&format!("Time 1 - fast [s];i [A];{name};T\n{data}")).about.other_times
        };
        assert_eq!((slow("Time 2 - slow [s]"), slow("on [s]")), (Some((2, 3)), None));
    }

    #[test]
    fn names_are_found_by_their_keys_and_above_the_name_of_the_first_column() {
        let data = rows(|k| format!("\"\",{}.5,{}\n", k % 7, k % 5));
        let found =
            of(&format!("\"TraceName\",\"i\",\"n\"\n\"VUnit\",\"A\",\"rpm\"\n\"SampleRate\",2000,2000\n{data}"));
        assert_eq!((found.names.join("|"), found.about.step_s), ("|i [A]|n [rpm]".into(), Some(5e-4)));
        let data = rows(|k| format!("{},{}.5,{}\n", k as f64 / 1e3, k % 7, k % 5));
        let found = of(&format!("signal,i,n\nunit,A,rpm\nt_s,,\n{data}"));
        assert_eq!((found.names.join("|"), found.first), ("t_s|i [A]|n [rpm]".into(), 3));
        // Words of a boot are no names.
        let data = rows(|k| format!("{},{}.5,{}\n", 533 + 2 * k, k % 7, k % 5));
        assert!(of(&format!("sensor ok, starting\n{data}")).header.is_empty());
    }

    #[test]
    fn commas_that_separate_and_are_decimal_are_refused_but_not_in_quotes() {
        let data = rows(|k| format!("0,0{k:02},1,{}\n", k % 7));
        assert_eq!(of(&format!("t,i\n{data}")).both_commas, Some(1));
        let quoted = of(&format!("t,i\n{}", rows(|k| format!("\"0,00{k:02}\",\"1,{}\"\n", k % 7))));
        assert_eq!((quoted.both_commas, quoted.decimal_comma, quoted.number("1,5")), (None, true, Some(1.5)));
    }

    #[test]
    fn lines_before_the_header_and_units_are_understood() {
        assert_eq!(of("t_s;i\ns;A\n0.0;1\n0.5;2\n").names, ["t_s", "i [A]"]);
        let units = of("Time;Current;Speed\n[s];[A];[rpm]\n0.000;0.1;1000.2\n0.001;1.1;1001.2\n");
        assert_eq!((units.names.join("|"), units.first), ("Time [s]|Current [A]|Speed [rpm]".into(), 2));
        let text = "Logger,3\nSample Rate,2000\nNote,a,b,c\n0,0.5,0.2\n1,1.5,1.2\n2,2.5,2.2\n";
        let found = of(text);
        assert_eq!(
            (found.names.join("|"), found.first, found.about.step_s),
            ("c1|c2|c3".into(), 3, Some(1.0 / 2000.0))
        );
        assert_eq!(found.about.omitted[0].place, "lines 1 to 3");
        let scope = "X,CH1,Start,Increment,\nSequence,Volt,-1.2e-03,2.0e-06,\n0,0.1,\n1,1.1,\n2,2.1,\n";
        let found = of(scope);
        assert_eq!((found.names.join("|"), found.about.step_s), ("X|CH1 [V]|".into(), Some(2e-6)));
        let marked = ";Device,M2K\n;Sample rate,100000\nSample,Time(S),CH1(V)\n0,0.00000,0.1\n1,0.00001,1.1\n";
        let found = of(marked);
        assert_eq!((found.names.join("|"), found.first), ("Sample|Time(S)|CH1(V)".into(), 3));
        let labview = "LabVIEW Measurement\t\nDelta_X\t0.001\n***End_of_Header***\t\nX_Value\tVoltage\tComment\n0.000\t1.5\n0.001\t2.5\n0.002\t3.5\n";
        let found = of(labview);
        assert_eq!((found.names.join("|"), found.first), ("X_Value|Voltage".into(), 4));
    }

    #[test]
    fn times_are_told_by_their_cells_and_steps() {
        let clocks = |text: &str| {
            let found = of(text);
            (found.about.clocks.clone(), found.about.notes.len())
        };
        assert_eq!(clocks("Datum;t_s;i\n26.10.2022 08:17:00;0,000;0,5\n26.10.2022 08:17:01;0,001;1,5\n"), (vec![0], 0));
        assert_eq!(clocks("time,i\n1764200000.00000,1\n1764200000.00005,2\n"), (vec![0], 0));
        assert_eq!(clocks("timestamp,i\n123456789,1\n123457039,2\n"), (vec![0], 1));
        assert_eq!(clocks("time_ns,i\n1764200000000000000,1\n1764200000000250000,2\n"), (vec![0], 0));
        assert_eq!(clocks("t_s,i\n0.000,1\n0.001,2\n"), (vec![], 0));
        assert_eq!(of("time,i\n0,1\n1,2\n2,5\n").about.counters, [0]);
        let rising: String = (0..20).map(|k| format!("{}.{},7\n", 3104 + k / 10, k % 10)).collect();
        assert_eq!(clocks(&rising), (vec![0], 1));
    }

    /// What the content does not tell is given: rows before the header, names and units that look like others, a rare
    /// separator, marks between thousands.
    #[test]
    fn what_is_given_is_not_guessed() {
        let form = |skip: usize, units_row: bool, separator: &str, decimal: Option<Decimal>| TextForm {
            skip: Some(skip).filter(|skip| *skip > 0),
            units_row,
            separator: separator.parse().ok(),
            decimal,
        };
        let numbers = "3,17\n4,18\n5,19\nt,i\n0,1\n1,2\n2,2\n";
        let own = Layout::of(numbers, &form(3, false, "", None));
        assert_eq!((own.names.join("|"), own.first), ("t|i".into(), 4));
        let units = "7;8\nfoo;bar\n0.5;1\n1.5;2\n2.5;3\n";
        let own = Layout::of(units, &form(0, true, "", None));
        assert_eq!((own.names.join("|"), own.first), ("7|8".into(), 2));
        let own = Layout::of("t~i\n0~1\n1~2\n", &form(0, false, "~", None));
        assert_eq!((own.names.join("|"), own.separator, own.first), ("t|i".into(), b'~', 1));
        let own = Layout::of("t i;n\n0;1\n1;2\n", &form(0, false, ",", None));
        assert_eq!(own.names, ["t i;n"]);
        let thousands = "t;n\n0;2,000\n1;13,000.5\n2;4\n";
        let own = Layout::of(thousands, &form(0, false, "", Some(Decimal::Point)));
        let numbers = ["2,000", "13,000.5", "4", "1,5"].map(|cell| own.number(cell));
        assert_eq!((own.first, numbers), (1, [Some(2000.0), Some(13_000.5), Some(4.0), None]));
        let own = Layout::of("t;n\n0;2,000\n1;3,000\n", &form(0, false, "", Some(Decimal::Comma)));
        assert_eq!(["2,000", "1.000,5"].map(|cell| own.number(cell)), [Some(2.0), Some(1000.5)]);
    }
}
