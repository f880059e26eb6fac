//! Our method; all tables call this module.

use super::recorded::{Recorded, Selection};
use crate::demo::FirstInput;
use crate::literal::Judged;
use crate::recipes::shaft;
use model::Error;
use model::core::Finding;
use model::evaluate;
use model::train::train;

/// Name of the row with the results of [`verdicts`].
pub const NAME: &str = "ours: torque balance, bearing order, QDA, the core in f32";

/// Description of the method in one sentence.
pub const DESCRIPTION: &str = "Ours: drag and torque constant from the torque balance, each in standard deviations of its own record, and the prominence of \
     the outer race's order; no projection, quadratic discriminant with halved correlations, every verdict given by the embedded detector in single precision.";

/// Trains on one set and decides on another with the embedded detector. The class of a trace is its index in `classes`.
///
/// All tables use this function for our method. To change the configuration, change this function and the name above.
///
/// # Errors
/// Returns an error if training or embedding fails.
pub fn verdicts(
    training: &[(&Recorded, usize)],
    validation: &[(&Recorded, usize)],
    classes: &[String],
) -> Result<Vec<Option<usize>>, Error> {
    let labelled = |set: &[(&Recorded, usize)]| -> Vec<_> {
        let label = |&(recorded, class): &(&Recorded, usize)| {
            let mut labelled = recorded.labelled(FirstInput::Reference);
            labelled.class = class;
            labelled
        };
        set.iter().map(label).collect()
    };
    let model = train(&labelled(training), classes, &shaft())?.embed()?;
    let verdicts = evaluate::run(&model, &labelled(validation), || ())?;
    Ok(verdicts.into_iter().map(|verdict| verdict.decided.and_then(Finding::class)).collect())
}

/// Decisions of our method, counted as for the source's method: among all classes, and by one binary classifier per
/// defect.
///
/// # Errors
/// Same as [`verdicts`].
pub fn judge(training: &[Recorded], validation: &[Recorded], selection: Selection) -> Result<Judged, Error> {
    let names = selection.names();
    let [training, validation] =
        [training, validation].map(|set| selection.pick(set, |recorded: &Recorded| recorded.class));
    let decided = verdicts(&as_they_are(&training), &as_they_are(&validation), &names)?;
    let mut binary = Vec::new();
    for defect in 1..names.len() {
        let pair = [names[0].clone(), names[defect].clone()];
        let found = verdicts(&one_defect(&training, defect), &one_defect(&validation, defect), &pair)?;
        let mut found = found.into_iter();
        let seen = validation.iter().map(|recorded| recorded.class == 0 || recorded.class == defect);
        binary.push(seen.map(|seen| if seen { found.next().flatten() } else { None }).collect::<Vec<_>>());
    }
    let mut judged = Judged::new(&names);
    for (place, (recorded, decided)) in validation.iter().zip(decided).enumerate() {
        judged.add(recorded.class, decided, |defect| binary[defect - 1][place]);
    }
    Ok(judged)
}

fn as_they_are<'a>(set: &[&'a Recorded]) -> Vec<(&'a Recorded, usize)> {
    set.iter().map(|&recorded| (recorded, recorded.class)).collect()
}

/// The traces of the healthy class and of one defect, as classes 0 and 1.
fn one_defect<'a>(set: &[&'a Recorded], defect: usize) -> Vec<(&'a Recorded, usize)> {
    let seen = set.iter().filter(|recorded| recorded.class == 0 || recorded.class == defect);
    seen.map(|&recorded| (recorded, usize::from(recorded.class == defect))).collect()
}
