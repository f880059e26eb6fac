//! Which column is which signal, by names and units.

use crate::units::{Quantity, Unit};
use model::audit::sums::phase_currents;
use model::trace::{is_reference, words};

/// Channels that were found, each a column.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Guess {
    pub(crate) current: Option<String>,
    pub(crate) velocity: Option<String>,
    pub(crate) velocity_ref: Option<String>,
    pub(crate) current_ref: Option<String>,
    pub(crate) angle: Option<String>,
    pub(crate) load: Option<String>,
    /// Phase currents, of which none is the quadrature current.
    pub(crate) phases: Vec<String>,
}

/// Parts of names, the most telling first.
const CURRENT: [&str; 11] =
    ["iq", "current", "strom", "courant", "corriente", "電流", "电流", "curr", "amp", "ia", "i"];
const VELOCITY: [&str; 15] = [
    "velocity",
    "vel",
    "speed",
    "drehzahl",
    "geschwindigkeit",
    "vitesse",
    "速度",
    "回転数",
    "转速",
    "回転速度",
    "rpm",
    "erpm",
    "omega",
    "rev",
    "w",
];
const ANGLE: [&str; 15] = [
    "angle",
    "winkel",
    "theta",
    "角度",
    "position",
    "位置",
    "pos",
    "resolver",
    "encoder",
    "電気角",
    "phi",
    "lage",
    "rotorlage",
    "ángulo",
    "angolo",
];
const LOAD: [&str; 11] =
    ["load", "last", "lastmoment", "torque", "drehmoment", "couple", "トルク", "转矩", "moment", "force", "brake"];
/// Parts of names of what is computed, of another machine, or of the supply.
const SECONDARY: [&str; 12] =
    ["est", "estimated", "2", "error", "err", "filtered", "input", "supply", "bus", "battery", "batt", "source"];
/// Words of columns that say what a row is of.
const LABELS: [&str; 12] =
    ["label", "labels", "class", "klasse", "fault", "fehler", "state", "status", "id", "index", "sample", "target"];

/// Parts of names of a power, of what the motor gives, and of a mass, which are no load of the shaft.
const NO_LOAD: [&str; 3] = ["power", "motor", "payload"];
/// Parts of names of the torque that a drive computes of its current: CiA 402 calls it the actual value.
const OF_DRIVE: [&str; 4] = ["act", "actual", "ist", "istwert"];

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

/// Whether a name has a word of a current that is measured.
pub(super) fn is_current(name: &str) -> bool {
    rank(name, &CURRENT, false).is_some()
}

/// Whether a column says what a row is of, and is no signal.
pub(crate) fn is_label(name: &str) -> bool {
    let words = words(name);
    !is_reference(name) && words.first().is_some_and(|word| LABELS.contains(&word.as_str()))
        || words.last().is_some_and(|word| ["label", "class"].contains(&word.as_str()))
}

impl Guess {
    /// By the names of columns of numbers.
    pub(crate) fn of(names: &[String]) -> Self {
        let phases: Vec<String> = phase_currents(names).into_iter().map(|place| names[place].clone()).collect();
        let best = |parts: &[&str], reference: bool, refused: &[Quantity]| {
            let fits = |name: &&String| {
                Unit::of_column(name).is_none_or(|unit| !refused.contains(&unit.quantity))
                    && !phases.contains(name)
                    && !is_label(name)
            };
            let ranked = names.iter().filter(fits).filter_map(|name| Some((rank(name, parts, reference)?, name)));
            ranked.min_by_key(|(rank, _)| *rank).map(|(_, name)| name.clone())
        };
        use Quantity::{Angle, AngularVelocity, Current, Force, Length, Other, Torque, Velocity, Voltage};
        let of_motion = [Current, Torque, Force, Voltage, Other];
        let velocity_as = [&of_motion[..], &[Angle, Length]].concat();
        let angle_as = [&of_motion[..], &[AngularVelocity, Velocity, Length]].concat();
        let moving = [AngularVelocity, Velocity, Angle, Length];
        let current_as = [&moving[..], &[Torque, Force, Voltage, Other]].concat();
        // Of some currents the name has no other word than the unit: q_A.
        let in_amperes = |name: &&String| {
            Unit::of_column(name).is_some_and(|unit| unit.quantity == Current)
                && !(phases.contains(name)
                    || is_label(name)
                    || is_reference(name)
                    || words(name).iter().any(|word| word == "d"))
        };
        let current = best(&CURRENT, false, &current_as).or_else(|| names.iter().find(in_amperes).cloned());
        // The symbol of a speed is a letter, and its unit tells it: n [1/min]. Frequencies are of something else.
        let turns = |name: &&String| {
            let unit = Unit::of_column(name).filter(|unit| unit.quantity == AngularVelocity);
            unit.is_some_and(|unit| Some(unit) != Unit::named("Hz")) && !is_label(name)
        };
        let velocity = best(&VELOCITY, false, &velocity_as)
            .or_else(|| names.iter().filter(turns).find(|name| !is_reference(name)).cloned());
        let load = best(&LOAD, false, &[&moving[..], &[Current, Voltage, Other]].concat())
            .filter(|name| !words(name).iter().any(|word| NO_LOAD.contains(&word.as_str())));
        let is_of_drive = |name: &String| words(name).iter().any(|word| OF_DRIVE.contains(&word.as_str()));
        let (torque, load) = if load.as_ref().is_some_and(is_of_drive) { (load, None) } else { (None, load) };
        // It stands for the current that it is computed of.
        let current = current.or(torque);
        let different =
            |found: Option<String>, other: &Option<String>| found.filter(|name| Some(name) != other.as_ref());
        Self {
            velocity_ref: best(&VELOCITY, true, &velocity_as),
            current_ref: different(best(&CURRENT, true, &current_as), &current),
            angle: best(&ANGLE, false, &angle_as),
            load: different(load, &current),
            velocity,
            current,
            phases,
        }
    }

    /// The channels in A, rad/s and rad, where the names tell other units.
    pub(crate) fn converted(self) -> Self {
        let in_unit = |found: Option<String>, unit: &str| found.map(|name| converted(&name, unit));
        Self {
            current: in_unit(self.current, "A"),
            velocity: in_unit(self.velocity, "rad/s"),
            velocity_ref: in_unit(self.velocity_ref, "rad/s"),
            angle: in_unit(self.angle, "rad"),
            ..self
        }
    }
}

/// The column in this unit, if its name says that it is in another one of the same quantity.
pub(crate) fn converted(name: &str, unit: &str) -> String {
    let known = Unit::of_column(name).zip(Unit::named(unit)).and_then(|(own, wanted)| own.to(&wanted));
    match known {
        Some(factor) if factor != (1.0, 0.0) => format!("({name}){unit}"),
        _ => name.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str]) -> Guess {
        Guess::of(&names.iter().map(ToString::to_string).collect::<Vec<_>>()).converted()
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
        let log = of(&["Axis1.ActVelo [deg/s]", "Axis1.ActTorque"]);
        assert_eq!((log.current, log.load), (some("Axis1.ActTorque"), None));
        assert_eq!(of(&["S-0-0051 Lage-Istwert [Grad]"]).angle, some("(S-0-0051 Lage-Istwert [Grad])rad"));
        assert_eq!(of(&["Iq_A", "n [1/min]", "M [Nm]"]).velocity, some("(n [1/min])rad/s"));
        assert_eq!(of(&["iq_A", "fsw_Hz"]).velocity, None);
        assert_eq!(of(&["Input current [A]", "motor_current_A"]).current, some("motor_current_A"));
    }

    #[test]
    fn columns_of_other_languages_are_found() {
        let some = |name: &str| Some(name.to_string());
        let log =
            of(&["Zeit in s", "Iq in A", "Drehzahl in 1/min", "Solldrehzahl in 1/min", "Winkel in Grad", "Lastmoment"]);
        assert_eq!((log.current, log.load), (some("Iq in A"), some("Lastmoment")));
        assert_eq!((log.velocity, log.angle), (some("(Drehzahl in 1/min)rad/s"), some("(Winkel in Grad)rad")));
        assert_eq!(log.velocity_ref, some("(Solldrehzahl in 1/min)rad/s"));
        let log = of(&["電流[A]", "回転数[rpm]", "指令速度[rpm]", "角度[deg]", "負荷トルク[Nm]"]);
        assert_eq!((log.current, log.load), (some("電流[A]"), some("負荷トルク[Nm]")));
        assert_eq!((log.velocity, log.velocity_ref), (some("(回転数[rpm])rad/s"), some("(指令速度[rpm])rad/s")));
        assert_eq!(log.angle, some("(角度[deg])rad"));
    }

    #[test]
    fn a_phase_current_or_a_label_is_no_channel() {
        for names in
            [&["ia", "ib", "ic", "omega"][..], &["i_u [A]", "i_v [A]", "speed"], &["current_a", "current_b", "w"]]
        {
            let log = of(names);
            assert_eq!((log.current, log.phases.len() >= 2), (None, true), "{names:?}");
        }
        assert_eq!(of(&["current_a", "velocity_rad_s"]).current, Some("current_a".into()));
        assert_eq!(of(&["ia_A", "ib_A", "iq_A"]).current, Some("iq_A".into()));
        assert_eq!(of(&["d_A", "q_A", "position"]).current, Some("q_A".into()));
        for name in ["label", "fault_current", "class", "state_velocity", "bearing_label"] {
            assert!(is_label(name), "{name}");
            assert_eq!(of(&[name]), Guess::default(), "{name}");
        }
    }
}
