//! What the first `cargo demo` costs, as a number that does not depend on the machine: the processor time of our crates
//! and of the demonstration over that of some libraries, compiled in the same run.

use std::time::Duration;

use anyhow::{Result, ensure};

use super::wrapper::Call;

/// Libraries of the demo, at the versions of the lock file. Those that this program uses too are built before.
const REFERENCE: [&str; 6] = ["matrixmultiply", "nalgebra", "rayon", "simba", "statrs", "wide"];
/// Largest and smallest cost. Below it something is not compiled or not counted.
const ALLOWED: [f64; 2] = [4.0, 12.0];
/// Most calls of the compiler.
const MOST_CALLS: usize = 160;

/// Returns the cost in words.
///
/// # Errors
/// A cost out of its bounds, more crates than allowed, or a library that was not compiled.
pub fn judge(calls: &[Call], run: Duration) -> Result<String> {
    ensure!(calls.len() <= MOST_CALLS, "{} crates are compiled; {MOST_CALLS} are allowed", calls.len());
    for name in REFERENCE {
        ensure!(calls.iter().any(|call| call.name == name), "{name} was not compiled: nothing to compare with");
    }
    let sum = |of: &dyn Fn(&str) -> bool| -> Duration {
        calls.iter().filter(|call| of(&call.name)).map(|call| call.processor).sum()
    };
    let reference = sum(&|name| REFERENCE.contains(&name));
    let ours = sum(&|name| name.replace('-', "_").starts_with("bearing_watch")) + run;
    let cost = ours.as_secs_f64() / reference.as_secs_f64();
    let [least, most] = ALLOWED;
    let words = format!("our crates and the demonstration take {cost:.1} times the processor of six libraries");
    ensure!(least <= cost && cost <= most, "{words}; {least} to {most} are allowed; see `cargo xtask times`");
    Ok(words)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cost_is_relative_and_bounded_on_both_sides() {
        let call = |name: &str, seconds| Call {
            name: name.to_owned(),
            time: Duration::ZERO,
            processor: Duration::from_secs(seconds),
        };
        let with = |own: u64| {
            let mut calls = REFERENCE.map(|name| call(name, 2)).to_vec();
            calls.extend([call("bearing_watch", 1), call("bearing-watch-studies (program)", own), call("serde", 900)]);
            calls
        };
        let slow = |mut calls: Vec<Call>| {
            calls.iter_mut().for_each(|call| call.processor *= 3);
            calls
        };
        let words = judge(&with(71), Duration::from_secs(24)).unwrap_or_default();
        assert!(words.contains("take 8.0 times"), "{words}");
        assert_eq!(judge(&slow(with(71)), Duration::from_secs(72)).ok(), Some(words));
        assert!(judge(&with(145), Duration::from_secs(1)).is_err(), "above");
        assert!(judge(&with(1), Duration::from_secs(1)).is_err(), "below");
        assert!(judge(&with(71)[1..], Duration::from_secs(24)).is_err(), "no reference");
        assert!(judge(&[with(71), vec![call("serde", 1); 200]].concat(), Duration::ZERO).is_err(), "too many");
    }
}
