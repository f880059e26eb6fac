//! Models of drives and detectors of bearing faults, from recorded signals in memory.
//!
//! ```text
//! signals (arrays: current, velocity, load, …) ─► identify, structure, validate, grey_box ─► parameters of the drive
//! signals + labels + settings ─► session ─► train ─► detector: model file, Rust source, C header
//! detector + other signals ─► evaluate ─► error rates with their intervals
//! ```
//!
//! Signals enter as arrays in SI units; the crate `bearing-watch-traces` reads them from files. Models are fitted in
//! double precision, and evaluated by the code that runs in firmware, the crate `bearing-watch`, in single precision.
//!
//! | module | content |
//! |---|---|
//! | [`trace`] | signals of one recording, their channels, labels and preparation |
//! | [`settings`] | what is trained and judged, and how |
//! | [`session`] | training and evaluation: settings and signals in; model, report and warnings out |
//! | [`audit`] | what recordings are worth before anything is trained |
//! | [`identify`] | parameters of a linear model of one trace, by eight methods |
//! | [`structure`] | which orders and delays such a model needs |
//! | [`recursive`] | the same of signals that come in pieces, by the estimator of the firmware |
//! | [`validate`] | whether it explains a trace: fit, residuals, poles, frequency response |
//! | [`grey_box`] | physical constants of a drive, with standard deviations |
//! | [`cogging`] | what turns with the rotor: cogging, ripple, unbalance |
//! | [`piecewise`] | first-order models of the straight runs of one record |
//! | [`train`] | labelled traces → projection, classes, gate and alarm |
//! | [`evaluate`] | verdicts on other traces, counted by class and run |
//! | [`life`] | load collective and nominal life of a bearing |
//! | [`bearings`] | dimensions of bearings by their designation |
//! | [`near`] | unknown words: the nearest known ones |
//! | [`core`] | traces through the detector of the firmware, and names of its features |
//! | [`outputs`] | files that are complete or absent |
//! | [`statistics`] | mean and standard deviation over repetitions |
//! | [`error`] | errors: one line with place and remedy |

pub mod audit;
pub mod bearings;
pub mod cogging;
pub mod core;
mod elementary;
pub mod error;
pub mod evaluate;
pub mod grey_box;
pub mod identify;
pub mod life;
pub mod near;
pub mod outputs;
pub mod piecewise;
pub mod recursive;
pub mod session;
pub mod settings;
pub mod statistics;
pub mod structure;
pub mod trace;
pub mod train;
pub mod validate;
pub mod visible;

pub use error::Error;
