//! Three phase currents, whose sum is zero without an earth fault: offsets and gains.

use crate::statistics::mean_sd;

/// Letters of the phases.
const PHASES: [[&str; 3]; 3] = [["a", "b", "c"], ["u", "v", "w"], ["1", "2", "3"]];
/// Words that the name of a current begins with, before or behind the letter of its phase.
const WORDS: [&str; 4] = ["i", "current", "phase", "iphase"];
/// Part of the currents' deviation that the sum may have.
const PART: f64 = 0.1;

/// The places of the three currents among columns with these names, by names such as `ia_A`, `i_u`, `phase_a_a`.
fn phases(names: &[String]) -> Option<[usize; 3]> {
    let bare = |name: &String| -> String {
        let lower = name.to_lowercase();
        let end = lower
            .rfind(['_', '[', '(', ' '])
            .filter(|at| matches!(lower[*at..].trim_matches(['_', '[', ']', '(', ')', ' ']), "a" | "ma"));
        // A unit behind a name that still tells the phase.
        let without = end.map(|at| &lower[..at]).filter(|rest| rest.len() > 1).unwrap_or(&lower);
        without.chars().filter(|c| c.is_alphanumeric()).collect()
    };
    let names: Vec<String> = names.iter().map(bare).collect();
    let place = |wanted: String| names.iter().position(|name| *name == wanted);
    PHASES.iter().find_map(|letters| {
        WORDS.iter().find_map(|word| {
            let [a, b, c] = letters.map(|letter| place(format!("{word}{letter}")));
            Some([a?, b?, c?])
        })
    })
}

/// What is wrong with the sum of the phase currents among these columns.
#[must_use]
pub fn findings(names: &[String], columns: &[&[f64]]) -> Vec<String> {
    let Some(places) = phases(names) else { return vec![] };
    let [a, b, c] = places.map(|place| columns[place]);
    let rows = a.iter().zip(b).zip(c).map(|((a, b), c)| a + b + c).filter(|sum| sum.is_finite());
    let sums: Vec<f64> = rows.collect();
    let size = places.iter().map(|place| mean_sd(columns[*place]).1).fold(0.0, f64::max);
    let (mean, deviation) = mean_sd(&sums);
    let names = places.map(|place| names[place].as_str()).join(", ");
    let mut found = Vec::new();
    if mean.abs() > PART * size {
        found.push(format!("the currents {names} sum to {mean:.4} in the mean: an offset of a sensor; remove it"));
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
        findings(&names.map(String::from), &[&columns[0], &columns[1], &columns[2]])
    }

    #[test]
    fn offsets_and_gains_of_three_phases_are_told() {
        for names in
            [["ia_A", "ib_A", "ic_A"], ["phase_a_a", "phase_b_a", "phase_c_a"], ["I_U [A]", "I_V [A]", "I_W [A]"]]
        {
            assert_eq!(of(names, |_, x| x), Vec::<String>::new(), "{names:?}");
            let offset = of(names, |k, x| if k == 1 { x + 0.17 } else { x });
            assert!(offset.len() == 1 && offset[0].contains("sum to 0.1700 in the mean"), "{names:?} {offset:?}");
            let gain = of(names, |k, x| if k == 2 { -x } else { x });
            assert!(gain[0].contains("do not sum to zero, by 200 % of one"), "{gain:?}");
        }
        assert!(of(["iq_A", "id_A", "speed"], |_, x| x).is_empty());
    }
}
