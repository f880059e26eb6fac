//! A table under construction: every repetition fills the same cells once; what is printed are means and deviations.

use crate::study::literal::Rule;

/// How the numbers of a column are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// So many decimals.
    Fixed(usize),
    /// Mantissa with so many decimals, and a power of ten.
    Power(usize),
    /// Two digits of the deviation, so many decimals without one.
    Deviation(usize),
}

impl Digits {
    /// A number as text.
    #[must_use]
    pub fn write(self, value: f64) -> String {
        match self {
            Self::Fixed(places) | Self::Deviation(places) => format!("{value:.places$}"),
            Self::Power(places) => format!("{value:.places$e}"),
        }
    }

    /// Mean and deviation as text.
    fn write_both(self, mean: f64, sd: f64) -> String {
        let digits = match self {
            Self::Deviation(most) if sd > 0.0 => {
                let place = 1.0 - sd.log10().floor();
                Self::Fixed((0..=most + 4).find(|&k| k as f64 >= place).unwrap_or(most))
            }
            other => other,
        };
        format!("{} ± {}", digits.write(mean), digits.write(sd))
    }
}

/// The head of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, with the unit where there is one.
    pub name: String,
    /// How its numbers are written.
    pub digits: Digits,
}

impl Column {
    /// A column.
    #[must_use]
    pub fn new(name: impl Into<String>, digits: Digits) -> Self {
        Self { name: name.into(), digits }
    }
}

/// What stands in a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Nothing.
    Empty,
    /// A figure of the source, as printed.
    Published(f64),
    /// One value a repetition.
    Measured(Vec<f64>),
}

/// Mean and standard deviation over repetitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of one repetition, N − 1; nothing from one of them.
    pub sd: Option<f64>,
    /// Repetitions.
    pub count: usize,
}

impl Cell {
    /// One value of a repetition.
    #[must_use]
    pub fn one(value: f64) -> Self {
        Self::Measured(vec![value])
    }

    /// A rate as a percentage.
    #[must_use]
    pub fn percent(rate: f64) -> Self {
        Self::one(100.0 * rate)
    }

    /// Over the repetitions; nothing where nothing was measured.
    #[must_use]
    pub fn statistic(&self) -> Option<Statistic> {
        let Self::Measured(values) = self else { return None };
        let count = values.len();
        let n = count as f64;
        let mean = values.iter().sum::<f64>() / n;
        let squares = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
        let sd = (count > 1).then(|| (squares / (n - 1.0)).sqrt());
        (count > 0).then_some(Statistic { mean, sd, count })
    }

    /// As it is shown.
    #[must_use]
    pub fn write(&self, digits: Digits) -> String {
        match (self, self.statistic()) {
            // The digits that the source printed.
            (Self::Published(value), _) if value.abs() < 1e-3 => format!("{value:e}"),
            (Self::Published(value), _) => value.to_string(),
            (_, Some(Statistic { mean, sd: Some(sd), .. })) => digits.write_both(mean, sd),
            (_, Some(Statistic { mean, .. })) => digits.write(mean),
            _ => "–".to_string(),
        }
    }
}

/// A row with its name.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What was done.
    pub name: String,
    /// A cell a column.
    pub cells: Vec<Cell>,
}

/// Samples of one feature by class, of the first repetition.
#[derive(Clone, Debug)]
pub struct Spread {
    /// Title of the plot.
    pub title: String,
    /// Name of the feature.
    pub feature: String,
    /// Class name and samples.
    pub classes: Vec<(String, Vec<f64>)>,
}

/// Two coordinates of every trace, with the rule that decides on them, of the first repetition.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Title of the plot.
    pub title: String,
    /// The classes.
    pub classes: Vec<PlaneClass>,
    /// Trained on the training points.
    pub rule: Rule,
}

/// Points of one class.
#[derive(Clone, Debug)]
pub struct PlaneClass {
    /// Its name.
    pub name: String,
    /// Training points.
    pub training: Vec<(f64, f64)>,
    /// Validation points.
    pub held_out: Vec<(f64, f64)>,
}

/// What is drawn of a table.
#[derive(Clone, Debug)]
pub enum Figure {
    /// Densities of a feature.
    Spread(Spread),
    /// Decision regions.
    Plane(Box<Plane>),
}

/// A published table beside ours.
#[derive(Clone, Debug)]
pub struct Table {
    /// Number in the source, or a word.
    pub id: &'static str,
    /// Title.
    pub title: String,
    /// Signals, order and traces.
    pub conditions: String,
    /// Heads of the columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Row>,
    /// Where and why ours differs from the source, a paragraph each.
    pub words: Vec<String>,
    /// Plots of the first repetition.
    pub figures: Vec<Figure>,
}

impl Table {
    /// Takes over another repetition's values of the same table.
    pub fn absorb(&mut self, other: Self) {
        for (row, more) in self.rows.iter_mut().zip(other.rows) {
            for (cell, more) in row.cells.iter_mut().zip(more.cells) {
                if let (Cell::Measured(values), Cell::Measured(more)) = (cell, more) {
                    values.extend(more);
                }
            }
        }
    }

    /// Statistic of the cell of a row and a column.
    #[must_use]
    pub fn statistic(&self, row: &str, column: &str) -> Option<Statistic> {
        self.cell(row, column)?.statistic()
    }

    /// The cell of a row and a column.
    #[must_use]
    pub fn cell(&self, row: &str, column: &str) -> Option<&Cell> {
        let place = self.columns.iter().position(|c| c.name == column)?;
        self.rows.iter().find(|r| r.name == row)?.cells.get(place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table(value: f64) -> Table {
        let cells = vec![Cell::Published(28.33), Cell::one(value), Cell::Empty];
        let columns = ["published", "ours", "none"].map(|name| Column::new(name, Digits::Fixed(1)));
        Table {
            id: "4.1",
            title: String::new(),
            conditions: String::new(),
            columns: columns.to_vec(),
            rows: vec![Row { name: "r".into(), cells }],
            words: vec![],
            figures: vec![],
        }
    }

    #[test]
    fn repetitions_gather_in_their_cells() {
        let mut all = table(2.0);
        assert_eq!(all.cell("r", "ours").map(|c| c.write(Digits::Fixed(1))), Some("2.0".into()));
        for value in [4.0, 6.0] {
            all.absorb(table(value));
        }
        // Deviations −2, 0, 2: variance 8/2 = 4.
        let found = all.cell("r", "ours").and_then(Cell::statistic);
        assert_eq!(found, Some(Statistic { mean: 4.0, sd: Some(2.0), count: 3 }));
        let written: Vec<_> = all.rows[0].cells.iter().map(|c| c.write(Digits::Fixed(1))).collect();
        assert_eq!(written, ["28.33", "4.0 ± 2.0", "–"]);
        let close = Cell::Measured(vec![-0.85871, -0.85923]);
        assert_eq!(close.write(Digits::Deviation(4)), "-0.85897 ± 0.00037"); // sd 0.00052/√2
        assert!(all.cell("r", "absent").is_none() && all.cell("absent", "ours").is_none());
    }
}
