//! Units as many drives and loggers write them.

use super::*;

/// Quantity and factor.
fn of(text: &str) -> Option<(Quantity, f64)> {
    parse(text).map(|unit| (unit.quantity, unit.to_base().0))
}

#[test]
fn spellings_of_many_drives_have_their_factor() {
    use Quantity::{Angle, AngularVelocity, Current, Force, Length, Time, Torque, Velocity, Voltage};
    for (spellings, quantity, factor) in [
        (
            &["rpm", "RPM", "1/min", "U/min", "r/min", "rev/min", "tr/min", "min-1", "min^-1", "min⁻¹", "1/(min)"][..],
            AngularVelocity,
            TURN / 60.0,
        ),
        (
            &["Umdr/min", "Umdrehungen pro Minute", "turns per minute", "回転/分", "min**-1", "r.p.m.", "tr.min-1"],
            AngularVelocity,
            TURN / 60.0,
        ),
        (&["0.1 rpm", "0,1 rpm", "0.1rpm", "1e-1 r/min", "0.1 1/min"], AngularVelocity, TURN / 600.0),
        (&["krpm", "1000 rpm"], AngularVelocity, TURN * 1000.0 / 60.0),
        (&["rps", "Hz", "turn/s", "U/s", "rev/sec"], AngularVelocity, TURN),
        (&["rad/min"], AngularVelocity, 1.0 / 60.0),
        (&["rad/s", "rad s-1", "rad·s⁻¹", "rad*s^-1", "radians per second"], AngularVelocity, 1.0),
        (&["rad.s-1", "rad.s^-1", "rad s^{-1}", "rad/(s)", "rad/sec.", "rad·sec⁻¹", "rad.s−1"], AngularVelocity, 1.0),
        (&["mrad/s", "rad/ks"], AngularVelocity, 1e-3),
        (&["deg/s", "°/s", "dps", "Grad/s", "度/秒", "deg.s-1", "°·s⁻¹", "deg s^-1"], AngularVelocity, DEGREE),
        (&["deg", "Grad", "°", "degrees", "度"], Angle, DEGREE),
        (&["0.01 deg", "0,01°", "cdeg"], Angle, DEGREE / 100.0),
        (&["turn/4096", "1/4096 turn", "rev/4096"], Angle, TURN / 4096.0),
        (&["A", "a", "Ampere", "amps"], Current, 1.0),
        (&["mA", "ma", "milliamps", "0.001 A"], Current, 1e-3),
        (&["0.1A", "0.1 A", "0,1 A", "dA", "100 mA"], Current, 0.1),
        (&["uA", "µA", "μA"], Current, 1e-6),
        (&["kA"], Current, 1e3),
        (&["mV", "mv"], Voltage, 1e-3),
        (&["Nm", "nm", "N·m", "N*m", "N.m", "N m", "N-m", "Newtonmeter"], Torque, 1.0),
        (&["mNm", "mN·m", "Nmm"], Torque, 1e-3),
        (&["cNm", "N·cm", "Ncm"], Torque, 1e-2),
        // Pound 0.45359237 kg, standard gravity 9.80665 m/s², inch 0.0254 m, foot 12 inches.
        (&["oz·in", "ozin", "oz-in"], Torque, 0.453_592_37 * 9.806_65 / 16.0 * 0.0254),
        (&["lbf·ft", "ftlb"], Torque, 0.453_592_37 * 9.806_65 * 12.0 * 0.0254),
        (&["lbf"], Force, 0.453_592_37 * 9.806_65),
        (&["in", "25.4 mm"], Length, 0.0254),
        (&["kN"], Force, 1e3),
        (&["mm", "0.001 m"], Length, 1e-3),
        (&["mm/s"], Velocity, 1e-3),
        (&["m/min"], Velocity, 1.0 / 60.0),
        (&["ms", "msec", "Millisekunden"], Time, 1e-3),
        (&["us", "µs", "usec"], Time, 1e-6),
        (&["100 ns"], Time, 1e-7),
    ] {
        for text in spellings {
            let found = of(text);
            let near = found.is_some_and(|(own, value)| own == quantity && (value / factor - 1.0).abs() < 1e-12);
            assert!(near, "{text}: {found:?} for {quantity:?} {factor}"); // rounding of a few products
        }
    }
}

#[test]
fn what_is_no_unit_or_not_clear_is_none() {
    for text in [
        "",
        "1",
        "0.5",
        "1/s",
        "s-1",
        "A rms",
        "Arms",
        "foo",
        "counts",
        "inc",
        "%",
        "-",
        "A/",
        "rad/0",
        "erpm",
        "4 5",
        "n.a.",
        "p.u.",
        "A*",
        "rad.s",
        "rad·s",
        "deg*s",
        "A_rms",
        "A-rms",
        "rad/(s",
        "((((m))))",
        "rad-",
        "1/s.",
    ] {
        assert_eq!(of(text), None, "{text}");
    }
    for text in ["m/s^2", "rad/s2", "W", "kW", "Ohm", "mΩ", "V/krpm", "Nm/A", "rad.s-2", "kg.m2", "bar·s"] {
        let expected = (text != "bar·s").then_some(Quantity::Other);
        assert_eq!(of(text).map(|(quantity, _)| quantity), expected, "{text}");
    }
}
