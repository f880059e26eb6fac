//! The stages of a run, their times, and the table at the end.

use std::fmt::Write as _;
use std::time::{Duration, Instant};

use crate::child;
use crate::tally::{Named, Tally};

/// What a line of [`Stages::rows`] starts with.
const ROW: &str = "stage\t";
/// What a line with a check that was not made starts with.
const LEFT: &str = "left\t";
/// What a line with a check that failed starts with.
const BROKEN: &str = "broken\t";

/// A stage that has ended.
#[derive(Debug)]
struct Stage {
    title: String,
    tally: Tally,
    time: Duration,
    /// Of the programs that it has run; unknown without Linux.
    processor: Option<Duration>,
}

/// The stages of a run.
#[derive(Debug, Default)]
pub struct Stages {
    done: Vec<Stage>,
}

impl Stages {
    /// Runs a stage: a heading, its checks, its time.
    pub fn stage<T>(&mut self, title: &str, work: impl FnOnce(&mut Tally) -> T) -> T {
        println!("\n== {title}");
        let (start, before) = (Instant::now(), child::processor_time());
        let mut tally = Tally::default();
        let result = work(&mut tally);
        let (time, after) = (start.elapsed(), child::processor_time());
        let processor = after.zip(before).map(|(after, before)| after.saturating_sub(before));
        self.done.push(Stage { title: title.to_owned(), tally, time, processor });
        result
    }

    /// The stages as lines for [`Stages::take_row`].
    pub fn rows(&self) -> String {
        let mut text = String::new();
        for Stage { title, tally, time, processor } in &self.done {
            let Tally { passed, failed, skipped, broken, left } = tally;
            let (time, processor) = (time.as_millis(), processor.map(|time| time.as_millis().to_string()));
            let processor = processor.unwrap_or_default();
            let _string_grows = writeln!(text, "{ROW}{title}\t{passed}\t{failed}\t{skipped}\t{time}\t{processor}");
            for (start, checks) in [(LEFT, left), (BROKEN, broken)] {
                for Named { what, reason } in checks {
                    let _string_grows = writeln!(text, "{start}{what}\t{reason}");
                }
            }
        }
        text
    }

    /// Adds a stage of another process, or the name of a check that failed or was not made to the last stage; whether
    /// the line is one of [`Stages::rows`].
    pub fn take_row(&mut self, line: &str) -> bool {
        if let Some(Stage { tally, .. }) = self.done.last_mut() {
            for (start, checks) in [(LEFT, &mut tally.left), (BROKEN, &mut tally.broken)] {
                if let Some((what, reason)) = line.strip_prefix(start).and_then(|rest| rest.split_once('\t')) {
                    checks.push(Named::new(what, reason));
                    return true;
                }
            }
        }
        let Some(row) = line.strip_prefix(ROW) else { return false };
        let cells: Vec<&str> = row.split('\t').collect();
        let number = |place: usize| cells.get(place).and_then(|cell| cell.parse::<u64>().ok());
        let counts = [number(1), number(2), number(3), number(4)];
        let (Some(title), [Some(passed), Some(failed), Some(skipped), Some(ms)]) = (cells.first(), counts) else {
            return false;
        };
        let tally = Tally { passed, failed, skipped, ..Tally::default() };
        let (time, processor) = (Duration::from_millis(ms), number(5).map(Duration::from_millis));
        self.done.push(Stage { title: (*title).to_owned(), tally, time, processor });
        true
    }

    /// All stages together.
    pub fn total(&self) -> Tally {
        let mut total = Tally::default();
        for stage in &self.done {
            total.add(&stage.tally);
        }
        total
    }

    /// Prints the table, what was not checked, what failed and, as the last line, the count; whether nothing failed.
    pub fn end(&self) -> bool {
        let total = self.total();
        println!("\n{}\n{}{total}", self.table(), total.list());
        total.failed == 0
    }

    /// The table of stages.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{:22} {:>6} {:>6} {:>7} {:>8} {:>11}\n",
            "stage", "passed", "failed", "skipped", "time", "processor"
        );
        let seconds = |time: Option<Duration>| time.map_or_else(|| "-".into(), |t| format!("{:.1} s", t.as_secs_f32()));
        for Stage { title, tally: Tally { passed, failed, skipped, .. }, time, processor } in &self.done {
            let verdict = if *failed > 0 { "  FAIL" } else { "" };
            let (time, processor) = (seconds(Some(*time)), seconds(*processor));
            let _string_grows =
                writeln!(text, "{title:22} {passed:>6} {failed:>6} {skipped:>7} {time:>8} {processor:>11}{verdict}");
        }
        let processor = self.done.iter().map(|stage| stage.processor).sum();
        let _string_grows = writeln!(text, "{:56}{:>11}", "", seconds(processor));
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_total_is_the_sum_of_the_stages() {
        let mut stages = Stages::default();
        stages.stage("one", |tally| tally.check::<_, &str>("a", Ok("")));
        stages.stage("two", |tally| tally.check::<&str, _>("b", Err("broken")));
        stages.stage("three", |tally| tally.skip("c", "not here"));
        assert_eq!(stages.total().to_string(), "1 passed, 1 failed, 1 skipped");
        assert!(stages.table().contains("two"));
    }

    #[test]
    fn stages_of_another_process_are_added() {
        let mut other = Stages::default();
        other.stage("of a, b", |tally| tally.check::<_, &str>("a", Ok("")));
        other.stage("two", |tally| {
            tally.skip("c", "not here");
            tally.check::<&str, _>("d", Err("at 3\n  of 4"));
        });
        let mut stages = Stages::default();
        assert_eq!(other.rows().lines().filter(|line| stages.take_row(line)).count(), 4);
        assert_eq!(stages.total().to_string(), "1 passed, 1 failed, 1 skipped");
        assert_eq!(stages.total().list(), "not checked:\n  c: not here\nfailed:\n  d: at 3 of 4\n");
        assert!(stages.table().contains("of a, b"));
        let mut known = Stages::default();
        assert!(known.take_row("stage\tone\t1\t0\t0\t4000\t7000"));
        assert!(known.table().contains(" 4.0 s       7.0 s\n"), "{}", known.table());
        assert!(known.take_row("stage\ttwo\t1\t0\t0\t4000\t"));
        assert!(known.table().contains(" 4.0 s           -\n"), "{}", known.table());
        for line in ["pass  a", "stage\tone\t1\t2", "stage\tone\t1\t2\tx\t4", "stage                  passed"] {
            assert!(!stages.take_row(line), "{line}");
        }
    }
}
