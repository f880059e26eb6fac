//! Long runs of estimators and of a whole drive; `cargo xtask long` makes them longer.

mod estimators;
mod soak;
