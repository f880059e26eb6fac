//! A resolver-to-digital converter whose bus gives any answers, and fails.

use std::cell::RefCell;

use bearing_watch::drive::ad2s1210::{Ad2s1210, Pins, Resolution, Settings, Thresholds};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::{self, OutputPin};
use embedded_hal::spi::{self, ErrorKind, Operation, SpiDevice};

use crate::input::Input;

/// The registers of a converter, and what disturbs it.
struct Device<'a> {
    registers: [u8; 256],
    address: u8,
    input: RefCell<Input<'a>>,
}

/// A wire to it.
#[derive(Clone, Copy)]
struct Wire<'d, 'a>(&'d RefCell<Device<'a>>);

impl spi::ErrorType for Wire<'_, '_> {
    type Error = ErrorKind;
}

impl SpiDevice for Wire<'_, '_> {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        let device = &mut *self.0.borrow_mut();
        let mut input = device.input.borrow_mut();
        let fault = input.byte();
        if fault > 250 {
            return Err(ErrorKind::Other);
        }
        for operation in operations {
            match operation {
                Operation::Read(back) => back.iter_mut().for_each(|cell| *cell = input.byte()),
                Operation::Transfer(back, out) => {
                    for (cell, data) in back.iter_mut().zip(*out) {
                        *cell = device.registers[usize::from(device.address)];
                        match data {
                            0x80.. => device.address = *data,
                            _ => device.registers[usize::from(device.address)] = *data,
                        }
                        if fault > 200 {
                            *cell = input.byte();
                        }
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }
}

impl digital::ErrorType for Wire<'_, '_> {
    type Error = digital::ErrorKind;
}

impl OutputPin for Wire<'_, '_> {
    fn set_low(&mut self) -> Result<(), digital::ErrorKind> {
        self.set_high()
    }

    fn set_high(&mut self) -> Result<(), digital::ErrorKind> {
        let fault = self.0.borrow().input.borrow_mut().byte();
        if fault > 252 { Err(digital::ErrorKind::Other) } else { Ok(()) }
    }
}

impl DelayNs for Wire<'_, '_> {
    fn delay_ns(&mut self, _ns: u32) {}
}

/// Settings of any values, and calls of the driver.
pub fn attack(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut settings = Settings {
        resolution: [Resolution::Bits10, Resolution::Bits12, Resolution::Bits14, Resolution::Bits16][input.below(4)],
        hysteresis: input.byte().is_multiple_of(2),
        phase_lock_44: input.byte().is_multiple_of(2),
        ..Settings::DEFAULT
    };
    if input.byte().is_multiple_of(4) {
        (settings.clock_hz, settings.excitation_hz) = (input.word(), input.word());
    }
    if input.byte().is_multiple_of(4) {
        settings.thresholds = Some(Thresholds {
            loss_mv: input.half(),
            overrange_mv: input.half(),
            mismatch_mv: input.half(),
            reset_mv: [input.half(), input.half()],
            tracking_steps: input.array(),
        });
    }
    let calls = input.array::<8>();
    let device = RefCell::new(Device { registers: [0; 256], address: 0, input: RefCell::new(input) });
    let wire = Wire(&device);
    let Ok(mut driver) = Ad2s1210::start(wire, Pins { sample: wire, a0: wire, a1: wire }, wire, &settings) else {
        return;
    };
    for call in calls {
        match call % 3 {
            0 => {
                if let Ok(reading) = driver.read() {
                    assert!(reading.velocity_rad_s.is_finite(), "{reading:?}");
                    let _position = reading.position();
                }
            }
            1 => drop(driver.read_angle()),
            _ => drop(driver.clear_faults()),
        }
    }
}
