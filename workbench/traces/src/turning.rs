//! The units of angle and velocity of a shaft: by the names of the columns, and where these tell none, by the values.
//!
//! | what tells the unit | example |
//! |---|---|
//! | the name | `theta_deg`, `Drehzahl in 1/min` |
//! | the value at which an angle begins anew | 6.283: rad; 360: degrees; 1: turns; 4096 of whole numbers: counts |
//! | the angle's slope over a velocity in a known unit | 0.159 over rad/s: turns |
//!
//! What nothing tells is a question: a channel with a question mark, which training refuses. Electrical angles and
//! speeds, known by `_e`, `elec`, `erpm`, ask for the pole pairs, unless a mechanical signal beside them tells these.

use std::f64::consts::TAU;

use crate::signal::{Role, Signal};
use crate::units::{Quantity, Unit};
use model::audit::scale::{are_whole, slope_by_velocity, wraps_at};
use model::outputs::trimmed;
use model::trace::words;

/// Words of names of electrical angles and speeds.
const ELECTRICAL: [&str; 9] =
    ["e", "el", "elec", "electric", "electrical", "elektrisch", "elektr", "erpm", "électrique"];
/// Units that are tried where values tell one.
const ANGLES: [&str; 5] = ["rad", "turn", "deg", "0.1 deg", "0.01 deg"];
const VELOCITIES: [&str; 6] = ["rad/s", "rpm", "turn/s", "deg/s", "0.1 rpm", "krpm"];
/// Difference of a ratio from the one of two units.
const NEAR: f64 = 0.01;
/// Largest number of pole pairs, and least range of values that are counts.
const MOST_PAIRS: f64 = 64.0;
const COUNTS: f64 = 50.0;
/// Difference of the ratio from 1 from which on it is named.
const OFF: f64 = 0.05;

/// A column of an angle or a velocity.
#[derive(Clone, Copy)]
pub(crate) struct Column<'a> {
    pub(crate) name: &'a str,
    pub(crate) values: &'a [f64],
}

/// The channel that a column becomes.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Channel {
    /// The column with its unit, such as `position[turn]`, `position[?]`.
    pub(crate) text: String,
    /// What tells the unit, or what is asked; `None` if the name tells it.
    pub(crate) said: Option<String>,
    /// The text with an answer in the place of each question: the unit that the other signal tells, or the base unit,
    /// and one pole pair.
    pub(crate) answer: String,
    kind: Kind,
}

impl Channel {
    /// Whether something is asked.
    pub(crate) fn is_question(&self) -> bool {
        self.text.contains('?')
    }

    /// The parts of the text that have a question mark, and the units that answer it; none if a number does.
    pub(crate) fn marks(&self) -> Vec<(String, &'static [&'static str])> {
        let units: &[&str] = if self.kind == Kind::Angle { &ANGLES[..3] } else { &VELOCITIES[..4] };
        let start = self.text.find("unwrap(").map_or(0, |at| at + "unwrap(".len());
        let start = if self.text[start..].starts_with('(') { start + 1 } else { start };
        let end = self.text.find(']').map_or(self.text.len(), |at| at + 1);
        let (column, divisor) = (&self.text[start..end], &self.text[end..]);
        let is_count = column.ends_with("[turn/?]");
        let column = column.contains('?').then(|| (column.to_string(), if is_count { &[][..] } else { units }));
        column.into_iter().chain(divisor.contains('?').then(|| (divisor.to_string(), &[][..]))).collect()
    }

    /// With an answer: one is so many base units by the other signal, if that is known, which is then said.
    fn answered(self, unit: Option<f64>, is_told: bool) -> Self {
        let base = if self.kind == Kind::Angle { "rad" } else { "rad/s" };
        let unit = unit.map(f64::abs).filter(|unit| unit.is_finite() && *unit > 0.0);
        let answer = unit.map_or_else(|| base.to_string(), |unit| format!("{unit:.4e} {base}"));
        let by_other = unit.filter(|_| is_told && self.is_question());
        let said = self.said.map(|said| match by_other {
            Some(unit) if (1e-3..1e4).contains(&unit) => {
                let digits = (2.0 - unit.log10().floor()).max(0.0) as usize;
                format!("{said} One is {} {base} by the other signal.", trimmed(unit, digits))
            }
            Some(unit) => format!("{said} One is {unit:.2e} {base} by the other signal."),
            None => said,
        });
        let answer = format!("[{answer}]");
        let answer = self.text.replace("[turn/?]", &answer).replace("[?]", &answer).replace("/?", "/1");
        Self { said, answer, ..self }
    }

    /// The values of the column in rad or rad/s; where the unit is a question, by its answer.
    pub(crate) fn values(&self, column: &Column<'_>) -> Vec<f64> {
        let role = if self.kind == Kind::Angle { Role::Angle } else { Role::Velocity };
        let text = &self.answer;
        let names = [column.name.to_string()];
        let signal = Signal::of_role(text, &names, role).or_else(|_| Signal::parse(column.name, &names));
        let rows = column.values.len();
        signal
            .map_or_else(|_| column.values.to_vec(), |signal| signal.values(rows, &|_| column.values, &|_, _| f64::NAN))
    }
}

/// Angle and velocity, and how they contradict each other.
#[derive(Debug, Default)]
pub(crate) struct Turning {
    pub(crate) angle: Option<Channel>,
    pub(crate) velocity: Option<Channel>,
    pub(crate) contradiction: Option<String>,
}

/// What is known of the unit of a column.
#[derive(Clone, Debug)]
struct Known {
    /// As it is written in brackets.
    unit: String,
    /// Base units in one of it.
    factor: f64,
    /// What tells it; empty if the name does.
    by: String,
}

impl Known {
    fn named(column: &Column<'_>, quantity: Quantity) -> Option<Self> {
        let unit = Unit::of_column(column.name).filter(|unit| unit.quantity == quantity);
        let unit = unit.or_else(|| of_erpm(column.name).filter(|_| quantity == Quantity::AngularVelocity))?;
        Some(Self { unit: unit.name().to_string(), factor: unit.to_base().0, by: String::new() })
    }

    fn found(unit: &str, by: String) -> Option<Self> {
        Some(Self { unit: unit.to_string(), factor: Unit::named(unit)?.to_base().0, by })
    }

    /// The unit of these whose factor is this one.
    fn of_factor(factor: f64, units: &[&str], by: &str) -> Option<Self> {
        let is_near =
            |unit: &&&str| Unit::named(unit).is_some_and(|unit| (factor.abs() / unit.to_base().0 - 1.0).abs() < NEAR);
        units.iter().find(is_near).and_then(|unit| Self::found(unit, by.to_string()))
    }
}

/// Revolutions a minute of an electrical angle.
fn of_erpm(name: &str) -> Option<Unit> {
    words(name).iter().any(|word| word == "erpm").then(|| Unit::named("rpm"))?
}

fn is_electrical(name: &str) -> bool {
    words(name).iter().any(|word| ELECTRICAL.contains(&word.as_str())) || name.contains("電気角")
}

impl Turning {
    /// Of columns of one recording with this rate.
    pub(crate) fn of(angle: Option<Column<'_>>, velocity: Option<Column<'_>>, rate_hz: Option<f64>) -> Self {
        let period = angle.and_then(|angle| wraps_at(angle.values));
        let ratio = || {
            let (angle, velocity) = (angle?, velocity?);
            slope_by_velocity(angle.values, velocity.values, rate_hz?, period)
        };
        let ratio = ratio();
        let mut of_angle =
            angle.and_then(|angle| Known::named(&angle, Quantity::Angle).or_else(|| by_wrap(&angle, period?)));
        let mut of_velocity = velocity.and_then(|velocity| Known::named(&velocity, Quantity::AngularVelocity));
        match (&of_angle, &of_velocity, ratio) {
            (Some(angle), None, Some(ratio)) => {
                of_velocity = Known::of_factor(ratio * angle.factor, &VELOCITIES, "by the slope of the angle");
            }
            (None, Some(velocity), Some(ratio)) => {
                let factor = velocity.factor / ratio;
                let counts = || angle.and_then(|angle| by_counts(&angle, TAU / factor, "by the velocity"));
                of_angle = Known::of_factor(factor, &ANGLES, "by its slope over the velocity").or_else(counts);
            }
            (None, None, Some(ratio)) => (of_angle, of_velocity) = by_both(ratio),
            _ => {}
        }
        // How many times as far the angle turns as the velocity says.
        let times = || Some(ratio? * of_angle.as_ref()?.factor / of_velocity.as_ref()?.factor);
        let times = times();
        let electrical = [angle, velocity].map(|column| column.is_some_and(|column| is_electrical(column.name)));
        let pairs = pole_pairs(times, electrical);
        let contradiction = times.filter(|times| (times - 1.0).abs() > OFF && pairs.is_none()).map(contradiction);
        // Base units in one of an unknown unit, by the other signal.
        let units = match (&of_angle, &of_velocity, ratio) {
            (Some(angle), None, Some(ratio)) => [None, Some(ratio * angle.factor)],
            (None, Some(velocity), Some(ratio)) => [Some(velocity.factor / ratio), None],
            (None, None, Some(ratio)) => [Some(1.0 / ratio), None],
            _ => [None, None],
        };
        // Of an electrical signal the pole pairs are in the factor.
        let is_told = of_angle.is_some() != of_velocity.is_some() && electrical == [false; 2];
        let wrong_turn = of_angle.as_ref().zip(period).and_then(|(known, period)| wrong_turn(known, period));
        Self {
            angle: angle.map(|column| {
                Kind::Angle.channel(&column, of_angle, (electrical[0], pairs)).answered(units[0], is_told)
            }),
            velocity: velocity.map(|column| {
                Kind::Velocity.channel(&column, of_velocity, (electrical[1], pairs)).answered(units[1], is_told)
            }),
            contradiction: wrong_turn.or(contradiction),
        }
    }

    /// What is asked, found, or contradicts, in sentences.
    pub(crate) fn told(&self) -> Vec<String> {
        let of = |channel: &Option<Channel>| channel.as_ref().and_then(|channel| channel.said.clone());
        [of(&self.angle), of(&self.velocity), self.contradiction.clone()].into_iter().flatten().collect()
    }
}

/// The unit of an angle by the value at which it begins anew.
fn by_wrap(column: &Column<'_>, period: f64) -> Option<Known> {
    let by = format!("it begins anew at {period:.4}");
    Known::of_factor(TAU / period, &ANGLES, &by).or_else(|| by_counts(column, period, &by))
}

/// Counts, so many a turn: a power of two, or a round number, of whole values.
fn by_counts(column: &Column<'_>, turn: f64, by: &str) -> Option<Known> {
    if !is_counts(column.values) {
        return None;
    }
    let turn = turn.abs();
    let is_near = |counts: &f64| (counts / turn - 1.0).abs() < NEAR && *counts >= 16.0;
    let round = |unit: f64| (turn / unit).round() * unit;
    let counts = [turn.log2().round().exp2(), round(1000.0), round(500.0), round(360.0), round(100.0)];
    let counts = counts.into_iter().find(is_near)?;
    Known::found(&format!("turn/{counts}"), format!("{counts} counts a turn {by}"))
}

fn is_counts(values: &[f64]) -> bool {
    let fold = |(low, high): (f64, f64), x: &f64| (low.min(*x), high.max(*x));
    let known = || values.iter().filter(|x| x.is_finite());
    let (low, high) = known().fold((f64::INFINITY, f64::NEG_INFINITY), fold);
    high - low > COUNTS && known().all(|x| x.fract() == 0.0)
}

/// The units of both by their ratio alone, if only one pair has it.
fn by_both(ratio: f64) -> (Option<Known>, Option<Known>) {
    let by = "by the slope of the angle over the velocity";
    let pairs = ANGLES[..3].iter().flat_map(|angle| VELOCITIES[..4].iter().map(move |velocity| (*angle, *velocity)));
    let fits = |(angle, velocity): &(&str, &str)| {
        let factor = |name: &str| Unit::named(name).map_or(f64::NAN, |unit| unit.to_base().0);
        (ratio.abs() * factor(angle) / factor(velocity) - 1.0).abs() < NEAR
    };
    let found: Vec<(&str, &str)> = pairs.filter(fits).collect();
    match found[..] {
        [(angle, velocity)] => (Known::found(angle, by.into()), Known::found(velocity, by.into())),
        _ => (None, None),
    }
}

/// The pole pairs that an electrical angle or velocity has by a mechanical one.
fn pole_pairs(times: Option<f64>, [angle, velocity]: [bool; 2]) -> Option<f64> {
    let times = times?.abs();
    let pairs = match (angle, velocity) {
        (true, false) => times,
        (false, true) => 1.0 / times,
        _ => return None,
    };
    let is_whole = (pairs / pairs.round() - 1.0).abs() < NEAR;
    (is_whole && (2.0..=MOST_PAIRS).contains(&pairs.round())).then(|| pairs.round())
}

/// Whether a column is an angle or a velocity.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Angle,
    Velocity,
}

impl Kind {
    /// The channel of a column: as it is, or with its unit stated, or with what is asked in its place.
    fn channel(self, column: &Column<'_>, known: Option<Known>, (electrical, pairs): (bool, Option<f64>)) -> Channel {
        let (name, is_angle) = (column.name, self == Self::Angle);
        let unit = known.as_ref().map_or("?", |known| known.unit.as_str());
        if electrical {
            return self.electrical((name, unit), pairs);
        }
        let (text, said) = match known {
            Some(Known { by, .. }) if by.is_empty() => (name.to_string(), None),
            Some(Known { unit, by, .. }) => {
                (format!("{name}[{unit}]"), Some(format!("{name} is taken in {unit}: {by}")))
            }
            None if is_angle && is_counts(column.values) => {
                let said = format!("{name} counts: how many counts has a turn of the shaft?");
                (format!("{name}[turn/?]"), Some(said))
            }
            None => {
                let units = if is_angle { "rad, turn or deg" } else { "rad/s, rpm, turn/s or deg/s" };
                (format!("{name}[?]"), Some(format!("the unit of {name} is not known: {units}?")))
            }
        };
        Channel { text, said, answer: String::new(), kind: self }
    }

    /// An electrical angle or speed over the pole pairs.
    fn electrical(self, (name, unit): (&str, &str), pairs: Option<f64>) -> Channel {
        let by = pairs.map_or_else(|| "?".to_string(), |pairs| pairs.to_string());
        let text = match self {
            Self::Angle => format!("(unwrap({name}[{unit}]) rad)/{by}"),
            Self::Velocity => format!("({name}[{unit}] rad/s)/{by}"),
        };
        let said = match pairs {
            Some(pairs) => format!("{name} is electrical: {pairs} pole pairs, by a mechanical signal"),
            None => format!("{name} is electrical: how many pole pairs has the motor?"),
        };
        Channel { text, said: Some(said), answer: String::new(), kind: self }
    }
}

/// An angle that does not begin anew after one turn in its unit.
fn wrong_turn(known: &Known, period: f64) -> Option<String> {
    let turns = period * known.factor / TAU;
    (!are_whole(turns)).then(|| {
        format!(
            "the angle begins anew at {period:.4}, which is {turns:.4} turns in {}: another unit, or a gear?",
            known.unit
        )
    })
}

fn contradiction(times: f64) -> String {
    let pairs = [times, 1.0 / times]
        .into_iter()
        .find(|pairs| (2.0..=MOST_PAIRS).contains(&pairs.round()) && (pairs / pairs.round() - 1.0).abs() < NEAR);
    match pairs {
        Some(pairs) => format!(
            "the angle turns {times:.4} times as far as the velocity says: one of them electrical, with {:.0} pole pairs, \
             or a gear?",
            pairs.round()
        ),
        None if (times + 1.0).abs() < OFF => "the angle runs against the velocity; change the sign of one".into(),
        None => {
            format!("the angle turns {times:.4} times as far as the velocity says: another unit, a gear, or the rate?")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE_HZ: f64 = 1000.0;

    /// Velocity, rad/s, and angle, rad.
    fn motion() -> (Vec<f64>, Vec<f64>) {
        let velocity = |t: f64| 40.0 + 60.0 * (TAU * 0.7 * t).sin();
        let angle = |t: f64| 40.0 * t + 60.0 / (TAU * 0.7) * (1.0 - (TAU * 0.7 * t).cos());
        let times = || (0..8000).map(|k| f64::from(k) / RATE_HZ);
        (times().map(velocity).collect(), times().map(angle).collect())
    }

    fn scaled(x: &[f64], factor: f64) -> Vec<f64> {
        x.iter().map(|x| factor * x).collect()
    }

    fn wrapped(x: &[f64], period: f64) -> Vec<f64> {
        x.iter().map(|x| x.rem_euclid(period)).collect()
    }

    /// The texts of the channels of an angle and a velocity.
    fn of(angle: (&str, &[f64]), velocity: Option<(&str, &[f64])>) -> (String, String, Turning) {
        let column = |(name, values)| Column { name, values };
        let turning = Turning::of(Some(column(angle)), velocity.map(column), Some(RATE_HZ));
        let text = |channel: &Option<Channel>| channel.as_ref().map_or_else(String::new, |own| own.text.clone());
        (text(&turning.angle), text(&turning.velocity), turning)
    }

    #[test]
    fn the_wrap_tells_the_unit_of_an_angle() {
        let (_, angle) = motion();
        for (turn, channel) in
            [(TAU, "theta[rad]"), (360.0, "theta[deg]"), (1.0, "theta[turn]"), (3600.0, "theta[0.1 deg]")]
        {
            let theta = wrapped(&scaled(&angle, turn / TAU), turn);
            assert_eq!(of(("theta", &theta), None).0, channel);
            let centred: Vec<f64> = theta.iter().map(|x| x - 0.5 * turn).collect();
            assert_eq!(of(("theta", &centred), None).0, channel);
        }
        for counts in [4096.0, 10_000.0, 65_536.0] {
            let whole: Vec<f64> = wrapped(&scaled(&angle, counts / TAU), counts).iter().map(|x| x.floor()).collect();
            assert_eq!(of(("position", &whole), None).0, format!("position[turn/{counts}]"));
        }
    }

    #[test]
    fn a_velocity_in_a_known_unit_tells_that_of_the_angle_and_the_other_way_round() {
        let (velocity, angle) = motion();
        let rpm = scaled(&velocity, 60.0 / TAU);
        for (turn, channel) in [(TAU, "pos[rad]"), (360.0, "pos[deg]"), (1.0, "pos[turn]")] {
            let found = of(("pos", &scaled(&angle, turn / TAU)), Some(("speed_rpm", &rpm)));
            assert_eq!((found.0.as_str(), found.1.as_str()), (channel, "speed_rpm"));
        }
        let counts: Vec<f64> = scaled(&angle, 4096.0 / TAU).iter().map(|x| x.round()).collect();
        assert_eq!(of(("pos", &counts), Some(("w_rad_s", &velocity))).0, "pos[turn/4096]");
        for (factor, channel) in
            [(1.0, "w[rad/s]"), (60.0 / TAU, "w[rpm]"), (1.0 / TAU, "w[turn/s]"), (360.0 / TAU, "w[deg/s]")]
        {
            let found = of(("angle_rad", &angle), Some(("w", &scaled(&velocity, factor))));
            assert_eq!((found.0.as_str(), found.1.as_str()), ("angle_rad", channel));
        }
        // The ratio of turns to revolutions a minute is that of no other pair.
        let found = of(("pos", &scaled(&angle, 1.0 / TAU)), Some(("speed", &rpm)));
        assert_eq!((found.0.as_str(), found.1.as_str()), ("pos[turn]", "speed[rpm]"));
    }

    #[test]
    fn what_nothing_tells_is_asked() {
        let (velocity, angle) = motion();
        let turns = [scaled(&angle, 1.0 / TAU), scaled(&velocity, 1.0 / TAU)];
        let found = of(("position", &turns[0]), Some(("velocity", &turns[1])));
        assert_eq!((found.0.as_str(), found.1.as_str()), ("position[?]", "velocity[?]"));
        assert!(found.2.told()[0].contains("the unit of position is not known: rad, turn or deg?"), "{:?}", found.2);
        let counts: Vec<f64> = scaled(&angle, 4096.0 / TAU).iter().map(|x| x.round()).collect();
        assert_eq!(of(("position", &counts), None).0, "position[turn/?]");
    }

    #[test]
    fn each_question_mark_has_its_text_and_its_answers() {
        let (velocity, angle) = motion();
        let turns = scaled(&angle, 1.0 / TAU);
        let marks = |turning: Turning| turning.angle.expect("an angle").marks();
        let position = marks(of(("position", &turns), Some(("velocity", &scaled(&velocity, 0.3)))).2);
        assert_eq!(position, [("position[?]".to_string(), &["rad", "turn", "deg"][..])]);
        let counts: Vec<f64> = scaled(&angle, 4096.0 / TAU).iter().map(|x| x.round()).collect();
        assert_eq!(marks(of(("position", &counts), None).2), [("position[turn/?]".to_string(), &[][..])]);
        let electrical = marks(of(("theta_e", &turns), None).2);
        assert_eq!(electrical[0], ("theta_e[?]".to_string(), &["rad", "turn", "deg"][..]));
        assert_eq!(electrical[1], (") rad)/?".to_string(), &[][..]));
    }

    #[test]
    fn an_unknown_unit_has_its_factor_by_the_other_signal() {
        let (velocity, angle) = motion();
        let hundredths = scaled(&velocity, 100.0);
        let (_, text, turning) = of(("angle_rad", &angle), Some(("speed", &hundredths)));
        let channel = turning.velocity.expect("a velocity");
        assert_eq!(text, "speed[?]");
        assert!(channel.said.as_ref().is_some_and(|said| said.ends_with("One is 0.01 rad/s by the other signal.")));
        let values = channel.values(&Column { name: "speed", values: &hundredths });
        assert!(values.iter().zip(&velocity).all(|(one, other)| (one - other).abs() < 1e-3 * 100.0));
    }

    #[test]
    fn electrical_signals_ask_for_the_pole_pairs_or_have_them_from_a_mechanical_one() {
        let (velocity, angle) = motion();
        let (electrical, speed) = (wrapped(&scaled(&angle, 7.0), TAU), scaled(&velocity, 7.0));
        let found = of(("theta_e", &electrical), Some(("omega_e", &speed)));
        assert_eq!((found.0.as_str(), found.1.as_str()), ("(unwrap(theta_e[rad]) rad)/?", "(omega_e[rad/s] rad/s)/?"));
        let found = of(("theta_elec", &electrical), Some(("velocity_rad_s", &velocity)));
        assert_eq!((found.0.as_str(), found.1.as_str()), ("(unwrap(theta_elec[rad]) rad)/7", "velocity_rad_s"));
        let erpm = scaled(&speed, 60.0 / TAU);
        let found = of(("angle_rad", &angle), Some(("erpm", &erpm)));
        assert_eq!(found.1, "(erpm[rpm] rad/s)/7");
        assert!(found.2.contradiction.is_none(), "{:?}", found.2);
    }

    #[test]
    fn contradictions_are_named_on_both_sides_of_one() {
        let (velocity, angle) = motion();
        for (factor, words) in [
            (0.001, "0.0010 times as far"),
            (0.5, "with 2 pole pairs, or a gear"),
            (7.0, "with 7 pole pairs, or a gear"),
            (57.3, "57.3000 times as far"),
            (0.7153, "0.7153 times as far"),
            (-1.0, "runs against the velocity"),
        ] {
            let found = of(("angle_rad", &scaled(&angle, factor)), Some(("velocity_rad_s", &velocity))).2;
            let told = found.contradiction.expect("a contradiction");
            assert!(told.contains(words), "{factor}: {told}");
        }
        let found = of(("theta_deg", &wrapped(&angle, TAU)), None).2;
        assert!(found.contradiction.is_some_and(|told| told.contains("begins anew at 6.283")));
        let several = wrapped(&angle, 4.0 * TAU);
        let found = of(("angle_rad", &several), Some(("velocity_rad_s", &velocity))).2;
        assert_eq!(found.contradiction, None);
    }
}
