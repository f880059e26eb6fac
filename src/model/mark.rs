//! The numbers of a model → a word by which what was made with one model is known from what was made with another.
//!
//! It is `const`, so that an exported model has it at compile time. [`Model::id`](crate::Model::id), the checksum of
//! the binary form, costs as much as reading a model. Models with other numbers have other marks, but for one pair in
//! 2³².

use super::parts::{Parts, RegressionParts, RunParts, ShaftParts};
use crate::alarm::EvidenceConstants;
use crate::decide::{Background, Direction, Rise, UNMARKED};
use crate::shaft::TrackedOrder;

/// Words so far.
struct Mark(u32);

impl Mark {
    /// Multiplication spreads a word upwards, the shift downwards.
    const fn word(self, word: u32) -> Self {
        let mixed = (self.0 ^ word).wrapping_mul(0x9E37_79B1);
        Self(mixed ^ (mixed >> 15))
    }

    const fn floats(self, values: &[f32]) -> Self {
        let (mut mark, mut rest) = (self, values);
        while let [x, later @ ..] = rest {
            mark = mark.word(x.to_bits());
            rest = later;
        }
        mark
    }

    const fn directions(self, directions: &[Direction]) -> Self {
        let (mut mark, mut rest) = (self, directions);
        while let [direction, later @ ..] = rest {
            let Direction { coordinate, order, background, centre, between, run, segment, skewness, correlation } =
                *direction;
            mark = mark.word(coordinate as u32).word(order as u32);
            mark = mark.floats(&[centre, between, run, segment, skewness, correlation]);
            let mut left: &[Background] = &background;
            while let [Background { coordinate, weight }, others @ ..] = left {
                mark = mark.word(*coordinate as u32).floats(&[*weight]);
                left = others;
            }
            rest = later;
        }
        mark
    }

    const fn rises(self, rises: &[Rise]) -> Self {
        let (mut mark, mut rest) = (self, rises);
        while let [Rise { fall, reach }, later @ ..] = rest {
            mark = mark.floats(&[*fall, *reach]);
            rest = later;
        }
        mark
    }

    const fn orders(self, orders: &[TrackedOrder]) -> Self {
        let (mut mark, mut rest) = (self, orders);
        while let [order, later @ ..] = rest {
            let TrackedOrder { order_q16, weights, slip_ratio, needed_score, most_relative, most_a } = *order;
            mark = mark.word(order_q16.cast_unsigned()).floats(&weights);
            mark = mark.floats(&[slip_ratio, needed_score, most_relative, most_a]);
            rest = later;
        }
        mark
    }
}

/// The mark of a model, never [`UNMARKED`].
#[doc(hidden)]
#[must_use]
pub const fn mark(parts: &Parts<'_>) -> u32 {
    let mut mark = Mark(parts.layout.classes as u32);
    mark = mark.floats(&[parts.sampling.interval_s]).word(parts.sampling.segment_samples);
    mark = mark.word(parts.sampling.block_mean as u32);
    if let Some(RegressionParts { scale, nominal, deviation, huber, rest, .. }) = parts.regression {
        mark = mark.floats(scale).floats(nominal).floats(&[deviation, huber, rest]);
    }
    if let Some(ShaftParts { balance, orders, .. }) = parts.shaft {
        mark = mark.floats(&balance.scale).floats(&balance.nominal).floats(&balance.prior);
        mark = mark.floats(&[balance.deviation]).orders(orders);
    }
    mark = mark.floats(parts.explained.as_flattened()).floats(parts.map).floats(parts.feature_means);
    mark = mark.floats(parts.usual).floats(parts.means).floats(parts.factors).floats(parts.log_prior);
    mark = mark.floats(parts.costs).floats(&[parts.reject_cost, parts.freedom, parts.limit]);
    mark = mark.word(match parts.healthy {
        Some(class) => class as u32,
        None => u32::MAX,
    });
    mark = mark.floats(parts.novelty_mean).floats(parts.novelty_factor).floats(parts.knots.as_flattened());
    mark = mark.floats(parts.laws.as_flattened().as_flattened()).directions(parts.directions);
    // Without rising coordinates these have no effect, and the mark remains.
    if !parts.rises.is_empty() {
        mark = mark.rises(parts.rises).floats(&[parts.acceptable]);
    }
    let RunParts { usual_segments, margin, most_runs } = parts.runs;
    // Without directions these have no effect, and the mark remains.
    if !parts.directions.is_empty() {
        mark = mark.floats(&[usual_segments, margin]).word(most_runs as u32);
    }
    let EvidenceConstants { bet, limit, cap, segments_a_run, log_mean, defect_log_mean } = parts.evidence;
    mark = mark.floats(&[bet, limit, cap, log_mean, defect_log_mean]).word(segments_a_run);
    if mark.0 == UNMARKED { 1 } else { mark.0 }
}
