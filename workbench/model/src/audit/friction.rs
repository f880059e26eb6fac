//! Estimates of friction and inertia from a trace, and the smallest change of each that would be detected.
//!
//! ```text
//! i = p₁ dω/dt + p₂ ω + p₃ tanh(ω/ω₀) + p₄ T_load + p₅ + e                                   (1)
//! own part   1 − R² of a term on the other terms                                              (2)  1 if orthogonal
//! smallest   (t √(1 + 1/n) + 1.28) s                                                          (3)
//! ```
//!
//! Every signal of (1) passes one low-pass filter, behind which a long recording is decimated. A term that the others
//! make up is left out. Changes are given in the unit of the current, at the usual (rms) size of the term. In (3), s
//! is the deviation of p over the n healthy traces and t the quantile of Student's distribution with n − 1 degrees of
//! freedom at the rate of false alarms: a change of that size is found in 9 of 10 traces of a drive like these. By
//! noise alone, s is the deviation of the estimate of one trace, and t that of the normal distribution.

use nalgebra::DVector;
use serde_json::{Value, json};
use statrs::distribution::{ContinuousCDF as _, Normal, StudentsT};

use crate::grey_box::filter::LowPass;
use crate::grey_box::normal::{inverse, solve};
use crate::statistics::mean_sd;
use crate::trace::median;

/// Names of the terms of (1).
const TERMS: [&str; 5] = ["inertia", "viscous friction", "Coulomb friction", "load", "constant"];
/// Cut-off of the filter, Hz, and as a part of the rate at most.
const CUTOFF_HZ: f64 = 8.0;
const CUTOFF_PART: f64 = 0.1;
/// Periods of the cut-off after which the filter has settled.
const SETTLED: f64 = 1.6;
/// Least part of its own that a term must have (2).
const OWN: f64 = 1e-3;
/// Rows up to which all are taken, and samples of the settling time that are left of more.
const ALL: usize = 1_000_000;
const LEFT: usize = 32;
/// 90 % quantile of the normal distribution.
const POWER: f64 = 1.28;
/// Fewest healthy traces of which a spread is given.
const FEWEST: usize = 4;

/// The terms of one trace, at their usual size, in the unit of the current.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms {
    /// Value, deviation by noise and own part (2) of each term; `None` if the trace does not determine it.
    of: [Option<[f64; 3]>; 5],
}

/// The signals of a trace.
#[derive(Clone, Copy, Debug)]
pub struct Motion<'a> {
    /// Current.
    pub current: &'a [f64],
    /// Velocity.
    pub velocity: &'a [f64],
    /// Load, if it is measured.
    pub load: Option<&'a [f64]>,
    /// Rows a second.
    pub rate_hz: f64,
}

impl Terms {
    /// Estimates (1); `None` for a trace that is too short or does not move.
    #[must_use]
    pub fn of(motion: &Motion<'_>) -> Option<Self> {
        Self::of_long(motion, ALL)
    }

    /// The same; of more than `all` rows the filtered signals are decimated.
    fn of_long(motion: &Motion<'_>, all: usize) -> Option<Self> {
        let cutoff = (CUTOFF_HZ / motion.rate_hz).min(CUTOFF_PART);
        let dropped = (SETTLED / cutoff).ceil() as usize;
        let rows = motion.current.len().min(motion.velocity.len());
        let size = (motion.velocity.iter().map(|v| v * v).sum::<f64>() / rows.max(1) as f64).sqrt();
        if rows < 6 * dropped || size.is_nan() || size <= 0.0 {
            return None;
        }
        let filter = LowPass::butterworth(1, cutoff);
        // 20 samples in a period of the cut-off: what is folded back is below a hundredth.
        let every = (dropped / LEFT).min(rows / all).max(1);
        let smooth = |x: &[f64]| settled(filter.forward(&x[..rows]), dropped, every);
        let direction: Vec<f64> = motion.velocity[..rows].iter().map(|v| (v / (0.05 * size)).tanh()).collect();
        let slope = settled(filter.derivative(&motion.velocity[..rows]), dropped, every) * motion.rate_hz;
        let mut columns = [
            Some(slope),
            Some(smooth(motion.velocity)),
            Some(smooth(&direction)),
            motion.load.map(smooth),
            Some(DVector::from_element((rows - dropped).div_ceil(every), 1.0)),
        ];
        drop(direction);
        // The constant and the velocity first: other terms are left out for them, not they for others.
        let mut kept: Vec<usize> = vec![];
        for term in [4, 1, 2, 3, 0] {
            let Some(column) = &columns[term] else { continue };
            let regressors: Vec<_> = kept.iter().filter_map(|&k| columns[k].as_ref()).chain([column]).collect();
            if inverse(&regressors).is_some_and(|inverse| inverse.own_part(kept.len()) > OWN) {
                kept.push(term);
            }
        }
        kept.sort_unstable();
        let chosen: Vec<DVector<f64>> = kept.iter().filter_map(|&k| columns[k].take()).collect();
        let solution = solve(&chosen, &smooth(motion.current), dropped / every)?;
        let mut of = [None; 5];
        for (k, &term) in kept.iter().enumerate() {
            let usual = chosen[k].norm() / (chosen[k].len() as f64).sqrt();
            let deviation = solution.covariance[(k, k)].max(0.0).sqrt();
            of[term] = Some([solution.theta[k] * usual, deviation * usual, solution.inverse.own_part(k)]);
        }
        Some(Self { of })
    }
}

/// Every n-th row of a filtered signal, without its first rows.
fn settled(mut x: Vec<f64>, dropped: usize, every: usize) -> DVector<f64> {
    if every == 1 {
        x.drain(..dropped);
        return DVector::from_vec(x);
    }
    DVector::from_vec(x.into_iter().skip(dropped).step_by(every).collect())
}

/// One term over the traces.
#[derive(Clone, Debug, PartialEq)]
pub struct Excited {
    /// Name of the term.
    pub term: &'static str,
    /// Number of traces that determine it, and of all with a motion.
    pub determined: [usize; 2],
    /// Median of the values, and of the own parts (2).
    pub usual: f64,
    /// See [`Excited::usual`].
    pub own: f64,
    /// (3) by noise alone.
    pub by_noise: f64,
    /// (3) by the spread over healthy traces, and their number; `None` of fewer than four.
    pub by_spread: Option<(f64, usize)>,
}

/// Returns the terms that traces determine. `healthy` says which traces are healthy; if none is known to be, all count.
#[must_use]
pub fn excited(traces: &[(Terms, bool)], false_alarm: f64) -> Vec<Excited> {
    let any = traces.iter().any(|(_, healthy)| *healthy);
    let upper = |law: Option<f64>| law.unwrap_or(f64::INFINITY);
    let normal = upper(Normal::new(0.0, 1.0).ok().map(|law| law.inverse_cdf(1.0 - false_alarm)));
    let each = |term: usize| {
        let all: Vec<[f64; 3]> = traces.iter().filter_map(|(own, _)| own.of[term]).collect();
        let healthy = traces.iter().filter(|(_, healthy)| *healthy || !any).filter_map(|(own, _)| own.of[term]);
        let healthy: Vec<f64> = healthy.map(|[value, ..]| value).collect();
        let middle = |place: usize| median(all.iter().map(|own| own[place]).collect::<Vec<_>>());
        let n = healthy.len();
        let by_spread = (n >= FEWEST).then(|| {
            let law = StudentsT::new(0.0, 1.0, n as f64 - 1.0).ok().map(|law| law.inverse_cdf(1.0 - false_alarm));
            ((upper(law) * (1.0 + 1.0 / n as f64).sqrt() + POWER) * mean_sd(&healthy).1, n)
        });
        (!all.is_empty()).then(|| Excited {
            term: TERMS[term],
            determined: [all.len(), traces.len()],
            usual: middle(0),
            own: middle(2),
            by_noise: (normal + POWER) * middle(1),
            by_spread,
        })
    };
    (0..TERMS.len()).filter_map(each).collect()
}

impl Excited {
    /// JSON object with the keys `term`, `determined`, `traces`, `usual`, `own_part`, `smallest_by_noise`,
    /// `smallest_by_spread`, `healthy_traces`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { term, determined: [determined, traces], usual, own, by_noise, by_spread } = self;
        let (spread, healthy) = by_spread.unzip();
        json!({
            "term": term, "determined": determined, "traces": traces, "usual": usual, "own_part": own,
            "smallest_by_noise": by_noise, "smallest_by_spread": spread, "healthy_traces": healthy,
        })
    }

    /// A change, and what it is of the usual value.
    #[must_use]
    pub fn part(&self, change: f64) -> String {
        let percent = 100.0 * change / self.usual.abs();
        if percent < 1e4 { format!("{change:.4} ({percent:.0} %)") } else { format!("{change:.4}") }
    }

    /// The headings of the lines.
    #[must_use]
    pub fn heading() -> String {
        let (term, traces, own, usual) = ("term", "traces", "own part", "usual");
        format!(
            "{term:18} {traces:>9} {own:>9} {usual:>10}   smallest change by noise, by the spread of healthy traces"
        )
    }
}

impl std::fmt::Display for Excited {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { term, determined: [determined, traces], usual, own, by_noise, by_spread } = self;
        let spread = match by_spread {
            Some((change, n)) => format!("{} of {n}", self.part(*change)),
            None => "– (fewer than 4)".into(),
        };
        let count = format!("{determined}/{traces}");
        write!(f, "{term:18} {count:>9} {own:>9.3} {usual:>10.4}   {}, {spread}", self.part(*by_noise))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::{Defect, DefectKind, Scenario, simulate, trace_seed};

    fn terms(defect: Option<Defect>, number: u32, kind: DefectKind) -> Terms {
        let scenario = defect.map_or(Scenario::STANDARD, |defect| Scenario::STANDARD.with_defect(defect));
        let trace = simulate(&scenario, trace_seed(31, kind, number)).expect("valid");
        let motion = Motion {
            current: &trace.current_a,
            velocity: &trace.velocity_rad_s,
            load: Some(&trace.load_torque_nm),
            rate_hz: 500.0,
        };
        Terms::of(&motion).expect("motion")
    }

    /// The smallest change that is promised is the size at which about nine of ten defects stand out.
    #[test]
    fn the_smallest_friction_is_found_in_nine_of_ten() {
        let healthy: Vec<(Terms, bool)> = (0..40).map(|k| (terms(None, k, DefectKind::Healthy), true)).collect();
        let found = excited(&healthy, 0.01);
        let of = |name: &str| found.iter().find(|own| own.term == name).expect("excited").clone();
        let viscous = of("viscous friction");
        let (smallest, count) = viscous.by_spread.expect("40 traces");
        assert_eq!((count, viscous.determined), (40, [40, 40]));
        // Roughness of full size doubles the viscous friction; its change is linear in the size.
        let full = terms(Some(Defect::full(DefectKind::Roughness)), 0, DefectKind::Roughness).of[1].expect("seen")[0];
        let size = smallest / (full - viscous.usual);
        assert!((0.003..0.5).contains(&size), "{size}");
        let values: Vec<f64> = healthy.iter().filter_map(|(own, _)| own.of[1]).map(|own| own[0]).collect();
        let (mean, deviation) = mean_sd(&values);
        let gate = mean + smallest - POWER * deviation;
        let seen = (0..60).filter(|&k| {
            let defect = Defect { severity: size, ..Defect::full(DefectKind::Roughness) };
            terms(Some(defect), k, DefectKind::Roughness).of[1].expect("seen")[0] > gate
        });
        // 90 %: standard deviation 4 %.
        let seen = seen.count();
        assert!((47..=60).contains(&seen), "{seen} of 60");
    }

    #[test]
    fn a_long_recording_has_the_terms_of_all_its_rows() {
        let trace = simulate(&Scenario::STANDARD, trace_seed(5, DefectKind::Healthy, 3)).expect("scenario");
        let (current, velocity) = (&trace.current_a, &trace.velocity_rad_s);
        let motion = Motion { current, velocity, load: Some(&trace.load_torque_nm), rate_hz: 500.0 };
        let [all, decimated] = [ALL, 1000].map(|all| Terms::of_long(&motion, all).expect("motion").of);
        for (one, other) in all.iter().zip(&decimated) {
            let (Some(one), Some(other)) = (one, other) else { panic!("{all:?} {decimated:?}") };
            // Of the deviation, which the decimated rows estimate anew; it scatters by a tenth.
            assert!((one[0] - other[0]).abs() < 0.5 * one[1], "{one:?} {other:?}");
            assert!((other[1] / one[1] - 1.0).abs() < 0.3, "{one:?} {other:?}");
            assert!((other[2] / one[2] - 1.0).abs() < 0.05, "{one:?} {other:?}");
        }
    }

    #[test]
    fn a_constant_speed_determines_one_term() {
        let noise = |k: usize| ((k * 7919) % 1000) as f64 * 1e-4;
        let current: Vec<f64> = (0..4000).map(|k| 2.0 + noise(k)).collect();
        let motion = Motion { current: &current, velocity: &[30.0; 4000], load: None, rate_hz: 1000.0 };
        let found = excited(&[(Terms::of(&motion).expect("motion"), false)], 0.01);
        assert_eq!(found.iter().map(|own| own.term).collect::<Vec<_>>(), ["constant"]);
        assert!(found[0].by_spread.is_none() && (found[0].usual - 2.05).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn the_smallest_change_is_that_of_the_formula() {
        // Four healthy values with the deviation √(5/3), and a defect, which widens nothing.
        let terms = |value: f64| Terms { of: [Some([value, 0.5, 0.9]), None, None, None, None] };
        let mut traces: Vec<(Terms, bool)> = [1.0, 2.0, 3.0, 4.0].map(|value| (terms(value), true)).to_vec();
        traces.push((terms(100.0), false));
        let [found] = &excited(&traces, 0.01)[..] else { panic!("one term") };
        // The 99 % quantiles of Student's distribution with 3 degrees of freedom and of the normal one, to 7 digits.
        let expected = (4.540_703 * 1.25_f64.sqrt() + 1.28) * (5.0_f64 / 3.0).sqrt();
        let (smallest, count) = found.by_spread.expect("four healthy traces");
        assert!(count == 4 && (smallest - expected).abs() < 1e-5, "{smallest} {expected}");
        assert!((found.by_noise - (2.326_348 + 1.28) * 0.5).abs() < 1e-6, "{}", found.by_noise);
        assert_eq!((found.determined, found.usual, found.own), ([5, 5], 3.0, 0.9));
        assert!(excited(&traces[1..], 0.01)[0].by_spread.is_none(), "three healthy traces");
    }
}
