//! The unit that the name of a column has.
//!
//! | form | example |
//! |---|---|
//! | in brackets at the end | `speed [rpm]`, `speed (rpm)`, `speed <rpm>` |
//! | behind the word *in*, or behind a bar | `Drehzahl in 1/min`, `n / (1/min)`, `t/ms` |
//! | behind an underscore | `speed_rpm`, `velocity_rad_s` |
//! | alone | `RPM` |

use model::trace::words;

use super::grammar::parse;
use super::unit::{Quantity, Unit};

/// Units of one letter that stand behind an underscore.
const LETTERS: [&str; 11] = ["A", "a", "V", "v", "N", "n", "m", "s", "K", "C", "c"];
/// Ends of names that are words of other meaning, although they are units.
const OTHER_WORDS: [&str; 8] = ["deg_c", "rot", "tour", "oz", "lb", "kp", "cycle", "in"];
/// Words of names whose `_min` is a unit; others have a least value.
const TIMES: [&str; 5] = ["t", "time", "zeit", "elapsed", "temps"];
/// Words by which `_m` is of the mechanical side, and no length.
const ROTARY: [&str; 6] = ["theta", "angle", "omega", "phi", "speed", "torque"];
/// Parts of a turn or a length that a speed is written of without a bar, by an `s` or `ps` behind them.
const SPEEDS: [&str; 6] = ["rad", "mrad", "deg", "turn", "rev", "m"];

/// The unit of a column.
pub(super) fn of(name: &str) -> Option<Unit> {
    let name = name.trim();
    match stated(name) {
        Some(text) => parse(text),
        None => alone(name)
            .or_else(|| name.match_indices('_').find_map(|(at, _)| of_end(name, at)))
            .or_else(|| of_last_word(name)),
    }
}

/// The unit that a column is called by; a letter or two say too little, and `in s` is none of a length.
fn alone(name: &str) -> Option<Unit> {
    parse(name).filter(|_| name.chars().count() > 2 && !name.starts_with("in "))
}

/// What a name states as its unit, in brackets or behind *in* or a bar, whether it is one or not.
pub(crate) fn stated(name: &str) -> Option<&str> {
    let name = name.trim();
    for (open, close) in [('[', ']'), ('(', ')'), ('<', '>'), ('［', '］'), ('（', '）')] {
        let inner = name.strip_suffix(close).and_then(|rest| rest.rsplit_once(open));
        // A number alone counts columns: speed (2).
        let is_number = |unit: &str| unit.trim().bytes().all(|byte| byte.is_ascii_digit());
        if let Some((_, unit)) = inner.filter(|(_, unit)| !is_number(unit)) {
            return Some(unit.trim());
        }
    }
    if let Some((_, unit)) = name.rsplit_once(" in ").filter(|(name, _)| !name.trim().is_empty()) {
        return Some(unit.trim());
    }
    if alone(name).is_some() {
        return None;
    }
    // A bar also divides two columns, or parts of a path; behind a mark it is within the unit: speed_rad/s.
    let is_unit = |unit: &&str| parse(unit).is_some();
    let behind_mark = name.match_indices(['_', ' ']).map(|(at, _)| name[at + 1..].trim());
    if let Some(unit) = behind_mark.filter(|unit| unit.contains('/') && !unit.starts_with('/')).find(is_unit) {
        return Some(unit);
    }
    let behind_bar = || name.match_indices('/').map(|(at, _)| name[at + 1..].trim()).find(is_unit);
    behind_bar().or_else(|| name.rsplit_once(", ").map(|(_, unit)| unit.trim()).filter(is_unit))
}

/// The unit behind the underscore at a place of a name. The longest end is asked first: m_s before s.
fn of_end(name: &str, at: usize) -> Option<Unit> {
    let end = &name[at + 1..];
    let lower = end.to_lowercase();
    if let Some(unit) = joined(end, &lower) {
        return Some(unit);
    }
    let is_letter = end.chars().count() == 1;
    let is_least = lower == "min" && !words(&name[..at]).iter().any(|word| TIMES.contains(&word.as_str()));
    let is_mechanical = end == "m" && words(&name[..at]).iter().any(|word| ROTARY.contains(&word.as_str()));
    if is_letter && !LETTERS.contains(&end) || is_mechanical || is_least || OTHER_WORDS.contains(&lower.as_str()) {
        return None;
    }
    parse(end).or_else(|| parse(&lower).filter(|_| end.len() > 2))
}

/// A quotient or a product whose mark is an underscore, or that has none: `rad_s`, `rev_per_min`, `N_m`, `radps`.
fn joined(end: &str, lower: &str) -> Option<Unit> {
    let speeds = [Quantity::AngularVelocity, Quantity::Velocity];
    let is_speed = |unit: &Unit| speeds.contains(&unit.quantity);
    let quotient = lower.replace("_per_", "/");
    if quotient.len() < lower.len() {
        return parse(&quotient);
    }
    let Some((one, other)) = end.split_once('_') else {
        let angle = || lower.strip_suffix('s').filter(|own| own.ends_with("rad"));
        let short = lower.strip_suffix("ps").or_else(angle).filter(|own| SPEEDS.contains(own))?;
        return parse(&format!("{short}/s")).filter(is_speed);
    };
    // Delay in seconds: delay_in_s.
    if one.eq_ignore_ascii_case("in") {
        return None;
    }
    let torque = || parse(&format!("{one}*{other}")).filter(|unit| unit.quantity == Quantity::Torque);
    let of = |one: &str, other: &str| parse(&format!("{one}/{other}")).filter(is_speed);
    of(one, other).or_else(|| of(&one.to_lowercase(), &other.to_lowercase())).or_else(torque)
}

/// A unit that the last word of a name is without an underscore: `SpeedRPM`, `speed rpm`, `motorCurrentMA` is none.
fn of_last_word(name: &str) -> Option<Unit> {
    let lower = name.to_lowercase();
    let named = |unit: &&&str| {
        let rest = lower.strip_suffix(**unit)?;
        let before = name.get(..rest.len())?.chars().next_back()?;
        let begins = name.get(rest.len()..)?.chars().next()?;
        (!before.is_alphanumeric() || before.is_lowercase() && begins.is_uppercase()).then_some(())
    };
    let found = ["krpm", "rpm", "rps", "deg"].iter().find(|unit| named(unit).is_some())?;
    parse(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_name_their_units() {
        for (name, unit) in [
            ("speed_rpm", "rpm"),
            ("velocity_rad_s", "rad/s"),
            ("nut_mm_s", "mm/s"),
            ("Speed [1/min]", "rpm"),
            ("angle (deg)", "deg"),
            ("torque_Nm", "Nm"),
            ("current_a", "A"),
            ("RPM", "rpm"),
            ("Drehzahl in 1/min", "rpm"),
            ("Winkel in Grad", "deg"),
            ("Zeit in s", "s"),
            ("n / (1/min)", "rpm"),
            ("n/(U/min)", "rpm"),
            ("t/ms", "ms"),
            ("I / mA", "mA"),
            ("Speed, rpm", "rpm"),
            ("回転数[rpm]", "rpm"),
            ("電流（mA）", "mA"),
            ("SpeedRPM", "rpm"),
            ("MotorSpeedRpm", "rpm"),
            ("motor speed rpm", "rpm"),
            ("iq_mA", "mA"),
            ("current [0.1A]", "0.1 A"),
            ("speed (0.1 rpm)", "0.1 rpm"),
            ("speed_krpm", "krpm"),
            ("speed_Hz", "Hz"),
            ("speed_rad_min", "rad/min"),
            ("time_min", "min"),
            ("torque_NM", "Nm"),
            ("torque_N_m", "Nm"),
            ("torque_N.m", "Nm"),
            ("torque [N-m]", "Nm"),
            ("speed_rad.s-1", "rad/s"),
            ("speed (rad.s⁻¹)", "rad/s"),
            ("omega_radps", "rad/s"),
            ("omega_rads", "rad/s"),
            ("omega_mrads", "mrad/s"),
            ("speed_mrad_s", "mrad/s"),
            ("speed_deg_per_s", "deg/s"),
            ("speed_rev_per_min", "rpm"),
            ("speed_km_h", "km/h"),
            ("speed_U/min", "rpm"),
            ("speed_rad/s", "rad/s"),
            ("motor speed rad/s", "rad/s"),
            ("n_min-1", "rpm"),
            ("delay_in_s", "s"),
            ("speed_1/min", "rpm"),
            ("IQ_MA", "mA"),
            ("rad/s", "rad/s"),
        ] {
            assert_eq!(of(name), parse(unit), "{name}");
            assert!(of(name).is_some(), "{name}");
        }
        for name in [
            "speed",
            "i",
            "i_d",
            "speed_r",
            "current_h",
            "speed_in",
            "speed_min",
            "theta_m",
            "erpm",
            "I [A rms]",
            "pos [inc]",
            "a/b",
            "vel [rad.s]",
            "I_A_rms",
            "speed [1/s]",
        ] {
            assert_eq!(of(name), None, "{name}");
        }
    }

    #[test]
    fn what_is_stated_but_no_unit_is_told() {
        for (name, text) in
            [("I [A rms]", "A rms"), ("vel (rad.s)", "rad.s"), ("pos (inc)", "inc"), ("Strom in Digits", "Digits")]
        {
            assert_eq!(stated(name), Some(text), "{name}");
        }
        assert_eq!((stated("current (1)"), stated("speed [12]")), (None, None));
        assert_eq!((stated("speed_rpm"), stated("/joint_states/j1/effort")), (None, None));
    }
}
