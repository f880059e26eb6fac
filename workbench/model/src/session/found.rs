//! What `evaluate` finds beside the confusion matrix, as text and as JSON.

use serde_json::{Map, Value};

use crate::core::features::Catalogue;
use crate::evaluate::{Breakdown, Chance, Control, Discrimination, FalseAlarms, Judged, Rate, Stability, stability};
use crate::train::features_of;

/// What is found beside the confusion matrix.
#[derive(Debug)]
pub struct Findings {
    /// False alarms by run, if the runs are known.
    pub by_run: Option<FalseAlarms>,
    /// What chance alone would give.
    pub chance: Option<Chance>,
    /// How well each score distinguishes each class from healthy.
    pub roc_areas: Vec<Discrimination>,
    /// Rates by the values of columns.
    pub by: Vec<Breakdown>,
    /// Negative controls.
    pub controls: Vec<Control>,
    /// Classes that the model was not trained on.
    pub untrained: Vec<Untrained>,
    /// By class; only those classes that have enough runs.
    pub stability: Vec<(String, Vec<Stability>)>,
}

impl Findings {
    pub(super) fn add_to(&self, value: &mut Value) {
        let rates = |control: bool| -> Map<_, _> {
            let own = self.untrained.iter().filter(|one| one.control == control);
            own.map(|one| (one.name.clone(), one.rate.to_json())).collect()
        };
        value["untrained_not_called_healthy"] = rates(false).into();
        value["controls_not_called_healthy"] = rates(true).into();
        value["chance"] = self.chance.as_ref().map_or(Value::Null, Chance::to_json);
        value["roc_areas"] = self.roc_areas.iter().map(Discrimination::to_json).collect();
        value["controls"] = self.controls.iter().map(Control::to_json).collect();
        let by = self.by.iter().map(|one| (one.column.clone(), one.to_json()));
        value["by"] = by.collect::<Map<_, _>>().into();
        if let Some(found) = &self.by_run {
            value["false_alarms_by_run"] = found.to_json();
            let each = |(class, rows): &(String, Vec<Stability>)| {
                (class.clone(), rows.iter().map(Stability::to_json).collect())
            };
            value["features_by_run"] = self.stability.iter().map(each).collect::<Map<_, _>>().into();
        }
    }

    /// Chance, false alarms, controls and untrained classes, as sentences.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let chance = self.chance.iter().map(ToString::to_string);
        let by_run = self.by_run.iter().map(|found| format!("false alarms {found}"));
        let controls = self.controls.iter().map(ToString::to_string);
        let untrained = self.untrained.iter().map(|Untrained { name, rate, control }| {
            let what = if *control { "negative control" } else { "not trained" };
            format!("{name}, {what}: not called healthy {rate}")
        });
        chance.chain(by_run).chain(controls).chain(untrained).collect()
    }

    pub(super) fn lines(&self) -> Vec<String> {
        let mut lines: Vec<String> = self.by.iter().map(ToString::to_string).chain(self.notes()).collect();
        lines.extend(self.roc_areas.iter().map(ToString::to_string));
        // The first class stands for the others of a model without a healthy one; JSON has all.
        for (class, rows) in self.stability.iter().take(1) {
            let runs = rows[0].runs;
            lines.push(format!("features of {class} over {runs} runs: likeness within a run (ICC), drift a run in"));
            lines.push("  standard deviations within a run, its p".into());
            lines.extend(rows.iter().map(|row| format!("  {row}")));
        }
        lines
    }
}

/// A class that the model was not trained on, and the rate of its traces or segments that are not called healthy.
#[derive(Debug)]
pub struct Untrained {
    name: String,
    rate: Rate,
    /// Whether it has no defect.
    control: bool,
}

pub(super) fn untrained(judged: &Judged<'_>, controls: &[String]) -> Vec<Untrained> {
    let one = |(class, name): (usize, &String)| {
        let rate = judged.right(|k| judged.verdicts[k].class == class)?;
        Some(Untrained { name: name.clone(), rate, control: controls.contains(name) })
    };
    judged.classes.iter().enumerate().skip(judged.trained).filter_map(one).collect()
}

/// The stability of the model's features over runs: of the healthy class, or of each class without one.
pub(super) fn stabilities(
    judged: &Judged<'_>,
    runs: &[String],
    catalogue: &Catalogue,
    features: &[String],
) -> Vec<(String, Vec<Stability>)> {
    let names = catalogue.names();
    let places: Vec<usize> = features.iter().filter_map(|name| names.iter().position(|own| own == name)).collect();
    let of_class = |class: usize| {
        let (mut rows, mut of_row) = (vec![], vec![]);
        for (verdict, run) in judged.verdicts.iter().zip(runs).filter(|(verdict, _)| verdict.class == class) {
            for segment in &verdict.segments {
                let (values, variances) = features_of(segment, catalogue);
                rows.push(places.iter().map(|&k| variances[k].is_finite().then_some(values[k])).collect());
                of_row.push(run.clone());
            }
        }
        let names: Vec<String> = places.iter().map(|&k| names[k].clone()).collect();
        (judged.classes[class].clone(), stability(&names, &rows, &of_row))
    };
    let classes = judged.healthy.map_or_else(|| (0..judged.trained).collect(), |healthy| vec![healthy]);
    classes.into_iter().map(of_class).filter(|(_, rows)| !rows.is_empty()).collect()
}
