//! Records of the actuator: as the firmware of its drive sees them, and as the source's recordings were prepared.
//!
//! ```text
//! phase currents ─► converter counts ─┐
//! resolver counts ────────────────────┼─► the core's front end, by 12 or 10 ─► 1 kHz                [`cleaned`]
//! command, load torque ───────────────┘
//! q current, position, force, angle, logged ─► filter, every n-th row                               [`thinned`]
//! ```

use bearing_watch::drive::{
    BalanceLimits, By, CleanSample, Factor, FrontEnd, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample,
    ResolverLimits, RotorFrame, TrackingConstants,
};
use bearing_watch::{Angle, Park};

use model::Error;
use model::trace::prepare::decimate;
use model::trace::{MotionTrace, Trace};
use rig::ema::{EmaScenario, EmaTrace};

/// Counts of the current converters at zero current: 12 bits.
const ZERO_COUNTS: f64 = 2048.0;
/// Amperes per count: 12 bits over 1.28 times the current limit of the drive.
const AMPERES_PER_COUNT: f64 = 0.025;
/// Further channels of the front end: velocity command, load torque.
const FURTHER: usize = 2;

/// Signals at one rate.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Signals {
    /// Interval of the samples.
    pub interval_s: f64,
    /// Quadrature current.
    pub current_a: Vec<f64>,
    /// Shaft velocity.
    pub velocity_rad_s: Vec<f64>,
    /// Shaft angle, wrapped or not.
    pub angle_rad: Vec<f64>,
    /// Command of the velocity.
    pub velocity_ref_rad_s: Vec<f64>,
    /// Load torque on the shaft.
    pub load_torque_nm: Vec<f64>,
}

impl Signals {
    fn push(&mut self, sample: &CleanSample<FURTHER>) {
        let CleanSample { current_a, velocity_rad_s, angle, further: [velocity_ref_rad_s, load_torque_nm], .. } =
            *sample;
        self.current_a.push(current_a.into());
        self.velocity_rad_s.push(velocity_rad_s.into());
        self.angle_rad.push(angle.radians().into());
        self.velocity_ref_rad_s.push(velocity_ref_rad_s.into());
        self.load_torque_nm.push(load_torque_nm.into());
    }

    /// The record for training and judging: y = current, u1 = velocity command, u2 = load torque, with the shaft.
    #[must_use]
    pub fn into_trace(self, id: String) -> Trace {
        let motion = MotionTrace {
            current_a: self.current_a.clone(),
            velocity_rad_s: self.velocity_rad_s,
            load_nm: self.load_torque_nm.clone(),
            angle_rad: self.angle_rad,
            reference_rad_s: self.velocity_ref_rad_s.clone(),
        };
        Trace {
            id,
            interval_s: Some(self.interval_s),
            y: self.current_a,
            u1: self.velocity_ref_rad_s,
            u2: self.load_torque_nm,
            motion: Some(motion),
            ..Trace::default()
        }
    }
}

/// The front end of the simulated drive.
#[must_use]
pub fn front_end(scenario: &EmaScenario) -> FrontEndConstants {
    let sensor =
        PhaseSensor { offset_counts: ZERO_COUNTS as f32, gain_a: AMPERES_PER_COUNT as f32, usable: [16, 4079] };
    FrontEndConstants {
        control_rate_hz: (1.0 / scenario.drive.interval_s) as f32,
        sensors: [sensor; 3],
        stuck_samples: 0,
        // The sum of three currents has √3 times the noise of one, and three offsets of at most 0.1 A.
        balance: BalanceLimits { noise_a: 0.8, offset_a: 1.6, gain_tolerance: 0.02, window: 400 },
        tracking: TrackingConstants {
            bandwidth_hz: 300.0,
            damping: 0.7,
            error_limit_rad: 0.1,
            lost_samples: 20,
            settle_samples: 20,
            resolver: ResolverLimits { low: 0.5, high: 1.5, mismatch: 0.1 },
        },
        frame: RotorFrame {
            pole_pairs: scenario.actuator.pole_pairs,
            electrical_offset: Angle::ZERO,
            park: Park::Standard,
        },
    }
}

/// A record at the control rate, with a value of its own in each row, through the core's front end. Samples before the
/// angle is found are left out.
///
/// # Errors
/// The front end refuses its constants, or a sample within the record is missing.
pub fn cleaned<const FACTOR: usize>(scenario: &EmaScenario, recorded: &EmaTrace) -> Result<Signals, Error>
where
    By<FACTOR>: Factor,
{
    let bits = scenario.sensors.resolver_bits;
    cleaned_at::<FACTOR>(scenario, recorded, |row| Angle::from_counts(recorded.resolver_counts[row], bits))
}

/// Same as [`cleaned`], with another angle for each row than that of the resolver.
///
/// # Errors
/// Same as [`cleaned`].
pub fn cleaned_at<const FACTOR: usize>(
    scenario: &EmaScenario,
    recorded: &EmaTrace,
    angle: impl Fn(usize) -> Angle,
) -> Result<Signals, Error>
where
    By<FACTOR>: Factor,
{
    let bad = |problem: String| Error::trace("simulated actuator", problem);
    let mut front_end = FrontEnd::<FURTHER, FACTOR>::new(&front_end(scenario)).map_err(|e| bad(e.to_string()))?;
    let mut clean = Signals { interval_s: FACTOR as f64 * scenario.drive.interval_s, ..Signals::default() };
    for row in 0..recorded.len() {
        let Some(sample) = front_end.push(&raw(recorded, row, angle(row))) else { continue };
        let complete = sample.current_a.is_finite() && sample.velocity_rad_s.is_finite();
        if complete {
            clean.push(&sample);
        } else if !clean.current_a.is_empty() {
            return Err(bad(format!("row {row} is missing behind the front end: {:?}", front_end.faults())));
        }
    }
    Ok(clean)
}

/// What the converters of the drive read in one row.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "`as` saturates, as a converter does")]
fn raw(recorded: &EmaTrace, row: usize, angle: Angle) -> RawSample<FURTHER> {
    let phases = [&recorded.phase_a_a, &recorded.phase_b_a, &recorded.phase_c_a];
    let counts = phases.map(|phase| (ZERO_COUNTS + phase[row] / AMPERES_PER_COUNT).round() as u16);
    RawSample {
        number: row as u32,
        currents: PhaseCounts::Three(counts),
        position: Position::Absolute(angle),
        further: [&recorded.velocity_ref_rad_s, &recorded.load_torque_nm].map(|column| column[row] as f32),
    }
}

/// A logged record with every `factor`-th row behind an anti-alias filter, the angle as it was unwrapped.
#[must_use]
pub fn thinned(scenario: &EmaScenario, recorded: &EmaTrace, factor: usize) -> Signals {
    let each = |column: &[f64]| decimate(column, factor);
    Signals {
        interval_s: factor as f64 * scenario.row_interval_s(),
        current_a: each(&recorded.current_a),
        velocity_rad_s: each(&recorded.velocity_rad_s),
        angle_rad: each(&recorded.angle_rad),
        velocity_ref_rad_s: each(&recorded.velocity_ref_rad_s),
        load_torque_nm: each(&recorded.load_torque_nm),
    }
}
