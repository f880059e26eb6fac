//! Records of drives over their sessions: a drive has one temperature a session, with a tenth of its range within.
//!
//! The field's own draw takes a temperature for each record, as if ten seconds led from a cold to a hot drive; the
//! records of a session would then differ more than its mean does from that of the next one.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::campaign::run::labelled;
use crate::campaign::{Cell, Purpose, Recording};
use model::Error;
use model::trace::labels::LabelledTrace;
use rig::field::{Drive, Field, Temperature};
use rig::{Scenario, simulate};

/// Part of the range of the temperature within a session.
const WITHIN: f64 = 0.1;
/// Most records of a session, and sessions of a drive, that have seeds of their own.
const RECORDS: u32 = 16;
const SESSIONS: u32 = 1000;

/// Unit, session and record in it.
pub(in crate::field) type Place = [u32; 3];

/// Number of the set of drives: another one for training and validation of each draw.
fn set_of(purpose: Purpose, draw: u32) -> u32 {
    2 * draw + u32::from(purpose == Purpose::Training)
}

/// The record at a place; all records of a cell have seeds of their own.
pub(in crate::field) fn record(cell: Cell, place: Place) -> Result<LabelledTrace, Error> {
    let [unit, session, record] = place;
    if session >= SESSIONS || record >= RECORDS {
        return Err(Error::Usage(format!("at most {SESSIONS} sessions of {RECORDS} records")));
    }
    let number = (unit * SESSIONS + session) * RECORDS + record;
    let seed = cell.seed(number)?;
    let drive = Drive { set: set_of(cell.purpose, cell.repetition), unit, session };
    let trace = simulate(&scenario(cell, seed, drive), seed).map_err(Error::other)?;
    Ok(labelled(Recording { cell, number, seed, trace }, 0))
}

fn scenario(cell: Cell, seed: u64, drive: Drive) -> Scenario {
    let mut scenario = cell.scenario(&Scenario::WITH_RESOLVER, seed);
    scenario.drive = Some(drive);
    let Some(wide) = scenario.field.temperature else { return scenario };
    let key = u64::from(drive.set) << 40 | u64::from(drive.unit) << 20 | u64::from(drive.session);
    let mut random = ChaCha8Rng::seed_from_u64(key);
    let [state, coulomb, a, b]: [f64; 4] = std::array::from_fn(|_| random.random_range(0.0..1.0));
    let flux = 1.0 - wide.flux_loss * state;
    // The deviation of a sum of two uniform numbers is 1/√6.
    let scatter = 6.0_f64.sqrt() * wide.viscous_scatter * (a + b - 1.0);
    let viscous = wide.viscous_cold.ln() + state * (wide.viscous_hot / wide.viscous_cold).ln() + scatter;
    scenario.motor.r_ohm *= 1.0 + wide.resistance_rise * state;
    scenario.motor.kt_nm_per_a *= flux;
    scenario.motor.ke_v_s_per_rad *= flux;
    scenario.motor.b_nm_s_per_rad *= viscous.exp();
    let near = Temperature {
        resistance_rise: WITHIN * wide.resistance_rise,
        flux_loss: WITHIN * wide.flux_loss,
        viscous_cold: wide.viscous_cold.powf(WITHIN),
        viscous_hot: wide.viscous_hot.powf(WITHIN),
        viscous_scatter: 2.0 * WITHIN * wide.viscous_scatter,
        coulomb_nm: wide.coulomb_nm * coulomb,
        ..wide
    };
    Scenario { field: Field { temperature: Some(near), ..scenario.field }, ..scenario }
}
