//! A table under construction: each repetition adds one value to every measured cell; the output shows mean and
//! standard deviation.

use crate::literal::Rule;

/// Number format of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Digits {
    /// This number of decimals.
    Fixed(usize),
    /// Mantissa with this number of decimals, and a power of ten.
    Power(usize),
    /// Two significant digits of the standard deviation; this number of decimals if there is no standard deviation.
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

    /// Mean and standard deviation as text.
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

/// The heading of a column.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Column {
    /// Name, with the unit if there is one.
    pub name: String,
    /// Number format.
    pub digits: Digits,
}

impl Column {
    /// Creates a column.
    #[must_use]
    pub fn new(name: impl Into<String>, digits: Digits) -> Self {
        Self { name: name.into(), digits }
    }
}

/// Content of a cell.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// No content.
    Empty,
    /// A figure of the source, as printed.
    Published(f64),
    /// One value per repetition.
    Measured(Vec<f64>),
}

/// Mean and standard deviation over repetitions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistic {
    /// Mean.
    pub mean: f64,
    /// Standard deviation of one repetition, N − 1; `None` for a single repetition.
    pub sd: Option<f64>,
    /// Number of repetitions.
    pub count: usize,
}

impl Cell {
    /// A measured cell with one value.
    #[must_use]
    pub fn one(value: f64) -> Self {
        Self::Measured(vec![value])
    }

    /// A measured cell with a rate, converted to percent.
    #[must_use]
    pub fn percent(rate: f64) -> Self {
        Self::one(100.0 * rate)
    }

    /// Statistic over the repetitions; `None` without measured values.
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

    /// The cell as text.
    #[must_use]
    pub fn write(&self, digits: Digits) -> String {
        match (self, self.statistic()) {
            // The number of digits that the source printed.
            (Self::Published(value), _) if *value != 0.0 && value.abs() < 1e-3 => format!("{value:e}"),
            (Self::Published(value), _) => value.to_string(),
            (_, Some(Statistic { mean, sd: Some(sd), .. })) => digits.write_both(mean, sd),
            (_, Some(Statistic { mean, .. })) => digits.write(mean),
            _ => "–".to_string(),
        }
    }
}

/// A named row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Name of the method.
    pub name: String,
    /// One cell per column.
    pub cells: Vec<Cell>,
}

/// Samples of one feature by class, from the first repetition.
#[derive(Clone, Debug)]
pub struct Spread {
    /// Title of the plot.
    pub title: String,
    /// Name of the feature.
    pub feature: String,
    /// Class names and samples.
    pub classes: Vec<(String, Vec<f64>)>,
}

/// Two coordinates of every trace and the decision rule, from the first repetition.
#[derive(Clone, Debug)]
pub struct Plane {
    /// Title of the plot.
    pub title: String,
    /// The classes.
    pub classes: Vec<PlaneClass>,
    /// Decision rule trained on the training points.
    pub rule: Rule,
}

/// Points of one class.
#[derive(Clone, Debug)]
pub struct PlaneClass {
    /// Name of the class.
    pub name: String,
    /// Training points.
    pub training: Vec<(f64, f64)>,
    /// Validation points.
    pub held_out: Vec<(f64, f64)>,
}

/// A named curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// Name in the legend.
    pub name: String,
    /// Points.
    pub points: Vec<(f64, f64)>,
}

/// Curves in stacked panels, from the first repetition.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// Title of the plot.
    pub title: String,
    /// Title of the common horizontal axis.
    pub x_label: String,
    /// Titles of the vertical axes, with their curves; each panel has the same ones.
    pub panels: Vec<(String, Vec<Curve>)>,
}

/// A plot of a table.
#[derive(Clone, Debug)]
pub enum Figure {
    /// Curves over a common axis.
    Curves(Box<Curves>),
    /// Densities of a feature.
    Spread(Spread),
    /// Decision regions.
    Plane(Box<Plane>),
}

/// A published table compared with our results.
#[derive(Clone, Debug)]
pub struct Table {
    /// Number of the table in the source, or a name.
    pub id: &'static str,
    /// Title.
    pub title: String,
    /// Signals, order and traces.
    pub conditions: String,
    /// Headings of the columns.
    pub columns: Vec<Column>,
    /// Rows.
    pub rows: Vec<Row>,
    /// Explanations of the differences from the source, one paragraph each.
    pub words: Vec<String>,
    /// Plots of the first repetition.
    pub figures: Vec<Figure>,
}

impl Table {
    /// Appends the values of another repetition of the same table.
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
