//! How the quadrature current, and the verdict of a trained detector, depend on the angle of the Park transform (thesis
//! Fig. 5.35).
//!
//! ```text
//! θ = θ_resolver + δ/p                      wrong by δ electrical          (1)
//! θ = θ₀ + ∫ ((1 + g) ω_m + o) dt           integrated velocity            (2)
//! e = rms(i_q − i_q,resolver)/rms(i_q,resolver)                            (3)
//! ```
//!
//! The recorded drive runs with the angle of its resolver; only the transform, the velocity and the bearing's order of
//! the detector are computed from (1) or (2), by the core's front end. The integral starts at the resolver's angle.

use std::f64::consts::TAU;

use bearing_watch::Angle;

use super::recipe;
use super::record::{Signals, cleaned, cleaned_at};
use super::sets::{self, CLASSES, FACTOR};
use model::Error;
use model::core::{Embedded, Finding};
use model::train::train;
use rayon::prelude::*;
use rig::ema::{EmaCondition, EmaScenario, EmaTrace};
use rig::trace_seed;

/// Where the angle of the transform comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum AngleFrom {
    /// The resolver.
    Resolver,
    /// (1) with δ in degrees.
    Wrong {
        /// δ.
        electrical_deg: f64,
    },
    /// (2).
    Integrated {
        /// g.
        gain: f64,
        /// o.
        offset_rad_s: f64,
    },
}

impl AngleFrom {
    /// All rows. Degrees of the shaft are six times as many electrical ones. A velocity channel of 12 bits over ± 480
    /// rad/s has steps of 0.23 rad/s: an offset of 0.1 rad/s is half a step.
    pub const ALL: [Self; 10] = [
        Self::Resolver,
        Self::wrong(1.0),
        Self::wrong(5.0),
        Self::wrong(10.0),
        Self::wrong(6.0),
        Self::wrong(30.0),
        Self::wrong(60.0),
        Self::Integrated { gain: 0.0, offset_rad_s: 0.0 },
        Self::Integrated { gain: 0.002, offset_rad_s: 0.0 },
        Self::Integrated { gain: 0.0, offset_rad_s: 0.1 },
    ];

    const fn wrong(electrical_deg: f64) -> Self {
        Self::Wrong { electrical_deg }
    }

    /// Name of the row.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Resolver => "resolver".into(),
            Self::Wrong { electrical_deg } => {
                let pole_pairs = f64::from(EmaScenario::STANDARD.actuator.pole_pairs);
                format!("wrong by {electrical_deg}° electrical, {:.2}° of the shaft", electrical_deg / pole_pairs)
            }
            Self::Integrated { gain: 0.0, offset_rad_s: 0.0 } => "integrated velocity, noise alone".into(),
            Self::Integrated { gain, offset_rad_s: 0.0 } => {
                format!("integrated velocity, gain + {:.1} %", 100.0 * gain)
            }
            Self::Integrated { gain: 0.0, offset_rad_s } => format!("integrated velocity, offset {offset_rad_s} rad/s"),
            Self::Integrated { gain, offset_rad_s } => {
                format!("integrated velocity, gain + {:.1} %, offset {offset_rad_s} rad/s", 100.0 * gain)
            }
        }
    }

    /// The angle of each row of a record, radians of the shaft, not wrapped.
    #[must_use]
    pub fn angles(&self, scenario: &EmaScenario, recorded: &EmaTrace) -> Vec<f64> {
        match *self {
            Self::Resolver => recorded.angle_rad.clone(),
            Self::Wrong { electrical_deg } => {
                let shift = electrical_deg.to_radians() / f64::from(scenario.actuator.pole_pairs);
                recorded.angle_rad.iter().map(|angle| angle + shift).collect() // (1)
            }
            Self::Integrated { gain, offset_rad_s } => {
                let velocity = recorded.velocity_rad_s.iter().map(|omega| (1.0 + gain) * omega + offset_rad_s);
                let mut angle = recorded.angle_rad.first().copied().unwrap_or(0.0);
                let step = |omega: f64| {
                    let before = angle;
                    angle += omega * scenario.drive.interval_s;
                    before
                };
                velocity.map(step).collect() // (2)
            }
        }
    }

    /// The record behind the front end.
    ///
    /// # Errors
    /// Errors of [`cleaned_at`].
    pub fn clean(&self, scenario: &EmaScenario, recorded: &EmaTrace) -> Result<Signals, Error> {
        if *self == Self::Resolver {
            return cleaned::<FACTOR>(scenario, recorded);
        }
        let angles = self.angles(scenario, recorded);
        cleaned_at::<FACTOR>(scenario, recorded, |row| binary(angles[row]))
    }
}

#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a part of a turn below one")]
fn binary(angle_rad: f64) -> Angle {
    let turns = angle_rad / TAU;
    Angle::from_bits(((turns - turns.floor()) * 4_294_967_296.0) as u64 as u32)
}

/// Equation (3), %.
#[must_use]
pub fn current_error_percent(wrong: &[f64], right: &[f64]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let error = square(&mut wrong.iter().zip(right).map(|(one, other)| one - other));
    100.0 * (error / square(&mut right.iter().copied())).sqrt() // (3)
}

/// Effect of one source of the angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Effect {
    /// Mean of (3) over the records, %.
    pub current_error_percent: f64,
    /// Share of the records that are not named by their class.
    pub wrong: f64,
    /// Share of the healthy records that are not called healthy.
    pub false_alarms: f64,
}

/// The effects, one for each of [`AngleFrom::ALL`], and one healthy record from each source.
#[derive(Clone, Debug)]
pub struct Study {
    /// In the order of [`AngleFrom::ALL`].
    pub effects: Vec<Effect>,
    /// Angles at the control rate and signals behind the front end, in the same order.
    pub example: Vec<(Vec<f64>, Signals)>,
}

/// Trains on records with the resolver's angle, and judges others with every angle, `count` a class and set.
///
/// # Errors
/// Returns an error if the rig, training or embedding fails.
pub fn study((training, validation): (u32, u32), count: u32) -> Result<Study, Error> {
    let jobs = |set: u32| -> Vec<(usize, u64)> {
        let seeds = move |class: usize| (0..count).map(move |k| (class, trace_seed(set, CLASSES[class].kind, k)));
        (0..CLASSES.len()).flat_map(seeds).collect()
    };
    let condition = EmaCondition::MIX;
    let record = |&(class, seed): &(usize, u64)| sets::labelled(&condition, (class, CLASSES[class]), seed);
    let set = jobs(training).par_iter().map(record).collect::<Result<Vec<_>, _>>()?;
    let model = train(&set, &sets::class_names(), &recipe::recipe())?.embed()?;
    let judged =
        jobs(validation).par_iter().map(|&(class, seed)| one(&model, class, seed)).collect::<Result<Vec<_>, _>>()?;
    let records = judged.len() as f64;
    let effect = |k: usize| {
        let sum = judged.iter().fold(Effect::default(), |sum, record| sum.plus(&record[k]));
        Effect {
            current_error_percent: sum.current_error_percent / records,
            wrong: sum.wrong / records,
            false_alarms: sum.false_alarms / f64::from(count),
        }
    };
    let (scenario, recorded) = sets::recorded(&condition, CLASSES[0], trace_seed(validation, CLASSES[0].kind, 0))?;
    let example = |from: &AngleFrom| Ok((from.angles(&scenario, &recorded), from.clean(&scenario, &recorded)?));
    Ok(Study {
        effects: (0..AngleFrom::ALL.len()).map(effect).collect(),
        example: AngleFrom::ALL.iter().map(example).collect::<Result<_, Error>>()?,
    })
}

impl Effect {
    fn plus(self, other: &Self) -> Self {
        Self {
            current_error_percent: self.current_error_percent + other.current_error_percent,
            wrong: self.wrong + other.wrong,
            false_alarms: self.false_alarms + other.false_alarms,
        }
    }
}

/// One record with every angle.
fn one(model: &Embedded, class: usize, seed: u64) -> Result<Vec<Effect>, Error> {
    let (scenario, recorded) = sets::recorded(&EmaCondition::MIX, CLASSES[class], seed)?;
    let right = cleaned::<FACTOR>(&scenario, &recorded)?;
    let effect = |from: &AngleFrom| {
        let clean = from.clean(&scenario, &recorded)?;
        let current_error_percent = current_error_percent(&clean.current_a, &right.current_a);
        let found = model.combine(&model.run(&clean.into_trace(String::new()))).map(|(finding, _)| finding);
        let wrong = f64::from(u8::from(found != Some(Finding::Class(class))));
        Ok(Effect { current_error_percent, wrong, false_alarms: if class == 0 { wrong } else { 0.0 } })
    };
    AngleFrom::ALL.iter().map(effect).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rig::ema::Logging;

    #[test]
    fn a_wrong_angle_turns_the_current_by_its_cosine_and_an_integral_drifts() {
        let scenario = EmaScenario { rows: 2000, ..EmaScenario::STANDARD }.logged(Logging { every: 1, hold: 1 });
        let recorded = rig::ema::simulate(&scenario, 5).expect("valid");
        let clean = |from: AngleFrom| from.clean(&scenario, &recorded).expect("no faults");
        let right = clean(AngleFrom::Resolver);
        // 20 000 rows by 12, but for the delay of the filters and the samples before the loop locks.
        assert!((1666 - 60..1666 - 10).contains(&right.current_a.len()), "{}", right.current_a.len());
        for degrees in [5.0, 30.0, 60.0] {
            let wrong = clean(AngleFrom::wrong(degrees));
            let found = current_error_percent(&wrong.current_a, &right.current_a);
            // i_q cos δ − i_d sin δ; i_d is the noise of about 0.25 A behind the filters, beside 10 A.
            let expected = 100.0 * (1.0 - degrees.to_radians().cos());
            assert!((found - expected).abs() < 2.0, "{degrees}°: {found} {expected}");
        }
        let drift = |from: AngleFrom| from.angles(&scenario, &recorded)[19_999] - recorded.angle_rad[19_999];
        // The integral starts at the resolver's angle.
        let noise = drift(AngleFrom::Integrated { gain: 0.0, offset_rad_s: 0.0 });
        // 0.4 rad/s of white noise: 0.4/12 000 √20 000 = 0.005 rad; four of them, and the resolver's steps.
        assert!(noise.abs() < 0.02, "{noise}");
        // 0.1 rad/s during 1.667 s.
        let offset = drift(AngleFrom::Integrated { gain: 0.0, offset_rad_s: 0.1 });
        assert!((offset - noise - 0.1667).abs() < 1e-3, "{offset}");
    }

    #[test]
    fn rows_are_named_by_what_is_wrong() {
        let names: Vec<String> = AngleFrom::ALL.iter().map(AngleFrom::name).collect();
        assert_eq!(names[1], "wrong by 1° electrical, 0.17° of the shaft");
        assert_eq!(names[6], "wrong by 60° electrical, 10.00° of the shaft");
        assert_eq!(
            names[7..],
            ["noise alone", "gain + 0.2 %", "offset 0.1 rad/s"].map(|own| format!("integrated velocity, {own}"))
        );
    }
}
