//! ADC counts of the phase currents → amperes.
//!
//! ```text
//! i = gain · (counts − offset)                                          (1)
//! ```
//!
//! Counts outside the usable range are *saturated*. A converter that has the same counts in all samples of a window is
//! *stuck*, at the latest after two windows, until it has moved in a later one. The current is then NaN, which the
//! Park transform and the decimators pass on and the detector refuses. Earlier samples were used; the window must
//! therefore be long enough for a working converter to change in it, and short against a segment.

use crate::signal::Abc;

/// A phase of the motor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Phase {
    /// Phase a.
    A,
    /// Phase b.
    B,
    /// Phase c.
    C,
}

impl Phase {
    /// All phases, in the order of arrays with one element a phase.
    pub const ALL: [Self; 3] = [Self::A, Self::B, Self::C];
}

/// Converter counts of the phase currents at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum PhaseCounts {
    /// No counts: the quadrature current of the drive's own control, A, NaN if it is missing. Nothing checks its
    /// sensors.
    Quadrature(f32),
    /// Phases a and b, or b and c, or c and a, with the electrical offset of the first one; the third current is minus
    /// their sum, and nothing checks the sensors against each other.
    Two([u16; 2]),
    /// Phases a, b and c.
    Three([u16; 3]),
}

impl PhaseCounts {
    /// The counts of the sensors that there are.
    #[inline]
    #[must_use]
    pub const fn as_slice(&self) -> &[u16] {
        match self {
            Self::Quadrature(_) => &[],
            Self::Two(counts) => counts,
            Self::Three(counts) => counts,
        }
    }
}

/// One current sensor with its converter.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseSensor {
    /// Counts at no current; see [`OffsetCalibration`](super::OffsetCalibration).
    pub offset_counts: f32,
    /// Amperes a count; negative if the sensor counts against the direction into the motor.
    pub gain_a: f32,
    /// Lowest and highest usable count; beyond them sensor or converter is saturated.
    pub usable: [u16; 2],
}

impl PhaseSensor {
    /// The current (1), A; NaN if the counts are outside the usable range.
    #[inline]
    #[must_use]
    pub fn amperes(&self, counts: u16) -> f32 {
        if self.is_usable(counts) { self.plain_amperes(counts) } else { f32::NAN }
    }

    /// (1)
    #[inline(always)]
    fn plain_amperes(&self, counts: u16) -> f32 {
        self.gain_a * (f32::from(counts) - self.offset_counts)
    }

    /// One comparison: counts below the lowest wrap to large ones.
    #[inline(always)]
    fn is_usable(&self, counts: u16) -> bool {
        let [lowest, highest] = self.usable.map(u32::from);
        u32::from(counts).wrapping_sub(lowest) <= highest.wrapping_sub(lowest)
    }

    /// Whether the constants are finite and some counts usable.
    pub(super) fn is_valid(&self) -> bool {
        let [lowest, highest] = self.usable;
        let offset = self.offset_counts >= 0.0 && self.offset_counts <= f32::from(u16::MAX);
        let gain = self.gain_a.abs() >= f32::MIN_POSITIVE && self.gain_a.abs() <= 1e6;
        offset && gain && lowest < highest
    }
}

/// Refused samples of one phase, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct PhaseFaults {
    /// Counts outside the usable range.
    pub saturated: u32,
    /// Counts that repeated too often.
    pub stuck: u32,
}

/// Whether converters have moved: the counts at the start of a window, and all bits that differed from them since. Two
/// words hold three counts: a comparison of each would cost as much as the conversion.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Window {
    first: [u32; 2],
    moved: [u32; 2],
    /// Samples left.
    left: u32,
    stuck: [bool; 3],
    any_stuck: bool,
}

/// Counts of phases a and b, and of c, in two words.
#[inline(always)]
const fn packed(a: u16, b: u16, c: u16) -> [u32; 2] {
    [a as u32 | (b as u32) << 16, c as u32]
}

/// The current sensors of a motor: (1), saturation and stuck converters.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CurrentSensors {
    sensors: [PhaseSensor; 3],
    stuck_samples: u16,
    window: Window,
    faults: [PhaseFaults; 3],
}

impl CurrentSensors {
    /// Sensors of phases a, b, c; with two sensors the third is not used. `stuck_samples` is the number of samples, at
    /// least 2, over which a working converter does not repeat one value; 0 if a quiet one may do so for ever.
    #[must_use]
    pub const fn new(sensors: [PhaseSensor; 3], stuck_samples: u16) -> Self {
        // The first sample starts the first window.
        let window = Window { first: [0; 2], moved: [u32::MAX; 2], left: 1, stuck: [false; 3], any_stuck: false };
        Self { sensors, stuck_samples, window, faults: [PhaseFaults { saturated: 0, stuck: 0 }; 3] }
    }

    /// Phase currents, A; NaN where saturated or stuck. With two sensors the third current is minus the sum.
    #[inline(always)]
    pub fn convert(&mut self, counts: &PhaseCounts) -> Abc {
        let [first, second, third] = &self.sensors;
        let (currents, usable, words) = match *counts {
            PhaseCounts::Quadrature(_) => return Abc { a: f32::NAN, b: f32::NAN, c: f32::NAN },
            PhaseCounts::Two([a, b]) => {
                let usable = first.is_usable(a) & second.is_usable(b);
                let words = packed(a, b, 0);
                let (a, b) = (first.plain_amperes(a), second.plain_amperes(b));
                (Abc { a, b, c: -(a + b) }, usable, words)
            }
            PhaseCounts::Three([a, b, c]) => {
                let usable = first.is_usable(a) & second.is_usable(b) & third.is_usable(c);
                let words = packed(a, b, c);
                let [a, b, c] = [first.plain_amperes(a), second.plain_amperes(b), third.plain_amperes(c)];
                (Abc { a, b, c }, usable, words)
            }
        };
        let (Window { first: [ab, c], moved: [moved_ab, moved_c], left, .. }, [now_ab, now_c]) =
            (&mut self.window, words);
        *moved_ab |= now_ab ^ *ab;
        *moved_c |= now_c ^ *c;
        *left = left.wrapping_sub(1);
        if *left == 0 {
            self.close(counts, words);
        }
        if usable && !self.window.any_stuck {
            return currents;
        }
        self.refuse(counts)
    }

    /// A converter that has not moved is stuck until it has in a later window.
    #[cold]
    #[inline(never)]
    fn close(&mut self, counts: &PhaseCounts, words: [u32; 2]) {
        let [ab, c] = self.window.moved;
        let still = [ab & 0xffff == 0, ab >> 16 == 0, c == 0 && matches!(counts, PhaseCounts::Three(_))];
        let stuck = still.map(|still| still && self.stuck_samples > 0);
        let any_stuck = stuck.contains(&true);
        self.window = Window { first: words, moved: [0; 2], left: u32::from(self.stuck_samples), stuck, any_stuck };
    }

    /// Counts what is refused, and makes it NaN.
    #[cold]
    #[inline(never)]
    fn refuse(&mut self, counts: &PhaseCounts) -> Abc {
        let mut currents = [f32::NAN; 3];
        let phases = self.sensors.iter().zip(self.window.stuck).zip(&mut self.faults);
        for ((counts, current), ((sensor, stuck), faults)) in counts.as_slice().iter().zip(&mut currents).zip(phases) {
            *current = if stuck { f32::NAN } else { sensor.amperes(*counts) };
            if !sensor.is_usable(*counts) {
                faults.saturated = faults.saturated.saturating_add(1);
            } else if stuck {
                faults.stuck = faults.stuck.saturating_add(1);
            }
        }
        let [a, b, c] = currents;
        if matches!(counts, PhaseCounts::Two(_)) { Abc { a, b, c: -(a + b) } } else { Abc { a, b, c } }
    }

    /// Subtracts so many amperes from the currents of the phases from now on.
    pub(super) fn shift(&mut self, amperes: [f32; 3]) {
        for (sensor, amperes) in self.sensors.iter_mut().zip(amperes) {
            sensor.offset_counts += amperes / sensor.gain_a;
        }
    }

    /// Whether a converter is stuck now. Samples of the window before were used.
    #[must_use]
    pub const fn any_stuck(&self) -> bool {
        self.window.any_stuck
    }

    /// What was refused since the start or [`Self::clear_faults`], of phases a, b, c.
    #[must_use]
    pub const fn faults(&self) -> [PhaseFaults; 3] {
        self.faults
    }

    /// Counts from zero.
    pub fn clear_faults(&mut self) {
        self.faults = [PhaseFaults::default(); 3];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 2050.5, gain_a: -0.02, usable: [10, 4085] };

    #[test]
    fn counts_become_amperes_within_one_rounding() {
        for counts in 10..=4085_u16 {
            let exact = -0.02_f64 * (f64::from(counts) - 2050.5);
            // Three roundings of a value up to 41 A.
            assert!((f64::from(SENSOR.amperes(counts)) - exact).abs() < 1e-5, "{counts}");
        }
        assert!([0, 9, 4086, 65_535].iter().all(|counts| SENSOR.amperes(*counts).is_nan()));
    }

    #[test]
    fn a_saturated_phase_is_missing_alone_and_named() {
        let mut sensors = CurrentSensors::new([SENSOR; 3], 0);
        let currents = sensors.convert(&PhaseCounts::Three([2000, 4090, 2100]));
        assert!(currents.b.is_nan() && currents.a.is_finite() && currents.c.is_finite());
        assert!(sensors.convert(&PhaseCounts::Two([3, 2100])).clarke().beta.is_nan(), "β needs both");
        let clear = PhaseFaults::default();
        let once = PhaseFaults { saturated: 1, stuck: 0 };
        assert_eq!(sensors.faults(), [once, once, clear]);
        sensors.clear_faults();
        assert_eq!(sensors.faults(), [clear; 3]);
    }

    #[test]
    fn a_converter_is_stuck_after_a_window_without_movement_until_one_with() {
        let mut sensors = CurrentSensors::new([SENSOR; 3], 10);
        let stuck: std::vec::Vec<bool> = (0..100_u16)
            .map(|k| {
                let a = if (15..52).contains(&k) { 2000 } else { 2000 + k % 2 };
                sensors.convert(&PhaseCounts::Three([a, 2000 + k % 7, 2100 - k])).a.is_nan()
            })
            .collect();
        // Windows close at samples 0, 10, 20 …: 21 … 30 is the first one without movement, 51 … 60 the first one with.
        let expected: std::vec::Vec<bool> = (0..100).map(|k| (30..60).contains(&k)).collect();
        assert_eq!(stuck, expected);
        assert_eq!(sensors.faults()[0], PhaseFaults { saturated: 0, stuck: 30 });
        assert_eq!(sensors.faults()[1..], [PhaseFaults::default(); 2]);
    }

    #[test]
    fn all_converters_may_stick_and_quiet_ones_may_be_allowed() {
        let lost = |stuck_samples, counts| {
            let mut sensors = CurrentSensors::new([SENSOR; 3], stuck_samples);
            (0..1000).filter(|_| sensors.convert(&counts).b.is_nan()).count()
        };
        for counts in [PhaseCounts::Two([2050; 2]), PhaseCounts::Three([2050; 3])] {
            assert_eq!([lost(50, counts), lost(0, counts)], [950, 0]);
        }
    }

    #[test]
    fn the_third_of_two_currents_is_minus_the_sum() {
        let currents = CurrentSensors::new([SENSOR; 3], 0).convert(&PhaseCounts::Two([2000, 2100]));
        assert!(currents.a > 0.9 && currents.b < -0.9, "{currents:?}");
        assert_eq!(currents.c, -(currents.a + currents.b));
    }
}
