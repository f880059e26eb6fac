//! Times of rows: counters that wrap, midnight, and times that are rounded.
//!
//! | module | content |
//! |---|---|
//! | [`clock`] | dates, times of the day and large numbers → seconds from the first row |
//! | [`names`] | columns that are times by their names, and the unit of times without one |
//! | [`second_part`] | the part of a second in a column of its own |
//! | [`usual_rate`] | the usual rate that rounded times allow |
//! | `rounded` | rounded times → the line that they are rounded from |

pub(crate) mod clock;
pub(crate) mod names;
mod rounded;
pub(crate) mod second_part;
pub(crate) mod usual_rate;

pub(crate) use rounded::evened;

use model::trace::median;

/// Bits of the counters of loggers.
const BITS: [i32; 4] = [16, 24, 31, 32];
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;
/// Steps that a row may come late behind a wrap.
const LATE: f64 = 10.0;
/// Goes on where a counter of ticks of so many seconds wraps, or a clock passes midnight; says at which row.
pub(crate) fn unwrapped(times: &mut [f64], tick_s: Option<f64>) -> Option<String> {
    if times.is_sorted() {
        return None;
    }
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0).collect();
    let usual = median(&steps);
    let counters = tick_s
        .into_iter()
        .flat_map(|tick| BITS.map(|bits| (2_f64.powi(bits) * tick, format!("a counter of {bits} bits wraps"))));
    let all: Vec<(f64, String)> = counters.chain([(DAY_S, "the day ends".to_string())]).collect();
    let (mut shift, mut told) = (0.0, None);
    for row in 1..times.len() {
        let step = times[row] + shift - times[row - 1];
        if step < 0.0 {
            let fits = |(turn, _): &&(f64, String)| (0.0..=LATE * usual).contains(&(step + turn));
            let (turn, why) = all.iter().find(fits)?;
            shift += turn;
            told.get_or_insert_with(|| format!("{why} at row {}; the time goes on", row + 1));
        }
        times[row] += shift;
    }
    told
}

/// Whether most rows have the time of the row before.
pub(crate) fn stands(times: &[f64]) -> bool {
    /// Fewest rows that tell it.
    const FEWEST: usize = 16;
    let standing = times.windows(2).filter(|pair| pair[0] == pair[1]).count();
    times.len() >= FEWEST && 2 * standing > times.len()
}

/// The first row whose time is before that of an earlier one; a row may lack its time.
pub(crate) fn backwards(times: &[f64]) -> Option<usize> {
    // The quick check of the whole column first; the place only where it fails.
    if times.is_sorted() {
        return None;
    }
    let mut latest = f64::NEG_INFINITY;
    times.iter().position(|time| {
        let is_before = *time < latest;
        latest = latest.max(*time);
        is_before
    })
}

#[cfg(test)]
mod loggers;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counters_and_clocks_go_on() {
        let ticks = |k: u64| ((4_294_717_295 + 250 * k) % (1 << 32)) as f64 * 1e-6;
        let mut times: Vec<f64> = (0..3000).map(ticks).collect();
        let told = unwrapped(&mut times, Some(1e-6)).expect("wraps");
        assert!(told.contains("32 bits wraps at row"), "{told}");
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 2.5e-4).abs() < 1e-9));
        let mut times: Vec<f64> = (0..100).map(|k| f64::from(86_398_000 + 100 * k) % 86_400_000.0 / 1e3).collect();
        assert!(unwrapped(&mut times, None).expect("midnight").contains("the day ends at row 21"));
        assert!(times.windows(2).all(|pair| (pair[1] - pair[0] - 0.1).abs() < 1e-9));
        // Rows in disorder stay so.
        let disorder = vec![0.0, 0.1, 0.3, 0.2, 0.4];
        let mut times = disorder.clone();
        assert!(unwrapped(&mut times, Some(1e-6)).is_none());
        assert_eq!(times, disorder);
    }
}
