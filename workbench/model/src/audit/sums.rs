//! Three phase currents, whose sum is zero without an earth fault: offsets, gains, levels and half waves.

use super::columns::clipped;
use super::phases;
use crate::statistics::mean_sd;

/// Letters of the phases, and the numbers, which also count axes.
const LETTERS: [[&str; 3]; 4] = [["a", "b", "c"], ["u", "v", "w"], ["r", "s", "t"], ["l1", "l2", "l3"]];
const NUMBERS: [&str; 3] = ["1", "2", "3"];
/// Words that the name of a current begins with, before the letter of its phase.
const WORDS: [&str; 5] = ["i", "current", "strom", "phase", "iphase"];
/// Parts of the currents' deviation that the mean of the sum and its deviation may have.
const OFFSET: f64 = 0.05;
const PART: f64 = 0.1;

/// The places of at least so many of three currents among columns with these names, by names such as `ia_A`, `i_u`,
/// `phase_a_a`.
fn places(names: &[String], phases: &[&str; 3], least: usize) -> Option<Vec<usize>> {
    // The last letter may be a unit behind a name that still tells the phase.
    let plain = |name: &String| {
        let lower = name.to_lowercase();
        let end = lower
            .rfind(['_', '[', '(', ' '])
            .filter(|at| matches!(lower[*at..].trim_matches(['_', '[', ']', '(', ')', ' ']), "a" | "ma"));
        let without = end.map(|at| &lower[..at]).filter(|rest| rest.len() > 1).unwrap_or(&lower);
        [without, &lower].map(|text| text.chars().filter(|c| c.is_alphanumeric()).collect::<String>())
    };
    let names: Vec<[String; 2]> = names.iter().map(plain).collect();
    let place = |wanted: String| {
        let is_so = |form: usize| names.iter().position(|forms| forms[form] == wanted);
        is_so(0).or_else(|| is_so(1))
    };
    WORDS.iter().find_map(|word| {
        let found: Vec<usize> = phases.iter().filter_map(|phase| place(format!("{word}{phase}"))).collect();
        (found.len() >= least).then_some(found)
    })
}

/// The places of two or three phase currents among columns with these names.
#[must_use]
pub fn phase_currents(names: &[String]) -> Vec<usize> {
    LETTERS.iter().find_map(|phases| places(names, phases, 2)).unwrap_or_default()
}

/// What is wrong with the phase currents among these columns; the angle of the shaft, rad, and the rate of the rows, if
/// they are known.
#[must_use]
pub fn findings(names: &[String], columns: &[&[f64]], motion: Option<(&[f64], f64)>) -> Vec<String> {
    let three = |phases: &[&str; 3]| places(names, phases, 3)?.try_into().ok();
    let Some::<[usize; 3]>(places) = LETTERS.iter().chain([&NUMBERS]).find_map(three) else { return vec![] };
    let by_place = places.map(|place| columns[place]);
    let levels = (0..3).filter_map(|own| {
        let [one, other] = [(own + 1) % 3, (own + 2) % 3].map(|k| by_place[k]);
        let others: Vec<f64> = one.iter().zip(other).map(|(one, other)| -(one + other)).collect();
        clipped::told(&names[places[own]], &clipped::levels(by_place[own], &others))
    });
    // A level changes mean and deviation of the sum.
    let levels: Vec<String> = levels.collect();
    if !levels.is_empty() {
        return levels;
    }
    let [a, b, c] = places.map(|place| columns[place]);
    let rows = a.iter().zip(b).zip(c).map(|((a, b), c)| a + b + c).filter(|sum| sum.is_finite());
    let sums: Vec<f64> = rows.collect();
    let size = places.iter().map(|place| mean_sd(columns[*place]).1).fold(0.0, f64::max);
    let (mean, deviation) = mean_sd(&sums);
    let own = places.map(|place| names[place].as_str());
    let names = own.join(", ");
    let mut found = Vec::new();
    if mean.abs() > OFFSET * size {
        let offset = match phases::of_offset([a, b, c], mean, motion) {
            Some(phase) => format!("the current {} has an offset of {mean:.4}", own[phase]),
            None => format!("the currents {names} sum to {mean:.4} in the mean: an offset of a sensor"),
        };
        found.push(offset + "; calibrate the sensor, or remove it");
    }
    if deviation > PART * size {
        let percent = 100.0 * deviation / size;
        found.push(format!(
            "the currents {names} do not sum to zero, by {percent:.0} % of one: gain, sign or a wrong column"
        ));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(names: [&str; 3], change: impl Fn(usize, f64) -> f64) -> Vec<String> {
        let phase = |k: usize| {
            let turn = std::f64::consts::TAU;
            let own = |row: u32| (turn * f64::from(row) / 125.0 + turn * k as f64 / 3.0).sin();
            (0..1000).map(|row| change(k, own(row))).collect()
        };
        let columns: [Vec<f64>; 3] = [0, 1, 2].map(phase);
        findings(&names.map(String::from), &[&columns[0], &columns[1], &columns[2]], None)
    }

    #[test]
    fn offsets_and_gains_of_three_phases_are_told() {
        for names in
            [["ia_A", "ib_A", "ic_A"], ["phase_a_a", "phase_b_a", "phase_c_a"], ["I_U [A]", "I_V [A]", "I_W [A]"]]
        {
            assert_eq!(of(names, |_, x| x), Vec::<String>::new(), "{names:?}");
            let offset = of(names, |k, x| if k == 1 { x + 0.17 } else { x });
            let told = format!("the current {} has an offset of 0.1700", names[1]);
            assert!(offset.len() == 1 && offset[0].starts_with(&told), "{names:?} {offset:?}");
            let clipped = of(names, |k, x| if k == 0 { x.min(0.6) } else { x });
            assert!(clipped.len() == 1 && clipped[0].contains("is clipped at 0.6"), "{clipped:?}");
            let gain = of(names, |k, x| if k == 2 { -x } else { x });
            assert!(gain[0].contains("do not sum to zero, by 200 % of one"), "{gain:?}");
        }
        assert!(of(["iq_A", "id_A", "speed"], |_, x| x).is_empty());
    }
}
