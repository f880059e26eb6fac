//! Which columns are the phases and the position, by names and values.

use std::collections::BTreeMap;

use model::trace::words;

use super::phases::mean;

/// Places of the columns.
#[derive(Debug, PartialEq)]
pub(super) struct Signals {
    /// Two or three phases in their order.
    pub(super) phases: Vec<usize>,
    /// Of two phases, which they are: the place of the first one among a, b and c.
    pub(super) first: usize,
    /// One column, or sine and cosine.
    pub(super) position: Vec<usize>,
}

/// Names of the phases.
const PHASES: [[&str; 3]; 5] = [["a", "b", "c"], ["u", "v", "w"], ["1", "2", "3"], ["r", "s", "t"], ["0", "1", "2"]];
/// Parts of names of currents, the most telling first.
const CURRENT: [&str; 8] = ["phase", "current", "i", "adc", "cur", "iphase", "strom", "counts"];
/// Parts of names of a position, the most telling first.
const POSITION: [&str; 9] = ["resolver", "encoder", "enc", "position", "pos", "angle", "theta", "winkel", "counter"];
/// Parts of names of what is no measured position of the shaft.
const OTHER: [&str; 10] = ["velocity", "vel", "speed", "ref", "electrical", "elec", "command", "cmd", "err", "error"];

impl Signals {
    /// # Errors
    /// Which of them there is not.
    pub(super) fn of(names: &[String], columns: &[Vec<f64>]) -> Result<Self, String> {
        let phases = phases(names, columns).ok_or_else(|| {
            let listed = names.join(", ");
            format!("no columns of two or three phase currents, such as phase_a, phase_b, phase_c, among {listed}")
        })?;
        let free: Vec<usize> = (0..names.len()).filter(|place| !phases.0.contains(place)).collect();
        let position =
            position(names, &free).ok_or("no column of the position: counts, an angle, or sine and cosine")?;
        let (phases, first) = phases;
        Ok(Self { phases, first, position })
    }
}

/// Columns in the order of their phases, and the place of the first phase.
type Columns = (Vec<usize>, usize);

/// Of all names that differ in the name of the phase only, those that are most like currents: three before two.
fn phases(names: &[String], columns: &[Vec<f64>]) -> Option<Columns> {
    let mut best: Option<((usize, usize), Columns)> = None;
    for list in PHASES {
        // The rest of a name, with the places of the phases that have it.
        let mut rests: BTreeMap<String, [Option<usize>; 3]> = BTreeMap::new();
        for (place, name) in names.iter().enumerate() {
            for (rest, phase) in without_phase(name, &list) {
                rests.entry(rest).or_default()[phase].get_or_insert(place);
            }
        }
        for (rest, places) in rests {
            // Of c and a, c comes first: each phase is a third of a turn behind the one before.
            let (order, first) = match places {
                [Some(_), None, Some(_)] => ([2, 0, 1], 2),
                [None, ..] => ([1, 2, 0], 1),
                _ => ([0, 1, 2], 0),
            };
            let ordered: Vec<usize> = order.iter().filter_map(|k| places[*k]).collect();
            let alternate = ordered.iter().all(|place| alternates(&columns[*place]));
            let rank = rank(&rest, &CURRENT).filter(|_| alternate && ordered.len() > 1);
            let Some(rank) = rank else { continue };
            let key = (3 - ordered.len(), rank);
            if best.as_ref().is_none_or(|(other, _)| key < *other) {
                best = Some((key, (ordered, first)));
            }
        }
    }
    best.map(|(_, columns)| columns)
}

/// The rest of a name without the word, or the last letter of a word, that is a phase.
fn without_phase(name: &str, list: &[&str; 3]) -> Vec<(String, usize)> {
    let words = words(name);
    let mut rests = Vec::new();
    for (k, word) in words.iter().enumerate() {
        let phase = list.iter().position(|phase| word == phase || (word.len() > 1 && word.ends_with(phase)));
        let Some(phase) = phase else { continue };
        let stem = &word[..word.len() - list[phase].len()];
        // `ia` and `phase_a`, but not `alpha` for the phase a.
        if stem.is_empty() || CURRENT.contains(&stem) {
            let rest = words.iter().enumerate().map(|(j, other)| if j == k { stem } else { other.as_str() });
            rests.push((rest.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" "), phase));
        }
    }
    rests
}

/// Whether a column changes its sign around its mean.
fn alternates(column: &[f64]) -> bool {
    let known: Vec<f64> = column.iter().copied().filter(|value| value.is_finite()).collect();
    let mean = mean(column);
    let above = known.iter().filter(|value| **value > mean).count();
    above > known.len() / 20 && above < known.len() - known.len() / 20
}

/// The position, or sine and cosine.
fn position(names: &[String], free: &[usize]) -> Option<Vec<usize>> {
    let has = |place: usize, part: &str| words(&names[place]).iter().any(|word| word == part);
    let with = |part: &str| free.iter().copied().find(|place| has(*place, part));
    if let (Some(sin), Some(cos)) = (with("sin").or(with("sine")), with("cos").or(with("cosine"))) {
        return Some(vec![sin, cos]);
    }
    let fits = |place: &usize| !OTHER.iter().any(|part| has(*place, part));
    let ranked = free.iter().copied().filter(fits).filter_map(|place| Some((rank(&names[place], &POSITION)?, place)));
    ranked.min().map(|(_, place)| vec![place])
}

/// The rank of the most telling part.
fn rank(name: &str, parts: &[&str]) -> Option<usize> {
    let words = words(name);
    parts.iter().position(|part| words.iter().any(|word| word == part || (part.len() > 3 && word.contains(part))))
}
