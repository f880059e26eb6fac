//! Several rates in one text: the columns of slower groups are held at the times of the fastest one.
//!
//! ```text
//! 0.0  0.1   0.0  17.5         0.0  0.1  17.5
//! 0.5  0.2   1.0  17.6    ─►   0.5  0.2  17.5
//! 1.0  0.3   2.0  17.7         1.0  0.3  17.6
//! ```
//!
//! A row of such a text is no instant: each group has its own time, and ends by itself.

use crate::units::Unit;
use model::outputs::trimmed;

/// Steps of a group over which its last value is held; behind them it is missing.
const HELD: f64 = 1.5;
/// Part of a step by which times may differ that are the same.
const SAME: f64 = 1e-6;

/// The times of the columns of a text.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rates {
    /// Of each column the place of its time, and the step of that in its unit.
    times: Vec<(usize, f64)>,
    /// The time of the fastest group.
    fastest: usize,
    /// Seconds of the unit of the times.
    unit_s: f64,
}

impl Rates {
    /// By the place of the time of each column and its step in this unit; `None` of one rate.
    pub(super) fn of(times: Vec<(usize, f64)>, unit: &str) -> Option<Self> {
        let unit_s = Unit::named(unit)?.to(&Unit::named("s")?)?.0;
        let (fastest, least) = times.iter().copied().min_by(|one, other| one.1.total_cmp(&other.1))?;
        let is_slower = |(_, step): &(usize, f64)| *step > (1.0 + SAME) * least;
        (least > 0.0 && times.iter().any(is_slower)).then_some(Self { times, fastest, unit_s })
    }

    /// The place of the time of all columns.
    pub(super) const fn time(&self) -> usize {
        self.fastest
    }

    /// What is said of the columns.
    pub(super) fn told(&self, names: &[String]) -> String {
        let rate = |step: f64| trimmed(1.0 / (step * self.unit_s), 6);
        let fastest = self.times[self.fastest].1;
        let mut slow: Vec<(f64, Vec<&str>)> = Vec::new();
        for (name, (_, step)) in
            names.iter().zip(&self.times).filter(|(name, (_, step))| !name.is_empty() && *step > fastest)
        {
            match slow.iter_mut().find(|(own, _)| own == step) {
                Some((_, all)) => all.push(name),
                None => slow.push((*step, vec![name])),
            }
        }
        let each = |(step, names): &(f64, Vec<&str>)| format!("{} ({} a second)", names.join(", "), rate(*step));
        let slow: Vec<String> = slow.iter().map(each).collect();
        format!(
            "several rates in one file: the rows are those of the fastest channels, {} a second, and the last values of \
             slower ones are held: {}; to have these as they were recorded, export the channels of each rate in a file",
            rate(fastest),
            slow.join("; ")
        )
    }

    /// The columns that are read for these ones: these and their times.
    pub(super) fn needed(&self, wanted: &[usize]) -> Vec<usize> {
        let times = wanted.iter().map(|k| self.times[*k].0);
        let mut all: Vec<usize> = wanted.iter().copied().chain(times).chain([self.fastest]).collect();
        all.sort_unstable();
        all.dedup();
        all
    }

    /// The wanted columns at the times of the fastest group, and the seconds by which a group goes on behind it.
    pub(super) fn held(&self, wanted: &[usize], read: &dyn Fn(usize) -> Vec<f64>) -> (Vec<Vec<f64>>, f64) {
        let mut base = read(self.fastest);
        let end = base.iter().rposition(|time| time.is_finite()).map_or(0, |last| last + 1);
        base.truncate(end);
        let mut further = 0.0_f64;
        let mut column = |place: &usize| {
            let (time, step) = self.times[*place];
            let mut values = read(*place);
            if time == self.fastest {
                values.truncate(end);
                return values;
            }
            let times = read(time);
            let last = |times: &[f64]| times.iter().rfind(|time| time.is_finite()).copied();
            if let Some((own, all)) = last(&times).zip(last(&base)) {
                further = further.max((own - all - step) * self.unit_s);
            }
            held_at(&base, (&times, &values), step)
        };
        (wanted.iter().map(&mut column).collect(), further)
    }
}

/// The last of these values at each time; missing before the first one, and where it is older than its steps allow.
fn held_at(at: &[f64], (times, values): (&[f64], &[f64]), step: f64) -> Vec<f64> {
    let (mut next, mut last) = (0, None);
    let value = |at: &f64| {
        while next < times.len() && (times[next].is_nan() || times[next] <= at + SAME * step) {
            if times[next].is_finite() {
                last = Some((times[next], values[next]));
            }
            next += 1;
        }
        // A row without a time has no values.
        let (time, value) = last.filter(|_| at.is_finite())?;
        (at - time < HELD * step).then_some(value)
    };
    at.iter().map(value).map(|value| value.unwrap_or(f64::NAN)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rates(fast: f64, slow: f64) -> Option<Rates> {
        Rates::of(vec![(0, fast), (0, fast), (2, slow), (2, slow), (2, slow)], "ms")
    }

    #[test]
    fn slower_columns_are_held_at_the_times_of_the_fastest() {
        let own = rates(0.5, 1.0).expect("two rates");
        assert_eq!((own.time(), own.needed(&[3])), (0, vec![0, 2, 3]));
        let nan = f64::NAN;
        let table = [
            vec![0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0, nan],
            vec![7.0; 8],
            vec![0.5, 1.5, nan, nan, nan, nan, nan, nan],
            vec![10.0, 11.0, nan, nan, nan, nan, nan, nan],
            vec![nan, 21.0, nan, nan, nan, nan, nan, nan],
        ];
        let (columns, further) = own.held(&[0, 3, 4], &|k| table[k].clone());
        let told: Vec<String> = columns[1].iter().map(ToString::to_string).collect();
        assert_eq!(told, ["NaN", "10", "10", "11", "11", "11", "NaN"]);
        assert_eq!((columns[0].len(), columns[2][3], further <= 0.0), (7, 21.0, true));
        let told = own.told(&["time [ms]", "i", "", "w", "q"].map(String::from));
        assert!(told.contains("2000 a second") && told.contains("w, q (1000 a second)"), "{told}");
    }

    #[test]
    fn one_rate_is_none_of_several() {
        assert_eq!((rates(1.0, 1.0), rates(0.0, 1.0)), (None, None));
    }
}
