//! The channels of a model, and the trace column of each.
//!
//! Each quantity of the drive is one channel, even if several parts use it. A difference of two
//! channels of the shaft needs no separate channel.

use bearing_watch::Angle;
use bearing_watch::model::{Channel, Name};
use bearing_watch::plan::{Layout, MAX_CHANNELS, RegressionLayout, RunTimeSample, ShaftLayout, Signal};

use super::identifiers::identifiers;
use crate::Error;
use crate::identify::Structure;
use crate::trace::{Channels, MotionTrace, ShaftChannels, Trace};

/// Largest number of bearing orders.
pub const MAX_ORDERS: usize = 32;

/// A column of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Output.
    Y,
    /// First input.
    U1,
    /// Second input.
    U2,
    /// Current of the shaft.
    Current,
    /// Velocity.
    Velocity,
    /// Load torque.
    Load,
    /// A further column, by its place.
    Further(u8),
}

impl Field {
    /// The values; empty if the trace has no shaft.
    #[must_use]
    pub fn of(self, trace: &Trace) -> &[f64] {
        let motion = |pick: fn(&MotionTrace) -> &Vec<f64>| trace.motion.as_ref().map_or(&[][..], |motion| pick(motion));
        match self {
            Self::Y => &trace.y,
            Self::U1 => &trace.u1,
            Self::U2 => &trace.u2,
            Self::Current => motion(|m| &m.current_a),
            Self::Velocity => motion(|m| &m.velocity_rad_s),
            Self::Load => motion(|m| &m.load_nm),
            Self::Further(place) => trace.further.get(place as usize).map_or(&[], Vec::as_slice),
        }
    }
}

/// The column of a trace that is recorded as this field.
#[must_use]
pub fn column(field: Field, recorded: &Channels) -> Option<&str> {
    let of_shaft = |pick: fn(&ShaftChannels) -> Option<&String>| recorded.shaft.as_ref().and_then(pick);
    let name = match field {
        Field::Y => Some(&recorded.y),
        Field::U1 => Some(&recorded.u1),
        Field::U2 => Some(&recorded.u2),
        Field::Current => of_shaft(|shaft| Some(&shaft.current)),
        Field::Velocity => of_shaft(|shaft| shaft.velocity.as_ref()),
        Field::Load => of_shaft(|shaft| shaft.load.as_ref()),
        Field::Further(place) => recorded.further.get(usize::from(place)),
    };
    name.map(String::as_str)
}

/// The channels of a model with their columns, and the signals computed from them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wiring {
    /// Name and column of each channel.
    pub channels: Vec<(String, Field)>,
    /// The signals of the regression: y, u1, u2.
    pub signals: [Signal; 3],
    /// The signals of the shaft.
    pub shaft: Option<ShaftSignals>,
}

/// The signals of the shaft; `None` for what has no channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShaftSignals {
    /// Current.
    pub current: Signal,
    /// Velocity.
    pub velocity: Option<Signal>,
    /// Load torque.
    pub load: Option<Signal>,
}

/// What of a watched shaft has a channel, beside the current.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Measured {
    /// The velocity; otherwise it is taken from the angle.
    pub velocity: bool,
    /// The load torque.
    pub load: bool,
}

impl Wiring {
    /// The wiring of these columns. `watched` is `None` if the shaft is not watched.
    #[must_use]
    pub fn new(columns: &Channels, structure: Structure, watched: Option<Measured>) -> Self {
        let mut wiring = Self { channels: vec![], signals: [Signal::channel(0); 3], shaft: None };
        let rig = ShaftChannels::rig();
        let shaft = columns.shaft.as_ref().unwrap_or(&rig);
        if let Some(Measured { velocity, load }) = watched {
            let current = wiring.channel(&shaft.current, Field::Current);
            let mut other = |measured: bool, name: &Option<String>, usual: &str, field| {
                measured.then(|| wiring.channel(name.as_deref().unwrap_or(usual), field))
            };
            let velocity = other(velocity, &shaft.velocity, "velocity", Field::Velocity);
            let load = other(load, &shaft.load, "load", Field::Load);
            wiring.shaft = Some(ShaftSignals { current, velocity, load });
        }
        wiring.signals[0] = wiring.signal(&columns.y, Field::Y);
        if structure.nb > 0 {
            wiring.signals[1] = wiring.signal(&columns.u1, Field::U1);
        }
        if structure.nc > 0 {
            wiring.signals[2] = wiring.signal(&columns.u2, Field::U2);
        }
        for (name, place) in columns.further.iter().zip(0_u8..) {
            wiring.channel(name, Field::Further(place));
        }
        wiring
    }

    /// The wiring of only the shaft of another wiring.
    #[must_use]
    pub fn of_shaft(mut self, other: &Self) -> Self {
        let mut add = |signal: Signal| {
            let (name, field) = &other.channels[signal.channel as usize];
            self.channel(name, *field)
        };
        self.shaft = other.shaft.map(|ShaftSignals { current, velocity, load }| ShaftSignals {
            current: add(current),
            velocity: velocity.map(&mut add),
            load: load.map(&mut add),
        });
        self
    }

    /// The channel with this name; it is added if it does not exist.
    fn channel(&mut self, name: &str, field: Field) -> Signal {
        let found = self.channels.iter().position(|(own, _)| own == name);
        let place = found.unwrap_or_else(|| {
            self.channels.push((name.to_string(), field));
            self.channels.len() - 1
        });
        Signal::channel(place as u8)
    }

    /// Same as [`Wiring::channel`], but a difference of two existing channels needs no new channel.
    fn signal(&mut self, name: &str, field: Field) -> Signal {
        let of = |part: &str| self.channels.iter().position(|(own, _)| own == part.trim());
        let parts = name.match_indices('-').filter_map(|(at, _)| Some((of(&name[..at])?, of(&name[at + 1..])?)));
        match parts.collect::<Vec<_>>()[..] {
            [(plus, minus)] => Signal::channel(plus as u8).minus(Signal::channel(minus as u8)),
            _ => self.channel(name, field),
        }
    }

    /// The channels for the core. The limit of each signal's values is `limit` times its largest magnitude in training.
    ///
    /// # Errors
    /// More channels than a detector can have.
    pub(crate) fn core_channels<'a>(
        &self,
        traces: impl Iterator<Item = &'a Trace> + Clone,
        limit: f64,
    ) -> Result<Vec<Channel>, Error> {
        if self.channels.len() > MAX_CHANNELS {
            let count = self.channels.len();
            return Err(Error::Usage(format!("{count} channels are more than the {MAX_CHANNELS} of a detector")));
        }
        let each = |((_, field), text): (&(String, Field), String)| {
            let values = traces.clone().flat_map(|trace| field.of(trace));
            let largest = values.fold(0.0_f64, |most, x| most.max(x.abs()));
            let limit = if largest > 0.0 { (limit * largest) as f32 } else { 1.0 };
            let name = Name::new(&text).unwrap_or(Name::EMPTY);
            let unit = Name::new(unit(&text)).unwrap_or(Name::EMPTY);
            Ok(Channel { name, unit, limit, saturation: limit, stuck_samples: 0 })
        };
        let names = identifiers(self.channels.iter().map(|(name, _)| name.as_str()));
        self.channels.iter().zip(names).map(each).collect()
    }
}

/// The columns of a model's channels, derived from the signals that use them.
///
/// # Errors
/// A layout with a difference of channels that nothing else uses: their columns are not known.
pub fn fields(layout: &Layout) -> Result<Vec<Field>, String> {
    let mut fields = vec![None; layout.channels as usize];
    let mut set = |signal: Signal, field: Field| {
        if let (None, Some(cell)) = (signal.minus, fields.get_mut(signal.channel as usize)) {
            cell.get_or_insert(field);
        }
    };
    if let Some(ShaftLayout { current, velocity, load, .. }) = layout.shaft {
        set(current, Field::Current);
        velocity.into_iter().for_each(|velocity| set(velocity, Field::Velocity));
        load.measured().into_iter().for_each(|load| set(load, Field::Load));
    }
    if let Some(RegressionLayout { structure, y, u1, u2, .. }) = layout.regression {
        set(y, Field::Y);
        (structure.nb > 0).then(|| set(u1, Field::U1));
        (structure.nc > 0).then(|| set(u2, Field::U2));
    }
    // Averages of channels that no other part uses, in the order of the columns.
    let mut further = (0_u8..).map(Field::Further);
    for (place, cell) in fields.iter_mut().enumerate() {
        if cell.is_none() && (layout.averaged >> place) & 1 == 1 {
            *cell = further.next();
        }
    }
    let all: Option<Vec<Field>> = fields.into_iter().collect();
    all.ok_or_else(|| "the model takes a difference of channels that no other part uses".into())
}

/// The samples of a trace for the core, one at a time in the same buffer.
#[derive(Debug)]
pub struct Feed<'a> {
    columns: Vec<&'a [f64]>,
    motion: Option<&'a MotionTrace>,
    needs_angle: bool,
    sample: RunTimeSample,
}

impl<'a> Feed<'a> {
    /// Builds it from the columns of a model's channels; whether its plan needs the angle.
    #[must_use]
    pub fn new(trace: &'a Trace, fields: &[Field], needs_angle: bool) -> Self {
        let columns: Vec<&[f64]> = fields.iter().map(|field| field.of(trace)).collect();
        let sample = RunTimeSample { values: vec![0.0; columns.len()], angle: Angle::ZERO };
        Self { columns, motion: trace.motion.as_ref(), needs_angle, sample }
    }

    /// Sample `k`; zeros if the trace has no shaft. A missing value is NaN. An angle has no NaN: where it is missing,
    /// it is the last known one, and all values are missing if the plan needs it.
    pub fn at(&mut self, k: usize) -> &RunTimeSample {
        for (value, column) in self.sample.values.iter_mut().zip(&self.columns) {
            *value = column.get(k).map_or(0.0, |x| *x as f32);
        }
        if let Some(motion) = self.motion {
            if motion.angle_rad[k].is_finite() {
                self.sample.angle = motion.angle(k);
            } else if self.needs_angle {
                self.sample.values.fill(f32::NAN);
            }
        }
        &self.sample
    }
}

impl MotionTrace {
    /// The angle of one sample in the core's format.
    #[must_use]
    pub fn angle(&self, k: usize) -> Angle {
        // The fraction of a turn is computed in double precision: for many turns, single precision has too few digits.
        let turns = self.angle_rad[k] / std::f64::consts::TAU;
        Angle::from_bits(((turns - turns.floor()) * 4_294_967_296.0) as u64 as u32)
    }
}

/// The unit according to the suffix of a name.
fn unit(name: &str) -> &'static str {
    const UNITS: [(&str, &str); 13] = [
        ("_rad_s", "rad/s"),
        ("_mm_s", "mm/s"),
        ("_m_s", "m/s"),
        ("_nm", "N·m"),
        ("_rad", "rad"),
        ("_rpm", "rpm"),
        ("_kgf", "kgf"),
        ("_mm", "mm"),
        ("_a", "A"),
        ("_c", "°C"),
        ("_v", "V"),
        ("_n", "N"),
        ("_m", "m"),
    ];
    let name = name.to_lowercase();
    UNITS.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, unit)| unit)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Measured = Measured { velocity: true, load: true };

    #[test]
    fn each_quantity_is_one_channel() {
        let mut columns = Channels::new("current_a", "velocity_ref_rad_s-velocity_rad_s", "load_torque_nm");
        columns.shaft = Some(ShaftChannels::rig());
        let wiring = Wiring::new(&columns, Structure::new(2, 1, 2, 1, 1), Some(ALL));
        let names: Vec<&str> = wiring.channels.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["current_a", "velocity_rad_s", "load_torque_nm", "velocity_ref_rad_s-velocity_rad_s"]);
        assert_eq!(wiring.signals.map(|signal| signal.channel), [0, 3, 2]);
        let of_angle = Wiring::new(&columns, Structure::new(2, 1, 2, 1, 1), Some(Measured { velocity: false, ..ALL }));
        let names: Vec<&str> = of_angle.channels.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["current_a", "load_torque_nm", "velocity_ref_rad_s-velocity_rad_s"]);
    }

    #[test]
    fn without_a_shaft_a_difference_is_a_channel() {
        let columns = Channels::new("i", "ref-v", "load");
        let wiring = Wiring::new(&columns, Structure::new(2, 1, 0, 1, 1), None);
        assert_eq!(wiring.channels, [("i".into(), Field::Y), ("ref-v".into(), Field::U1)]);
        let trace = Trace { y: vec![1.0], u1: vec![-3.0], u2: vec![9.0], ..Trace::default() };
        let channels = wiring.core_channels([&trace].into_iter(), 10.0).expect("short names");
        assert_eq!((channels[1].name.as_str(), channels[1].limit), ("ref_v", 30.0));
    }

    #[test]
    fn a_missing_sample_is_nan_and_holds_the_angle() {
        let column = |lost: f64| vec![1.0, lost, 3.0];
        let motion = MotionTrace {
            current_a: column(f64::NAN),
            velocity_rad_s: column(f64::NAN),
            load_nm: column(f64::NAN),
            angle_rad: column(f64::NAN),
            reference_rad_s: vec![],
        };
        let trace = Trace { motion: Some(motion.clone()), ..Trace::default() };
        let mut feed = Feed::new(&trace, &[Field::Current, Field::Velocity, Field::Load], true);
        for (k, angle) in [motion.angle(0), motion.angle(0), motion.angle(2)].into_iter().enumerate() {
            let sample = feed.at(k);
            assert!(sample.values.iter().all(|x| x.is_nan() == (k == 1)), "{k}");
            assert_eq!(sample.angle, angle);
        }
        // A missing angle matters to a plan that needs it.
        let measured = MotionTrace { current_a: column(2.0), ..motion };
        let trace = Trace { motion: Some(measured), ..Trace::default() };
        for needs_angle in [false, true] {
            let mut feed = Feed::new(&trace, &[Field::Current], needs_angle);
            let missing = [0, 1, 2].map(|k| feed.at(k).values[0].is_nan());
            assert_eq!(missing, [false, needs_angle, false]);
        }
    }

    #[test]
    fn units_by_suffix() {
        assert_eq!(["current_a", "velocity_ref_rad_s", "load_torque_nm", "x"].map(unit), ["A", "rad/s", "N·m", ""]);
    }
}
