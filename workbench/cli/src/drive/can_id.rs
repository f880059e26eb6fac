//! Identifiers of CAN frames, as options of the command line.

use std::fmt;

/// The largest standard and extended identifiers.
const LARGEST: [u32; 2] = [0x7FF, 0x1FFF_FFFF];
/// Hexadecimal digits of the largest standard identifier.
const STANDARD_DIGITS: usize = 3;

/// An identifier of 11 or 29 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct CanId {
    pub(crate) number: u32,
    pub(crate) extended: bool,
}

impl CanId {
    /// The identifier, unless the number is too large.
    pub(crate) fn new(number: u32, extended: bool) -> Option<Self> {
        (number <= LARGEST[usize::from(extended)]).then_some(Self { number, extended })
    }

    /// The identifier of an option: up to three digits are a standard one, more an extended one.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
        let digits = digits.filter(|digits| digits.chars().all(|digit| digit.is_ascii_hexdigit()));
        let read = digits.and_then(|digits| {
            let number = u32::from_str_radix(digits, 16).ok()?;
            Self::new(number, digits.len() > STANDARD_DIGITS)
        });
        read.ok_or_else(|| "write 0x000 to 0x7FF, or an extended identifier with more digits up to 0x1FFFFFFF".into())
    }
}

impl fmt::Display for CanId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.extended { write!(f, "0x{:08X}", self.number) } else { write!(f, "0x{:03X}", self.number) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_are_read_by_their_digits() {
        let shown = |text| CanId::parse(text).map(|id| id.to_string());
        let read = [("0x123", "0x123"), ("0x7ff", "0x7FF"), ("0x0123", "0x00000123"), ("0X1FFFFFFF", "0x1FFFFFFF")];
        for (text, id) in read {
            assert_eq!(shown(text), Ok(id.into()));
        }
        assert_eq!(shown("0x5"), Ok("0x005".into()));
        for wrong in ["", "0x", "123", "0x800", "0x20000000", "0x123456789", "0x+12", "0x12g", "x12"] {
            assert!(shown(wrong).is_err(), "{wrong}");
        }
    }
}
