//! The page of what turns with the rotor.

use std::f64::consts::TAU;

use crate::page::or_reason;
use crate::page::table::table;
use crate::plot::{Series, lines};
use crate::{Color, Marker, Page};
use model::cogging::{Line, Lines, Wave, map};

/// Points of the map in the figure.
const POINTS: usize = 720;
/// Half of a 95 % interval, standard deviations.
const INTERVAL: f64 = 1.96;

/// The headings of [`cells`].
pub const HEADER: [&str; 7] =
    ["order", "torque / mN·m", "±", "current / A", "phase / °", "ripple of Kt / %", "phase of the ripple / °"];

/// The cells of a line: amplitudes and phases with their 95 % intervals.
#[must_use]
pub fn cells(line: &Line, torque_constant_nm_a: f64) -> Vec<String> {
    let torque = |of: fn(&Wave) -> String| line.torque_nm.as_ref().map_or_else(|| "–".into(), of);
    let ripple = |of: fn(&Wave) -> String| line.ripple.as_ref().map_or_else(|| "–".into(), of);
    let phase = |wave: &Wave| {
        format!("{:.0} ± {:.0}", wave.phase_rad().to_degrees(), wave.phase_interval_rad().to_degrees().min(180.0))
    };
    let current = line.torque_nm.map(|wave| wave.times(1.0 / torque_constant_nm_a).amplitude());
    vec![
        line.order.to_string(),
        torque(|wave| format!("{:.2}", 1e3 * wave.amplitude())),
        torque(|wave| format!("{:.2}", 1e3 * wave.amplitude_interval())),
        current.map_or_else(|| "–".into(), |current| format!("{current:.4}")),
        torque(phase),
        ripple(|wave| format!("{:.2} ± {:.2}", 100.0 * wave.amplitude(), 100.0 * wave.amplitude_interval())),
        ripple(phase),
    ]
}

/// The page: what was found, the map over one turn, and the lines; `change` says what differs from earlier recordings.
#[must_use]
pub fn page(lines: &Lines, lead: &str, change: Option<&str>) -> Page {
    let conclusion = match lines.lines.as_slice() {
        [] => "No line stands out.".to_owned(),
        all => {
            let orders: Vec<String> = all.iter().map(|line| line.order.to_string()).collect();
            format!("The rotor has lines at the orders {}.", orders.join(", "))
        }
    };
    let changed = change.map_or_else(String::new, |change| format!(" Since the earlier recordings: {change}."));
    let rows: Vec<Vec<String>> = lines.lines.iter().map(|line| cells(line, lines.torque_constant_nm_a)).collect();
    Page::new("What turns with the rotor")
        .conclusion(conclusion + &changed)
        .lead(lead)
        .section("Map", &over_a_turn(lines))
        .section("Lines", &(amplitudes(lines) + &table(&HEADER, &rows)))
}

fn over_a_turn(rotor: &Lines) -> String {
    let points = map(rotor, POINTS);
    let degrees = |angle_rad: f64| 360.0 * angle_rad / TAU;
    let line = points.iter().map(|point| (degrees(point.angle_rad), point.current_a));
    let band = points.iter().map(|point| {
        let half = INTERVAL * point.deviation_a;
        (degrees(point.angle_rad), point.current_a - half, point.current_a + half)
    });
    let series = [Series::new("current", Color::of(0), line).with_band(band)];
    or_reason(lines("Current against cogging and unbalance", "angle of the shaft / °", "current / A", &series))
}

fn amplitudes(rotor: &Lines) -> String {
    let waves = || rotor.lines.iter().filter_map(|line| Some((f64::from(line.order), line.torque_nm?)));
    let points = waves().map(|(order, wave)| (order, 1e3 * wave.amplitude()));
    // There is nothing between two orders, so no line joins them.
    let stems = waves().map(|(order, wave)| (order, 0.0, 1e3 * wave.amplitude()));
    let intervals = waves().map(|(order, wave)| {
        let (middle, half) = (1e3 * wave.amplitude(), 1e3 * wave.amplitude_interval());
        (order, middle - half, middle + half)
    });
    let series = [
        Series::intervals("from zero", Color::of(6), stems),
        Series::points("torque", Color::of(0), Marker::Circle, points),
        Series::intervals("95 % interval", Color::of(0), intervals),
    ];
    or_reason(lines("Torque that does not depend on the current", "order", "amplitude / mN·m", &series))
}
