//! The driver of the resolver-to-digital converter against a mocked bus: each byte, level and wait, and each failure.

use std::cell::Cell;

use bearing_watch::drive::Position;
use bearing_watch::drive::ad2s1210::{Ad2s1210, Error, Faults, Pins, Resolution, Settings, Thresholds};
use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::{ErrorKind, ErrorType, Operation, SpiDevice};
use embedded_hal_mock::eh1::MockError;
use embedded_hal_mock::eh1::delay::NoopDelay;
use embedded_hal_mock::eh1::digital::{Mock as Pin, State, Transaction as Level};
use embedded_hal_mock::eh1::spi::{Mock as Bus, Transaction as Byte};

/// The levels of A0 and A1 that select position, velocity and registers, by the converter's data sheet.
const POSITION: [State; 2] = [State::Low, State::Low];
const VELOCITY: [State; 2] = [State::Low, State::High];
const REGISTERS: [State; 2] = [State::High, State::High];

/// What bus and pins expect.
#[derive(Default)]
struct Script {
    bytes: Vec<Byte<u8>>,
    sample: Vec<Level>,
    mode: [Vec<Level>; 2],
}

impl Script {
    fn select(mut self, levels: [State; 2]) -> Self {
        for (own, level) in self.mode.iter_mut().zip(levels) {
            own.push(Level::set(level));
        }
        self
    }

    /// One byte each way, with a chip select of its own.
    fn byte(mut self, out: u8, back: u8) -> Self {
        self.bytes.extend([Byte::transaction_start(), Byte::transfer(vec![out], vec![back]), Byte::transaction_end()]);
        self
    }

    fn registers(self, out: [u8; 2], back: u8) -> Self {
        let [first, second] = out;
        self.select(REGISTERS).byte(first, 0x00).byte(second, back)
    }

    /// A register is written, and contains `found` when it is read back.
    fn written(self, address: u8, data: u8, found: u8) -> Self {
        self.registers([address, data], 0x00).registers([address, 0x92], found)
    }

    fn latch(mut self) -> Self {
        self.sample.extend([Level::set(State::Low), Level::set(State::High)]);
        self
    }

    fn word(mut self, levels: [State; 2], bytes: [u8; 3]) -> Self {
        self.bytes.extend([Byte::transaction_start(), Byte::read_vec(bytes.to_vec()), Byte::transaction_end()]);
        self.select(levels)
    }

    fn idle(mut self) -> Self {
        self.sample.push(Level::set(State::High));
        self
    }

    /// The start with these settings' registers, all of which are accepted.
    fn started(self, control: u8, excitation: u8) -> Self {
        self.idle().written(0x92, control, control).written(0x91, excitation, excitation).reset()
    }

    fn reset(self) -> Self {
        self.registers([0xF0, 0x00], 0x00).latch().registers([0xFF, 0x92], 0b0100_1000).latch()
    }

    fn mocks(&self) -> (Bus<u8>, Pins<Pin, Pin, Pin>) {
        let [a0, a1] = &self.mode;
        (Bus::new(&self.bytes), Pins { sample: Pin::new(&self.sample), a0: Pin::new(a0), a1: Pin::new(a1) })
    }

    /// Runs a program over the mocks, which must have used all that they expected.
    fn run<T>(self, program: impl FnOnce(Bus<u8>, Pins<Pin, Pin, Pin>) -> T) -> T {
        let (mut bus, mut pins) = self.mocks();
        let result = program(bus.clone(), pins.clone());
        bus.done();
        pins.sample.done();
        pins.a0.done();
        pins.a1.done();
        result
    }
}

/// Registers of a converter behind a bus that fails after so many transactions.
struct Failing {
    registers: [u8; 256],
    address: u8,
    left: usize,
}

impl ErrorType for Failing {
    type Error = ErrorKind;
}

impl SpiDevice for Failing {
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), ErrorKind> {
        self.left = self.left.checked_sub(1).ok_or(ErrorKind::Overrun)?;
        for operation in operations {
            match operation {
                Operation::Transfer(back, out) => {
                    back[0] = self.registers[usize::from(self.address)];
                    match out[0] {
                        address @ 0x80.. => self.address = address,
                        data => self.registers[usize::from(self.address)] = data,
                    }
                }
                Operation::Read(back) => back.fill(0x20),
                other => panic!("{other:?}"),
            }
        }
        Ok(())
    }
}

/// A pin whose levels do not matter.
struct Free;

impl embedded_hal::digital::ErrorType for Free {
    type Error = MockError;
}

impl OutputPin for Free {
    fn set_low(&mut self) -> Result<(), MockError> {
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), MockError> {
        Ok(())
    }
}

type Converter = Ad2s1210<Bus<u8>, Pin, Pin, Pin, NoopDelay>;

fn start(
    bus: Bus<u8>,
    pins: Pins<Pin, Pin, Pin>,
    settings: &Settings,
) -> Result<Converter, Error<ErrorKind, MockError>> {
    Ad2s1210::start(bus, pins, NoopDelay::new(), settings)
}

#[test]
fn start_writes_and_verifies_every_register() {
    let thresholds = Thresholds {
        loss_mv: 2200,
        overrange_mv: 4104,
        mismatch_mv: 380,
        reset_mv: [1000, 3000],
        tracking_steps: [50, 10],
    };
    let settings = Settings {
        resolution: Resolution::Bits14,
        excitation_hz: 4000,
        hysteresis: false,
        thresholds: Some(thresholds),
        ..Settings::DEFAULT
    };
    // Bits 6 and 5, and twice the code 10 of 14 bits; steps of 250 Hz and of 38 mV.
    let mut script = Script::default().idle().written(0x92, 0b0110_1010, 0b0110_1010).written(0x91, 16, 16);
    for (address, data) in (0x88..).zip([57, 108, 10, 26, 78, 50, 10]) {
        script = script.written(address, data, data);
    }
    script.reset().run(|bus, pins| start(bus, pins, &settings).expect("starts"));
}

#[test]
fn a_reading_has_angle_velocity_and_faults() {
    let script = Script::default().started(0b0111_1111, 40);
    let script = script.latch().word(POSITION, [0x40, 0x00, 0]).word(VELOCITY, [0xF0, 0x00, 0]);
    let script = script.latch().word(POSITION, [0xFF, 0xFF, 0x40]).word(VELOCITY, [0x7F, 0xFF, 0x08]);
    let script = script.latch().word(POSITION, [0x80, 0x00, 0x01]);
    script.run(|bus, pins| {
        let mut device = start(bus, pins, &Settings::DEFAULT).expect("starts");
        let one = device.read().expect("reads");
        assert_eq!((one.angle.bits(), one.faults), (0x4000_0000, Faults::NONE));
        // An eighth of 125 turns/s backwards.
        assert!((one.velocity_rad_s / (-15.625 * std::f32::consts::TAU) - 1.0).abs() < 1e-6, "{one:?}");
        let two = device.read().expect("reads");
        assert_eq!(two.angle.bits(), 0xFFFF_0000);
        assert!((two.velocity_rad_s / (124.996_185 * std::f32::consts::TAU) - 1.0).abs() < 1e-6, "{two:?}");
        assert!(two.faults.contains(Faults::LOSS) && two.faults.contains(Faults::TRACKING) && two.faults.any());
        assert!(!two.faults.contains(Faults::CLIPPED));
        assert_eq!([one.position(), two.position()], [Position::Absolute(one.angle), Position::Missing]);
        let (angle, faults) = device.read_angle().expect("reads");
        assert_eq!((angle.bits(), faults), (0x8000_0000, Faults::PARITY));
    });
}

#[test]
fn the_velocity_follows_clock_and_resolution() {
    let settings = Settings { clock_hz: 10_240_000, resolution: Resolution::Bits12, ..Settings::DEFAULT };
    let script = Script::default().started(0b0111_0101, 32);
    script.latch().word(POSITION, [0; 3]).word(VELOCITY, [0x40, 0x00, 0]).run(|bus, pins| {
        let reading = start(bus, pins, &settings).expect("starts").read().expect("reads");
        // Half of 1000 turns/s at 8.192 MHz.
        assert!((reading.velocity_rad_s / (625.0 * std::f32::consts::TAU) - 1.0).abs() < 1e-6, "{reading:?}");
    });
}

/// Sums up what it is asked to wait, ns.
struct Waited<'a>(&'a Cell<u64>);

impl DelayNs for Waited<'_> {
    fn delay_ns(&mut self, ns: u32) {
        self.0.set(self.0.get() + u64::from(ns));
    }
}

#[test]
fn a_slower_clock_settles_a_third_later() {
    for (clock_hz, excitation, ms) in [(8_192_000, 40, 60), (6_144_000, 53, 80), (10_240_000, 32, 60)] {
        let settings = Settings { clock_hz, ..Settings::DEFAULT };
        Script::default().started(0b0111_1111, excitation).run(|bus, pins| {
            let waited = Cell::new(0);
            let device = Ad2s1210::start(bus, pins, Waited(&waited), &settings).map(|_| ());
            assert_eq!((device, waited.get() / 1_000_000), (Ok(()), ms), "{clock_hz}");
        });
    }
}

#[test]
fn settings_out_of_range_are_refused_before_anything_is_sent() {
    let refused = |settings: Settings| {
        Script::default().run(|bus, pins| start(bus, pins, &settings).map(|_| ()).expect_err("refused"))
    };
    assert_eq!(refused(Settings { clock_hz: 0, ..Settings::DEFAULT }), Error::Clock(0));
    assert_eq!(refused(Settings { clock_hz: 16_000_000, ..Settings::DEFAULT }), Error::Clock(16_000_000));
    assert_eq!(refused(Settings { excitation_hz: 25_000, ..Settings::DEFAULT }), Error::Excitation(25_000));
}

#[test]
fn a_register_that_is_not_as_written_is_named() {
    let absent = Script::default().idle().written(0x92, 0x7F, 0x00);
    let refused =
        |script: Script| script.run(|bus, pins| start(bus, pins, &Settings::DEFAULT).map(|_| ()).expect_err("refused"));
    assert_eq!(refused(absent), Error::Unverified(0x92));
    // A bus that is not driven reads ones, which is also a wrong parity.
    assert_eq!(refused(Script::default().idle().written(0x92, 0x7F, 0xFF)), Error::Parity(0x92));
    let second = Script::default().idle().written(0x92, 0x7F, 0x3F).written(0x91, 40, 41);
    assert_eq!(refused(second), Error::Unverified(0x91));
}

#[test]
fn each_failure_of_the_bus_is_an_error_and_none_is_a_reading() {
    // Two registers of four bytes, two bytes of the reset, two of the faults.
    const STARTED: usize = 12;
    for left in 0..=STARTED + 2 {
        let bus = Failing { registers: [0; 256], address: 0, left };
        let pins = Pins { sample: Free, a0: Free, a1: Free };
        match Ad2s1210::start(bus, pins, NoopDelay::new(), &Settings::DEFAULT) {
            Err(error) => assert_eq!((error, left < STARTED), (Error::Bus(ErrorKind::Overrun), true)),
            Ok(mut device) => {
                let read = device.read().map(|reading| reading.angle.bits());
                let expected = if left == STARTED + 2 { Ok(0x2020_0000) } else { Err(Error::Bus(ErrorKind::Overrun)) };
                assert_eq!((read, left >= STARTED), (expected, true), "{left}");
            }
        }
    }
}

#[test]
fn a_failing_pin_is_an_error() {
    let fault = MockError::Io(std::io::ErrorKind::NotConnected);
    let script = Script { sample: vec![Level::set(State::High).with_error(fault.clone())], ..Script::default() };
    let failed = script.run(|bus, pins| start(bus, pins, &Settings::DEFAULT).map(|_| ()).expect_err("refused"));
    assert_eq!(failed, Error::Pin(fault));
    assert_eq!(failed.to_string(), "a pin failed: Io(NotConnected)");
}
