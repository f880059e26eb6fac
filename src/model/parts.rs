//! The numbers of a model as slices of any length, as the checks read them.

use super::sampling::Sampling;
use crate::alarm::EvidenceConstants;
use crate::decide::{Covariate, Direction, Feature, KNOTS, Law, Rise};
use crate::plan::Layout;
use crate::regression::factor::Forgetting;
use crate::shaft::{Blocks, Lags, TorqueBalance, TrackedOrder};
use crate::signal::{Channel, Label};

/// The numbers of a regression as slices.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct RegressionView<'a> {
    pub scale: &'a [f32],
    pub nominal: &'a [f32],
    pub forgetting: Forgetting,
    pub rest: f32,
    pub settle: u16,
    pub handover: u16,
}

/// The numbers of a shaft as slices.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct ShaftView<'a> {
    pub lags: Lags,
    pub balance: &'a TorqueBalance,
    pub orders: &'a [TrackedOrder],
    pub blocks: Blocks,
}

/// The numbers of the directions together.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct RunsView {
    pub usual_segments: f32,
    pub margin: f32,
    pub most_runs: u16,
}

/// The numbers of a model as slices of any length.
#[doc(hidden)]
#[derive(Clone, Copy, Debug)]
pub struct ModelView<'a> {
    pub layout: Layout,
    pub names: &'a [(&'a str, &'a str)],
    pub sampling: &'a Sampling,
    pub channels: &'a [Channel],
    pub regression: Option<RegressionView<'a>>,
    pub shaft: Option<ShaftView<'a>>,
    pub features: &'a [Feature],
    pub covariates: &'a [Covariate],
    pub covariate_map: &'a [[f32; 2]],
    pub map: &'a [f32],
    pub feature_means: &'a [f32],
    pub usual: &'a [f32],
    pub means: &'a [f32],
    pub factors: &'a [f32],
    pub log_prior: &'a [f32],
    pub costs: &'a [f32],
    pub reject_cost: f32,
    pub healthy: Option<u8>,
    pub novelty_mean: &'a [f32],
    pub novelty_factor: &'a [f32],
    pub knots: &'a [[f32; 2]; KNOTS],
    pub laws: &'a [Law],
    pub rises: &'a [Rise],
    pub freedom: f32,
    pub acceptable: f32,
    pub limit: f32,
    pub directions: &'a [Direction],
    pub runs: RunsView,
    pub evidence: EvidenceConstants,
    pub labels: &'a [Label],
}
