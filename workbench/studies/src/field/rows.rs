//! The rows and columns of the table, and the cells of traces behind them.

use crate::campaign::{Cell, Purpose};
use model::Error;
use rig::{Condition, Defect, DefectKind};

/// Validation records of the gate: healthy ones, and the defects of the columns.
pub const COLUMNS: [Defect; 8] = [
    Defect::HEALTHY,
    Defect::full(DefectKind::Spall),
    sized(DefectKind::Spall, 1.0 / 2.0),
    sized(DefectKind::Spall, 1.0 / 4.0),
    sized(DefectKind::Spall, 1.0 / 8.0),
    Defect::full(DefectKind::Roughness),
    sized(DefectKind::Roughness, 1.0 / 8.0),
    sized(DefectKind::Roughness, 1.0 / 32.0),
];

/// Classes of the discriminant, all at full size in training.
pub const CLASSES: [DefectKind; 3] = [DefectKind::Healthy, DefectKind::Spall, DefectKind::Roughness];

/// Sizes of the defects on which the discriminant is judged.
pub const CLASS_SIZES: [f64; 2] = [1.0, 0.5];

const fn sized(kind: DefectKind, severity: f64) -> Defect {
    Defect { kind, severity }
}

/// One row: the conditions of training and validation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Condition of the training records.
    pub trained: Condition,
    /// Condition of the validation records.
    pub judged: Condition,
    /// Whether a discriminant of three classes is trained and judged as well.
    pub classes: bool,
    /// Whether the detector knows the temperature, as a covariate.
    pub known: bool,
}

impl Row {
    /// Trained and judged under the same condition.
    const fn same(condition: Condition, classes: bool) -> Self {
        Self { trained: condition, judged: condition, classes, known: false }
    }

    /// Name of the row: that of the condition, with `-known` if the temperature is known, and with `-unseen` if the
    /// gate was trained under [`Condition::MIX`].
    #[must_use]
    pub fn name(&self) -> String {
        if self.known {
            return format!("{}-known", self.judged.name);
        }
        if self.trained == self.judged { self.judged.name.into() } else { format!("{}-unseen", self.judged.name) }
    }

    /// The cell of a defect in the training set.
    #[must_use]
    pub const fn training(&self, draw: u32, defect: Defect) -> Cell {
        Cell { purpose: Purpose::Training, repetition: draw, condition: self.trained, defect }
    }

    /// The cell of a defect in the validation set.
    #[must_use]
    pub const fn validation(&self, draw: u32, defect: Defect) -> Cell {
        Cell { purpose: Purpose::Validation, repetition: draw, condition: self.judged, defect }
    }

    /// The defects of the validation set: those of the columns, and those on which the discriminant is judged.
    #[must_use]
    pub fn judged_defects(&self) -> Vec<Defect> {
        let mut all = COLUMNS.to_vec();
        let sizes = CLASS_SIZES.into_iter().flat_map(|size| CLASSES[1..].iter().map(move |kind| sized(*kind, size)));
        all.extend(sizes.filter(|defect| self.classes && !COLUMNS.contains(defect)));
        all
    }
}

/// All rows: MIX as the reference, each condition of the field, missing samples that the training set did not
/// have, and a drive that knows its temperature.
#[must_use]
pub fn rows() -> Vec<Row> {
    let field = |condition: &Condition| condition.name.starts_with("field-");
    let missing = |condition: &Condition| condition.name.starts_with("missing-");
    let mut rows = vec![Row::same(Condition::MIX, true)];
    rows.extend(Condition::FIELD.into_iter().map(|condition| Row::same(condition, field(&condition))));
    let unseen = |judged: Condition| Row { trained: Condition::MIX, judged, classes: false, known: false };
    rows.extend(Condition::FIELD.into_iter().filter(missing).map(unseen));
    let temperature = Condition::FIELD.into_iter().filter(|condition| condition.name == "temperature");
    rows.extend(temperature.map(|condition| Row { known: true, ..Row::same(condition, false) }));
    rows
}

/// The rows of axes with a weight that the drive does not measure.
#[must_use]
pub fn axes() -> Vec<Row> {
    Condition::AXES.into_iter().map(|condition| Row::same(condition, false)).collect()
}

/// The rows with these names, in the order of [`rows`] and then [`axes`]; all [`rows`] without names, and all [`axes`]
/// for the name `axes`.
///
/// # Errors
/// [`Error::Usage`] with the known names if a name is unknown.
pub fn named(names: &[String]) -> Result<Vec<Row>, Error> {
    if names.is_empty() {
        return Ok(rows());
    }
    if names == ["axes"] {
        return Ok(axes());
    }
    let all: Vec<Row> = rows().into_iter().chain(axes()).collect();
    if let Some(name) = names.iter().find(|name| all.iter().all(|row| row.name() != **name)) {
        let known: Vec<String> = all.iter().map(Row::name).collect();
        return Err(Error::Usage(format!("--only: no row {name}; there are {}", known.join(", "))));
    }
    Ok(all.into_iter().filter(|row| names.contains(&row.name())).collect())
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    #[test]
    fn every_condition_of_the_field_has_a_row() {
        let names: Vec<String> = rows().iter().map(Row::name).collect();
        assert_eq!(names.iter().collect::<HashSet<_>>().len(), names.len());
        assert!(Condition::FIELD.iter().all(|condition| names.iter().any(|name| name == condition.name)));
        assert_eq!((names.len(), names[0].as_str()), (1 + 26 + 3 + 1, "mix"));
        assert_eq!(rows().iter().filter(|row| row.classes).count(), 5);
    }

    #[test]
    fn seeds_of_training_and_validation_are_apart() {
        let (mut training, mut validation) = (HashSet::new(), HashSet::new());
        for row in rows() {
            for draw in 0..25 {
                for number in [0, 1, 59, 149, 299] {
                    let seed = |cell: Cell| cell.seed(number).expect("fits");
                    let classes = CLASSES.map(|kind| seed(row.training(draw, Defect::full(kind))));
                    training.extend(classes);
                    let defects = row.judged_defects();
                    let own: Vec<u64> = defects.iter().map(|defect| seed(row.validation(draw, *defect))).collect();
                    assert_eq!(own.iter().collect::<HashSet<_>>().len(), own.len(), "{}", row.name());
                    validation.extend(own);
                }
            }
        }
        assert!(training.is_disjoint(&validation));
        // 27 conditions: the rows after them use the training sets and records of other rows.
        assert_eq!(training.len(), 27 * 25 * 5 * 3);
        assert_eq!(validation.len(), 25 * 5 * (27 * 8 + 5));
    }

    #[test]
    fn rows_are_chosen_by_name() {
        let asked = ["slip", "mix", "missing-bursts-unseen"].map(String::from);
        let found: Vec<String> = named(&asked).expect("known").iter().map(Row::name).collect();
        assert_eq!(found, ["mix", "slip", "missing-bursts-unseen"]);
        assert_eq!(named(&[]).expect("all").len(), rows().len());
        assert_eq!(named(&["axes".into()]).expect("known"), axes());
        assert_eq!(named(&["axis-0.4-sine".into()]).expect("known"), [axes()[3]]);
        let message = named(&["slipp".into()]).expect_err("unknown").to_string();
        assert!(message.contains("no row slipp; there are mix, temperature"), "{message}");
    }
}
