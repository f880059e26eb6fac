//! The converter's byte of latched faults.

/// Faults that the converter has latched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Faults(u8);

impl Faults {
    /// No fault.
    pub const NONE: Self = Self(0);
    /// The stored configuration has a wrong parity.
    pub const PARITY: Self = Self(1);
    /// The phase of the inputs is too far from that of the excitation.
    pub const PHASE: Self = Self(1 << 1);
    /// The shaft turns faster than the resolution allows.
    pub const VELOCITY: Self = Self(1 << 2);
    /// Loss of tracking.
    pub const TRACKING: Self = Self(1 << 3);
    /// Sine and cosine differ in amplitude.
    pub const MISMATCH: Self = Self(1 << 4);
    /// Sine or cosine exceeds its threshold.
    pub const OVERRANGE: Self = Self(1 << 5);
    /// Loss of signal.
    pub const LOSS: Self = Self(1 << 6);
    /// Sine or cosine is clipped.
    pub const CLIPPED: Self = Self(1 << 7);

    /// From the byte of the converter.
    pub(super) const fn from_bits(bits: u8) -> Self {
        Self(bits)
    }

    /// The byte of the converter.
    #[must_use]
    pub const fn bits(self) -> u8 {
        self.0
    }

    /// Whether all of these faults are set.
    #[must_use]
    pub const fn contains(self, faults: Self) -> bool {
        self.0 & faults.0 == faults.0
    }

    /// Whether any fault is set.
    #[must_use]
    pub const fn any(self) -> bool {
        self.0 != 0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_have_the_bits_of_the_register() {
        type Own = Faults;
        // D0 to D7 of the fault register in the data sheet.
        let all = [
            Own::PARITY,
            Own::PHASE,
            Own::VELOCITY,
            Own::TRACKING,
            Own::MISMATCH,
            Own::OVERRANGE,
            Own::LOSS,
            Own::CLIPPED,
        ];
        for (fault, bit) in all.into_iter().zip([1_u8, 2, 4, 8, 16, 32, 64, 128]) {
            assert_eq!(fault.bits(), bit);
            assert!(Own::from_bits(0xFF).contains(fault) && !Own::from_bits(!bit).contains(fault));
        }
        assert!(!Own::NONE.any() && Own::CLIPPED.any());
    }
}
