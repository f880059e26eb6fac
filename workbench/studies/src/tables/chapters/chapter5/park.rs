//! Figure 5.35: the quadrature current from several angles, and what a trained detector says of it.

use crate::ema::park::{AngleFrom, Study, study};
use crate::tables::result::{Cell, Column, Curve, Curves, Digits, Figure, Row, Table};
use model::Error;
use rig::ema::EmaScenario;

/// Records a class and set.
const RECORDS: u32 = 10;

/// Shown time, s.
const SHOWN_S: f64 = 5.0;
/// Points of a shown curve.
const POINTS: usize = 500;

/// The shown angles, by their place in [`AngleFrom::ALL`].
const SHOWN: [usize; 4] = [0, 5, 8, 9];

/// Computes the table of one repetition.
///
/// # Errors
/// Returns an error if the rig or training fails.
pub(in crate::tables) fn measure(sets: (u32, u32)) -> Result<Table, Error> {
    let found = study(sets, RECORDS)?;
    let row = |(from, effect): (&AngleFrom, &crate::ema::park::Effect)| Row {
        name: from.name(),
        cells: vec![
            Cell::one(effect.current_error_percent),
            Cell::percent(effect.wrong),
            Cell::percent(effect.false_alarms),
        ],
    };
    let columns = [("error of iq, % rms", 2), ("wrong verdicts, %", 1), ("of these healthy, %", 1)];
    Ok(Table {
        id: "5.35",
        title: "Figure 5.35: quadrature current and verdict by the angle of the Park transform".into(),
        conditions: format!(
            "EMA MIX at 12 kHz, through the core's front end; trained with the resolver's angle on {RECORDS} records of \
             healthy, spall and roughness at the calibrated size, judged on as many others with each angle; error beside \
             iq from the resolver; wrong: not named by its class, gate at 1 %; of these healthy: share of the healthy \
             records that are not called healthy."
        ),
        columns: columns.map(|(name, digits)| Column::new(name, Digits::Fixed(digits))).to_vec(),
        rows: AngleFrom::ALL.iter().zip(&found.effects).map(row).collect(),
        words: vec![],
        figures: vec![Figure::Curves(Box::new(curves(&found)))],
    })
}

/// Errors of the angle and currents of the example.
fn curves(found: &Study) -> Curves {
    let scenario = EmaScenario::STANDARD;
    let electrical = f64::from(scenario.actuator.pole_pairs).to_degrees();
    let thin = |points: Vec<(f64, f64)>| -> Vec<(f64, f64)> {
        let every = points.len().div_ceil(POINTS).max(1);
        points.into_iter().step_by(every).collect()
    };
    let shown = |values: Vec<f64>, interval_s: f64| {
        let points = values.into_iter().enumerate().map(|(k, value)| (k as f64 * interval_s, value));
        thin(points.take_while(|(t, _)| *t <= SHOWN_S).collect())
    };
    let right = found.example.first().map(|(angles, _)| angles.as_slice()).unwrap_or_default();
    let angle = |place: usize| {
        let (angles, _) = &found.example[place];
        let errors = angles.iter().zip(right).map(|(wrong, right)| electrical * (wrong - right)).collect();
        Curve { name: AngleFrom::ALL[place].name(), points: shown(errors, scenario.drive.interval_s) }
    };
    let current = |place: usize| {
        let (_, signals) = &found.example[place];
        Curve { name: AngleFrom::ALL[place].name(), points: shown(signals.current_a.clone(), signals.interval_s) }
    };
    Curves {
        title: "Figure 5.35: a healthy record with four angles of the Park transform".into(),
        x_label: "time / s".into(),
        panels: vec![
            ("error of the angle / ° electrical".into(), SHOWN.map(angle).to_vec()),
            ("iq / A".into(), SHOWN.map(current).to_vec()),
        ],
    }
}
