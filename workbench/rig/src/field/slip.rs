//! A spall whose balls slip: another order than the kinematic one, pulses of another width, pulses that grow with the
//! load.
//!
//! ```text
//! dx/dt = O (1 + s + j) ω/2π                                                     (1)
//! j(k) = p j(k−1) + σ √(1 − p²) g(k),   p = exp(−Ts/τ),   g ~ N(0, 1)            (2)
//! T = Td (d₀/d) a tanh(ω/ω₀) p(x; d) − ε Kt i [cos(ξ+θ) + cos(ξ−θ)
//!                                             + ½cos(2ξ+θ) + ½cos(2ξ−θ)],   ξ = 2πx     (3)
//! a = min(a₀ + |T_load|/T₁, a₁)                                                  (4)
//! ```
//!
//! x is the phase of the defect in periods, O the order of the outer race, s the slip of the record and j its
//! fluctuation. (3) is the spall of [`bearing`](crate::bearing) with pulses of width d instead of d₀ = 0.15 and of
//! the same mean torque. Other defects do not depend on slip.

use core::f64::consts::TAU;

use super::draws::between;
use crate::bearing::{PULSE_DUTY, direction, pulse};
use crate::{DefectTorque, NoiseSource, PlantState, RigError, fraction, not_negative, positive};

/// Ranges of the effect.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Slip {
    /// Lower and upper limit of |s| of (1); the sign is random.
    pub slip: [f64; 2],
    /// σ of (2).
    pub jitter: f64,
    /// τ of (2).
    pub correlation_s: f64,
    /// Lower and upper limit of d of (3).
    pub width: [f64; 2],
    /// a₀ of (4).
    pub load_floor: f64,
    /// T₁ of (4).
    pub load_scale_nm: f64,
    /// a₁ of (4).
    pub load_ceiling: f64,
}

/// Values of one record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SlipValues {
    /// s of (1).
    pub slip: f64,
    /// d of (3).
    pub width: f64,
    /// The ranges that they were drawn from.
    pub ranges: Slip,
}

impl Slip {
    /// The ranges of the field.
    pub const FIELD: Self = Self {
        slip: [0.002, 0.02],
        jitter: 0.003,
        correlation_s: 0.3,
        width: [0.05, 0.6],
        load_floor: 0.5,
        load_scale_nm: 0.15,
        load_ceiling: 2.0,
    };

    pub(super) fn validate(&self) -> Result<(), RigError> {
        for slip in self.slip {
            fraction("field.slip.slip", slip)?;
        }
        fraction("field.slip.jitter", self.jitter)?;
        positive("field.slip.correlation_s", self.correlation_s)?;
        for width in self.width {
            positive("field.slip.width", width)?;
            fraction("field.slip.width", width)?;
        }
        not_negative("field.slip.load_floor", self.load_floor)?;
        positive("field.slip.load_scale_nm", self.load_scale_nm)?;
        not_negative("field.slip.load_ceiling", self.load_ceiling)?;
        Ok(())
    }

    pub(super) fn draw(&self, mut source: NoiseSource) -> SlipValues {
        let size = between(&mut source, self.slip);
        let slip = if source.uniform(-1.0, 1.0) < 0.0 { -size } else { size };
        SlipValues { slip, width: between(&mut source, self.width), ranges: *self }
    }
}

/// The bearing with slip, advanced once a sample.
#[derive(Debug, Clone)]
pub(super) struct SlippingBearing {
    values: SlipValues,
    source: NoiseSource,
    pole: f64,
    jitter: f64,
    order: f64,
    anchor_rad: f64,
    anchor_periods: f64,
}

impl SlippingBearing {
    /// A bearing of outer-race order `order` on a shaft at `angle_rad`; its balls start as without slip.
    pub(super) fn new(
        values: SlipValues,
        mut source: NoiseSource,
        order: f64,
        angle_rad: f64,
        sample_time_s: f64,
    ) -> Self {
        let jitter = values.ranges.jitter * source.gaussian();
        Self {
            values,
            source,
            pole: libm::exp(-sample_time_s / values.ranges.correlation_s),
            jitter,
            order,
            anchor_rad: angle_rad,
            anchor_periods: order * angle_rad / TAU,
        }
    }

    /// Draws the fluctuation of the next sampling interval; the shaft is at `angle_rad`.
    pub(super) fn advance(&mut self, angle_rad: f64) {
        (self.anchor_periods, self.anchor_rad) = (self.periods(angle_rad), angle_rad);
        let drive = self.values.ranges.jitter * (1.0 - self.pole * self.pole).sqrt();
        self.jitter = self.pole * self.jitter + drive * self.source.gaussian(); // (2)
    }

    /// x at an angle within the sampling interval: the integral of (1).
    fn periods(&self, angle_rad: f64) -> f64 {
        let order = self.order * (1.0 + self.values.slip + self.jitter);
        self.anchor_periods + order * (angle_rad - self.anchor_rad) / TAU
    }

    /// The torque of the defect that opposes positive rotation, under an external load.
    pub(super) fn torque_nm(&self, law: &DefectTorque, at: &PlantState, load_nm: f64) -> f64 {
        match *law {
            DefectTorque::Spall { pulse_nm, ripple_nm_per_a, .. } => {
                self.spall_nm(at, load_nm, pulse_nm, ripple_nm_per_a)
            }
            DefectTorque::SpallAndViscous { pulse_nm, ripple_nm_per_a, friction_nm_s_per_rad, .. } => {
                self.spall_nm(at, load_nm, pulse_nm, ripple_nm_per_a) + friction_nm_s_per_rad * at.velocity_rad_s
            }
            _ => law.at(at),
        }
    }

    /// Equation (3); the bracket is 2 cos θ (cos ξ + ½ cos 2ξ).
    fn spall_nm(&self, at: &PlantState, load_nm: f64, pulse_nm: f64, ripple_nm_per_a: f64) -> f64 {
        let Slip { load_floor, load_scale_nm, load_ceiling, .. } = self.values.ranges;
        let growth = (load_floor + load_nm.abs() / load_scale_nm).min(load_ceiling); // (4)
        let periods = self.periods(at.angle_rad);
        let height = pulse_nm * PULSE_DUTY / self.values.width * growth;
        let drag = height * direction(at.velocity_rad_s) * pulse(periods, self.values.width);
        let cos = libm::cos(TAU * periods);
        let bracket = 2.0 * libm::cos(at.angle_rad) * (cos + cos * cos - 0.5);
        drag - ripple_nm_per_a * at.current_a * bracket
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::tests::moments;
    use crate::{BearingGeometry, Defect, DefectKind, Stream};

    const ORDER: f64 = 3.718;

    fn bearing(seed: u64, ranges: Slip) -> SlippingBearing {
        let source = |stream| NoiseSource::new(seed, stream);
        let values = ranges.draw(source(Stream::Slip));
        SlippingBearing::new(values, source(Stream::SlipJitter), ORDER, 1.5, 0.002)
    }

    fn law(kind: DefectKind) -> DefectTorque {
        Defect::full(kind).torque(0.05, &BearingGeometry::THESIS).expect("valid")
    }

    #[test]
    fn pulses_a_turn_are_the_order_with_slip() {
        for seed in 0..20 {
            let mut bearing = bearing(seed, Slip { jitter: 0.0, ..Slip::FIELD });
            // 300 turns forward in 5000 samples, and 100 back.
            for k in 1..=5000 {
                bearing.advance(1.5 + TAU * 300.0 * f64::from(k) / 5000.0);
            }
            bearing.advance(1.5 + TAU * 200.0);
            let passes = bearing.periods(1.5 + TAU * 200.0) - ORDER * 1.5 / TAU;
            let slip = passes / (200.0 * ORDER) - 1.0;
            // Rounding of 5000 additions to a sum near 1000.
            assert!((slip - bearing.values.slip).abs() < 1e-12 && (0.002..0.02).contains(&slip.abs()), "{slip}");
        }
    }

    #[test]
    fn slips_and_widths_cover_their_ranges_with_both_signs() {
        let draws: Vec<SlipValues> = (0..1000).map(|seed| bearing(seed, Slip::FIELD).values).collect();
        let positive = draws.iter().filter(|drawn| drawn.slip > 0.0).count();
        // Four standard deviations of 1000 coins: 2√1000.
        assert!(positive.abs_diff(500) < 64, "{positive}");
        assert!(draws.iter().all(|drawn| (0.05..0.6).contains(&drawn.width)));
        // The extremes of 1000 draws lie within 1 % of the width of the range, with a probability of 1 − 1e-4.
        assert!(draws.iter().any(|drawn| drawn.width < 0.0555) && draws.iter().any(|drawn| drawn.width > 0.5945));
    }

    #[test]
    fn jitter_has_its_size_and_its_memory() {
        let mut bearing = bearing(4, Slip::FIELD);
        let jitter: Vec<f64> = (0..1_000_000)
            .map(|_| {
                bearing.advance(1.5);
                bearing.jitter
            })
            .collect();
        let (mean, sd) = moments(&jitter);
        // 2000 s hold 2000/(2·0.3) = 3300 independent values for the mean, twice that for the square: four standard
        // deviations are 0.07 and 0.035 of the size.
        assert!(mean.abs() < 0.07 * 0.003 && (sd / 0.003 - 1.0).abs() < 0.035, "{mean} {sd}");
        // After 150 samples, 0.3 s, a correlation of 1/e; four standard deviations of about 1/√3300 each.
        let apart = jitter.iter().zip(&jitter[150..]).map(|(a, b)| a * b).sum::<f64>() / 1e6 / (sd * sd);
        assert!((apart - (-1.0_f64).exp()).abs() < 0.07, "{apart}");
    }

    #[test]
    fn the_mean_torque_does_not_depend_on_the_width_and_grows_with_the_load() {
        // Mean of the standard pulses: Td d₀/2.
        let standard = 0.06 * 0.15 / 2.0;
        for (seed, load, growth) in [(1, 0.0, 0.5), (2, 0.075, 1.0), (3, -0.15, 1.5), (4, 0.5, 2.0)] {
            let bearing = bearing(seed, Slip { jitter: 0.0, ..Slip::FIELD });
            let points = 100_000;
            let order = ORDER * (1.0 + bearing.values.slip);
            let torque = |k: i32| {
                let angle_rad = 1.5 + f64::from(k) / f64::from(points) * TAU / order;
                bearing.torque_nm(
                    &law(DefectKind::Spall),
                    &PlantState { current_a: 0.0, velocity_rad_s: 50.0, angle_rad },
                    load,
                )
            };
            let mean = (0..points).map(torque).sum::<f64>() / f64::from(points);
            // The rectangle rule over a period of a function with a continuous slope: O(1/n²).
            assert!((mean / (growth * standard) - 1.0).abs() < 1e-7, "{mean} {growth}");
        }
    }

    #[test]
    fn without_slip_it_is_the_standard_spall() {
        let ranges = Slip { slip: [0.0; 2], jitter: 0.0, width: [0.15; 2], load_floor: 1.0, ..Slip::FIELD };
        let order = BearingGeometry::THESIS.orders().outer;
        let source = |stream| NoiseSource::new(1, stream);
        let values = ranges.draw(source(Stream::Slip));
        let mut bearing = SlippingBearing::new(values, source(Stream::SlipJitter), order, 0.0, 0.002);
        for k in 0..1000 {
            let x = f64::from(k);
            let at = PlantState { current_a: 0.01 * x, velocity_rad_s: 40.0 - 0.08 * x, angle_rad: 0.037 * x };
            bearing.advance(at.angle_rad);
            for kind in DefectKind::ALL {
                // Rounding of 1000 additions to a phase near 20 periods (at most 2e-12, 1e-13 is likely), times the
                // slope of a pulse, 1.3 N·m a period.
                assert!((bearing.torque_nm(&law(kind), &at, 0.0) - law(kind).at(&at)).abs() < 2e-12, "{kind:?} {k}");
            }
        }
    }
}
