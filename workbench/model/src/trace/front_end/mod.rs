//! The front end of a drive over recordings at the control rate: the same code as in firmware.
//!
//! A file in TOML describes it:
//!
//! ```toml
//! control_rate_hz = 12000.0
//! factor = 12                                          # 12 kHz → 1 kHz
//!
//! [currents]
//! columns = ["phase_a_a", "phase_b_a", "phase_c_a"]    # a, b and c; of two, `phases` says which
//! quantity = "amperes"                                 # or "counts"; or "quadrature", of the drive's own control
//! offset_counts = [2048.0, 2048.0, 2048.0]
//! gain_a = [0.02, 0.02, 0.02]                          # amperes a count
//! usable_counts = [16, 4079]
//! stuck_samples = 0
//!
//! [balance]
//! noise_counts = 5.0                                   # of the sum of the currents; or noise_a
//! offset_counts = 25.0                                 # the largest that is removed; or offset_a; or twice the noise
//! gain_tolerance = 0.02
//! window = 400
//!
//! [position]
//! counts = "resolver_counts"                           # or sin and cos; or angle_rad
//! bits = 14                                            # or counts_per_turn = 8000
//! reversed = false                                     # true if it counts against the order of the phases
//!
//! [tracking]
//! bandwidth_hz = 300.0
//! damping = 0.7
//! error_limit_rad = 0.1
//! lost_samples = 20
//! settle_samples = 20
//!
//! [motor]
//! pole_pairs = 6
//! electrical_offset_rad = 0.0
//! park = "standard"                                    # or "thesis"
//! ```
//!
//! A trace behind it has the columns `current_a`, `velocity_rad_s` and `angle_rad`, which hide recorded columns of
//! these names, and every other recorded column, decimated by the same filters. Currents recorded in amperes are
//! rounded to counts first, as the converter of the drive does.

mod balance;
mod refused;

use std::f64::consts::TAU;
use std::path::Path;

use bearing_watch::drive::{FrontEndConstants, PhaseSensor, Position, ResolverLimits, RotorFrame, TrackingConstants};
use bearing_watch::{Angle, EncoderCounts, Park};
use serde::{Deserialize, Serialize};

use crate::Error;
pub use balance::PhaseBalance;
pub use refused::{Refused, words};

/// The factors for which the core has filters.
pub const FACTORS: [usize; 13] = [1, 2, 4, 8, 16, 32, 6, 12, 24, 48, 10, 20, 40];

/// A front end, and the recorded columns that it reads.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrontEndFile {
    /// Rate of the recorded rows, Hz.
    pub control_rate_hz: f32,
    /// Recorded rows per sample: one of [`FACTORS`].
    pub factor: usize,
    /// The current sensors.
    pub currents: Currents,
    /// What the sum of three currents must be; not for a quadrature current.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub balance: Option<PhaseBalance>,
    /// The position sensor.
    pub position: Columns,
    /// The loop that follows the angle.
    pub tracking: Tracking,
    /// The motor.
    pub motor: Motor,
}

/// The current sensors, phases a, b and c.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Currents {
    /// The columns of two or three phases.
    pub columns: Vec<String>,
    /// Which phases two columns are, in their order; of three they are a, b and c.
    #[serde(default, skip_serializing_if = "Phases::is_usual")]
    pub phases: Phases,
    /// What the columns contain.
    #[serde(default)]
    pub quantity: Quantity,
    /// Counts at no current, of each column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub offset_counts: Vec<f32>,
    /// Amperes a count, of each column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gain_a: Vec<f32>,
    /// Lowest and highest usable count.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub usable_counts: Option<[u16; 2]>,
    /// Equal counts in a row that mean a stuck converter; 0 for no limit.
    #[serde(default)]
    pub stuck_samples: u16,
}

/// Two phases with a sensor each. The core numbers them from the first one on: with b and c, the third is a.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[expect(missing_docs, reason = "the names say all")]
pub enum Phases {
    #[default]
    Ab,
    Bc,
    Ca,
}

impl Phases {
    /// Whether the first column is phase a.
    #[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
    fn is_usual(&self) -> bool {
        *self == Self::Ab
    }

    /// The electrical angle of the first phase, in thirds of a turn.
    fn thirds(self) -> f64 {
        match self {
            Self::Ab => 0.0,
            Self::Bc => 1.0,
            Self::Ca => 2.0,
        }
    }

    /// The names of the phases that have a column.
    #[must_use]
    pub const fn names(self) -> [&'static str; 2] {
        match self {
            Self::Ab => ["a", "b"],
            Self::Bc => ["b", "c"],
            Self::Ca => ["c", "a"],
        }
    }
}

/// What the columns of the currents contain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Quantity {
    /// Counts of the converter.
    #[default]
    Counts,
    /// Amperes.
    Amperes,
    /// One column, the quadrature current in A that the control of the drive makes itself.
    Quadrature,
}

/// The columns of the position sensor: counts with those of a turn, sine and cosine, or an angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, untagged)]
pub enum Columns {
    /// Counts, of 2^bits or of any number a turn.
    Counts {
        /// Column.
        counts: String,
        /// 1 … 32.
        #[serde(skip_serializing_if = "Option::is_none")]
        bits: Option<u32>,
        /// Of an encoder: four times its lines.
        #[serde(skip_serializing_if = "Option::is_none")]
        counts_per_turn: Option<u32>,
        /// Whether it counts against the order of the phases.
        #[serde(default, skip_serializing_if = "is_false")]
        reversed: bool,
    },
    /// Demodulated signals of a resolver; one that turns against the order of the phases has its sine negated.
    Resolver {
        /// Column of amplitude times sine.
        sin: String,
        /// Column of amplitude times cosine.
        cos: String,
        /// Lowest and highest amplitude.
        amplitude: [f32; 2],
        /// Largest relative difference of the amplitudes.
        mismatch: f32,
    },
    /// An angle in radians, wrapped or not.
    Angle {
        /// Column.
        angle_rad: String,
        /// Whether it grows against the order of the phases.
        #[serde(default, skip_serializing_if = "is_false")]
        reversed: bool,
    },
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "as serde calls it")]
fn is_false(value: &bool) -> bool {
    !value
}

/// What a position sensor counts in a turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// 2^bits.
    Bits(u32),
    /// Any number.
    Counts(u32, EncoderCounts),
}

impl Turn {
    /// The angle of so many counts.
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "counts wrap around")]
    fn angle(self, counts: f64) -> Angle {
        let counts = counts.round() as i64;
        match self {
            Self::Bits(bits) => Angle::from_counts(counts as u32, bits),
            Self::Counts(turn, encoder) => encoder.angle(counts.rem_euclid(i64::from(turn)) as i32),
        }
    }
}

impl Columns {
    /// What the sensor counts in a turn.
    ///
    /// # Errors
    /// Neither or both of `bits` and `counts_per_turn`, or one that is out of range.
    pub fn turn(&self) -> Result<Option<Turn>, String> {
        let Self::Counts { bits, counts_per_turn, .. } = self else { return Ok(None) };
        let turn = match (*bits, *counts_per_turn) {
            (Some(bits @ 1..=32), None) => Turn::Bits(bits),
            (Some(bits), None) => return Err(format!("[position] bits {bits}: a turn has 2^1 to 2^32 counts")),
            (None, Some(turn)) => {
                let most = EncoderCounts::MOST;
                let encoder = EncoderCounts::new(turn)
                    .ok_or_else(|| format!("[position] counts_per_turn {turn}: a turn has 1 to {most} counts"))?;
                Turn::Counts(turn, encoder)
            }
            (None, None) | (Some(_), Some(_)) => {
                return Err("[position] counts come with bits, or with counts_per_turn".into());
            }
        };
        Ok(Some(turn))
    }

    /// The reading of a row, from its values of the columns in their order.
    #[expect(clippy::cast_possible_truncation, reason = "signals are single")]
    #[must_use]
    pub fn reading(&self, values: [f64; 2]) -> Position {
        let [first, second] = values;
        let (angle, reversed) = match self {
            Self::Resolver { .. } => return Position::Resolver { sin: first as f32, cos: second as f32 },
            Self::Counts { .. } | Self::Angle { .. } if !first.is_finite() => return Position::Missing,
            Self::Counts { reversed, .. } => match self.turn() {
                Ok(Some(turn)) => (turn.angle(first), *reversed),
                Ok(None) | Err(_) => return Position::Missing,
            },
            Self::Angle { reversed, .. } => (angle_of(first), *reversed),
        };
        Position::Absolute(if reversed { angle.negated() } else { angle })
    }
}

/// [`TrackingConstants`] without those of the resolver.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tracking {
    bandwidth_hz: f32,
    damping: f32,
    error_limit_rad: f32,
    lost_samples: u16,
    settle_samples: u16,
}

/// [`RotorFrame`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motor {
    pole_pairs: u32,
    #[serde(default)]
    electrical_offset_rad: f64,
    park: Convention,
}

/// [`Park`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Convention {
    Standard,
    Thesis,
}

impl FrontEndFile {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// An unreadable file, a missing or unknown key, a value out of range.
    pub fn read(path: &Path) -> Result<Self, Error> {
        let text = std::fs::read_to_string(path).map_err(Error::io(path))?;
        Self::parse(&text).map_err(|(place, problem)| Error::content(path, place, problem))
    }

    /// Parses and checks the text of a file.
    ///
    /// # Errors
    /// The place and the problem of a text that is refused.
    pub fn parse(text: &str) -> Result<Self, (String, String)> {
        let own: Self = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            (format!("line {}", before.matches('\n').count() + 1), one_line(error.message()))
        })?;
        own.check().map_err(|problem| ("values".into(), problem))?;
        Ok(own)
    }

    fn check(&self) -> Result<(), String> {
        let Currents { columns, offset_counts, gain_a, usable_counts, quantity, .. } = &self.currents;
        let phases = columns.len();
        if *quantity == Quantity::Quadrature {
            let other = [offset_counts, gain_a].iter().any(|list| !list.is_empty()) || usable_counts.is_some();
            if phases != 1 || other || self.balance.is_some() {
                return Err("a quadrature current is one column, without counts, gains and [balance]".into());
            }
        } else if !(2..=3).contains(&phases) || offset_counts.len() != phases || gain_a.len() != phases {
            return Err("[currents] has two or three columns, and as many offset_counts and gain_a".into());
        } else if usable_counts.is_none() || self.balance.is_none() {
            return Err("currents of phases need usable_counts, and the section [balance]".into());
        }
        if !FACTORS.contains(&self.factor) {
            let factors: Vec<String> = FACTORS.iter().map(ToString::to_string).collect();
            return Err(format!("factor {}: there are filters for {}", self.factor, factors.join(", ")));
        }
        if phases == 3 && self.currents.phases != Phases::Ab {
            return Err("[currents] phases is for two columns; three are a, b and c".into());
        }
        self.balance.map_or(Ok(()), PhaseBalance::check)?;
        self.position.turn()?;
        if !self.motor.electrical_offset_rad.is_finite() {
            return Err("[motor] electrical_offset_rad is not a number".into());
        }
        self.constants().check().map_err(|error| error.message().into())
    }

    /// The text of a file that [`FrontEndFile::read`] reads.
    ///
    /// # Errors
    /// None for values that were read here; those of the serialiser otherwise.
    pub fn to_text(&self) -> Result<String, toml::ser::Error> {
        Ok(format!("# The front end of these traces, for --front-end.\n{}", toml::to_string(self)?))
    }

    /// The recorded columns that the front end reads, phases first.
    pub fn columns(&self) -> Vec<&str> {
        let mut columns: Vec<&str> = self.currents.columns.iter().map(String::as_str).collect();
        match &self.position {
            Columns::Counts { counts, .. } => columns.push(counts),
            Columns::Resolver { sin, cos, .. } => columns.extend([sin.as_str(), cos.as_str()]),
            Columns::Angle { angle_rad, .. } => columns.push(angle_rad),
        }
        columns
    }

    /// The constants of the core's front end.
    #[must_use]
    pub fn constants(&self) -> FrontEndConstants {
        let Currents { offset_counts, gain_a, usable_counts, stuck_samples, .. } = &self.currents;
        let usable = usable_counts.unwrap_or([0, u16::MAX]);
        // Of two sensors the third is not used, and of a quadrature current none.
        let phase = |k: usize| {
            let of = |list: &[f32]| list.get(k).or(list.last()).copied().unwrap_or(1.0);
            PhaseSensor { offset_counts: of(offset_counts), gain_a: of(gain_a), usable }
        };
        let Tracking { bandwidth_hz, damping, error_limit_rad, lost_samples, settle_samples } = self.tracking;
        let resolver = match self.position {
            Columns::Resolver { amplitude: [low, high], mismatch, .. } => ResolverLimits { low, high, mismatch },
            Columns::Counts { .. } | Columns::Angle { .. } => ResolverLimits { low: 0.5, high: 1.5, mismatch: 0.1 },
        };
        FrontEndConstants {
            control_rate_hz: self.control_rate_hz,
            sensors: [phase(0), phase(1), phase(2)],
            stuck_samples: *stuck_samples,
            balance: self.balance.map_or(PhaseBalance::UNUSED, |balance| balance.limits(gain_a)),
            tracking: TrackingConstants {
                bandwidth_hz,
                damping,
                error_limit_rad,
                lost_samples,
                settle_samples,
                resolver,
            },
            frame: RotorFrame {
                pole_pairs: self.motor.pole_pairs,
                // From the first of the phases on.
                electrical_offset: angle_of(
                    self.motor.electrical_offset_rad - self.currents.phases.thirds() * TAU / 3.0,
                ),
                park: self.park(),
            },
        }
    }

    /// The sign convention of the quadrature current.
    #[must_use]
    pub const fn park(&self) -> Park {
        match self.motor.park {
            Convention::Standard => Park::Standard,
            Convention::Thesis => Park::Thesis,
        }
    }

    /// Interval of the samples, s.
    #[must_use]
    pub fn interval_s(&self) -> f64 {
        self.factor as f64 / f64::from(self.control_rate_hz)
    }
}

/// The binary angle of an angle in radians; that of one that is not finite is zero.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a part of a turn below one; `as` saturates"
)]
#[must_use]
pub fn angle_of(radians: f64) -> Angle {
    let turns = radians / TAU;
    Angle::from_bits(((turns - turns.floor()) * 4_294_967_296.0) as u64 as u32)
}

/// A message of several lines as one.
fn one_line(message: &str) -> String {
    message.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ")
}
