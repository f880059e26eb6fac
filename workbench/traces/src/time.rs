//! Times of rows: counters that wrap, midnight, and times that are rounded.

use model::trace::median;

/// Bits of the counters of loggers.
const BITS: [i32; 4] = [16, 24, 31, 32];
/// Seconds of a day.
const DAY_S: f64 = 86_400.0;
/// Steps that a row may come late behind a wrap.
const LATE: f64 = 10.0;
/// Times are rounded if the unit is at least this part of a step.
const COARSE: f64 = 1e-3;
/// Least number and least part of the steps that rounding made longer than others: fewer may be rows that are missing.
const LONGER: f64 = 20.0;
const PART: f64 = 0.1;
/// Part of a unit by which steps of rounded times may be off whole units.
const WHOLE: f64 = 0.1;

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

/// Puts times that are rounded to a coarse unit onto the line that they are rounded from; says so.
pub(crate) fn evened(times: &mut [f64]) -> Option<String> {
    let first = *times.first()?;
    let steps: Vec<f64> = times.windows(2).map(|pair| pair[1] - pair[0]).collect();
    // The line of least squares: the first and the last time are rounded as well.
    let middle = 0.5 * (times.len() - 1) as f64;
    let (mut products, mut squares) = (0.0, 0.0);
    for (k, time) in times.iter().enumerate() {
        let at = k as f64 - middle;
        products += at * (time - first);
        squares += at * at;
    }
    let step = products / squares;
    // Of times that are no numbers nothing is known.
    if !step.is_finite() || step <= 0.0 {
        return None;
    }
    let shortest = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let unit = steps.iter().map(|own| own - shortest).filter(|own| *own > COARSE * step).fold(f64::INFINITY, f64::min);
    let longer = steps.iter().filter(|own| **own > shortest + 0.5 * unit).count();
    let rare = longer.min(steps.len() - longer) as f64;
    if !unit.is_finite() || rare < LONGER || rare < PART * steps.len() as f64 {
        return None;
    }
    // Rounded times are apart by whole units.
    let is_whole = |own: &f64| (own / unit - (own / unit).round()).abs() < WHOLE;
    if !steps.iter().all(is_whole) {
        return None;
    }
    // Rounding moves each time by at most a unit; a row that is missing moves all later ones by a step.
    let off = |(k, time): (usize, &f64)| time - first - k as f64 * step;
    let (low, high) =
        times.iter().enumerate().map(off).fold((0.0_f64, 0.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    if high - low > 1.02 * unit {
        return None;
    }
    times.iter_mut().enumerate().for_each(|(k, time)| *time = first + k as f64 * step);
    Some(format!("the times are rounded to {unit:.3e} s; {:.6} rows a second by all of them", 1.0 / step))
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

    #[test]
    fn rounded_times_are_those_of_the_rate_and_lost_rows_stay() {
        // 1500 Hz in whole milliseconds.
        let mut times: Vec<f64> = (0..3000).map(|k| (f64::from(k) / 1.5).floor() / 1e3).collect();
        assert!(evened(&mut times).expect("rounded").contains("1500"), "{times:?}");
        assert!((times[2999] - times[0] - 1.999).abs() < 2e-3);
        let lost: Vec<f64> = (0..3000).filter(|k| k % 50 != 7).map(|k| f64::from(k) / 1e3).collect();
        let irregular: Vec<f64> = (0..3000).map(|k| f64::from(k) / 1e3 + f64::from(k * 7 % 5) * 1e-4).collect();
        let even: Vec<f64> = (0..3000).map(|k| f64::from(k) / 1e3).collect();
        // %g behind 100 s: more than half of the times stand.
        let mut coarse: Vec<f64> = (0..2500).map(|k| ((100.0 + f64::from(k) * 4e-4) * 1e3).round() / 1e3).collect();
        assert!(evened(&mut coarse).is_some());
        let rate = 2499.0 / (coarse[2499] - coarse[0]);
        assert!((rate / 2500.0 - 1.0).abs() < 2e-5, "{rate}");
        for times in [lost, even] {
            let mut own = times.clone();
            assert_eq!(evened(&mut own), None);
            assert_eq!(own, times);
        }
        // Jitter of known steps is rounding as well: the rows are those of the line.
        assert!(evened(&mut irregular.clone()).is_none());
    }
}
