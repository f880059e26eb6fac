//! Calls of the driver of the resolver-to-digital converter, over a bus, pins and a delay whose answers cannot be seen
//! through.

use core::convert::Infallible;
use core::hint::black_box as opaque;

use bearing_watch::drive::ad2s1210::{Ad2s1210, Faults, Pins, Reading, Resolution, Settings, Thresholds};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

struct Wire;

impl spi::ErrorType for Wire {
    type Error = ErrorKind;
}

impl SpiDevice for Wire {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        for operation in operations {
            match operation {
                Operation::Read(back) | Operation::Transfer(back, _) => back.fill(opaque(0x3F)),
                _ => {}
            }
        }
        opaque(Ok(()))
    }
}

impl digital::ErrorType for Wire {
    type Error = Infallible;
}

impl OutputPin for Wire {
    fn set_low(&mut self) -> Result<(), Infallible> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        Ok(())
    }
}

impl DelayNs for Wire {
    fn delay_ns(&mut self, ns: u32) {
        opaque(ns);
    }
}

pub fn run(show: impl Fn(&dyn core::fmt::Display)) {
    let thresholds = Thresholds {
        loss_mv: 2200,
        overrange_mv: 4104,
        mismatch_mv: 380,
        reset_mv: [1000, 3000],
        tracking_steps: [50, 10],
    };
    for resolution in [Resolution::Bits10, Resolution::Bits12, Resolution::Bits14, Resolution::Bits16] {
        let settings = opaque(Settings { resolution, thresholds: Some(thresholds), ..Settings::DEFAULT });
        let pins = Pins { sample: Wire, a0: Wire, a1: Wire };
        let mut device = match Ad2s1210::start(Wire, pins, Wire, &settings) {
            Ok(device) => device,
            Err(error) => {
                show(&error);
                continue;
            }
        };
        if let Ok(reading) = Ad2s1210::read(&mut device) {
            opaque((Reading::position(&reading), reading.velocity_rad_s, Faults::any(reading.faults)));
        }
        if let Ok((angle, faults)) = Ad2s1210::read_angle(&mut device) {
            opaque((angle, Faults::bits(faults)));
        }
        if let Ok(faults) = Ad2s1210::clear_faults(&mut device) {
            opaque(Faults::contains(faults, Faults::LOSS));
        }
        opaque(Ad2s1210::release(device).0);
    }
}
