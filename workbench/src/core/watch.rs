//! What segments come to together: verdicts, combined surprise, and the core's evidence.

use bearing_watch::Model;
use bearing_watch::decide::{Alarm, Cause, Decision, Evidence, Trend};

use super::segment::SegmentReport;

/// State of the evidence after a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watched {
    /// Largest score, nats.
    pub score: f32,
    /// The alarm that stands.
    pub alarm: Option<Alarm>,
    /// Slope of the distance from healthy.
    pub trend: Option<Trend>,
}

impl Watched {
    /// The class an alarm points to; `unknown` where to none.
    #[must_use]
    pub fn cause<'a>(&self, classes: &'a [String]) -> Option<&'a str> {
        self.alarm.map(|alarm| match alarm.cause {
            Cause::Class(class) => classes.get(usize::from(class)).map_or("", String::as_str),
            Cause::Unknown => "unknown",
        })
    }
}

/// The core's evidence over segments in the order given.
pub(super) fn watch<const M: usize, const F: usize, const Z: usize, const C: usize, const K: usize>(
    model: &Model<M, F, Z, C, K>,
    segments: &[SegmentReport],
) -> Vec<Watched> {
    let mut evidence = Evidence::new(model.evidence, &model.classifier);
    let each = |segment: &SegmentReport| {
        let alarm = evidence.observe(decision(segment).as_ref());
        Watched { score: evidence.score(), alarm, trend: evidence.trend() }
    };
    segments.iter().map(each).collect()
}

/// The decision of a segment again; nothing where it had none.
fn decision<const C: usize>(segment: &SegmentReport) -> Option<Decision<C>> {
    if segment.log_likelihoods.is_empty() {
        return None;
    }
    let (mut log_likelihoods, mut posteriors) = ([f32::NEG_INFINITY; C], [0.0; C]);
    log_likelihoods.iter_mut().zip(&segment.log_likelihoods).for_each(|(cell, x)| *cell = *x);
    posteriors.iter_mut().zip(&segment.posteriors).for_each(|(cell, x)| *cell = *x);
    let (distance, surprise) = (segment.distance, segment.surprise);
    Some(Decision { class: 0, log_likelihoods, posteriors, expected_costs: [f32::INFINITY; C], distance, surprise })
}

/// Surprise of several independent segments together (Fisher 1932): the sum of k unit exponentials is at least S with
/// probability e^−S Σ_{j<k} S^j/j!.
pub(super) fn combined_surprise(surprises: impl Iterator<Item = f32>) -> f32 {
    let (mut sum, mut count) = (0.0_f64, 0);
    for surprise in surprises {
        sum += f64::from(surprise);
        count += 1;
    }
    if count < 2 {
        return sum as f32;
    }
    // ln of the terms, the largest taken out.
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
        // Two: S − ln(1 + S).
        assert!((combined_surprise([1.0, 4.0].into_iter()) - (5.0 - 6.0_f32.ln())).abs() < 1e-6);
        assert!(combined_surprise([0.0; 3].into_iter()).abs() < 1e-6);
        // A thousand usual ones are usual: about one nat.
        let many = combined_surprise(std::iter::repeat_n(1.0, 1000));
        assert!((0.5..1.0).contains(&many), "{many}");
    }
}
