//! What the campaign on the actuator measures.

use crate::campaign::Goal;
use rig::ema::{EmaCondition, EmaDefect, Race};
use rig::{Defect, DefectKind};

use super::sets::CLASSES;

/// Outcome of a record that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Counted {
    /// The most plausible class is not the true one; the gate is ignored.
    Error,
    /// The verdict is another class than the true one, but not healthy.
    Misnamed,
    /// The verdict is healthy.
    CalledHealthy,
    /// The verdict is not healthy.
    Detected,
}

/// Records that differ only in their random draws.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Group {
    /// The condition.
    pub condition: EmaCondition,
    /// Class and size.
    pub defect: Defect,
    /// Race of a spall.
    pub race: Race,
}

impl Group {
    /// A group of records with a spall of the inner race, if it has one.
    #[must_use]
    pub const fn new(condition: EmaCondition, defect: Defect) -> Self {
        Self { condition, defect, race: Race::Inner }
    }

    /// The defect of the actuator.
    #[must_use]
    pub fn ema_defect(&self) -> EmaDefect {
        EmaDefect::of(self.defect.kind, self.defect.severity, self.race)
    }

    /// Place of its class in [`CLASSES`], if it is one of them.
    #[must_use]
    pub fn class(&self) -> Option<usize> {
        CLASSES.iter().position(|class| class.kind == self.defect.kind).filter(|_| self.race == Race::Inner)
    }
}

/// A rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Experiment {
    /// Experiments of one section are reported together.
    pub section: &'static str,
    /// Name.
    pub name: String,
    /// Condition of the training records of [`CLASSES`].
    pub trained: EmaCondition,
    /// Judged records.
    pub judged: Vec<Group>,
    /// Counted outcome.
    pub counted: Counted,
    /// Goal, if there is one.
    pub goal: Option<Goal>,
}

const MIX: EmaCondition = EmaCondition::MIX;

/// All experiments.
#[must_use]
pub fn all() -> Vec<Experiment> {
    classes().into_iter().chain(sizes()).chain(gate()).collect()
}

fn named(name: &str) -> EmaCondition {
    EmaCondition::named(name).unwrap_or(MIX)
}

fn classes() -> Vec<Experiment> {
    let one = |name: &str, trained: EmaCondition, judged: EmaCondition, goal| Experiment {
        section: "healthy, spall, roughness: error of the three classes",
        name: name.into(),
        trained,
        judged: CLASSES.map(|defect| Group::new(judged, defect)).to_vec(),
        counted: Counted::Error,
        goal,
    };
    let most = Some(Goal::AtMost(1.0));
    vec![
        one("MIX", MIX, MIX, most),
        one("trained in MIX, triangles", MIX, named("moog-2-mix"), most),
        one("trained in MIX, constant load of 8 kN", MIX, named("moog-5-mix"), most),
        one("trained in MIX, squares of 5 mm", MIX, named("moog-3-mix"), None),
        one("trained on the standard experiment alone, MIX", EmaCondition::STANDARD, MIX, None),
    ]
}

fn sizes() -> Vec<Experiment> {
    let one = |(name, severity): (&str, f64), counted| {
        let defect = |kind| Group::new(MIX, Defect { kind, severity });
        Experiment {
            section: "other sizes in MIX, trained at the calibrated one",
            name: name.into(),
            trained: MIX,
            judged: [DefectKind::Spall, DefectKind::Roughness].map(defect).to_vec(),
            counted,
            goal: None,
        }
    };
    vec![
        one(("twice the size: misnamed", 2.0 * EmaDefect::CALIBRATED), Counted::Misnamed),
        one(("twice the size: called healthy", 2.0 * EmaDefect::CALIBRATED), Counted::CalledHealthy),
        one(("half the size: misnamed", 0.5 * EmaDefect::CALIBRATED), Counted::Misnamed),
        one(("half the size: called healthy", 0.5 * EmaDefect::CALIBRATED), Counted::CalledHealthy),
    ]
}

fn gate() -> Vec<Experiment> {
    let one = |name: &str, group: Group, counted, goal| Experiment {
        section: "gate at 1 % false alarms in MIX, trained on the three classes",
        name: name.into(),
        trained: MIX,
        judged: vec![group],
        counted,
        goal,
    };
    let sized = |kind| Group::new(MIX, Defect { kind, severity: EmaDefect::CALIBRATED });
    let outer = Group { race: Race::Outer, ..sized(DefectKind::Spall) };
    let unseen = |name, group| one(name, group, Counted::CalledHealthy, Some(Goal::AtMost(1.0)));
    let alone = |name, group| one(name, group, Counted::CalledHealthy, None);
    vec![
        one("healthy: false alarms", Group::new(MIX, Defect::HEALTHY), Counted::Detected, None),
        unseen("spall and roughness: called healthy", sized(DefectKind::SpallAndRoughness)),
        alone("spall of the outer race: called healthy", outer),
        alone("Coulomb friction of the spall's mean: called healthy", sized(DefectKind::Coulomb)),
        alone("weak magnet, flux − 2.5 %: called healthy", sized(DefectKind::WeakMagnet)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_distinct_and_conditions_known() {
        let all = all();
        for (k, one) in all.iter().enumerate() {
            assert!(all[..k].iter().all(|other| other.name != one.name), "{}", one.name);
            assert!(!one.judged.is_empty(), "{}", one.name);
        }
        let conditions: Vec<&str> = classes().iter().map(|one| one.judged[0].condition.name).collect();
        assert_eq!(conditions, ["mix", "moog-2-mix", "moog-5-mix", "moog-3-mix", "mix"]);
        // What the error counts is a class; a spall of the outer race is none.
        assert!(classes().iter().flat_map(|one| &one.judged).all(|group| group.class().is_some()));
        assert_eq!(all.iter().filter(|one| one.judged[0].class().is_none()).count(), 4);
    }
}
