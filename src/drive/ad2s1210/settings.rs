//! Settings of the converter → what its registers contain.
//!
//! ```text
//! f_exc = code · f_clk/2¹⁵,   code 4 … 80                                                              (1)
//! control = 1 · 2⁶ + lock 44° · 2⁵ + hysteresis · 2⁴ + encoder · 2² + resolution                       (2)
//! ```

/// Clock of the figures of the data sheet.
pub(super) const NOMINAL_CLOCK_HZ: u32 = 8_192_000;
/// Clocks that the converter takes.
const CLOCKS_HZ: core::ops::RangeInclusive<u32> = 6_144_000..=10_240_000;
/// Codes of (1).
const EXCITATION_CODES: core::ops::RangeInclusive<u64> = 4..=80;
/// A step of the thresholds.
const STEP_MV: u16 = 38;
/// Data of a register have seven bits.
const DATA: u8 = 0x7F;

/// Bits of the position word that carry information.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Resolution {
    /// 10 bits, up to 2500 turns/s.
    Bits10,
    /// 12 bits, up to 1000 turns/s.
    Bits12,
    /// 14 bits, up to 500 turns/s.
    Bits14,
    /// 16 bits, up to 125 turns/s.
    Bits16,
}

impl Resolution {
    /// The code of the control register, the largest tracking rate in turns/s, and the settling time after a reset in
    /// ms, both at [`NOMINAL_CLOCK_HZ`].
    pub(super) const fn figures(self) -> (u8, f32, u32) {
        match self {
            Self::Bits10 => (0b00, 2500.0, 10),
            Self::Bits12 => (0b01, 1000.0, 20),
            Self::Bits14 => (0b10, 500.0, 25),
            Self::Bits16 => (0b11, 125.0, 60),
        }
    }
}

/// What the converter is set to. The levels of the resolution pins RES0 and RES1 must agree with `resolution`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Settings {
    /// Frequency at CLKIN, 6.144 to 10.24 MHz; usually a crystal of 8.192 MHz.
    pub clock_hz: u32,
    /// Frequency of the excitation, 2 to 20 kHz; rounded down to a multiple of `clock_hz`/2¹⁵.
    pub excitation_hz: u32,
    /// Resolution of position and velocity.
    pub resolution: Resolution,
    /// Whether the position has a hysteresis of one step of its resolution.
    pub hysteresis: bool,
    /// Whether the phase of the inputs may differ by 44° from the excitation, instead of by any phase.
    pub phase_lock_44: bool,
    /// Thresholds of the faults; `None` leaves those after power-on.
    pub thresholds: Option<Thresholds>,
}

impl Settings {
    /// A crystal of 8.192 MHz, excitation of 10 kHz, 16 bits, hysteresis and a phase lock of 44°.
    pub const DEFAULT: Self = Self {
        clock_hz: NOMINAL_CLOCK_HZ,
        excitation_hz: 10_000,
        resolution: Resolution::Bits16,
        hysteresis: true,
        phase_lock_44: true,
        thresholds: None,
    };

    /// Whether the converter takes this clock.
    pub(super) fn has_clock(&self) -> bool {
        CLOCKS_HZ.contains(&self.clock_hz)
    }

    /// The code of (1); `None` if there is none for this frequency.
    pub(super) fn excitation_code(&self) -> Option<u8> {
        let code = (u64::from(self.excitation_hz) << 15).checked_div(u64::from(self.clock_hz))?;
        if EXCITATION_CODES.contains(&code) { u8::try_from(code).ok() } else { None }
    }

    /// (2), with the encoder's resolution equal to the other.
    pub(super) const fn control(&self) -> u8 {
        let (code, _, _) = self.resolution.figures();
        1 << 6 | (self.phase_lock_44 as u8) << 5 | (self.hysteresis as u8) << 4 | code << 2 | code
    }
}

/// Thresholds of the monitored amplitude, mV, each rounded down to a multiple of 38 mV up to 4826 mV, and of the
/// tracking error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Thresholds {
    /// Loss of signal: below it.
    pub loss_mv: u16,
    /// Degradation of signal: above it.
    pub overrange_mv: u16,
    /// Degradation of signal: largest and smallest amplitude differ by more.
    pub mismatch_mv: u16,
    /// Values from which the largest and the smallest amplitude are collected again after a reset of the faults.
    pub reset_mv: [u16; 2],
    /// Loss of tracking above the first, until below the second, in steps of 0.35° at 10 bits, 0.14° at 12 and 0.09° at
    /// 14 and 16 bits, up to 127.
    pub tracking_steps: [u8; 2],
}

impl Thresholds {
    /// The values of the registers from that of the loss of signal on, in the order of their addresses.
    pub(super) fn codes(&self) -> [u8; 7] {
        let step = |mv: u16| u8::try_from(mv / STEP_MV).unwrap_or(DATA).min(DATA);
        let [most, least] = self.reset_mv.map(step);
        let [high, low] = self.tracking_steps.map(|steps| steps.min(DATA));
        [step(self.loss_mv), step(self.overrange_mv), step(self.mismatch_mv), most, least, high, low]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_those_of_the_data_sheet() {
        // 10 kHz from 8.192 MHz: 40 steps of 250 Hz.
        assert_eq!(Settings::DEFAULT.excitation_code(), Some(40));
        let with = |excitation_hz: u32| Settings { excitation_hz, ..Settings::DEFAULT }.excitation_code();
        assert_eq!([1_000, 20_000, 20_250, 0].map(with), [Some(4), Some(80), None, None]);
        let slow = Settings { clock_hz: 6_144_000, ..Settings::DEFAULT };
        assert_eq!(slow.excitation_code(), Some(53));
        assert!(slow.has_clock() && !Settings { clock_hz: 6_143_999, ..slow }.has_clock());
        assert_eq!(Settings { clock_hz: 0, ..slow }.excitation_code(), None);
    }

    #[test]
    fn the_control_register_has_all_fields() {
        assert_eq!(Settings::DEFAULT.control(), 0b0111_1111);
        let other = Settings { resolution: Resolution::Bits12, hysteresis: false, ..Settings::DEFAULT };
        assert_eq!(other.control(), 0b0110_0101);
        assert_eq!(Settings { phase_lock_44: false, ..other }.control(), 0b0100_0101);
    }

    #[test]
    fn thresholds_stay_within_seven_bits() {
        let all = Thresholds {
            loss_mv: 2200,
            overrange_mv: 4826,
            mismatch_mv: 37,
            reset_mv: [u16::MAX, 38],
            tracking_steps: [200, 5],
        };
        assert_eq!(all.codes(), [57, 127, 0, 127, 1, 127, 5]);
    }
}
