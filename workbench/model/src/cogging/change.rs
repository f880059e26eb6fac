//! What has changed between two sets of lines: nothing, the unbalance, or the angle of the rotor.
//!
//! ```text
//! χ²(δ) = Σ |C′_k − C_k e^(−jkδ)|²/v_k,   v_k = σ_k² + σ′_k² + (t|C_k|)²                              (1)
//! ```
//!
//! The measured angle is δ more than before if a resolver or its magnet has slipped. (1) is least for the slip that
//! explains the lines best: steps of 1/1024 turn, each peak by Newton's method. If the lines are of
//! orders with a common factor, several slips explain them, and the smallest of those is returned. Each of three
//! explanations is accepted if its χ² is below the quantile of its degrees of freedom (Wilson and Hilferty, 1931):
//!
//! ```text
//! nothing      χ²(0), 2L degrees of freedom
//! slip         χ²(δ), 2L − 1
//! unbalance    χ²(0) without order 1, 2L − 2, and order 1 has grown
//! ```
//!
//! t is how much a line differs between motions for other reasons: delays, torque that depends on the temperature.

use std::f32::consts::TAU;
use std::iter::zip;

use bearing_watch::Angle;

/// Steps of δ in a turn: an order of 128 turns by an eighth of its period in one.
const STEPS: u16 = 1024;
/// Lines that are compared at most.
const LINES: usize = 16;
/// Steps of Newton's method.
const NEWTON: u8 = 4;
/// Half of the difference of χ² within which the smaller of two slips is taken.
const ALIKE: f32 = 2.0;

/// The line `a cos kθ + b sin kθ`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RotorLine {
    /// k, periods a turn.
    pub order: u16,
    /// a.
    pub cosine_a: f32,
    /// b.
    pub sine_a: f32,
    /// Standard deviation of a, and of b.
    pub deviation_a: f32,
}

impl RotorLine {
    /// The amplitude √(a² + b²).
    #[must_use]
    pub fn amplitude_a(&self) -> f32 {
        self.power().sqrt()
    }

    /// a² + b².
    fn power(&self) -> f32 {
        self.cosine_a * self.cosine_a + self.sine_a * self.sine_a
    }
}

/// When a change is named.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorLimits {
    /// Quantile of the normal distribution at the rate of false names: 3.09 for one in a thousand.
    pub quantile: f32,
    /// t of (1).
    pub tolerance: f32,
}

impl RotorLimits {
    /// One false name in a thousand comparisons, and lines that repeat to a twentieth.
    pub const USUAL: Self = Self { quantile: 3.09, tolerance: 0.05 };
}

/// What has changed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum RotorChange {
    /// The lines are those of before.
    Unchanged,
    /// Order 1 has grown: unbalance.
    Unbalance {
        /// Amplitude of order 1 before.
        before_a: f32,
        /// Its amplitude now.
        now_a: f32,
    },
    /// All lines have turned by one angle: magnet or resolver has slipped on the shaft.
    Slipped {
        /// δ of (1), from −π to π.
        angle_rad: f32,
        /// Standard deviation of it.
        deviation_rad: f32,
    },
    /// Lines have changed in another way.
    Other {
        /// The order that has changed most.
        order: u16,
    },
}

/// A line of before and now, as a term of (1).
#[derive(Clone, Copy, Debug)]
struct Term {
    order: u16,
    /// `C′_k conj(C_k)/v_k`.
    product: [f32; 2],
    /// `|C′_k − C_k|²/v_k`.
    distance: f32,
    /// `(|C′_k|² + |C_k|²)/v_k`.
    power: f32,
}

impl Term {
    const NONE: Self = Self { order: 0, product: [0.0; 2], distance: 0.0, power: 0.0 };

    fn of(before: &RotorLine, now: &RotorLine, tolerance: f32) -> Self {
        let square = |x: f32| x * x;
        let noise = square(before.deviation_a) + square(now.deviation_a);
        let variance = (noise + square(tolerance) * before.power()).max(f32::MIN_POSITIVE);
        // C = a − jb.
        let real = now.cosine_a * before.cosine_a + now.sine_a * before.sine_a;
        let imaginary = now.cosine_a * before.sine_a - now.sine_a * before.cosine_a;
        let distance = square(now.cosine_a - before.cosine_a) + square(now.sine_a - before.sine_a);
        Self {
            order: before.order,
            product: [real / variance, imaginary / variance],
            distance: distance / variance,
            power: (now.power() + before.power()) / variance,
        }
    }

    /// `e^(jkδ)`.
    fn phasor(&self, slip: Angle) -> [f32; 2] {
        let phase = slip.times(u32::from(self.order)).sin_cos();
        [phase.cos, phase.sin]
    }
}

/// The product of two complex numbers.
fn times([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    [a * c - b * d, a * d + b * c]
}

/// The terms of all lines, and their number.
struct Terms {
    list: [Term; LINES],
    lines: u8,
}

impl Terms {
    fn of(before: &[RotorLine], now: &[RotorLine], tolerance: f32) -> Self {
        let mut terms = Self { list: [Term::NONE; LINES], lines: 0 };
        let both = zip(before, now).filter(|(before, now)| before.order == now.order);
        for (term, (before, now)) in zip(&mut terms.list, both) {
            *term = Term::of(before, now, tolerance);
            terms.lines = terms.lines.saturating_add(1);
        }
        terms
    }

    fn used(&self) -> &[Term] {
        self.list.get(..usize::from(self.lines)).unwrap_or(&[])
    }

    fn sum(&self, of: impl Fn(&Term) -> f32) -> f32 {
        self.used().iter().fold(0.0, |sum, term| sum + of(term))
    }

    /// The order of the greatest distance.
    fn changed_most(&self) -> u16 {
        let most =
            self.used().iter().fold(&Term::NONE, |most, term| if term.distance > most.distance { term } else { most });
        most.order
    }

    /// The slip of the greatest likeness; of those that are alike, the smallest.
    fn searched(&self) -> Slip {
        let mut best = self.refined(Angle::ZERO);
        let one = Angle::from_counts(1, 10);
        let steps = self.list.map(|term| term.phasor(one));
        let mut turned = self.list.map(|term| term.product);
        let [mut older, mut old] = [f32::INFINITY; 2];
        let mut step = 0_u16;
        // Two steps more than a turn, so that a peak at its end is between two others.
        while step < STEPS.saturating_add(2) {
            let likeness = turned.iter().take(self.used().len()).fold(0.0, |sum, [real, _]| sum + real);
            if old > older && old >= likeness {
                let peak = self.refined(Angle::from_counts(u32::from(step.wrapping_sub(1)), 10));
                let is_smaller = peak.angle.radians().abs() < best.angle.radians().abs();
                let more = if is_smaller { -ALIKE } else { ALIKE };
                if peak.likeness > best.likeness + more {
                    best = peak;
                }
            }
            (older, old) = (old, likeness);
            for ((product, step), _) in zip(zip(&mut turned, &steps), self.used()) {
                *product = times(*product, *step);
            }
            step = step.saturating_add(1);
        }
        best
    }

    /// The peak next to an angle.
    fn refined(&self, from: Angle) -> Slip {
        let at = |angle: Angle| {
            self.used().iter().fold([0.0; 3], |[likeness, slope, information], term| {
                let ([real, imaginary], k) = (times(term.product, term.phasor(angle)), f32::from(term.order));
                [likeness + real, slope - k * imaginary, information + k * k * real]
            })
        };
        let mut angle = from;
        let mut left = NEWTON;
        while left > 0 {
            let [_, slope, information] = at(angle);
            // Off a peak the curvature has the other sign; a step is at most one of the search.
            let step = if information > 0.0 { slope / information } else { 0.0 };
            let most = TAU / f32::from(STEPS);
            angle = angle.plus(Angle::from_radians(step.clamp(-most, most)));
            left = left.wrapping_sub(1);
        }
        let [likeness, _, information] = at(angle);
        Slip { angle, likeness, information }
    }
}

/// A slip and the sum of the real parts of its terms; χ² is their power less twice of it.
#[derive(Clone, Copy, Debug)]
struct Slip {
    angle: Angle,
    likeness: f32,
    /// −d²/dδ² of the likeness: one over the variance of δ.
    information: f32,
}

impl RotorChange {
    /// Compares up to 16 lines with those of before, in the same order; pairs of different orders are left out.
    #[must_use]
    pub fn between(before: &[RotorLine], now: &[RotorLine], limits: &RotorLimits) -> Self {
        let terms = Terms::of(before, now, limits.tolerance);
        let degrees = 2.0 * f32::from(terms.lines);
        let accepted = |distance: f32, fewer: f32| distance <= quantile(degrees - fewer, limits.quantile);
        // False for NaN: such lines have changed.
        if accepted(terms.sum(|term| term.distance), 0.0) {
            return Self::Unchanged;
        }
        let grown = zip(before, now).find(|(before, now)| before.order == 1 && now.power() > before.power());
        let others = terms.sum(|term| if term.order == 1 { 0.0 } else { term.distance });
        let slip = terms.searched();
        let left = terms.sum(|term| term.power) - 2.0 * slip.likeness;
        let is_slip = accepted(left, 1.0);
        match grown {
            Some((before, now)) if accepted(others, 2.0) && (!is_slip || others < left) => {
                Self::Unbalance { before_a: before.amplitude_a(), now_a: now.amplitude_a() }
            }
            _ if is_slip => Self::Slipped {
                angle_rad: slip.angle.radians(),
                deviation_rad: 1.0 / slip.information.max(f32::MIN_POSITIVE).sqrt(),
            },
            _ => Self::Other { order: terms.changed_most() },
        }
    }
}

/// The quantile of χ² with these degrees of freedom, by that of the normal distribution.
fn quantile(degrees: f32, normal: f32) -> f32 {
    let spread = 2.0 / (9.0 * degrees.max(1.0));
    let root = 1.0 - spread + normal * spread.sqrt();
    degrees.max(0.0) * root * root * root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A line of this amplitude and phase.
    fn line(order: u16, amplitude_a: f32, phase_rad: f32) -> RotorLine {
        let (sine_a, cosine_a) = (amplitude_a * phase_rad.sin(), amplitude_a * phase_rad.cos());
        RotorLine { order, cosine_a, sine_a, deviation_a: 0.002 }
    }

    /// These lines at angles that are `slip_rad` more than before.
    fn slipped(lines: &[RotorLine], slip_rad: f32) -> Vec<RotorLine> {
        let turn = |line_before: &RotorLine| {
            let phase_rad = line_before.sine_a.atan2(line_before.cosine_a) + f32::from(line_before.order) * slip_rad;
            line(line_before.order, line_before.amplitude_a(), phase_rad)
        };
        lines.iter().map(turn).collect()
    }

    #[test]
    fn changes_are_told_apart() {
        let usual = RotorLimits::USUAL;
        let before =
            [line(1, 0.12, 0.4), line(2, 0.06, -2.0), line(6, 0.06, 1.0), line(12, 0.12, 3.0), line(24, 0.08, 0.0)];
        assert_eq!(RotorChange::between(&before, &before, &usual), RotorChange::Unchanged);
        for degrees in [3.0_f32, -3.0, 17.0, 90.0, -170.0] {
            let slip_rad = degrees.to_radians();
            let change = RotorChange::between(&before, &slipped(&before, slip_rad), &usual);
            let RotorChange::Slipped { angle_rad, deviation_rad } = change else { panic!("{degrees}: {change:?}") };
            // Without noise; single precision of the 24th order.
            assert!((angle_rad - slip_rad).abs() < 1e-4 && deviation_rad < 0.01, "{degrees}: {change:?}");
        }
        let mut heavy = before;
        heavy[0] = line(1, 0.24, 0.4);
        let RotorChange::Unbalance { before_a, now_a } = RotorChange::between(&before, &heavy, &usual) else {
            panic!("unbalance")
        };
        assert!((before_a - 0.12).abs() < 1e-6 && (now_a - 0.24).abs() < 1e-6);
        let mut other = before;
        other[3] = line(12, 0.2, 3.0);
        assert_eq!(RotorChange::between(&before, &other, &usual), RotorChange::Other { order: 12 });
        other[3].cosine_a = f32::NAN;
        assert!(matches!(RotorChange::between(&before, &other, &usual), RotorChange::Other { .. }));
    }

    /// Orders 6 and 12 are the same after a sixth of a turn.
    #[test]
    fn of_slips_that_explain_the_same_the_smallest_is_returned() {
        let before = [line(6, 0.06, 1.0), line(12, 0.12, 3.0)];
        for (degrees, expected) in
            [(7.0_f32, 7.0_f32), (67.0, 7.0), (-175.0, 5.0), (-7.0, -7.0), (53.0, -7.0), (173.0, -7.0)]
        {
            let now = slipped(&before, degrees.to_radians());
            let change = RotorChange::between(&before, &now, &RotorLimits::USUAL);
            let RotorChange::Slipped { angle_rad, .. } = change else { panic!("{degrees}: {change:?}") };
            assert!((angle_rad.to_degrees() - expected).abs() < 0.01, "{degrees}: {angle_rad}");
        }
    }

    #[test]
    fn only_lines_of_the_same_order_are_compared_and_only_a_grown_first_order_is_an_unbalance() {
        let before = [line(1, 0.2, 0.4), line(6, 0.06, 1.0), line(12, 0.12, 3.0)];
        let with = |place: usize, line: RotorLine| {
            let mut now = before;
            now[place] = line;
            RotorChange::between(&before, &now, &RotorLimits::USUAL)
        };
        assert_eq!(with(0, line(2, 0.9, 0.4)), RotorChange::Unchanged, "of another order");
        assert_eq!(with(0, line(1, 0.1, 0.4)), RotorChange::Other { order: 1 }, "less than before");
        assert!(matches!(with(0, line(1, 0.4, 0.4)), RotorChange::Unbalance { .. }));
        let both = [line(1, 0.4, 0.4), line(6, 0.16, 1.0), line(12, 0.12, 3.0)];
        let change = RotorChange::between(&before, &both, &RotorLimits::USUAL);
        assert!(matches!(change, RotorChange::Other { .. }), "{change:?}");
    }
}
