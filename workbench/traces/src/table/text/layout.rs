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

use crate::table::columns::About;
use crate::table::text::cells::{
    Line, clean, grouped, is_decimal_comma, is_decimal_point, lines, plain_number, plainly_grouped, row_ends, split,
    start_of_line, truth, without_end,
};
use crate::table::text::header::Head;
use crate::table::text::preamble::{self, Lasts, Mark, Told};
use crate::table::text::rows::Rows;
use crate::table::text::time_groups::{Rates, twins};
use crate::time::clock::Clock;
use crate::time::names::{self, Guess};
use crate::time::second_part;
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
    /// The duration that a line before the rows states.
    pub(super) lasts: Option<Lasts>,
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
        let mark = mark(&of_rows, separator, form.decimal);
        let mut about = About::default();
        let is_empty = |k: &usize| of_rows.iter().all(|row| row[*k].is_empty());
        let used = (0..cells).rev().find(|k| !is_empty(k)).map_or(cells, |last| last + 1);
        let head = Head::of((content, comments), rows, (used, mark));
        head.doubts(content, first, &mut about);
        about.notes.extend(head.rates.as_ref().map(|rates| rates.told(&head.names)));
        let (told, lasts) = match head.step_s {
            Some(step) => (Told::of_header(step), None),
            None => preamble::told(&content[..first], comments, mark),
        };
        let mut names = head.names;
        names.resize(cells, String::new());
        // LabVIEW keeps the column of times that it does not write.
        if is_empty(&0) && names[0].eq_ignore_ascii_case("X_Value") {
            names[0].clear();
        }
        let own = Self {
            separator,
            decimal_comma: mark == Mark::Comma,
            thousands: form.decimal.is_some(),
            comment,
            row_ends: false,
            rates: head.rates,
            names,
            header: head.cells,
            first: content[first].before,
            clocks: vec![],
            about,
            lasts: None,
            both_commas: both_commas(rows, (content, &of_rows)),
        };
        own.with_clocks(&of_rows).with_rate(&of_rows, content[first].before, (told, lasts))
    }

    /// Compares the column of times with others and with the rate that is told, or takes this rate if there is none.
    fn with_rate(mut self, rows: &[Vec<&str>], before: usize, (told, lasts): (Told, Option<Lasts>)) -> Self {
        let is_time = |k: usize| names::usual(&self.names[k]).is_some() && !self.about.counters.contains(&k);
        let time = (0..self.names.len()).find(|k| is_time(*k)).or_else(|| self.about.clocks.first().copied());
        let Some(time) = time else {
            (self.about.step_s, self.lasts) = (told.step_s(&mut self.about.notes), lasts);
            self.doubt_counter(rows);
            return self;
        };
        self.find_twins(rows, time, before);
        self.about.fraction = second_part::of(&self.names, rows, time, |cell| self.number(cell));
        let times: Vec<f64> = rows.iter().take(TIMES).map_while(|row| self.seconds(time, row[time])).collect();
        let fits = self.about.fraction.is_none() && times.len() > SETTLED;
        self.about.notes.extend(told.beside(&self.names[time], &times).filter(|_| fits));
        self
    }

    /// The time in a cell of a column, s.
    fn seconds(&self, place: usize, cell: &str) -> Option<f64> {
        let name = &self.names[place];
        let unit_s = || names::usual(name).flatten().or_else(|| names::seconds(name)).unwrap_or(1.0);
        match self.clocks.iter().find(|(clock, _)| *clock == place) {
            Some((_, clock)) => clock.seconds(cell, self.decimal_comma),
            None => Some(self.number(cell)? * unit_s()),
        }
    }

    /// Says which column may be a time in steps of an unknown unit.
    fn doubt_counter(&mut self, rows: &[Vec<&str>]) {
        let place = self.names.iter().position(|name| names::may_count(name));
        let Some(place) = place.filter(|_| self.about.step_s.is_none() && !self.header.is_empty()) else { return };
        let values: Vec<f64> =
            rows.iter().filter_map(|row| self.number(row[place])).filter(|value| value.is_finite()).collect();
        let counts = values.iter().all(|value| value.fract() == 0.0) && values.len() >= SETTLED;
        if counts && names::rises(&values) {
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
        if names::usual(&self.names[time]).is_none() && names::seconds(&self.names[time]).is_none() {
            return;
        }
        for (place, differs) in twins(&self.names, rows, time) {
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
        let seconds = |k: usize| Some(step(k)? * names::seconds(&self.names[k])?);
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
        let named = (0..self.names.len()).find_map(|k| Some((k, names::usual(&self.names[k])?)));
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
            None if step > 0.0 => names::unit(values[0], step, integers),
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
                Some(_) => names::by_unit(&name),
                None => names::by_rise("header", &name),
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
            (0..self.names.len()).find_map(|k| Some((k, names::seconds(&self.names[k]).filter(|_| rises(k))?)));
        let by_rise = || {
            let (k, values) = (0..self.names.len()).find_map(|k| Some((k, values(k)?)))?;
            (self.header.is_empty() && names::rises(&values)).then_some((k, None))
        };
        by_unit.map(|(k, unit)| (k, Some(unit))).or_else(by_rise)
    }

    fn told(mut self) -> Self {
        self.about.clocks = self.clocks.iter().map(|(place, _)| *place).collect();
        self.about.ticks_s = self.clocks.iter().filter_map(|(place, clock)| Some((*place, clock.unit_s()?))).collect();
        self
    }
}

/// The decimal mark that is given, or that the rows show.
fn mark(rows: &[Vec<&str>], separator: u8, given: Option<Decimal>) -> Mark {
    let any = |wanted: fn(&str) -> bool| rows.iter().flatten().any(|cell| wanted(cell));
    // Beside commas that separate cells, such a number is quoted, and no other one has a point.
    let is_comma = || {
        any(is_decimal_comma) && (separator != b',' || !any(|cell| cell.contains('.') && plain_number(cell).is_some()))
    };
    match given {
        Some(Decimal::Comma) => Mark::Comma,
        None if is_comma() => Mark::Comma,
        None if !any(is_decimal_point) => Mark::Unknown,
        _ => Mark::Point,
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
