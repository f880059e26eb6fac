//! Counting what passed, and the table at the end.

use std::fmt::{self, Write as _};
use std::time::{Duration, Instant};

use crate::child;

/// How many checks ended how.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Tally {
    pub passed: u64,
    pub failed: u64,
    pub skipped: u64,
}

impl Tally {
    /// One check's outcome, said aloud.
    pub fn check<T: fmt::Display, E: fmt::Display>(&mut self, what: &str, outcome: Result<T, E>) {
        match outcome {
            Ok(detail) => {
                self.passed += 1;
                println!("pass  {what}{}", Detail(detail));
            }
            Err(detail) => {
                self.failed += 1;
                println!("FAIL  {what}{}", Detail(detail));
            }
        }
    }

    /// A check that cannot be made here, said aloud.
    pub fn skip(&mut self, what: &str, reason: &str) {
        self.skipped += 1;
        println!("skip  {what}: {reason}");
    }

    /// Adds a line such as `test result: ok. 5 passed; 0 failed; 2 ignored; 0 measured; …`.
    pub fn add_libtest(&mut self, line: &str) {
        if !line.starts_with("test result: ") {
            return;
        }
        let mut number = 0;
        for word in line.split([' ', ';']) {
            match word {
                "passed" => self.passed += number,
                "failed" => self.failed += number,
                "ignored" => self.skipped += number,
                other => number = other.parse().unwrap_or(0),
            }
        }
    }

    /// Adds a line such as `2 failed, 121 passed, 1 skipped, 3 xfailed, 1 error in 4.50s`, the last one of pytest.
    pub fn add_pytest(&mut self, line: &str) {
        let line = line.trim_matches(['=', ' ']);
        let Some((counts, _)) = line.rsplit_once(" in ").filter(|(_, time)| time.contains('s')) else { return };
        let counts = counts.split(", ").map(|part| part.split_once(' '));
        let counts = counts.map(|part| part.and_then(|(number, word)| Some((number.parse().ok()?, word))));
        let Some(counts) = counts.collect::<Option<Vec<(u64, &str)>>>() else { return };
        for (number, word) in counts {
            match word {
                "passed" | "xfailed" => self.passed += number,
                "failed" | "error" | "errors" | "xpassed" => self.failed += number,
                "skipped" => self.skipped += number,
                _ => {}
            }
        }
    }

    fn add(&mut self, other: Self) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
    }
}

/// A colon and the text, or nothing where there is none.
struct Detail<T>(T);

impl<T: fmt::Display> fmt::Display for Detail<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = self.0.to_string();
        if text.is_empty() { Ok(()) } else { write!(f, ": {text}") }
    }
}

/// The last line of a run; scripts read it.
impl fmt::Display for Tally {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { passed, failed, skipped } = self;
        write!(f, "{passed} passed, {failed} failed, {skipped} skipped")
    }
}

/// What a line of [`Stages::rows`] starts with.
const ROW: &str = "stage\t";

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
        let row = |Stage { title, tally: Tally { passed, failed, skipped }, time, processor }: &Stage| {
            let processor = processor.map(|time| time.as_millis().to_string()).unwrap_or_default();
            format!("{ROW}{title}\t{passed}\t{failed}\t{skipped}\t{}\t{processor}\n", time.as_millis())
        };
        self.done.iter().map(row).collect()
    }

    /// Adds a stage of another process; whether the line is one of [`Stages::rows`].
    pub fn take_row(&mut self, line: &str) -> bool {
        let Some(row) = line.strip_prefix(ROW) else { return false };
        let cells: Vec<&str> = row.split('\t').collect();
        let number = |place: usize| cells.get(place).and_then(|cell| cell.parse::<u64>().ok());
        let counts = [number(1), number(2), number(3), number(4)];
        let (Some(title), [Some(passed), Some(failed), Some(skipped), Some(ms)]) = (cells.first(), counts) else {
            return false;
        };
        let tally = Tally { passed, failed, skipped };
        let (time, processor) = (Duration::from_millis(ms), number(5).map(Duration::from_millis));
        self.done.push(Stage { title: (*title).to_owned(), tally, time, processor });
        true
    }

    /// All stages together.
    pub fn total(&self) -> Tally {
        let mut total = Tally::default();
        for stage in &self.done {
            total.add(stage.tally);
        }
        total
    }

    /// The table of stages.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{:22} {:>6} {:>6} {:>7} {:>8} {:>11}\n",
            "stage", "passed", "failed", "skipped", "time", "processor"
        );
        let seconds = |time: Option<Duration>| time.map_or_else(|| "-".into(), |t| format!("{:.1} s", t.as_secs_f32()));
        for Stage { title, tally: Tally { passed, failed, skipped }, time, processor } in &self.done {
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
    fn libtest_lines_add_up() {
        let mut tally = Tally::default();
        tally.add_libtest(
            "test result: ok. 5 passed; 0 failed; 2 ignored; 0 measured; 1 filtered out; finished in 0.00s",
        );
        tally.add_libtest(
            "test result: FAILED. 1 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1.20s",
        );
        tally.add_libtest("test passed ... ok");
        assert_eq!(tally.to_string(), "6 passed, 3 failed, 2 skipped");
    }

    #[test]
    fn the_last_line_of_pytest_adds_up() {
        let mut tally = Tally::default();
        tally.add_pytest("= 2 failed, 121 passed, 1 skipped, 3 xfailed, 4 warnings, 1 error in 405.51s (0:06:45) =");
        tally.add_pytest("tests/test_x.py ....    [ 12%]");
        tally.add_pytest("9 bottles hang in 3 rows");
        assert_eq!(tally.to_string(), "124 passed, 3 failed, 1 skipped");
        tally.add_pytest("5 passed in 1.20s");
        assert_eq!(tally.passed, 129);
    }

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
        other.stage("two", |tally| tally.skip("c", "not here"));
        let mut stages = Stages::default();
        assert_eq!(other.rows().lines().filter(|line| stages.take_row(line)).count(), 2);
        assert_eq!(stages.total().to_string(), "1 passed, 0 failed, 1 skipped");
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
