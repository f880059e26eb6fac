//! Recordings in many layouts, rates and units: what is described of each is right, or asked, and never wrong without a
//! word.

use std::f64::consts::TAU;

use super::guess::Guess;
use super::proposal::Proposal;
use crate::reader::of_content;
use crate::signal::signs;
use crate::turning::Column;
use crate::units::Unit;
use model::audit::times::Times;

const ROWS: usize = 900;
const RPM: f64 = 60.0 / TAU;
const DEGREE: f64 = 360.0 / TAU;

/// Names of a column, its values for one in base units, where it begins anew, and whether it is whole numbers.
type Spelling = (&'static str, f64, Option<f64>, bool);

const VELOCITIES: [Spelling; 22] = [
    ("velocity_rad_s", 1.0, None, false),
    ("speed [rpm]", RPM, None, false),
    ("Drehzahl in 1/min", RPM, None, false),
    ("omega (rad.s-1)", 1.0, None, false),
    ("omega [rad.s⁻¹]", 1.0, None, false),
    ("vel [rad.s]", 1.0, None, false),
    ("n_min-1", RPM, None, false),
    ("speed_deg/s", DEGREE, None, false),
    ("speed [krpm]", RPM / 1000.0, None, false),
    ("velocity [turn/s]", 1.0 / TAU, None, false),
    ("speed_Hz", 1.0 / TAU, None, false),
    ("speed [0.1 rpm]", 10.0 * RPM, None, false),
    ("speed (U/min)", RPM, None, false),
    ("speed_radps", 1.0, None, false),
    ("Geschwindigkeit [°/s]", DEGREE, None, false),
    ("速度[rpm]", RPM, None, false),
    ("speed [rad*s^-1]", 1.0, None, false),
    ("speed", RPM, None, false),
    ("velocity", 1.0, None, false),
    ("speed [digits]", 37.0, None, false),
    // Two's complement of 16 and 24 bits without its sign.
    ("speed_rpm", RPM, Some(65_536.0), true),
    ("speed [mrad/s]", 1000.0, Some(16_777_216.0), true),
];
const ANGLES: [Spelling; 10] = [
    ("angle_rad", 1.0, None, false),
    ("theta", 1.0, Some(TAU), false),
    ("theta [deg]", DEGREE, Some(360.0), false),
    ("Winkel in Grad", DEGREE, None, false),
    ("angle [°]", DEGREE, Some(360.0), false),
    ("pos", 1.0 / TAU, Some(1.0), false),
    ("position", 4096.0 / TAU, Some(4096.0), true),
    ("theta", DEGREE, Some(360.0), false),
    ("position [turn]", 1.0 / TAU, None, false),
    ("theta_e", 5.0, Some(TAU), false),
];
const CURRENTS: [Spelling; 8] = [
    ("iq_A", 1.0, None, false),
    ("iq [mA]", 1e3, None, false),
    ("Strom in A", 1.0, None, false),
    ("current (0.1A)", 10.0, None, false),
    ("Iq [A_rms]", 0.7, None, false),
    ("iq", 1.0, None, false),
    ("電流[A]", 1.0, None, false),
    ("iq_mA", 1e3, Some(65_536.0), true),
];

/// How a file writes its rows, its time and its rate.
struct Layout {
    separator: char,
    decimal: char,
    /// Name and unit of the time, s; without one a line before the header has the rate.
    time: Option<(&'static str, f64)>,
    line: &'static str,
    /// Whether units are a row of their own.
    units_row: bool,
}

const LAYOUTS: [Layout; 7] = [
    Layout { separator: ',', decimal: '.', time: Some(("t_s", 1.0)), line: "", units_row: false },
    Layout { separator: ';', decimal: ',', time: Some(("Zeit [ms]", 1e-3)), line: "", units_row: false },
    Layout { separator: '\t', decimal: '.', time: Some(("time_us", 1e-6)), line: "", units_row: true },
    Layout { separator: ',', decimal: '.', time: None, line: "Sample rate,{rate},Hz\n", units_row: false },
    Layout { separator: ';', decimal: ',', time: None, line: "Abtastintervall;{step};s\n", units_row: false },
    Layout { separator: '\t', decimal: '.', time: Some(("t [s]", 1.0)), line: "# Drive log 3\n", units_row: false },
    Layout { separator: ',', decimal: '.', time: None, line: "", units_row: false },
];
const RATES: [f64; 4] = [1000.0, 1250.0, 2000.0, 8000.0];

/// Current, velocity and angle of a row, in A, rad/s and rad.
fn motion(t: f64) -> [f64; 3] {
    let velocity = 12.0 + 31.0 * (TAU * 3.1 * t).sin();
    let angle = 12.0 * t + 31.0 / (TAU * 3.1) * (1.0 - (TAU * 3.1 * t).cos());
    [0.3 * velocity.signum() + 0.02 * velocity, velocity, angle]
}

fn written(value: f64, (_, factor, period, is_whole): Spelling) -> f64 {
    let value = if is_whole { (value * factor).floor() } else { value * factor };
    period.map_or(value, |period| value.rem_euclid(period))
}

/// The text of a file.
fn text(layout: &Layout, rate: f64, spellings: [Spelling; 3]) -> String {
    let number = |value: f64, digits: usize| format!("{value:.digits$}").replace('.', &layout.decimal.to_string());
    let line = layout.line.replace("{rate}", &number(rate, 0)).replace("{step}", &number(1.0 / rate, 7));
    let time = layout.time.map(|(name, _)| name.to_string());
    let names: Vec<String> = time.into_iter().chain(spellings.map(|(name, ..)| name.to_string())).collect();
    let mark = layout.separator.to_string();
    let in_brackets = |name: &String| name.split_once(" [").map(|(name, unit)| (name.to_string(), format!("[{unit}")));
    let heading = match layout.units_row && names.iter().skip(1).all(|name| in_brackets(name).is_some()) {
        false => names.join(&mark),
        true => {
            let (own, units): (Vec<String>, Vec<String>) =
                names.iter().map(|name| in_brackets(name).unwrap_or((name.clone(), "[us]".into()))).unzip();
            own.join(&mark) + "\n" + &units.join(&mark)
        }
    };
    let mut text = line + &heading + "\n";
    for row in 0..ROWS {
        let t = row as f64 / rate;
        let time = layout.time.map(|(_, unit)| number(t / unit, if unit < 1e-5 { 1 } else { 7 }));
        let digits = |own: Spelling| if own.3 { 0 } else { 6 };
        let cells = motion(t).into_iter().zip(spellings).map(|(value, own)| number(written(value, own), digits(own)));
        text += &time.into_iter().chain(cells).collect::<Vec<_>>().join(&mark);
        text += "\n";
    }
    text
}

#[derive(Default)]
struct Counts {
    right: usize,
    asked: usize,
    refused: usize,
    wrong: Vec<String>,
}

/// What becomes of one file.
fn judged(counts: &mut Counts, layout: &Layout, rate: f64, spellings: [Spelling; 3]) {
    let content = text(layout, rate, spellings);
    let what = format!("{:?} at {rate}: {:?}", layout.separator, spellings.map(|(name, ..)| name));
    let Ok((names, mut first, _)) = of_content("a.csv", &content, None) else {
        counts.refused += 1;
        return;
    };
    let found_hz = first.times_s.as_deref().and_then(Times::of).map(|times| times.rate_hz);
    if found_hz.is_some_and(|found| (found / rate - 1.0).abs() > 1e-3)
        || found_hz.is_none() == (layout.time.is_some() || !layout.line.is_empty())
    {
        counts.wrong.push(format!("{what}: {found_hz:?} rows a second"));
        return;
    }
    for (name, column) in names.iter().zip(&mut first.columns) {
        if let Some(own) = signs::of_column(name, column) {
            column.iter_mut().for_each(|x| *x = own.decoded(*x));
        }
    }
    let proposal = Proposal::of(&names);
    let turning = proposal.turning(&names, &first.columns, found_hz);
    let doubts = proposal.doubts(false);
    let Guess { current, velocity, angle, .. } = &proposal.columns;
    let (Some(current), Some(velocity), Some(angle)) = (current, velocity, angle) else {
        counts.wrong.push(format!("{what}: {:?} of {names:?}", proposal.columns));
        return;
    };
    let column = |name: &String| {
        let place = names.iter().position(|own| own == name).unwrap_or_default();
        Column { name: &names[place], values: &first.columns[place] }
    };
    let mut is_asked = turning.contradiction.is_some() || doubts.iter().any(|doubt| doubt.contains("not known"));
    let of = |channel: &Option<crate::turning::Channel>, name: &String| {
        channel.as_ref().map(|channel| (channel.is_question(), channel.values(&column(name))))
    };
    let factor = Unit::of_column(current).map_or(1.0, |unit| unit.to_base().0);
    let currents: Vec<f64> = column(current).values.iter().map(|x| factor * x).collect();
    let mut all = vec![("current", false, currents, 0, TAU)];
    for (what, found, place) in
        [("velocity", of(&turning.velocity, velocity), 1), ("angle", of(&turning.angle, angle), 2)]
    {
        let Some((is_question, values)) = found else { continue };
        is_asked |= is_question;
        all.push((what, is_question, values, place, TAU));
    }
    for (of, is_question, values, place, turn) in all {
        // An angle is right but for whole turns, and numbers but for the step of whole ones.
        let is_right = |(row, value): (usize, &f64)| {
            let expected = motion(row as f64 / rate)[place];
            let off = value - expected;
            let off = if place == 2 { off - turn * (off / turn).round() } else { off };
            off.abs()
                < 0.01
                    + 0.002 * expected.abs()
                    + 2.0 / spellings[place].1.abs() * f64::from(u8::from(spellings[place].3))
        };
        let is_stated = is_question || place == 0 && doubts.iter().any(|doubt| doubt.contains("not known"));
        if !is_stated && turning.contradiction.is_none() && !values.iter().enumerate().all(is_right) {
            counts.wrong.push(format!("{what}: {of} {:?}", &values[..3]));
            return;
        }
    }
    if is_asked { counts.asked += 1 } else { counts.right += 1 }
}

#[test]
fn layouts_rates_and_units_are_right_or_asked() {
    let (mut counts, mut turn) = (Counts::default(), 0);
    for layout in &LAYOUTS {
        for rate in RATES {
            for velocity in VELOCITIES {
                for angle in ANGLES.into_iter().skip(turn % 3).step_by(3) {
                    turn += 1;
                    judged(&mut counts, layout, rate, [CURRENTS[turn % CURRENTS.len()], velocity, angle]);
                }
            }
        }
    }
    let Counts { right, asked, refused, wrong } = counts;
    println!("{turn} files: right {right}, asked {asked}, refused {refused}, wrong {}", wrong.len());
    assert!(wrong.is_empty(), "{} wrong: {:#?}", wrong.len(), &wrong[..wrong.len().min(12)]);
    assert!(turn > 1000 && refused == 0 && 10 * right > 4 * turn, "{right} of {turn} right, {refused} refused");
}
