//! One feature in a ranking, and what it gains.

/// What a change of features gains: scores before less scores after, so that more is better.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gain {
    /// Of the guarded log score, nats.
    pub log: f64,
    /// Its standard error, from the groups' own gains.
    pub standard_error: f64,
    /// Of the error rate.
    pub error: f64,
}

/// One feature.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranked {
    /// Its name.
    pub name: String,
    /// J of (1); 0 where it has no spread.
    pub fisher: f64,
    /// J_ij of (2), for each pair of classes i < j in turn.
    pub pairs: Vec<f64>,
    /// What it gains beside all others; nothing where those or all together are singular.
    pub among_all: Option<Gain>,
    /// What it gained when it was chosen, or gains beside those that were.
    pub beside_chosen: Option<Gain>,
    /// Whether forward selection chose it.
    pub kept: bool,
    /// Why it is kept or would be dropped.
    pub reason: String,
}
