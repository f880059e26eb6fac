//! Raw samples of a turning motor, and the bits of its front end.

use bearing_watch::drive::{
    BalanceLimits, By, Factor, FrontEnd, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample,
    ResolverLimits, RotorFrame, TrackingConstants,
};
use bearing_watch::{Angle, Park};

use super::numbers::Numbers;

const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 2048.0, gain_a: 0.02, usable: [16, 4079] };

/// A drive of 10 kHz with 12-bit current sensors and a resolver.
pub const CONSTANTS: FrontEndConstants = FrontEndConstants {
    control_rate_hz: 10_000.0,
    sensors: [SENSOR; 3],
    stuck_samples: 100,
    balance: BalanceLimits { noise_a: 0.1, offset_a: 0.2, gain_tolerance: 0.02, window: 320 },
    tracking: TrackingConstants {
        bandwidth_hz: 300.0,
        damping: 0.7,
        error_limit_rad: 0.1,
        lost_samples: 20,
        settle_samples: 20,
        resolver: ResolverLimits { low: 0.8, high: 1.2, mismatch: 0.05 },
    },
    frame: RotorFrame { pole_pairs: 6, electrical_offset: Angle::ZERO, park: Park::Standard },
};

/// How the drive measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sensors {
    /// Three currents and a resolver.
    Resolver,
    /// Two currents and a converter of 14 bits.
    Converter,
}

/// A motor at 300 rad/s with a current of 10 A, and noise.
pub struct Motor<const FURTHER: usize> {
    sensors: Sensors,
    number: u32,
    numbers: Numbers,
}

impl<const FURTHER: usize> Motor<FURTHER> {
    #[must_use]
    pub const fn new(sensors: Sensors) -> Self {
        Self { sensors, number: 0, numbers: Numbers(7) }
    }

    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "1546 … 2551 counts")]
    pub fn sample(&mut self) -> RawSample<FURTHER> {
        let number = self.number;
        self.number = number.wrapping_add(1);
        // 0.03 rad a sample.
        let shaft = Angle::from_bits(number.wrapping_mul(20_507_188));
        let electrical = shaft.times(6);
        let mut current = |third: u32| {
            let sc = electrical.plus(Angle::from_bits(third.wrapping_mul(0x5555_5555))).sin_cos();
            (2048.5 + 500.0 * sc.cos + 2.0 * self.numbers.draw()) as u16
        };
        let (a, c, b) = (current(0), current(1), current(2));
        let mut noise = || 1e-3 * self.numbers.draw();
        let sc = shaft.sin_cos();
        let (currents, position) = match self.sensors {
            Sensors::Resolver => {
                (PhaseCounts::Three([a, b, c]), Position::Resolver { sin: sc.sin + noise(), cos: sc.cos + noise() })
            }
            Sensors::Converter => {
                (PhaseCounts::Two([a, b]), Position::Absolute(Angle::from_counts(shaft.bits() >> 18, 14)))
            }
        };
        RawSample { number, currents, position, further: self.numbers.array() }
    }
}

/// Hands every output of both kinds of sensors to `add`, for a hash: equal on host and target.
pub fn bits(mut add: impl FnMut(&[f32])) {
    fn one<const FACTOR: usize>(sensors: Sensors, add: &mut impl FnMut(&[f32]))
    where
        By<FACTOR>: Factor,
    {
        let Ok(mut front_end) = FrontEnd::<2, FACTOR>::new(&CONSTANTS) else { return };
        let mut motor = Motor::<2>::new(sensors);
        for _ in 0..4000 {
            // The bits of a NaN differ between processors.
            if let Some(clean) = front_end.push(&motor.sample()).filter(|clean| clean.velocity_rad_s.is_finite()) {
                let [command, load] = clean.further;
                add(&[clean.current_a, clean.velocity_rad_s, clean.angle.radians(), command, load]);
            }
        }
    }
    one::<8>(Sensors::Resolver, &mut add);
    one::<10>(Sensors::Converter, &mut add);
    one::<12>(Sensors::Converter, &mut add);
}
