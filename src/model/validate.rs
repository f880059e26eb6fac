//! The checks of a model. They run at compile time for exported constants, and when a binary model is read.
//!
//! Enters: the numbers of a model as [`ModelView`]. Leaves: nothing, or the first [`ModelError`]. Every length must
//! match the layout, every number its plausible range: what a range excludes is no product of training, and would
//! leave the range of `f32`, or a gate or an alarm without effect, behind a good checksum. An infinite limit is a
//! choice: nothing is novel, no alarm, no rejection. The code is `const`, so it walks slices by patterns.

use super::error::ModelError;
use super::parts::{ModelView, RegressionView, RunsView, ShaftView};
use super::ranges::{all_powers_of_two, all_within, are_factors, bounded, differences_alike, is_law, reaches, split};
use super::sampling::{MAX_BLOCK_MEAN, MAX_SEGMENT_SAMPLES, Sampling};
use crate::alarm::EvidenceConstants;
use crate::decide::{Background, Covariate, MAX_SURPRISE};
use crate::plan::{Load, Memory, Method, RegressionLayout, ShaftLayout, Signal, Structure};
use crate::record::{Field, LARGEST, LEAST_LOG, LONGEST_S, MOST_NATS};
use crate::regression::estimate::is_stable;
use crate::regression::factor::MAX_SEGMENT_ROWS;
use crate::shaft::{MAX_BLOCKS, StateVariable, least_steps};
use crate::signal::{Channel, Label};

/// ln 1, with roundings.
const LOG_ONE: f32 = 1e-3;
/// Squared distance from healthy that is novel by any gate: a million deviations.
const NOVEL: f32 = 1e12;

/// Returns early with an error unless the condition holds.
macro_rules! require {
    ($good:expr, $field:ident) => {
        // Not by `!`: what is not a number is refused.
        if $good {
        } else {
            return Err(ModelError::OutOfRange(Field::$field));
        }
    };
}

/// Returns early with an error unless the lengths are equal.
macro_rules! require_length {
    ($given:expr, $wanted:expr, $field:ident) => {
        if $given != $wanted {
            return Err(ModelError::Length(Field::$field));
        }
    };
}

/// Returns early with the field of a record that is out of range.
macro_rules! within {
    ($check:expr) => {
        if let Err(field) = $check {
            return Err(ModelError::OutOfRange(field));
        }
    };
}

/// Returns early with the error of another check.
macro_rules! pass {
    ($check:expr) => {
        if let Err(error) = $check {
            return Err(error);
        }
    };
}

/// Checks every length against the layout and every number against its range.
///
/// # Errors
/// The first thing that does not fit.
#[doc(hidden)]
pub const fn check(parts: &ModelView<'_>) -> Result<(), ModelError> {
    let layout = &parts.layout;
    if let Err(error) = layout.check() {
        return Err(ModelError::Layout(error));
    }
    let Sampling { interval_s, block_mean, segment_samples, .. } = *parts.sampling;
    require!(interval_s >= 0.0 && interval_s <= LONGEST_S, SamplingInterval);
    require!(block_mean >= 1 && block_mean <= MAX_BLOCK_MEAN, BlockMean);
    // Only the regression averages.
    require!(block_mean == 1 || layout.regression.is_some(), BlockMean);
    require!(segment_samples > 0 && segment_samples <= MAX_SEGMENT_SAMPLES, SegmentLength);
    pass!(check_channels(parts));
    match (&layout.regression, &parts.regression) {
        (Some(layout), Some(regression)) => pass!(check_regression(layout, regression, parts)),
        (None, None) => {}
        _ => return Err(ModelError::Length(Field::NominalModel)),
    }
    match (&layout.shaft, &parts.shaft) {
        (Some(layout), Some(shaft)) => pass!(check_shaft(layout, shaft, parts)),
        (None, None) => {}
        _ => return Err(ModelError::Length(Field::BalanceNominal)),
    }
    pass!(check_classifier(parts));
    pass!(check_novelty(parts));
    check_labels(parts.labels, parts.layout.classes as usize)
}

const fn check_channels(parts: &ModelView<'_>) -> Result<(), ModelError> {
    require_length!(parts.channels.len(), parts.layout.channels as usize, ChannelName);
    let (mut channels, mut names, mut index) = (parts.channels, parts.names, 0_u8);
    while let [Channel { name, unit, limit, saturation, stuck_samples }, rest @ ..] = channels {
        require!(*limit >= f32::MIN_POSITIVE && *limit <= 1e18, ChannelLimit);
        require!(*saturation > 0.0 && *saturation <= *limit, Saturation);
        // A single sample is not a run of equal samples.
        require!(*stuck_samples != 1, StuckSamples);
        if let [(own_name, own_unit), later @ ..] = names {
            if !name.is(own_name) || !unit.is(own_unit) {
                return Err(ModelError::Channel { index });
            }
            names = later;
        }
        channels = rest;
        index = index.wrapping_add(1);
    }
    Ok(())
}

/// The largest plausible magnitude of a signal.
const fn limit_of(channels: &[Channel], signal: Signal) -> f32 {
    let (mut sum, mut rest, mut index) = (0.0, channels, 0_u8);
    while let [channel, later @ ..] = rest {
        let other = match signal.minus {
            Some(other) => other == index,
            None => false,
        };
        if signal.channel == index || other {
            sum += channel.limit;
        }
        rest = later;
        index = index.wrapping_add(1);
    }
    sum
}

const fn check_regression(
    layout: &RegressionLayout,
    regression: &RegressionView<'_>,
    parts: &ModelView<'_>,
) -> Result<(), ModelError> {
    let Structure { na, nb, nc, .. } = layout.structure;
    let (columns, n) = (layout.columns(), layout.structure.parameters());
    let RegressionView { scale, nominal, forgetting, rest, settle, handover } = *regression;
    let segment_samples = parts.sampling.segment_samples;
    let longest = match layout.memory {
        Memory::Segment => MAX_SEGMENT_ROWS,
        Memory::Fading => MAX_SEGMENT_SAMPLES,
    };
    let shortest = columns.saturating_add(layout.structure.depth());
    require!(segment_samples <= longest && segment_samples as usize > shortest, SegmentLength);
    require_length!(scale.len(), columns, ColumnScale);
    require_length!(nominal.len(), n, NominalModel);
    require!(all_powers_of_two(scale), ColumnScale);
    // Beyond that, sums of squares over a segment could leave the range of f32.
    let y_limit = limit_of(parts.channels, layout.y);
    let (of_output, scale) = split(scale, na as usize);
    let (first, scale) = split(scale, nb as usize);
    let (second, scale) = split(scale, nc as usize);
    require!(differences_alike(of_output) && differences_alike(first) && differences_alike(second), ColumnScale);
    let inputs =
        bounded(first, limit_of(parts.channels, layout.u1)) && bounded(second, limit_of(parts.channels, layout.u2));
    let largest = if y_limit > 1.0 { y_limit } else { 1.0 };
    require!(bounded(of_output, y_limit) && inputs && all_within(scale, 0.0, 1e14 / largest), LimitTimesScale);
    require!(all_within(nominal, -LARGEST, LARGEST), NominalModel);
    require!(rest >= 0.0 && rest <= LARGEST, RestThreshold);
    require!(handover as u32 <= segment_samples / 2, Handover);
    if matches!(layout.method, Method::Instruments) {
        require!(is_stable(split(nominal, na as usize).0), NominalStability);
        require!(segment_samples / 4 >= settle as u32 + handover as u32, Settling);
    }
    if matches!(layout.memory, Memory::Fading) {
        // Forgetting without excitation would replace what is known by noise; without inputs nothing moves.
        require!(rest > 0.0 && nb as usize + nc as usize > 0, RestThreshold);
        // A memory of n rows leaves no degree of freedom for a variance.
        let rows = 1.0 / (1.0 - forgetting.lambda);
        require!(rows > 2.0 * n as f32, ForgettingFactor);
        within!(forgetting.check());
    }
    Ok(())
}

const fn check_shaft(layout: &ShaftLayout, shaft: &ShaftView<'_>, parts: &ModelView<'_>) -> Result<(), ModelError> {
    let ShaftView { lags, balance, orders, blocks } = *shaft;
    within!(lags.check());
    within!(balance.check());
    within!(balance.filter.check());
    let StateVariable { gain, damping, rate_per_s } = balance.filter;
    let expected = StateVariable::new(gain, balance.interval_s);
    let designed =
        damping.to_bits() == expected.damping.to_bits() && rate_per_s.to_bits() == expected.rate_per_s.to_bits();
    require!(designed, BalanceFilter);
    // The factor of the balance sums at most as many rows as any other of one level.
    let samples = parts.sampling.segment_samples as u64 * parts.sampling.block_mean as u64;
    let steps = if layout.is_halved() { samples.div_ceil(2) } else { samples };
    let Some(rows) = steps.checked_div(balance.row_interval as u64) else {
        return Err(ModelError::OutOfRange(Field::RowInterval));
    };
    require!(rows <= MAX_SEGMENT_ROWS as u64, SegmentLength);
    let most_blocks = steps / least_steps(layout.orders, layout.harmonics);
    require!(layout.orders == 0 || most_blocks <= MAX_BLOCKS as u64, SegmentLength);
    require!(all_powers_of_two(&balance.scale) && all_within(&balance.scale, 0.0, f32::MAX), BalanceScale);
    let velocity = match layout.velocity {
        Some(velocity) => limit_of(parts.channels, velocity),
        // An angle differs by at most half a turn from the last one.
        None => core::f32::consts::PI * layout.decimation as f32 / balance.interval_s,
    };
    let load = match layout.load {
        Load::Measured(load) => limit_of(parts.channels, load),
        Load::Unknown | Load::Weight { .. } => 1.0,
    };
    let [acceleration_scale, velocity_scale, _, load_scale, _, friction_scale, _, current_scale] = balance.scale;
    let current = limit_of(parts.channels, layout.current);
    require!(
        bounded(&[acceleration_scale], velocity * rate_per_s)
            && bounded(&[velocity_scale], velocity)
            && bounded(&[load_scale, friction_scale], load)
            && bounded(&[current_scale], current),
        LimitTimesScale
    );
    require_length!(orders.len(), layout.orders as usize, BearingOrder);
    let mut rest = orders;
    while let [order, later @ ..] = rest {
        within!(order.check());
        require!(are_weights(&order.weights, layout.harmonics as usize), BearingOrder);
        rest = later;
    }
    if layout.orders > 0 {
        within!(blocks.check());
    }
    Ok(())
}

/// Whether the weights of the harmonics that are computed are none negative and not all zero, and the others zero.
const fn are_weights(weights: &[f32], harmonics: usize) -> bool {
    let (computed, rest) = split(weights, harmonics);
    all_within(computed, 0.0, 1e3) && !all_within(computed, 0.0, 1e-3) && all_within(rest, 0.0, 0.0)
}

const fn check_classifier(parts: &ModelView<'_>) -> Result<(), ModelError> {
    let layout = &parts.layout;
    require_length!(parts.features.len(), layout.features as usize, Feature);
    let mut features = parts.features;
    while let [feature, rest @ ..] = features {
        require!(feature.exists(layout), Feature);
        features = rest;
    }
    require_length!(parts.covariates.len(), layout.covariates as usize, Covariate);
    require_length!(parts.covariate_map.len(), layout.covariate_map_len(), Covariate);
    require!(all_within(parts.covariate_map.as_flattened(), -LARGEST, LARGEST), Covariate);
    let mut covariates = parts.covariates;
    while let [covariate, rest @ ..] = covariates {
        within!(covariate.check());
        let Covariate { feature, centre, low, high, .. } = *covariate;
        require!(feature.exists(layout) && low <= centre && centre <= high, Covariate);
        covariates = rest;
    }
    require_length!(parts.feature_means.len(), layout.features as usize, Projection);
    require_length!(parts.usual.len(), layout.features as usize, Projection);
    require_length!(parts.map.len(), layout.map(), Projection);
    require_length!(parts.means.len(), layout.means(), ClassDensity);
    require_length!(parts.factors.len(), layout.densities(), ClassDensity);
    let classes = layout.classes as usize;
    require_length!(parts.log_prior.len(), classes, Prior);
    require_length!(parts.costs.len(), layout.costs(), Cost);
    let affine = all_within(parts.map, -LARGEST, LARGEST) && all_within(parts.feature_means, -LARGEST, LARGEST);
    require!(affine && all_within(parts.usual, 0.0, LARGEST), Projection);
    let factors = are_factors(parts.factors, layout.coordinates as usize, LARGEST);
    require!(all_within(parts.means, -LARGEST, LARGEST) && factors, ClassDensity);
    require!(all_within(parts.log_prior, LEAST_LOG, LOG_ONE), Prior);
    // Infinity is allowed: never reject.
    let rejects = parts.reject_cost >= 0.0 && (parts.reject_cost <= 1e6 || parts.reject_cost == f32::INFINITY);
    require!(all_within(parts.costs, 0.0, 1e6) && rejects, Cost);
    Ok(())
}

const fn check_novelty(parts: &ModelView<'_>) -> Result<(), ModelError> {
    let layout = &parts.layout;
    require_length!(parts.novelty_mean.len(), layout.coordinates as usize, HealthyDensity);
    require_length!(parts.novelty_factor.len(), layout.density(), HealthyDensity);
    require_length!(parts.laws.len(), layout.laws(), RisingCoordinates);
    require_length!(parts.rises.len(), layout.laws(), RisingCoordinates);
    require!(all_within(parts.novelty_mean, -LARGEST, LARGEST), HealthyDensity);
    require!(all_within(parts.novelty_factor, f32::MIN, f32::MAX), HealthyDensity);
    if let Some(class) = parts.healthy {
        require!(class < layout.classes, HealthyClass);
        require!(are_factors(parts.novelty_factor, layout.coordinates as usize, LARGEST), HealthyDensity);
        require!(is_law(parts.knots), SurpriseCurve);
        // Infinity is allowed: nothing is novel. Beyond the largest surprise nothing would be either.
        require!(parts.limit > 0.0 && (parts.limit <= MAX_SURPRISE || parts.limit == f32::INFINITY), NoveltyLimit);
        require!(parts.limit == f32::INFINITY || reaches(parts.knots, parts.limit, NOVEL), SurpriseCurve);
        if let [others, rising @ ..] = parts.laws {
            require!(parts.freedom >= 1.0 && parts.freedom <= LARGEST, RisingCoordinates);
            require!(parts.acceptable > 1.0, RisingCoordinates);
            let mut rises = parts.rises;
            while let [rise, later @ ..] = rises {
                within!(rise.check());
                rises = later;
            }
            require!(layout.rising == layout.coordinates || is_law(others), SurpriseCurve);
            let mut rest = rising;
            while let [law, later @ ..] = rest {
                require!(is_law(law), SurpriseCurve);
                rest = later;
            }
        }
    }
    pass!(check_directions(parts));
    within!(parts.evidence.check());
    let EvidenceConstants { limit, cap, log_mean, defect_log_mean, .. } = parts.evidence;
    require!(limit > 0.0 && (limit <= MOST_NATS || limit == f32::INFINITY), Evidence);
    // A mean is at most the largest e-value.
    require!(log_mean <= cap && defect_log_mean <= cap, Evidence);
    Ok(())
}

/// Directions are those of the healthy class.
const fn check_directions(parts: &ModelView<'_>) -> Result<(), ModelError> {
    let layout = &parts.layout;
    require_length!(parts.directions.len(), layout.directions as usize, Direction);
    require!(layout.directions == 0 || parts.healthy.is_some(), Direction);
    let RunsView { usual_segments, margin, .. } = parts.runs;
    require!(layout.directions == 0 || (usual_segments >= 1.0 && usual_segments <= 1e6), Direction);
    // A run at the cap must not reach the limit.
    require!(layout.directions == 0 || parts.evidence.cap < parts.evidence.limit, Evidence);
    require!(layout.directions == 0 || (margin >= 0.0 && margin <= 10.0), Direction);
    let mut directions = parts.directions;
    while let [direction, rest @ ..] = directions {
        within!(direction.check());
        require!(direction.coordinate < layout.coordinates, Direction);
        let mut left: &[Background] = &direction.background;
        while let [background, others @ ..] = left {
            within!(background.check());
            require!(background.coordinate < layout.coordinates, Direction);
            left = others;
        }
        directions = rest;
    }
    Ok(())
}

/// An empty label is one that did not fit, or a class without a name.
const fn check_labels(labels: &[Label], classes: usize) -> Result<(), ModelError> {
    require_length!(labels.len(), classes, Label);
    let mut rest = labels;
    while let [label, later @ ..] = rest {
        require!(!label.is(""), Label);
        rest = later;
    }
    Ok(())
}
