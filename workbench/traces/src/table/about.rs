//! What a table says of itself beside its numbers.

/// What was left out of a file, and why.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Omitted {
    /// Line, column or array.
    pub place: String,
    /// Why, and what to do about it.
    pub reason: String,
}

/// Columns that are times, and what was left out or guessed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct About {
    /// Places of columns whose numbers are seconds from the first row, whatever their names say.
    pub clocks: Vec<usize>,
    /// Seconds of a step of the integers that some of them are.
    pub ticks_s: Vec<(usize, f64)>,
    /// Places of columns that have the name of a time and count rows.
    pub counters: Vec<usize>,
    /// Places of columns that repeat the time for another channel.
    pub twins: Vec<usize>,
    /// A column with the part of a second that the time lacks: its place, and the seconds of its unit.
    pub fraction: Option<(usize, f64)>,
    /// A channel that has other times: its place, and the line where they differ first.
    pub other_times: Option<(usize, u64)>,
    /// Seconds from row to row, if the file tells them and has no column of times.
    pub step_s: Option<f64>,
    /// What was left out.
    pub omitted: Vec<Omitted>,
    /// What was guessed, a sentence each.
    pub notes: Vec<String>,
}

impl About {
    /// What was left out or guessed, a sentence each.
    pub fn told(&self) -> impl Iterator<Item = String> + '_ {
        let omitted = self.omitted.iter().map(|Omitted { place, reason }| format!("{place}: left out: {reason}"));
        omitted.chain(self.notes.iter().cloned())
    }

    /// Adds what was left out.
    pub fn omit(&mut self, place: impl Into<String>, reason: impl Into<String>) {
        self.omitted.push(Omitted { place: place.into(), reason: reason.into() });
    }
}
