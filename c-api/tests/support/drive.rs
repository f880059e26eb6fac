//! A simulated drive: its front end, and what it reads.

use bearing_watch::drive::{
    BalanceLimits, FrontEndConstants, PhaseCounts, PhaseSensor, Position, RawSample, ResolverLimits, RotorFrame,
    TrackingConstants,
};
use bearing_watch::{Angle, Park};
use bearing_watch_c::{BwFrontEndConstants, BwPark, BwPhaseSensor, BwPosition, BwRawSample};

pub const RATE_HZ: f32 = 10_000.0;
const SENSOR: PhaseSensor = PhaseSensor { offset_counts: 32_768.0, gain_a: 0.001, usable: [100, 65_000] };
const OFFSET: Angle = Angle::from_bits(0x1234_5678);

/// A front end of the core.
pub const CONSTANTS: FrontEndConstants = FrontEndConstants {
    control_rate_hz: RATE_HZ,
    sensors: [SENSOR, PhaseSensor { offset_counts: 32_760.5, ..SENSOR }, SENSOR],
    stuck_samples: 200,
    balance: BalanceLimits { noise_a: 0.02, offset_a: 0.04, gain_tolerance: 0.02, window: 160 },
    tracking: TrackingConstants {
        bandwidth_hz: 300.0,
        damping: 0.707,
        error_limit_rad: 0.1,
        lost_samples: 20,
        settle_samples: 21,
        resolver: ResolverLimits { low: 0.7, high: 1.3, mismatch: 0.1 },
    },
    frame: RotorFrame { pole_pairs: 6, electrical_offset: OFFSET, park: Park::Standard },
};

/// The same for the C interface.
pub fn for_c(own: &FrontEndConstants, factor: u16, further: u16) -> BwFrontEndConstants {
    let sensor = |own: PhaseSensor| BwPhaseSensor {
        offset_counts: own.offset_counts,
        gain_a: own.gain_a,
        lowest_counts: own.usable[0],
        highest_counts: own.usable[1],
    };
    BwFrontEndConstants {
        control_rate_hz: own.control_rate_hz,
        factor,
        further,
        sensors: own.sensors.map(sensor),
        stuck_samples: own.stuck_samples,
        balance_window_samples: own.balance.window,
        balance_noise_a: own.balance.noise_a,
        balance_offset_a: own.balance.offset_a,
        balance_gain_tolerance: own.balance.gain_tolerance,
        tracking_bandwidth_hz: own.tracking.bandwidth_hz,
        tracking_damping: own.tracking.damping,
        tracking_error_limit_rad: own.tracking.error_limit_rad,
        tracking_lost_samples: own.tracking.lost_samples,
        tracking_settle_samples: own.tracking.settle_samples,
        resolver_lowest_amplitude: own.tracking.resolver.low,
        resolver_highest_amplitude: own.tracking.resolver.high,
        resolver_mismatch: own.tracking.resolver.mismatch,
        pole_pairs: own.frame.pole_pairs,
        electrical_offset_turn32: own.frame.electrical_offset.bits(),
        park: match own.frame.park {
            Park::Standard => BwPark::Standard as i32,
            Park::Thesis => BwPark::Thesis as i32,
        },
    }
}

/// What the drive reads: the shaft turns to and fro with a current of 3 A and a ripple.
pub fn raw(number: u32) -> RawSample<2> {
    use std::f64::consts::TAU;
    let t = f64::from(number) / f64::from(RATE_HZ);
    let angle = 1.0 + 40.0 * (TAU * 0.5 * t).sin();
    let q = 3.0 + 0.5 * (TAU * 11.0 * t).sin();
    let electrical = 6.0 * angle + f64::from(OFFSET.bits()) / 4_294_967_296.0 * TAU;
    // A vector 90° ahead of the magnet axis.
    let phase = |k: f64| (32_768.0 - 1000.0 * q * (electrical - k * TAU / 3.0).sin()).round() as u16;
    let position = Position::Absolute(Angle::from_bits((angle / TAU * 4_294_967_296.0) as i64 as u32));
    let further = [(TAU * 5.0 * t).cos() as f32, 0.1];
    RawSample { number, currents: PhaseCounts::Three([0.0, 1.0, 2.0].map(phase)), position, further }
}

/// The same for the C interface.
pub fn raw_for_c(own: &RawSample<2>) -> BwRawSample {
    let (counts, phases) = match own.currents {
        PhaseCounts::Two([a, b]) => ([a, b, 0xFFFF], 2),
        PhaseCounts::Three(counts) => (counts, 3),
        PhaseCounts::Quadrature(_) => ([0; 3], 1),
    };
    let empty = BwRawSample {
        number: own.number,
        counts,
        phases,
        position: BwPosition::Missing as u8,
        angle: 0,
        sin: f32::NAN,
        cos: f32::NAN,
        current_a: if let PhaseCounts::Quadrature(current_a) = own.currents { current_a } else { 7.0 },
    };
    match own.position {
        Position::Missing => empty,
        Position::Absolute(angle) => BwRawSample { position: BwPosition::Absolute as u8, angle: angle.bits(), ..empty },
        Position::Resolver { sin, cos } => BwRawSample { position: BwPosition::Resolver as u8, sin, cos, ..empty },
    }
}
