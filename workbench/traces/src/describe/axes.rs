//! Which axis of a recording of several is described: the one that moves.

use std::collections::BTreeMap;

use super::guess::Guess;
use model::statistics::mean_sd;
use model::trace::{bridged, words};

/// Part of the largest motion below which an axis rests.
const RESTS: f64 = 0.05;

/// The columns of the axis that moves and those of no axis, with a sentence that says which one was taken; `None` if
/// there are not several axes.
pub(super) fn of_moving(names: &[String], columns: &[Vec<f64>]) -> Option<(Vec<String>, String)> {
    let mut axes: BTreeMap<u32, Vec<String>> = BTreeMap::new();
    for name in names {
        if let Some(axis) = axis(name) {
            axes.entry(axis).or_default().push(name.clone());
        }
    }
    let deviation = |name: &String| {
        let place = names.iter().position(|own| own == name)?;
        Some(mean_sd(&bridged(columns.get(place)?)).1)
    };
    let moves = |names: &Vec<String>| {
        let guess = Guess::of(names);
        guess.current.as_ref()?;
        deviation(guess.velocity.as_ref().or(guess.angle.as_ref())?)
    };
    let motions: Vec<(u32, f64)> = axes.iter().filter_map(|(axis, names)| Some((*axis, moves(names)?))).collect();
    let largest = motions.iter().map(|(_, deviation)| *deviation).fold(0.0, f64::max);
    let moving: Vec<u32> = motions.iter().filter(|(_, own)| *own > RESTS * largest).map(|(axis, _)| *axis).collect();
    let (taken, others) = moving.split_first().filter(|_| motions.len() > 1)?;
    let kept = names.iter().filter(|name| axis(name).is_none_or(|axis| axis == *taken)).cloned().collect();
    let list: Vec<String> = others.iter().map(ToString::to_string).collect();
    let said = match &list[..] {
        [] => format!("axis {taken} is taken: the others rest"),
        others => format!("axis {taken} is taken; {} move too: which one has the bearing?", others.join(", ")),
    };
    Some((kept, said))
}

/// The number of the axis in the name of a column.
fn axis(name: &str) -> Option<u32> {
    words(name).iter().find_map(|word| word.trim_start_matches(['j', 'm']).parse().ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: &[&str], motions: &[f64]) -> Option<(Vec<String>, String)> {
        let names: Vec<String> = names.iter().map(ToString::to_string).collect();
        let wave = |size: &f64| (0..500).map(|k| size * (0.05 * f64::from(k)).sin()).collect();
        of_moving(&names, &motions.iter().map(wave).collect::<Vec<_>>())
    }

    #[test]
    fn the_axis_that_moves_is_taken() {
        for (names, motions, first) in [
            (&["iq1_A", "vel1", "iq2_A", "vel2", "t_motor"][..], &[1.0, 1e-3, 1.0, 40.0, 0.1][..], "iq2_A"),
            (&["Current_J0", "Speed_J0", "Current_J1", "Speed_J1"], &[1.0, 0.0, 1.0, 3.0], "Current_J1"),
            (
                &["axis3.current", "axis3.position", "axis1.current", "axis1.position"],
                &[1.0, 9.0, 1.0, 0.01],
                "axis3.current",
            ),
        ] {
            let (kept, said) = of(names, motions).expect("several axes");
            assert_eq!(kept[0], first);
            assert!(said.ends_with("the others rest"), "{said}");
        }
        let (kept, said) = of(&["iq1", "vel1", "iq2", "vel2"], &[1.0, 30.0, 1.0, 20.0]).expect("several axes");
        assert_eq!(kept, ["iq1", "vel1"]);
        assert!(said.contains("2 move too: which one has the bearing?"), "{said}");
        assert!(of(&["iq1_A", "vel1", "torque2"], &[1.0; 3]).is_none());
        assert!(of(&["current_a", "velocity_rad_s"], &[1.0; 2]).is_none());
    }
}
