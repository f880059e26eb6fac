//! Settings: the tables and their draws.

use crate::study::demo;

/// The available tables, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Id(&'static str);

impl Id {
    /// All tables.
    pub const ALL: [Self; 8] =
        [Self("2.2"), Self("3.1"), Self("3.2"), Self("4.1"), Self("4.2"), Self("4.3"), Self("4.4"), Self("piecewise")];

    /// Parses a table number.
    ///
    /// # Errors
    /// Returns an error for an unknown number; the message lists the known numbers.
    pub fn parse(text: &str) -> Result<Self, String> {
        let known = Self::ALL.into_iter().find(|id| id.0 == text.trim());
        let names = Self::ALL.map(|id| id.0).join(", ");
        known.ok_or_else(|| format!("there is no table \"{text}\"; there are {names}"))
    }

    /// The number as text.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        self.0
    }
}

/// Settings of a run.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Number of draws of training and validation sets.
    pub repetitions: u32,
    /// Repetition r trains on set `seed` + 2r and validates on set `seed` + 2r + 1.
    pub seed: u32,
    /// Tables, in the order of output.
    pub tables: Vec<Id>,
}

impl Settings {
    /// Number of progress steps of [`run`](super::run).
    #[must_use]
    pub fn steps(&self) -> usize {
        self.repetitions as usize * (self.tables.len() + 1)
    }

    pub(super) fn sets(&self, repetition: u32) -> (u32, u32) {
        demo::Settings { repetitions: self.repetitions, traces: 0, seed: self.seed }.sets(repetition)
    }
}
