//! Which column is which signal, by names and units.

use crate::units::{Quantity, Unit};
use model::trace::{is_reference, words};

/// Channels that were found; each is a column, with its unit converted where that is needed.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Guess {
    pub(crate) current: Option<String>,
    pub(crate) velocity: Option<String>,
    pub(crate) velocity_ref: Option<String>,
    pub(crate) current_ref: Option<String>,
    pub(crate) angle: Option<String>,
    pub(crate) load: Option<String>,
}

/// Parts of names, the most telling first.
const CURRENT: [&str; 9] = ["iq", "current", "strom", "courant", "corriente", "curr", "amp", "ia", "i"];
const VELOCITY: [&str; 10] =
    ["velocity", "vel", "speed", "drehzahl", "geschwindigkeit", "vitesse", "rpm", "omega", "rev", "w"];
const ANGLE: [&str; 7] = ["angle", "winkel", "theta", "position", "pos", "resolver", "encoder"];
const LOAD: [&str; 6] = ["load", "torque", "drehmoment", "couple", "force", "brake"];
/// Parts of names of what is computed or of another machine.
const SECONDARY: [&str; 6] = ["est", "estimated", "2", "error", "err", "filtered"];

/// Parts of names of a power, and of what the motor gives, which are no load of the shaft.
const NO_LOAD: [&str; 2] = ["power", "motor"];

/// How well a name fits: the rank of its most telling part, worse if it is computed.
fn rank(name: &str, parts: &[&str], reference: bool) -> Option<usize> {
    let words = words(name);
    let has = |list: &[&str]| words.iter().any(|word| list.contains(&word.as_str()));
    if is_reference(name) != reference {
        return None;
    }
    let best = parts
        .iter()
        .position(|part| words.iter().any(|word| word == part || (part.len() > 3 && word.contains(part))))?;
    Some(best + if has(&SECONDARY) { 100 } else { 0 })
}

impl Guess {
    /// By the names of columns of numbers.
    pub(crate) fn of(names: &[String]) -> Self {
        let best = |parts: &[&str], reference: bool, refused: &[Quantity]| {
            let fits = |name: &&String| unit_of(name).is_none_or(|unit| !refused.contains(&unit.quantity));
            let ranked = names.iter().filter(fits).filter_map(|name| Some((rank(name, parts, reference)?, name)));
            ranked.min_by_key(|(rank, _)| *rank).map(|(_, name)| name.clone())
        };
        use Quantity::{Angle, AngularVelocity, Current, Force, Length, Torque, Velocity, Voltage};
        let of_motion = [Current, Torque, Force, Voltage];
        let velocity_as = [&of_motion[..], &[Angle, Length]].concat();
        let angle_as = [&of_motion[..], &[AngularVelocity, Velocity, Length]].concat();
        let moving = [AngularVelocity, Velocity, Angle, Length];
        let in_unit = |found: Option<String>, unit: &str| found.map(|name| converted(&name, unit));
        let current = best(&CURRENT, false, &[&moving[..], &[Torque, Force, Voltage]].concat());
        let velocity = best(&VELOCITY, false, &velocity_as);
        let load = best(&LOAD, false, &[&moving[..], &[Current, Voltage]].concat())
            .filter(|name| !words(name).iter().any(|word| NO_LOAD.contains(&word.as_str())));
        let different =
            |found: Option<String>, other: &Option<String>| found.filter(|name| Some(name) != other.as_ref());
        Self {
            velocity_ref: in_unit(best(&VELOCITY, true, &velocity_as), "rad/s"),
            current_ref: different(best(&CURRENT, true, &[&moving[..], &[Torque, Force, Voltage]].concat()), &current),
            angle: in_unit(best(&ANGLE, false, &angle_as), "rad"),
            load: different(load, &current),
            current: in_unit(current, "A"),
            velocity: in_unit(velocity, "rad/s"),
        }
    }
}

/// The unit of a column; `theta_m` and `omega_m` are of the machine's mechanical side, not in metres.
fn unit_of(name: &str) -> Option<Unit> {
    const ROTARY: [&str; 6] = ["theta", "angle", "omega", "phi", "speed", "torque"];
    let is_mechanical = name.ends_with("_m") && words(name).iter().any(|word| ROTARY.contains(&word.as_str()));
    Unit::of_column(name).filter(|_| !is_mechanical)
}

/// The column in this unit, if its name says that it is in another one of the same quantity.
fn converted(name: &str, unit: &str) -> String {
    let known = unit_of(name).zip(Unit::named(unit)).and_then(|(own, wanted)| own.to(&wanted));
    match known {
        Some(factor) if factor != (1.0, 0.0) => format!("({name}){unit}"),
        _ => name.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Guess {
        Guess::of(&names.iter().map(ToString::to_string).collect::<Vec<_>>())
    }

    #[test]
    fn columns_of_real_logs_are_found() {
        let some = |name: &str| Some(name.to_string());
        let log = of(&[
            "iq1_cmd_A",
            "iq1_A",
            "pos1_rad",
            "vel1_rad_s",
            "torque1_est_Nm",
            "iq2_A",
            "torque_sensor_Nm",
            "vbus_V",
        ]);
        assert_eq!((log.current, log.current_ref), (some("iq1_A"), some("iq1_cmd_A")));
        assert_eq!(
            (log.velocity, log.angle, log.load),
            (some("vel1_rad_s"), some("pos1_rad"), some("torque_sensor_Nm"))
        );
        let log = of(&["velocity_ref_rad_s", "velocity_rad_s", "current_a", "load_torque_nm", "angle_rad"]);
        assert_eq!((log.velocity_ref, log.load), (some("velocity_ref_rad_s"), some("load_torque_nm")));
        let log = of(&["IQ", "RPM"]);
        assert_eq!((log.current, log.velocity, log.load), (some("IQ"), some("(RPM)rad/s"), None));
        let log = of(&["current_a", "velocity_mm_s", "velocity_ref_mm_s", "position_mm", "position_ref_mm"]);
        assert_eq!(
            (log.velocity, log.velocity_ref, log.angle),
            (some("velocity_mm_s"), some("velocity_ref_mm_s"), None)
        );
        let log = of(&["Current", "Speed", "Acc", "angle_deg"]);
        assert_eq!((log.current, log.velocity, log.angle), (some("Current"), some("Speed"), some("(angle_deg)rad")));
        let log = of(&["ia_A", "ib_A", "speed_rpm", "fsw_Hz", "id_A", "iq_A"]);
        assert_eq!((log.current, log.velocity), (some("iq_A"), some("(speed_rpm)rad/s")));
        let log = of(&["motorCurrent_mA", "SpeedSetpoint"]);
        assert_eq!((log.current, log.velocity_ref), (some("(motorCurrent_mA)A"), some("SpeedSetpoint")));
        assert_eq!(of(&["motor_iq_1", "motor_torque_1", "power_load_mech_1"]).load, None);
        assert_eq!(of(&["X131_DE_time", "time2"]), Guess::default());
    }
}
