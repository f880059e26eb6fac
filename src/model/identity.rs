//! The numbers of a model → the number by which the model, and what was made with it, is known.
//!
//! It is `const`, so that an exported model has it at compile time. Models with other numbers have other identities,
//! but for one pair in 2³².

use super::parts::{ModelView, RegressionView, RunsView, ShaftView};
use super::sampling::Sampling;
use crate::alarm::EvidenceConstants;
use crate::decide::{Background, Covariate, Direction, Feature, NO_MODEL, Rise};
use crate::shaft::{Blocks, Lags, TorqueBalance, TrackedOrder};
use crate::signal::Channel;

/// Words so far.
struct Mixed(u32);

impl Mixed {
    /// Multiplication spreads a word upwards, the shift downwards.
    const fn word(self, word: u32) -> Self {
        let mixed = (self.0 ^ word).wrapping_mul(0x9E37_79B1);
        Self(mixed ^ (mixed >> 15))
    }

    const fn floats(self, values: &[f32]) -> Self {
        let (mut mixed, mut rest) = (self, values);
        while let [x, later @ ..] = rest {
            mixed = mixed.word(x.to_bits());
            rest = later;
        }
        mixed
    }

    const fn directions(self, directions: &[Direction]) -> Self {
        let (mut mixed, mut rest) = (self, directions);
        while let [direction, later @ ..] = rest {
            let Direction { coordinate, order, background, centre, between, run, segment, skewness, correlation } =
                *direction;
            mixed = mixed.word(coordinate as u32).word(order as u32);
            mixed = mixed.floats(&[centre, between, run, segment, skewness, correlation]);
            let mut left: &[Background] = &background;
            while let [Background { coordinate, weight }, others @ ..] = left {
                mixed = mixed.word(*coordinate as u32).floats(&[*weight]);
                left = others;
            }
            rest = later;
        }
        mixed
    }

    const fn rises(self, rises: &[Rise]) -> Self {
        let (mut mixed, mut rest) = (self, rises);
        while let [Rise { fall, reach }, later @ ..] = rest {
            mixed = mixed.floats(&[*fall, *reach]);
            rest = later;
        }
        mixed
    }

    const fn orders(self, orders: &[TrackedOrder]) -> Self {
        let (mut mixed, mut rest) = (self, orders);
        while let [order, later @ ..] = rest {
            let TrackedOrder { order_q16, weights, slip_ratio, needed_score, most_relative, most_a } = *order;
            mixed = mixed.word(order_q16.cast_unsigned()).floats(&weights);
            mixed = mixed.floats(&[slip_ratio, needed_score, most_relative, most_a]);
            rest = later;
        }
        mixed
    }

    const fn channels(self, channels: &[Channel]) -> Self {
        let (mut mixed, mut rest) = (self, channels);
        while let [Channel { limit, saturation, stuck_samples, .. }, later @ ..] = rest {
            mixed = mixed.floats(&[*limit, *saturation]).word(*stuck_samples as u32);
            rest = later;
        }
        mixed
    }

    const fn balance(self, balance: &TorqueBalance) -> Self {
        let TorqueBalance { interval_s, filter, row_interval, settle, scale, nominal, prior, deviation, .. } = balance;
        let TorqueBalance { sign_velocity_rad_s, stribeck_velocity_rad_s, usual_velocity_rad_s, .. } = balance;
        let TorqueBalance { usual_load_nm, row_spread, largest_change_rad, adapt_after_rows, .. } = balance;
        self.floats(scale)
            .floats(nominal)
            .floats(prior)
            .floats(&[*deviation, *interval_s, filter.gain, *usual_load_nm, *row_spread, *largest_change_rad])
            .floats(&[*sign_velocity_rad_s, *stribeck_velocity_rad_s, *usual_velocity_rad_s])
            .word(*row_interval as u32)
            .word(*settle as u32)
            .word(*adapt_after_rows as u32)
    }

    const fn blocks(self, blocks: &Blocks) -> Self {
        let Blocks { controls, cell_turns_log2, slip, slowest_rad_s, pole, high_pass } = blocks;
        let mut mixed =
            self.floats(&[*slip, *slowest_rad_s, *pole, *high_pass]).word(cell_turns_log2.cast_unsigned() as u32);
        let mut rest: &[i32] = controls;
        while let [control, later @ ..] = rest {
            mixed = mixed.word(control.cast_unsigned());
            rest = later;
        }
        mixed
    }

    const fn feature(self, feature: Feature) -> Self {
        self.word(u16::from_le_bytes(feature.code()) as u32)
    }

    const fn features(self, features: &[Feature]) -> Self {
        let (mut mixed, mut rest) = (self, features);
        while let [feature, later @ ..] = rest {
            mixed = mixed.feature(*feature);
            rest = later;
        }
        mixed
    }

    const fn covariates(self, covariates: &[Covariate]) -> Self {
        let (mut mixed, mut rest) = (self, covariates);
        while let [Covariate { feature, centre, low, high, usual }, later @ ..] = rest {
            mixed = mixed.feature(*feature).floats(&[*centre, *low, *high, *usual]);
            rest = later;
        }
        mixed
    }
}

/// The number of a model, never [`NO_MODEL`].
#[doc(hidden)]
#[must_use]
pub const fn identity(parts: &ModelView<'_>) -> u32 {
    let Sampling { interval_s, park, block_mean, segment_samples } = *parts.sampling;
    let mut mixed = Mixed(parts.layout.classes as u32).floats(&[interval_s]).word(segment_samples);
    mixed = mixed.word(block_mean as u32).word(match park {
        None => 0,
        Some(park) => 1 + park as u32,
    });
    mixed = mixed.channels(parts.channels).features(parts.features).covariates(parts.covariates);
    if let Some(RegressionView { scale, nominal, forgetting, rest, settle, handover }) = parts.regression {
        mixed = mixed.floats(scale).floats(nominal).floats(&[rest]);
        mixed = mixed.floats(&[forgetting.lambda, forgetting.floor]).word(settle as u32).word(handover as u32);
    }
    if let Some(ShaftView { lags: Lags { current, velocity, load }, balance, orders, blocks }) = &parts.shaft {
        mixed = mixed.floats(&[*current, *velocity, *load]).balance(balance).orders(orders).blocks(blocks);
    }
    mixed = mixed.floats(parts.covariate_map.as_flattened()).floats(parts.map).floats(parts.feature_means);
    mixed = mixed.floats(parts.usual).floats(parts.means).floats(parts.factors).floats(parts.log_prior);
    mixed = mixed.floats(parts.costs).floats(&[parts.reject_cost, parts.freedom, parts.limit, parts.acceptable]);
    mixed = mixed.word(match parts.healthy {
        Some(class) => class as u32,
        None => u32::MAX,
    });
    mixed = mixed.floats(parts.novelty_mean).floats(parts.novelty_factor).floats(parts.knots.as_flattened());
    mixed = mixed.floats(parts.laws.as_flattened().as_flattened()).directions(parts.directions).rises(parts.rises);
    let RunsView { usual_segments, margin, most_runs } = parts.runs;
    mixed = mixed.floats(&[usual_segments, margin]).word(most_runs as u32);
    let EvidenceConstants { bet, limit, cap, segments_a_run, log_mean, defect_log_mean } = parts.evidence;
    mixed = mixed.floats(&[bet, limit, cap, log_mean, defect_log_mean]).word(segments_a_run);
    if mixed.0 == NO_MODEL { 1 } else { mixed.0 }
}
