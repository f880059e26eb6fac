//! Size of a growing defect and the time left, beside the truth, on drives that were not in training.
//!
//! A draw trains as [`super::delay`] does and judges the core on histories of other drives. A history is healthy for
//! 20 to 60 runs, and then its defect grows by one of the [`Law`]s from nothing to full size. Its runs are recorded
//! ones of the drive, under all effects of the field: each is drawn from those of the nearest recorded size, and
//! shifted by what is between that size and the one of the history in the drive's mean. So the noise has the law of
//! the rig, and the feature follows the size as it does there; the filter knows neither.
//!
//! ```text
//! μ(a) = mean of the direction at the size a, by lines between the recorded sizes                       (1)
//! truth: runs from now until μ(a) − μ(0) reaches the named size L                                       (2)
//! L    = mean over the drives of μ(½) − μ(0)                                                            (3)
//! ```
//!
//! The time left is asked for at 25, 50 and 75 % of the life (2). Healthy histories count the runs after which the core
//! says that the drive grows: with runs in random order, and with runs whose offsets last, the recorded ones in the
//! order of an autoregressive sequence of φ = 0.8.

mod drive;
mod history;
mod laws;
mod render;
#[cfg(test)]
mod tests;

pub use history::{Asked, Healthy, Outcome, PARTS, Settings};
pub use laws::Law;
pub use render::{text, to_json};

use drive::Drive;
use history::{grown, healthy};

use super::delay;
use crate::campaign::{Cell, Purpose};
use model::Error;
use rig::{Condition, Defect, DefectKind};

/// Histories of one kind of defect.
#[derive(Clone, Debug, PartialEq)]
pub struct Kind {
    /// The kind.
    pub kind: DefectKind,
    /// The direction that is judged.
    pub direction: String,
    /// (3), in standard deviations of usual runs.
    pub named: f64,
    /// Of each law.
    pub grown: Vec<(Law, Vec<Outcome>)>,
    /// Healthy histories in random order, and with offsets that last.
    pub healthy: [Vec<Healthy>; 2],
}

/// What one draw gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Draw {
    /// The condition.
    pub condition: &'static str,
    /// The kinds of defects that training has a direction for.
    pub kinds: Vec<Kind>,
}

/// Trains and judges one draw.
///
/// # Errors
/// Simulation or training fails; training chooses no direction for any kind.
pub fn draw(condition: Condition, number: u32, settings: &Settings) -> Result<Draw, Error> {
    let trained = delay::trained(condition, number, &settings.fleet)?;
    let model = trained.embed()?;
    let names = &trained.coordinate_names;
    let directions = trained.watch.directions.iter().flat_map(|directions| directions.list.iter()).enumerate();
    let mut kinds = vec![];
    for kind in [DefectKind::Spall, DefectKind::Roughness] {
        let raises = |name: &str| match kind {
            DefectKind::Spall => name == "order_outer",
            _ => name == "viscous" || name == "drag",
        };
        let raised = directions.clone().find(|(_, direction)| raises(&names[direction.coordinate]));
        let Some((place, direction)) = raised else { continue };
        let levels = &direction.levels;
        let usual = trained.watch.directions.as_ref().map_or(1.0, |directions| directions.usual);
        let scale = (levels.run + levels.record / usual).sqrt();
        let cell = |severity| Cell {
            purpose: Purpose::Validation,
            repetition: number,
            condition,
            defect: if severity > 0.0 { Defect { kind, severity } } else { Defect::HEALTHY },
        };
        let drives: Vec<Drive> = (0..settings.fleet.drives)
            .map(|unit| Drive::recorded(&model, (place, scale), &cell, unit, &settings.fleet))
            .collect::<Result<_, _>>()?;
        let half: Vec<f64> = drives.iter().map(|drive| drive.shift(0.5)).collect();
        let named = half.iter().sum::<f64>() / half.len() as f64;
        kinds.push(Kind {
            kind,
            direction: direction.words(names),
            named,
            grown: Law::ALL.map(|law| (law, grown(&model, &drives, (law, named), settings))).to_vec(),
            healthy: [0.0, 0.8].map(|lasting| healthy(&model, &drives, (lasting, named), settings)),
        });
    }
    if kinds.is_empty() {
        return Err(Error::Training("training chose no direction for a spall or roughness".into()));
    }
    Ok(Draw { condition: condition.name, kinds })
}
