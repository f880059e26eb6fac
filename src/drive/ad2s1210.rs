//! Driver of the resolver-to-digital converter AD2S1210 (Analog Devices) on an SPI bus of `embedded-hal` 1.0.
//!
//! Input: the bus, the pins SAMPLE, A0 and A1, and [`Settings`]. Output: a [`Reading`] of angle, velocity and
//! [`Faults`].
//!
//! ```text
//! angle = word · 2π/2¹⁶                             the word is left-aligned whatever the resolution   (1)
//! ω = word/2¹⁵ · 2π · n · f_clk/8.192 MHz,          n = 2500, 1000, 500, 125 turns/s                   (2)
//! ```
//!
//! n in (2) is the largest tracking rate at 10, 12, 14 and 16 bits. A0 and A1 select what the bus transfers: position,
//! velocity, or registers. A register's address has its highest bit set, data have it clear; the converter sets it in
//! what it returns if the parity of the stored value is wrong. Each byte of a register's transfer has a chip select of
//! its own. The bus is in SPI mode 1, at most 25 MHz; the chip select is the pin WR/FSYNC.
//!
//! Each function transfers a fixed number of bytes. The only waits are that of [`Ad2s1210::start`] and two of 350 ns a
//! latch, by the given `DelayNs`.

mod faults;
mod settings;

use core::f32::consts::TAU;
use core::fmt;

use embedded_hal::delay::DelayNs;
use embedded_hal::digital::OutputPin;
use embedded_hal::spi::SpiDevice;

pub use faults::Faults;
pub use settings::{Resolution, Settings, Thresholds};

use super::Position;
use crate::signal::Angle;
use settings::NOMINAL_CLOCK_HZ;

/// Width of a pulse at SAMPLE: two periods of the slowest clock and 20 ns.
const SAMPLE_NS: u32 = 350;
/// Addresses of registers; the seven thresholds follow each other.
const THRESHOLDS: u8 = 0x88;
const EXCITATION: u8 = 0x91;
const CONTROL: u8 = 0x92;
const SOFT_RESET: u8 = 0xF0;
const FAULTS: u8 = 0xFF;
/// Set in an address, and in returned data of wrong parity.
const HIGHEST: u8 = 1 << 7;
/// Bits of the control register that are compared: its bit 6 is reserved.
const COMPARED: u8 = 0x3F;

/// Angle and velocity of one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Reading {
    /// (1). Valid only without faults.
    pub angle: Angle,
    /// (2), positive where the angle increases. Valid only without faults.
    pub velocity_rad_s: f32,
    /// Faults since the last [`Ad2s1210::clear_faults`].
    pub faults: Faults,
}

impl Reading {
    /// The reading for a [`FrontEnd`](crate::drive::FrontEnd): missing if there is any fault.
    #[must_use]
    pub const fn position(&self) -> Position {
        if self.faults.any() { Position::Missing } else { Position::Absolute(self.angle) }
    }
}

/// Why the converter cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Error<B, P> {
    /// The bus failed.
    Bus(B),
    /// A pin failed.
    Pin(P),
    /// The clock is not between 6.144 and 10.24 MHz.
    Clock(u32),
    /// The converter cannot make this excitation frequency, Hz.
    Excitation(u32),
    /// The register with this address has a wrong parity.
    Parity(u8),
    /// The register with this address does not contain what was written: no converter, or another SPI mode.
    Unverified(u8),
}

impl<B: fmt::Debug, P: fmt::Debug> fmt::Display for Error<B, P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Bus(error) => write!(f, "the bus failed: {error:?}"),
            Self::Pin(error) => write!(f, "a pin failed: {error:?}"),
            Self::Clock(hz) => write!(f, "a clock of {hz} Hz is outside 6.144 to 10.24 MHz"),
            Self::Excitation(hz) => write!(f, "an excitation of {hz} Hz cannot be made from this clock"),
            Self::Parity(register) => write!(f, "register {register:#04x} has a wrong parity"),
            Self::Unverified(register) => {
                write!(f, "register {register:#04x} does not contain what was written; check wiring and SPI mode 1")
            }
        }
    }
}

impl<B: fmt::Debug, P: fmt::Debug> core::error::Error for Error<B, P> {}

/// The pins of the converter that the driver sets.
#[derive(Clone, Copy, Debug)]
pub struct Pins<S, A, C> {
    /// SAMPLE: its falling edge latches position, velocity and faults.
    pub sample: S,
    /// A0.
    pub a0: A,
    /// A1.
    pub a1: C,
}

/// What the bus transfers: levels of A0 and A1.
#[derive(Clone, Copy)]
enum Mode {
    Position,
    Velocity,
    Registers,
}

/// A converter that is started and verified.
#[derive(Debug)]
pub struct Ad2s1210<B, S, A, C, D> {
    bus: B,
    pins: Pins<S, A, C>,
    delay: D,
    /// (2) of a step of the word.
    step_rad_s: f32,
}

impl<B, S, A, C, D> Ad2s1210<B, S, A, C, D>
where
    B: SpiDevice,
    S: OutputPin,
    A: OutputPin<Error = S::Error>,
    C: OutputPin<Error = S::Error>,
    D: DelayNs,
{
    /// Configures the converter, reads each register back, resets the excitation, waits until the converter tracks (up
    /// to 80 ms), and clears the faults of the reset.
    ///
    /// # Errors
    /// Says which setting is out of range, or which register is not as written. The converter is then not usable.
    pub fn start(
        bus: B,
        pins: Pins<S, A, C>,
        delay: D,
        settings: &Settings,
    ) -> Result<Self, Error<B::Error, S::Error>> {
        if !settings.has_clock() {
            return Err(Error::Clock(settings.clock_hz));
        }
        let excitation = settings.excitation_code().ok_or(Error::Excitation(settings.excitation_hz))?;
        let (_, turns_s, settling_ms) = settings.resolution.figures();
        let nominal = settings.clock_hz as f32 / NOMINAL_CLOCK_HZ as f32;
        let step_rad_s = TAU * turns_s * nominal / 32_768.0; // (2)
        let mut converter = Self { bus, pins, delay, step_rad_s };
        converter.pins.sample.set_high().map_err(Error::Pin)?;
        converter.write(CONTROL, settings.control(), COMPARED)?;
        converter.write(EXCITATION, excitation, !HIGHEST)?;
        for (register, code) in (THRESHOLDS..).zip(settings.thresholds.iter().flat_map(Thresholds::codes)) {
            converter.write(register, code, !HIGHEST)?;
        }
        converter.transfer([SOFT_RESET, 0])?;
        // A slower clock settles later; the clock is at least three quarters of the nominal one.
        converter.delay.delay_ms(if settings.clock_hz < NOMINAL_CLOCK_HZ {
            settling_ms + settling_ms / 3
        } else {
            settling_ms
        });
        converter.clear_faults()?;
        Ok(converter)
    }

    /// Latches and reads angle, velocity and faults: six bytes.
    ///
    /// # Errors
    /// Bus or pin failed; there is no reading.
    pub fn read(&mut self) -> Result<Reading, Error<B::Error, S::Error>> {
        self.latch()?;
        let [high, low, first] = self.word(Mode::Position)?;
        let [velocity_high, velocity_low, second] = self.word(Mode::Velocity)?;
        let position = u16::from_be_bytes([high, low]);
        let velocity = i16::from_be_bytes([velocity_high, velocity_low]);
        Ok(Reading {
            angle: Angle::from_counts(u32::from(position), 16),    // (1)
            velocity_rad_s: f32::from(velocity) * self.step_rad_s, // (2)
            faults: Faults::from_bits(first | second),
        })
    }

    /// Latches and reads angle and faults alone: three bytes, for a fast interrupt. A velocity is then that of a
    /// tracking loop over the angles.
    ///
    /// # Errors
    /// Bus or pin failed; there is no reading.
    pub fn read_angle(&mut self) -> Result<(Angle, Faults), Error<B::Error, S::Error>> {
        self.latch()?;
        let [high, low, faults] = self.word(Mode::Position)?;
        let position = u16::from_be_bytes([high, low]);
        Ok((Angle::from_counts(u32::from(position), 16), Faults::from_bits(faults)))
    }

    /// Returns the latched faults, and lets the converter forget those that are over.
    ///
    /// # Errors
    /// Bus or pin failed.
    pub fn clear_faults(&mut self) -> Result<Faults, Error<B::Error, S::Error>> {
        self.latch()?;
        let faults = self.register(FAULTS)?;
        // The reading clears the register; the next latch updates the fault pins and the byte behind each word.
        self.latch()?;
        Ok(Faults::from_bits(faults))
    }

    /// Returns bus, pins and delay.
    #[must_use]
    pub fn release(self) -> (B, Pins<S, A, C>, D) {
        (self.bus, self.pins, self.delay)
    }

    fn latch(&mut self) -> Result<(), Error<B::Error, S::Error>> {
        self.pins.sample.set_low().map_err(Error::Pin)?;
        self.delay.delay_ns(SAMPLE_NS);
        self.pins.sample.set_high().map_err(Error::Pin)?;
        self.delay.delay_ns(SAMPLE_NS);
        Ok(())
    }

    fn select(&mut self, mode: Mode) -> Result<(), Error<B::Error, S::Error>> {
        let (a0, a1) = match mode {
            Mode::Position => (false, false),
            Mode::Velocity => (false, true),
            Mode::Registers => (true, true),
        };
        self.pins.a0.set_state(a0.into()).map_err(Error::Pin)?;
        self.pins.a1.set_state(a1.into()).map_err(Error::Pin)
    }

    /// A word, high byte first, and the faults.
    fn word(&mut self, mode: Mode) -> Result<[u8; 3], Error<B::Error, S::Error>> {
        self.select(mode)?;
        let mut bytes = [0; 3];
        self.bus.read(&mut bytes).map_err(Error::Bus)?;
        Ok(bytes)
    }

    /// Two bytes with a chip select each; returns the second that comes back.
    fn transfer(&mut self, bytes: [u8; 2]) -> Result<u8, Error<B::Error, S::Error>> {
        self.select(Mode::Registers)?;
        let mut last = 0;
        for byte in bytes {
            let mut back = [0];
            self.bus.transfer(&mut back, &[byte]).map_err(Error::Bus)?;
            [last] = back;
        }
        Ok(last)
    }

    /// The value of a register. A second address, rather than data, keeps the first register from being written.
    fn register(&mut self, address: u8) -> Result<u8, Error<B::Error, S::Error>> {
        self.transfer([address, CONTROL])
    }

    /// Writes a register and compares these bits of what it then contains.
    fn write(&mut self, address: u8, data: u8, compared: u8) -> Result<(), Error<B::Error, S::Error>> {
        self.transfer([address, data])?;
        let back = self.register(address)?;
        if back & HIGHEST != 0 {
            return Err(Error::Parity(address));
        }
        if (back ^ data) & compared != 0 {
            return Err(Error::Unverified(address));
        }
        Ok(())
    }
}
