//! Settings: the tables and their draws.

use crate::demo;

/// The available tables, by number.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Id(&'static str);

impl Id {
    /// Figure 5.35.
    pub const PARK: Self = Self("5.35");

    /// All tables. Tables 5.14 and 5.15 are part of 5.12 and 5.13.
    pub const ALL: [Self; 21] = [
        Self("2.2"),
        Self("3.1"),
        Self("3.2"),
        Self("4.1"),
        Self("4.2"),
        Self("4.3"),
        Self("4.4"),
        Self("piecewise"),
        Self("5.2"),
        Self("5.3"),
        Self("5.4"),
        Self("5.5"),
        Self("5.6"),
        Self("5.7"),
        Self("5.8"),
        Self("5.9"),
        Self("5.10"),
        Self("5.11"),
        Self("5.12"),
        Self("5.13"),
        Self::PARK,
    ];

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

    /// Whether it is one of the actuator.
    #[must_use]
    pub fn is_chapter_5(&self) -> bool {
        self.0.starts_with('5')
    }
}

/// Largest number of draws of Figure 5.35, whose records pass the front end once for each angle.
const PARK_DRAWS: u32 = 2;

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
        (0..self.repetitions).map(|repetition| 1 + self.of(repetition).count()).sum()
    }

    /// Number of draws for the actuator, whose traces take longest.
    #[must_use]
    pub const fn actuator_repetitions(&self) -> u32 {
        self.repetitions.div_ceil(4)
    }

    /// The tables of one repetition.
    pub(super) fn of(&self, repetition: u32) -> impl Iterator<Item = Id> + '_ {
        let few = self.actuator_repetitions();
        let draws = move |id: &Id| match *id {
            Id::PARK => few.min(PARK_DRAWS),
            id if id.is_chapter_5() => few,
            _ => u32::MAX,
        };
        self.tables.iter().copied().filter(move |id| repetition < draws(id))
    }

    pub(super) fn sets(&self, repetition: u32) -> (u32, u32) {
        demo::Settings { repetitions: self.repetitions, traces: 0, seed: self.seed }.sets(repetition)
    }
}
