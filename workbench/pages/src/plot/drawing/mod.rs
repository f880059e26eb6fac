//! What every plot is drawn with: the figure, its panels, colours and numbers, and the attributes of plotly.

pub(super) mod decimate;
mod described;
pub(super) mod figure;
pub(super) mod numbers;
pub(super) mod plotly;
pub(super) mod stack;
pub(super) mod theme;
