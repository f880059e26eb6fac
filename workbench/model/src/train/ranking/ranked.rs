//! One feature in a ranking, and its gain.

/// Gain of a change of features: scores before minus scores after, so that larger is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Gain of the guarded log score, nats.
    pub log: f64,
    /// Its standard error, from the gains of the single groups.
    pub standard_error: f64,
    /// Gain of the error rate.
    pub error: f64,
}

/// One feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// Its name.
    pub name: String,
    /// J of (1); 0 without spread.
    pub fisher: f64,
    /// J_ij of (2), for each pair of classes i < j in turn.
    pub pairs: Vec<f64>,
    /// Gain beside all other features; `None` if those or all together are singular.
    pub among_all: Option<Gain>,
    /// Gain when it was chosen, or beside the chosen features if it was not.
    pub beside_chosen: Option<Gain>,
    /// Whether forward selection chose it.
    pub kept: bool,
    /// Why it is kept or would be dropped.
    pub reason: String,
}
