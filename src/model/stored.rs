//! The numbers of a model → the payload of its binary form, and the number by which the model, and what was made with
//! it, is known. [`super::reader`] reads in the same order.
//!
//! It is `const`, so that an exported model has its identity at compile time. Models with other numbers have other
//! identities, but for one pair in 2³²; names and units are no part of it.

use super::parts::{ModelView, RegressionView, RunsView, ShaftView};
use super::sampling::Sampling;
use crate::decide::NO_MODEL;
use crate::plan::{Kind, Layout, Load, Memory, Method, RegressionLayout, ShaftLayout, Signal, Structure};
use crate::record::{NONE, Output, WEIGHT};
use crate::signal::{Channel, Label, Park};

/// Appends each record of a list.
macro_rules! each {
    ($list:expr, $output:expr) => {{
        let mut rest = $list;
        while let [record, later @ ..] = rest {
            record.put($output);
            rest = later;
        }
    }};
}

/// The number of a model, never [`NO_MODEL`].
#[doc(hidden)]
#[must_use]
pub const fn identity(parts: &ModelView<'_>) -> u32 {
    let mut output = Output::new(&mut []);
    put(parts, &mut output);
    if output.identity() == NO_MODEL { 1 } else { output.identity() }
}

/// Appends layout and numbers.
pub(super) const fn put(parts: &ModelView<'_>, output: &mut Output<'_>) {
    put_layout(&parts.layout, output);
    let Sampling { interval_s, park, block_mean, segment_samples } = *parts.sampling;
    output.f32(interval_s);
    output.u8(match park {
        None => 0,
        Some(Park::Standard) => 1,
        Some(Park::Thesis) => 2,
    });
    output.u16(block_mean);
    output.u32(segment_samples);
    let mut channels = parts.channels;
    while let [Channel { name, unit, limit, saturation, stuck_samples }, rest @ ..] = channels {
        output.text(&name.to_bytes());
        output.text(&unit.to_bytes());
        output.floats(&[*limit, *saturation]);
        output.u16(*stuck_samples);
        channels = rest;
    }
    if let Some(RegressionView { scale, nominal, forgetting, rest, settle, handover }) = parts.regression {
        output.floats(scale);
        output.floats(nominal);
        forgetting.put(output);
        output.f32(rest);
        output.u16(settle);
        output.u16(handover);
    }
    if let Some(ShaftView { lags, balance, orders, blocks }) = &parts.shaft {
        lags.put(output);
        balance.put(output);
        each!(*orders, output);
        blocks.put(output);
    }
    put_classifier(parts, output);
    parts.evidence.put(output);
    let mut labels: &[Label] = parts.labels;
    while let [label, rest @ ..] = labels {
        output.text(&label.to_bytes());
        labels = rest;
    }
}

const fn put_layout(layout: &Layout, output: &mut Output<'_>) {
    output.u8(layout.channels);
    output.u8(layout.regression.is_some() as u8);
    if let Some(RegressionLayout { structure, method, memory, y, u1, u2 }) = layout.regression {
        let Structure { na, nb, nc, nkb, nkc, offset } = structure;
        output.u8(offset as u8);
        output.u8(na);
        output.u8(nb);
        output.u8(nc);
        output.u8(nkb);
        output.u8(nkc);
        output.u8(matches!(method, Method::Instruments) as u8);
        output.u8(match memory {
            Memory::Segment => 0,
            Memory::Fading => 2,
        });
        put_signal(Some(y), output);
        put_signal(Some(u1), output);
        put_signal(Some(u2), output);
    }
    output.u8(layout.shaft.is_some() as u8);
    if let Some(ShaftLayout { current, velocity, load, orders, harmonics, decimation }) = layout.shaft {
        put_signal(Some(current), output);
        put_signal(velocity, output);
        put_load(load, output);
        output.u8(orders);
        // The high half of the byte is the decimation less one, so that 0 is that of each sample.
        output.u8(harmonics & 0xF | decimation.wrapping_sub(1) << 4);
    }
    output.u16(layout.averaged);
    let Layout { features, covariates, coordinates, rising, directions, classes, discriminant, .. } = *layout;
    output.u8(features);
    output.u8(covariates);
    output.u8(coordinates);
    output.u8(rising);
    output.u8(directions);
    output.u8(classes);
    output.u8(matches!(discriminant, Kind::Quadratic) as u8);
}

/// A load that is not measured names no channel; the byte of the channel that is subtracted says what follows.
const fn put_load(load: Load, output: &mut Output<'_>) {
    match load {
        Load::Unknown => put_signal(None, output),
        Load::Measured(signal) => put_signal(Some(signal), output),
        Load::Weight { axis_q32, changes } => {
            output.u8(NONE);
            output.u8(WEIGHT);
            output.u32(axis_q32);
            output.u8(changes as u8);
        }
    }
}

const fn put_signal(signal: Option<Signal>, output: &mut Output<'_>) {
    let Signal { channel, minus } = match signal {
        Some(signal) => signal,
        None => Signal::channel(NONE),
    };
    output.u8(channel);
    output.u8(match minus {
        Some(other) => other,
        None => NONE,
    });
}

const fn put_classifier(parts: &ModelView<'_>, output: &mut Output<'_>) {
    each!(parts.features, output);
    each!(parts.covariates, output);
    output.floats(parts.covariate_map.as_flattened());
    output.floats(parts.map);
    output.floats(parts.feature_means);
    output.floats(parts.usual);
    output.floats(parts.means);
    output.floats(parts.factors);
    output.floats(parts.log_prior);
    output.floats(parts.costs);
    output.f32(parts.reject_cost);
    let Some(class) = parts.healthy else {
        return output.u8(NONE);
    };
    output.u8(class);
    output.floats(parts.novelty_mean);
    output.floats(parts.novelty_factor);
    output.floats(parts.knots.as_flattened());
    output.f32(parts.limit);
    if !parts.laws.is_empty() {
        output.floats(&[parts.freedom, parts.acceptable]);
        each!(parts.rises, output);
        output.floats(parts.laws.as_flattened().as_flattened());
    }
    if !parts.directions.is_empty() {
        let RunsView { usual_segments, margin, most_runs } = parts.runs;
        output.floats(&[usual_segments, margin]);
        output.u16(most_runs);
        each!(parts.directions, output);
    }
}
