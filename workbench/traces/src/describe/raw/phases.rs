//! Offsets and steps of the current sensors, found in the columns of the currents.

use std::collections::BTreeSet;

use super::position::are_counts;

/// A converter counts as stuck after this many times the longest repetition of the recordings, and after
/// [`LEAST_STUCK`] samples at least.
const REPETITIONS: usize = 20;
const LEAST_STUCK: usize = 200;
/// Time of a window of the balance of the currents, s.
const WINDOW_S: f64 = 0.04;
/// Largest offset that is removed, in deviations of the noise and as a part of the largest current.
const OFFSET_NOISES: f64 = 6.0;
const OFFSET_PART: f64 = 0.01;
/// Bits of a converter that currents in amperes are rounded by, if the recording has no steps.
const BITS: u32 = 16;

/// What the currents of all recordings have in common, by each of them.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::describe) struct Extremes {
    largest: f64,
    longest: usize,
}

impl Extremes {
    /// With those of a recording.
    pub(in crate::describe) fn with(self, columns: &[&[f64]]) -> Self {
        let values = columns.iter().flat_map(|column| known(column));
        let longest = columns.iter().map(|column| longest_repetition(column)).max().unwrap_or(0);
        Self {
            largest: values.fold(self.largest, |most, value| most.max(value.abs())),
            longest: longest.max(self.longest),
        }
    }
}

/// The currents.
#[derive(Debug)]
pub(super) struct Phases {
    /// Amperes, or counts less the offset if the amperes of a count are not known.
    pub(super) amperes: Vec<Vec<f64>>,
    are_counts: bool,
    offsets: Vec<f64>,
    gain_a: f64,
    bits: u32,
    /// Largest current of the recordings, A, or counts.
    largest: f64,
    window: usize,
    stuck: usize,
    /// Whether amperes have no steps: the converter is not that of the drive.
    is_smooth: bool,
}

impl Phases {
    /// Of two or three columns.
    pub(super) fn of(columns: &[&[f64]], rate_hz: f64, others: Extremes) -> Self {
        let are_counts = columns.iter().all(|column| are_counts(column));
        let means: Vec<f64> = columns.iter().map(|column| mean(column)).collect();
        let Extremes { largest, longest } = others.with(columns);
        let step = columns.iter().filter_map(|column| step(column)).fold(f64::INFINITY, f64::min);
        let is_smooth = !are_counts && (!step.is_finite() || largest / step > f64::from(1_u32 << (BITS - 1)));
        let (offsets, gain_a, bits) = if are_counts {
            // A converter of counts with a sign has its zero in the middle.
            (means.clone(), 1.0, bits_of(largest))
        } else if is_smooth {
            // Twice the largest current of the recordings.
            let half = f64::from(1_u32 << (BITS - 1));
            (vec![half; columns.len()], 2.0 * largest / half, BITS)
        } else {
            let bits = bits_of(4.0 * largest / step).clamp(8, BITS);
            (vec![f64::from(1_u32 << (bits - 1)); columns.len()], step, bits)
        };
        let without_offset = |(column, offset): (&&[f64], &f64)| -> Vec<f64> {
            column.iter().map(|value| if are_counts { value - offset } else { *value }).collect()
        };
        let amperes: Vec<Vec<f64>> = columns.iter().zip(&offsets).map(without_offset).collect();
        let largest = if are_counts { amperes.iter().map(|own| largest_of(own)).fold(0.0, f64::max) } else { largest };
        let stuck = (REPETITIONS * longest).max(LEAST_STUCK);
        Self {
            amperes,
            are_counts,
            offsets,
            gain_a,
            bits,
            largest,
            window: ((WINDOW_S * rate_hz).round() as usize).clamp(50, 4000),
            stuck: if stuck > usize::from(u16::MAX) / 2 { 0 } else { stuck },
            is_smooth,
        }
    }

    /// Moves the offsets by so much, in amperes as above; those of recorded amperes stay.
    pub(super) fn shift(&mut self, by: &[f64]) {
        if !self.are_counts {
            return;
        }
        for ((own, offset), by) in self.amperes.iter_mut().zip(&mut self.offsets).zip(by) {
            *offset += by;
            own.iter_mut().for_each(|value| *value -= by);
        }
    }

    /// The section of the file, and the one of the balance, with the noise of the sum of three currents.
    pub(super) fn lines(&self, names: &[String], first: usize, noise: f64) -> Vec<String> {
        // Three converters that round.
        let noise = noise.max(self.gain_a * 0.25_f64.sqrt());
        let offset = (OFFSET_NOISES * noise).max(OFFSET_PART * self.largest);
        let list = |value: &dyn Fn(usize) -> String| (0..names.len()).map(value).collect::<Vec<_>>().join(", ");
        let highest = (1_u64 << self.bits) - 17;
        let unknown = if self.are_counts { "  # set: amperes a count, by the data sheet; one here" } else { "" };
        let mut lines = vec![format!("columns = [{}]", names.join(", "))];
        if names.len() == 2 {
            lines.push(format!("phases = \"{}\"", ["ab", "bc", "ca"][first]));
        }
        lines.extend([
            format!("quantity = \"{}\"", if self.are_counts { "counts" } else { "amperes" }),
            format!("offset_counts = [{}]", list(&|k| format!("{:.2}", self.offsets[k]))),
            format!("gain_a = [{}]{unknown}", list(&|_| format!("{:.6e}", self.gain_a))),
            format!("usable_counts = [16, {}]  # of {} bits", highest.min(65_519), self.bits),
            format!("stuck_samples = {}  # no converter of the recording repeats itself so long", self.stuck),
            "\n[balance]".into(),
            // In counts it stays right when the gain is set.
            format!("noise_counts = {:.4}  # of the sum of the currents", noise / self.gain_a),
            format!(
                "offset_counts = {:.4}  # of a sensor that ages or is warm: removed up to this size",
                offset / self.gain_a
            ),
            "gain_tolerance = 0.02".into(),
            format!("window = {}", self.window),
        ]);
        lines
    }

    /// What is not known.
    pub(super) fn said(&self) -> Vec<String> {
        let mut said = Vec::new();
        if self.are_counts {
            said.push("the amperes of a count are not in the recording: gain_a is 1 until you set it".into());
        }
        if self.is_smooth {
            said.push(format!("the currents have no steps of a converter: one of {BITS} bits is assumed"));
        }
        said
    }
}

fn largest_of(column: &[f64]) -> f64 {
    known(column).fold(0.0, |most, value| most.max(value.abs()))
}

pub(super) fn mean(column: &[f64]) -> f64 {
    let (sum, count) = known(column).fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    sum / count.max(1) as f64
}

fn known(column: &[f64]) -> impl Iterator<Item = f64> {
    column.iter().copied().filter(|value| value.is_finite())
}

/// Bits of a converter that reaches so many counts.
fn bits_of(counts: f64) -> u32 {
    (counts.max(1.0) + 1.0).log2().ceil() as u32
}

/// The step of which all values are multiples, within the digits of a text.
fn step(column: &[f64]) -> Option<f64> {
    let values: BTreeSet<i64> = known(column).take(20_000).map(|value| (value * 1e9).round() as i64).collect();
    let values: Vec<i64> = values.into_iter().collect();
    let least = values.windows(2).map(|pair| pair[1] - pair[0]).filter(|gap| *gap > 1000).min()? as f64;
    let off = |gap: f64| (gap / least - (gap / least).round()).abs() * least;
    // Rounded digits leave a part of a step.
    let fits = values.windows(2).filter(|pair| off((pair[1] - pair[0]) as f64) < 0.05 * least + 1000.0).count();
    (fits * 10 > values.len() * 9).then_some(1e-9 * least)
}

fn longest_repetition(column: &[f64]) -> usize {
    let (mut longest, mut length) = (0, 0);
    for pair in column.windows(2) {
        length = if pair[0] == pair[1] { length + 1 } else { 0 };
        longest = longest.max(length);
    }
    longest
}
