//! Definitions of the experiments: training set, test set and counted outcome.

use model::Error;
use rig::{Condition, Defect, DefectKind};

/// Goal for a rate, percent.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Goal {
    /// Upper limit.
    AtMost(f64),
    /// Lower limit.
    AtLeast(f64),
}

impl Goal {
    /// Whether the rate meets the goal.
    #[must_use]
    pub fn met(self, percent: f64) -> bool {
        // Percentages computed from equal counts may differ by rounding.
        let slack = 1e-9;
        match self {
            Self::AtMost(most) => percent <= most + slack,
            Self::AtLeast(least) => percent >= least - slack,
        }
    }
}

impl std::fmt::Display for Goal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::AtMost(most) => write!(f, "≤ {most}"),
            Self::AtLeast(least) => write!(f, "≥ {least}"),
        }
    }
}

/// A training set.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    /// Condition of the traces.
    pub condition: Condition,
    /// One defect per class; the first class is healthy.
    pub classes: Vec<Defect>,
    /// Number of traces per class.
    pub count: u32,
}

/// Outcome of a test record that is counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judge {
    /// The most probable class is not the true class; the novelty gate is ignored.
    Error,
    /// The verdict is a wrong class, either healthy or another defect.
    Misnamed,
    /// The verdict is healthy.
    CalledHealthy,
    /// The verdict is not healthy.
    Detected,
}

/// One experiment of a campaign; its result is one rate.
#[derive(Clone, Debug)]
pub struct Experiment {
    /// Experiments with the same group are reported together.
    pub group: &'static str,
    /// Name of the experiment.
    pub name: String,
    /// Training set.
    pub training: Training,
    /// Conditions and defects of the test records.
    pub tests: Vec<(Condition, Defect)>,
    /// Number of records that are combined to one verdict.
    pub records: u32,
    /// Counted outcome.
    pub judge: Judge,
    /// Goal, if there is one.
    pub goal: Option<Goal>,
}

impl Experiment {
    /// What the name starts with: the condition of the test records.
    fn condition(&self) -> &str {
        self.name.split([':', ',']).next().unwrap_or_default()
    }
}

const STANDARD: Condition = Condition::STANDARD;
const MIX: Condition = Condition::MIX;
const HEALTHY: Defect = Defect::HEALTHY;

const fn sized(kind: DefectKind, severity: f64) -> Defect {
    Defect { kind, severity }
}

/// All experiments, with `count` traces per class and set.
#[must_use]
pub fn all(count: u32) -> Vec<Experiment> {
    let mut all = three_classes(count);
    all.extend(half_size(count));
    all.extend(healthy_only(count));
    all.extend(limits(count));
    all.extend(isolation(count));
    all.extend(unseen(count));
    all
}

/// The experiments of these conditions, all if none is named. The name of an experiment starts with its condition, up
/// to a colon or a comma.
///
/// # Errors
/// [`Error::Usage`] if no experiment has one of the names.
pub fn named(count: u32, names: &[String]) -> Result<Vec<Experiment>, Error> {
    let all = all(count);
    if let Some(name) = names.iter().find(|name| !all.iter().any(|own| own.condition().eq_ignore_ascii_case(name))) {
        let mut known: Vec<String> = Vec::new();
        for condition in all.iter().map(|own| own.condition().to_lowercase()) {
            if !known.contains(&condition) {
                known.push(condition);
            }
        }
        return Err(Error::Usage(format!("--only: no row {name}; there are {}", known.join(", "))));
    }
    let is_wanted = |own: &Experiment| names.iter().any(|name| own.condition().eq_ignore_ascii_case(name));
    Ok(all.into_iter().filter(|own| names.is_empty() || is_wanted(own)).collect())
}

/// Healthy, spall, roughness at full size.
#[must_use]
pub fn full_size() -> Vec<Defect> {
    vec![HEALTHY, Defect::full(DefectKind::Spall), Defect::full(DefectKind::Roughness)]
}

fn three_classes(count: u32) -> Vec<Experiment> {
    let one = |group, name: String, trained: Condition, tested: Condition, most: f64| Experiment {
        group,
        name,
        training: Training { condition: trained, classes: full_size(), count },
        tests: full_size().into_iter().map(|defect| (tested, defect)).collect(),
        records: 1,
        judge: Judge::Error,
        goal: Some(Goal::AtMost(most)),
    };
    let same = "3-class error, conditions as trained";
    let mut all = vec![one(same, "standard".into(), STANDARD, STANDARD, 0.2), one(same, "MIX".into(), MIX, MIX, 0.5)];
    let shifts = Condition::EXCITATION.into_iter().chain(Condition::LOAD).chain(Condition::RESISTANCE);
    let shifted = "3-class error, trained on the standard rig, judged under another condition";
    all.extend(shifts.map(|c| one(shifted, format!("{}: {}", c.name, c.about), STANDARD, c, 0.5)));
    let noise = "3-class error, trained on the standard rig, judged under other noise";
    let free = |e: Experiment| Experiment { goal: None, ..e };
    all.extend(
        Condition::NOISE.into_iter().map(|c| free(one(noise, format!("{}: {}", c.name, c.about), STANDARD, c, 0.0))),
    );
    all
}

fn half_size(count: u32) -> Vec<Experiment> {
    let one = |condition: Condition, name: &str, judge, most| Experiment {
        group: "half-size defects, trained at full size",
        name: format!("{}: {name}", condition.name),
        training: Training { condition, classes: full_size(), count },
        tests: [DefectKind::Spall, DefectKind::Roughness].map(|kind| (condition, sized(kind, 0.5))).to_vec(),
        records: 1,
        judge,
        goal: Some(Goal::AtMost(most)),
    };
    let both = |condition| {
        [one(condition, "misnamed", Judge::Misnamed, 2.0), one(condition, "called healthy", Judge::CalledHealthy, 0.5)]
    };
    both(STANDARD).into_iter().chain(both(MIX)).collect()
}

fn healthy_only(count: u32) -> Vec<Experiment> {
    let one = |condition: Condition, traces: u32, defect: Defect, goal| Experiment {
        group: "trained on healthy traces alone, detected at 1 % false alarms",
        name: match defect.kind {
            DefectKind::Healthy => format!("{}, {traces} healthy traces: false alarms", condition.name),
            kind => {
                format!("{}, {traces} healthy traces: {} at {}", condition.name, kind.name(), part(defect.severity))
            }
        },
        training: Training { condition, classes: vec![HEALTHY], count: traces },
        tests: vec![(condition, defect)],
        records: 1,
        judge: Judge::Detected,
        goal,
    };
    use DefectKind::{Roughness, Spall};
    let least = |percent| Some(Goal::AtLeast(percent));
    let mut all = Vec::new();
    for traces in [count, 5 * count] {
        all.push(one(STANDARD, traces, sized(Spall, 0.125), least(99.0)));
        all.push(one(STANDARD, traces, sized(Roughness, 0.125), least(100.0)));
    }
    for (severity, goal) in [(0.5, 100.0), (0.25, 97.0), (0.125, 50.0)] {
        all.push(one(MIX, 5 * count, sized(Spall, severity), least(goal)));
    }
    all.push(one(MIX, 5 * count, sized(Roughness, 0.125), least(100.0)));
    // A healthy record that is detected is a false alarm. These experiments have too few records to measure a rate of
    // 1 %; `alarms::false_alarms` measures it.
    for (condition, traces) in [(STANDARD, count), (STANDARD, 5 * count), (MIX, 5 * count)] {
        all.push(one(condition, traces, HEALTHY, None));
    }
    all
}

fn limits(count: u32) -> Vec<Experiment> {
    let one = |group, condition: Condition, defect: Defect, records, goal: bool| Experiment {
        group,
        name: format!("{}: {} at {}", condition.name, defect.kind.name(), part(defect.severity)),
        training: Training { condition, classes: vec![HEALTHY, defect], count },
        tests: vec![(condition, HEALTHY), (condition, defect)],
        records,
        judge: Judge::Error,
        goal: goal.then_some(Goal::AtMost(1.0)),
    };
    use DefectKind::{Roughness, Spall};
    let single = "healthy or not, retrained at each size: error of one 10 s record";
    let four = "healthy or not, retrained at each size: error of four records together";
    let mut all = Vec::new();
    let mut sizes = |group, condition, kind, sizes: &[f64], wanted: f64, records| {
        all.extend(sizes.iter().map(|&s| one(group, condition, sized(kind, s), records, s >= wanted)));
    };
    sizes(single, STANDARD, Spall, &[0.125, 0.0625], 0.125, 1);
    sizes(single, STANDARD, Roughness, &[1.0 / 64.0, 1.0 / 128.0], 1.0 / 64.0, 1);
    sizes(single, MIX, Spall, &[0.25, 0.2, 0.125], 0.2, 1);
    sizes(single, MIX, Roughness, &[1.0 / 16.0, 1.0 / 32.0, 1.0 / 64.0], 1.0 / 32.0, 1);
    sizes(four, MIX, Spall, &[0.125, 0.0625], 0.125, 4);
    sizes(four, MIX, Roughness, &[1.0 / 64.0, 1.0 / 128.0], 1.0 / 64.0, 4);
    all
}

fn isolation(count: u32) -> Vec<Experiment> {
    let one = |(severity, most)| {
        let classes = vec![HEALTHY, sized(DefectKind::Spall, severity), sized(DefectKind::Coulomb, severity)];
        Experiment {
            group: "spall against Coulomb roughness of equal mean torque, three classes: error",
            name: format!("standard: size {}", part(severity)),
            tests: classes.iter().map(|defect| (STANDARD, *defect)).collect(),
            training: Training { condition: STANDARD, classes, count },
            records: 1,
            judge: Judge::Error,
            // A goal of 0 means that no test record is wrong.
            goal: Some(Goal::AtMost(most)),
        }
    };
    [(1.0, 0.0), (0.5, 1.0), (0.25, 4.0)].into_iter().map(one).collect()
}

fn unseen(count: u32) -> Vec<Experiment> {
    let one = |condition: Condition, kind: DefectKind| Experiment {
        group: "a state not trained, gate at 1 % false alarms: called healthy",
        name: format!("{}: {}", condition.name, kind.name()),
        training: Training { condition, classes: full_size(), count },
        tests: vec![(condition, Defect::full(kind))],
        records: 1,
        judge: Judge::CalledHealthy,
        goal: Some(Goal::AtMost(1.0)),
    };
    let kinds = [DefectKind::SpallAndRoughness, DefectKind::Coulomb, DefectKind::WeakMagnet];
    [STANDARD, MIX].into_iter().flat_map(|condition| kinds.map(|kind| one(condition, kind))).collect()
}

/// The severity as text, for example `1/8` or `full size`.
#[must_use]
pub fn part(severity: f64) -> String {
    if severity >= 1.0 { "full size".into() } else { format!("1/{}", (1.0 / severity).round()) }
}
