//! Evaluation of several segments together: combined surprise, and the core's evidence.

use bearing_watch::alarm::{Contribution, Growth, Interval, Silence};
use bearing_watch::plan::RunTime;
use bearing_watch::{Alarm, Decision, Evidence, Model};

use super::coordinates::Side;
use super::segment::SegmentReport;

/// State of the evidence after a segment.
#[derive(Clone, Debug, PartialEq)]
pub struct AlarmState {
    /// Largest score, nats.
    pub score: f32,
    /// The alarm, once raised.
    pub alarm: Option<Alarm>,
    /// What raised it, in a model whose alarm watches directions.
    pub main: Option<Contribution>,
    /// Size and growth in the direction that raised the alarm, before an alarm in that of the largest score.
    pub growth: Option<(u8, Growth)>,
    /// Whether no segment has had a verdict for too long, and why.
    pub silence: Option<Silence>,
    /// What each direction contributes, after the last segment of a run; empty after others.
    pub run: Vec<Contribution>,
    /// Size and growth in each direction, after the last segment of a run; empty after others.
    pub growths: Vec<Growth>,
}

impl AlarmState {
    pub(super) fn of(evidence: &Evidence<RunTime>) -> Self {
        let (score, alarm) = (evidence.score(), evidence.alarm());
        let (main, silence) = (evidence.main_contribution(), evidence.silence());
        let directions = (0..u8::MAX).map_while(|k| evidence.contribution(k));
        let largest = directions.max_by(|a, b| a.score.total_cmp(&b.score));
        let direction = main.or(largest).map(|contribution| contribution.direction);
        let growth = direction.and_then(|k| evidence.growth(k).map(|growth| (k, growth)));
        Self { score, alarm, main, growth, silence, run: vec![], growths: vec![] }
    }

    /// At the end of a run.
    pub(super) fn of_run(evidence: &Evidence<RunTime>) -> Self {
        let run = (0..u8::MAX).map_while(|direction| evidence.contribution(direction)).collect();
        let growths = (0..u8::MAX).map_while(|direction| evidence.growth(direction)).collect();
        Self { run, growths, ..Self::of(evidence) }
    }

    /// Size, slope and time left of the direction, with its name by `name`; empty without directions.
    #[must_use]
    pub fn size(&self, name: &dyn Fn(u8) -> String) -> String {
        let Some((direction, growth)) = self.growth else { return String::new() };
        let name = name(direction);
        let size = between(growth.size, 1);
        let course = growth.left.map_or_else(|| "not growing".into(), |left| course(&growth, left));
        format!("{name}: {size} deviations above what is usual for this drive (90 % interval), {course}")
    }

    /// By how much and since when what raised the alarm has risen or fallen; empty without directions.
    #[must_use]
    pub fn rise(&self) -> String {
        self.main.map_or_else(String::new, |Contribution { deviations, since, .. }| {
            let (by, place) = (deviations.abs(), Side::of(deviations).place());
            format!(", {by:.1} deviations {place} what is usual for this drive, since segment {}", since + 1)
        })
    }
}

/// State of the core's evidence after each of these segments.
pub(super) fn over(model: &Model<RunTime>, segments: &[SegmentReport]) -> Vec<AlarmState> {
    let mut evidence = Evidence::new(model);
    let mut observe = |segment: &SegmentReport| {
        match (decision(model, segment), segment.reason) {
            (None, Some(reason)) => evidence.observe_outcome(Err(reason)),
            (decision, _) => evidence.observe(decision.as_ref()),
        };
        AlarmState::of(&evidence)
    };
    segments.iter().map(&mut observe).collect()
}

/// Slope of a size that grows, and so many usual runs until the named size, or that it is reached.
fn course(growth: &Growth, left: Interval) -> String {
    // Without a sampling interval only runs are known.
    let hours = growth.left_hours().filter(|_| growth.run_hours > 0.0);
    let slope = match hours {
        Some(_) => format!("{} an hour of segments", between(growth.slope_per_hour(), 2)),
        None => format!("{} a usual run", between(growth.slope, 2)),
    };
    let named = format!("{:.0} deviations, which a single segment shows", growth.named);
    if left.high <= 0.0 {
        return format!("grows by {slope}, and has reached {named}");
    }
    let runs = format!("{} usual runs", between(left, 1));
    let time =
        hours.map_or_else(|| runs.clone(), |hours| format!("{} hours of segments, or {runs},", between(hours, 1)));
    format!("grows by {slope}; if it goes on so, {time} until {named}")
}

/// A value with its interval.
fn between(of: Interval, digits: usize) -> String {
    let Interval { value, low, high } = of;
    format!("{value:.digits$} [{low:.digits$}, {high:.digits$}]")
}

/// Reconstructs the decision on a segment; `None` if it had none.
pub(super) fn decision(model: &Model<RunTime>, segment: &SegmentReport) -> Option<Decision<RunTime>> {
    if segment.log_likelihoods.is_empty() {
        return None;
    }
    let classifier = &model.constants().classifier;
    let mut decision = classifier.decide(model.plan(), &segment.log_likelihoods, segment.surprise)?;
    (decision.distance, decision.distance_surprise) = (segment.distance, segment.distance_surprise);
    (decision.most, decision.fall) = (segment.most, segment.fall);
    decision.set_beyond(&segment.beyond);
    decision.set_directed(&segment.directed);
    Some(decision)
}

/// Surprise of several independent segments together (Fisher 1932): the sum of k unit exponentials is at least S with
/// probability e^−S Σ_{j<k} S^j/j!.
pub(crate) fn combined_surprise(surprises: impl Iterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0);
    for surprise in surprises {
        sum += f64::from(surprise);
        count += 1;
    }
    if count < 2 {
        return sum as f32;
    }
    // Logarithms of the terms; the largest is factored out.
    let mut terms = vec![0.0_f64];
    for j in 1..count {
        terms.push(terms[terms.len() - 1] + (sum.max(f64::MIN_POSITIVE) / f64::from(j)).ln());
    }
    let largest = terms.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let ln_total = largest + terms.iter().map(|term| (term - largest).exp()).sum::<f64>().ln();
    (sum - ln_total).max(0.0) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn surprises_combine_as_exponentials() {
        assert!((combined_surprise([3.5].into_iter()) - 3.5).abs() < 1e-6);
        // Two segments: S − ln(1 + S).
        assert!((combined_surprise([1.0, 4.0].into_iter()) - (5.0 - 6.0_f32.ln())).abs() < 1e-6);
        assert!(combined_surprise([0.0; 3].into_iter()).abs() < 1e-6);
        // A thousand segments of average surprise combine to about one nat.
        let many = combined_surprise(std::iter::repeat_n(1.0, 1000));
        assert!((0.5..1.0).contains(&many), "{many}");
    }
}
