//! What is wrong with recordings, in words.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::sync::Arc;

use super::audited::{Audited, Finding};
use crate::resample::unwrapped;
use model::audit::angle as of_angle;
use model::audit::bits;
use model::audit::held::step;
use model::audit::held::{held, too_slow};
use model::audit::pairs::{self, COLLINEAR, correlation, lag};
use model::audit::sessions::apart;
use model::audit::sums;
use model::audit::times::Times;
use model::statistics::mean_sd;
use model::trace::is_reference;
use model::trace::median;

/// Deviation of the steps in time, relative to the usual one, of irregular times.
const IRREGULAR: f64 = 0.05;
/// Largest number of columns whose pairs are compared, and number of rows in which the steps of angle and velocity are
/// searched.
const PAIRED: usize = 200;
const STEPS: usize = 100_000;
/// Fewest rows of which pairs of columns are compared.
const FEWEST_PAIRED: usize = 200;

pub(super) fn add(findings: &mut Vec<Finding>, what: String, trace: &str) {
    match findings.iter_mut().find(|finding| finding.what == what) {
        Some(finding) => finding.traces.push(trace.to_string()),
        None => findings.push(Finding { what, traces: vec![trace.to_string()] }),
    }
}

impl Audited {
    pub(super) fn findings(&self, findings: &mut Vec<Finding>) {
        let id = &self.id;
        if let Some(Times { jitter, gaps, longest_gap_s, standing, rate_hz, .. }) = self.times {
            if jitter > IRREGULAR {
                add(findings, "irregular times (jitter above 5 % of a step); resample".into(), id);
            }
            if gaps > 0 {
                add(findings, format!("gaps in time, up to {:.0} steps", longest_gap_s * rate_hz), id);
            }
            if standing > 0 {
                add(findings, "times that stand; several rows have one time".into(), id);
            }
        }
        for left_out in &self.left_out {
            add(findings, left_out.clone(), id);
        }
        let rate = self.times.map(|times| times.rate_hz);
        let motion = self.angle.as_deref().map(Vec::as_slice).zip(rate);
        for finding in sums::findings(&self.names, &self.signals(), motion) {
            add(findings, finding, id);
        }
        // What is wanted rather than measured may stand, and have few values.
        let measured = self.names.iter().zip(&self.columns).filter(|(name, _)| !is_reference(name));
        for (name, column) in measured {
            for finding in column.findings(rate) {
                add(findings, format!("column {name}: {finding}"), id);
            }
        }
        let counts = self.names.iter().zip(&self.values).filter_map(|(name, x)| Some((name.as_str(), bits::whole(x)?)));
        let angle = self.angle.as_deref().and_then(|x| bits::of_angle(x, step(&x[..x.len().min(STEPS)])));
        for (name, counts) in counts.chain(angle.map(|counts| ("of the angle", counts))) {
            if let Some(finding) = bits::told(&counts) {
                add(findings, format!("column {name}: {finding}"), id);
            }
        }
        let is_whole = self.times.is_none_or(|times| times.gaps == 0);
        if let Some(finding) = self.angle.as_deref().filter(|_| is_whole).and_then(|angle| of_angle::lost_rows(angle)) {
            add(findings, finding, id);
        }
        for said in self.turning.told() {
            add(findings, said, id);
        }
        let slow = self.current.as_deref().and_then(|current| too_slow(held(current)?, rate));
        if let Some(problem) = slow {
            add(findings, format!("the current {problem}"), id);
        }
        let is_compared = self.values.len() <= PAIRED && self.rows() >= FEWEST_PAIRED;
        let compared = if is_compared { &self.values[..] } else { &[][..] };
        // Counts of rows and travels that only go on are alike whatever they count.
        let rises: Vec<bool> = compared.iter().map(|x| x.windows(2).all(|pair| pair[1] >= pair[0])).collect();
        if self.values.len() > PAIRED {
            let what = format!("{} columns: pairs of them were not compared", self.values.len());
            add(findings, what, id);
        }
        for (k, one) in compared.iter().enumerate() {
            for (j, other) in self.values.iter().enumerate().take(k) {
                // What is wanted and what is measured are alike in a good drive.
                let is_wanted = is_reference(&self.names[j]) != is_reference(&self.names[k]);
                if !(is_wanted || rises[j] && rises[k]) && correlation(one, other).abs() > COLLINEAR {
                    add(findings, format!("columns {} and {} say the same", self.names[j], self.names[k]), id);
                }
            }
        }
        // Where times are irregular, the velocity does not tell how far the shaft turns from row to row.
        let even = |times: &Times| times.jitter <= IRREGULAR && times.gaps == 0;
        let times = self.times.filter(|times| even(times) && self.turning.contradiction.is_none());
        if let (Some(velocity), Some(angle), Some(times)) = (&self.velocity, &self.angle, times) {
            for finding in of_angle::findings(angle, velocity, times.rate_hz) {
                add(findings, finding, id);
            }
            let step = |x: &[f64]| step(&x[..x.len().min(STEPS)]);
            let deviation = mean_sd(velocity).1;
            let steps = (step(angle), step(velocity), deviation);
            if let Some(finding) = of_angle::coarse(steps, times.rate_hz) {
                add(findings, finding, id);
            }
        }
        if let (Some(velocity), Some(angle)) = (&self.velocity, &self.angle) {
            // A difference is half a row later than the first of its two angles.
            let differences: Vec<f64> = unwrapped(angle, TAU).windows(2).map(|pair| pair[1] - pair[0]).collect();
            if let Some((rows, _)) = lag(&differences, velocity).filter(|(rows, _)| (rows - 0.5).abs() > 0.75) {
                add(findings, format!("the velocity comes {rows:.1} rows after the angle's differences"), id);
            }
        }
        if let (Some(y), Some(u)) = (&self.current, self.velocity_ref.as_ref().or(self.velocity.as_ref()))
            && let (mean, deviation) = mean_sd(u)
            && deviation < 1e-3 * mean.abs()
            && mean_sd(y).1 > 0.0
        {
            add(findings, "constant speed: inertia and friction cannot be told apart".into(), id);
        }
    }
}

/// Finds classes that differ in what no bearing changes.
pub(super) fn session_sets(traces: &[Audited], classes: &[String], findings: &mut Vec<Finding>) {
    if classes.is_empty() {
        return;
    }
    let mean = |signal: &Option<Arc<Vec<f64>>>| signal.as_ref().map_or(f64::NAN, |signal| mean_sd(signal).0);
    let step = |trace: &Audited, name: &str| {
        let place = trace.names.iter().position(|own| own == name);
        place.map_or(f64::NAN, |place| trace.columns[place].step)
    };
    let time = |of: fn(&Times) -> f64| move |trace: &Audited| trace.times.as_ref().map_or(f64::NAN, of);
    let mut compare = |property: &str, of: &dyn Fn(&Audited) -> f64, size: Option<f64>| {
        let values: Vec<f64> = traces.iter().map(of).collect();
        let known: Vec<f64> =
            values.iter().zip(classes).map(|(x, class)| if class.is_empty() { f64::NAN } else { *x }).collect();
        for found in apart(property, (&known, size), classes) {
            add(findings, found.to_string(), "all of both");
        }
    };
    compare("the rate", &time(|times| times.rate_hz), None);
    compare("the jitter of the times", &time(|times| times.jitter), None);
    compare("the number of rows", &|trace| trace.values.first().map_or(f64::NAN, |column| column.len() as f64), None);
    // Of a controlled velocity the reference says what was asked for; the friction changes the velocity itself.
    let asked: fn(&Audited) -> &Option<Arc<Vec<f64>>> =
        if traces.iter().any(|trace| trace.velocity_ref.is_some()) { |t| &t.velocity_ref } else { |t| &t.velocity };
    let sizes: Vec<f64> =
        traces.iter().filter_map(|trace| asked(trace).as_deref()).map(|signal| largest(signal)).collect();
    compare("the mean speed", &|trace| mean(asked(trace)), Some(median(&sizes)));
    for name in &traces[0].names {
        compare(&format!("the step of {name}"), &|trace| step(trace, name), None);
    }
}

/// The largest magnitude.
fn largest(signal: &[f64]) -> f64 {
    signal.iter().fold(0.0, |most, x| x.abs().max(most))
}

/// Finds traces whose rate differs from that of the others.
pub(super) fn several_rates(traces: &[Audited], findings: &mut Vec<Finding>) {
    /// Difference of two rates that are not one.
    const APART: f64 = 0.02;
    let rates = || traces.iter().filter_map(|trace| Some((trace.times?.rate_hz, &trace.id)));
    let usual = median(rates().map(|(rate, _)| rate).collect::<Vec<_>>());
    for (rate, id) in rates().filter(|(rate, _)| (rate / usual - 1.0).abs() > APART) {
        add(findings, format!("{rate:.4} rows a second, where most traces have {usual:.4}"), id);
    }
}

pub(super) fn equal_traces(traces: &[Audited], findings: &mut Vec<Finding>) {
    /// Most traces that are named with those that repeat them.
    const NAMED: usize = 3;
    let columns: Vec<Vec<&[f64]>> = traces.iter().map(Audited::signals).collect();
    let mut first_of: BTreeMap<usize, usize> = BTreeMap::new();
    for [one, other] in pairs::equal(&columns) {
        first_of.entry(other).and_modify(|first| *first = one.min(*first)).or_insert(one);
    }
    let firsts: BTreeSet<usize> = first_of.values().copied().collect();
    for (other, first) in first_of {
        let which = if firsts.len() > NAMED { "another one" } else { &traces[first].id };
        add(findings, format!("the same recording as {which}"), &traces[other].id);
    }
}
