//! Decimal numbers of up to 16 characters and a sign, such as −0.125, without a loop over their digits.
//!
//! The sixteen bytes before the end of a cell are looked at as one integer. A byte with 0x30 removed is a digit if it
//! is at most 9, and one other byte may be the point. The digits are moved together, and three products make a number
//! of each eight of them. Below 2⁵³ the number and the power of ten are exact, so that their quotient is the nearest
//! number, as that of a reader of any number is (Clinger 1990, *How to read floating point numbers accurately*).

use std::ops::Range;

/// Powers of ten that divide the digits.
const POWERS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
/// Integers up to here are exact.
const EXACT: u64 = 1 << 53;

/// Returns the number in a cell of a text, if it is such a number and the cell ends at least 16 bytes after the start
/// of the text.
#[inline]
pub(super) fn decimal(text: &[u8], cell: Range<usize>, point: u8) -> Option<f64> {
    let before = text.get(..cell.end)?;
    let word = before.last_chunk::<16>()?;
    let minus = *text.get(cell.start)? == b'-';
    let length = cell.end.checked_sub(cell.start + usize::from(minus)).filter(|length| (1..=16).contains(length))?;
    let (number, places) = if length <= 8 {
        let (digits, places) = eight::digits(u64::from_le_bytes(*word.last_chunk()?), length, point)?;
        (eight::number(digits), places)
    } else {
        let (digits, places) = sixteen::digits(u128::from_le_bytes(*word), length, point)?;
        (eight::number(digits as u64) * 100_000_000 + eight::number((digits >> 64) as u64), places)
    };
    if number > EXACT {
        return None;
    }
    // The sign is set as a bit: a branch for it would be mispredicted for half of the numbers of a noisy signal.
    Some(f64::from_bits((number as f64 / POWERS[places]).to_bits() | u64::from(minus) << 63))
}

/// Digits in the bytes of one integer, the first one in the lowest byte.
macro_rules! digits_in {
    ($word:ty) => {
        const BYTES: usize = size_of::<$word>();

        const fn all(byte: u8) -> $word {
            <$word>::from_ne_bytes([byte; BYTES])
        }

        /// Returns the digits in the last bytes, moved together after zeros, and how many of them are behind the point.
        #[inline]
        pub(super) fn digits(word: $word, length: usize, point: u8) -> Option<($word, usize)> {
            let before = 8 * (BYTES - length);
            let digits = ((word ^ all(b'0')) >> before) << before;
            // The carry of a byte that is no digit only reaches those after it.
            let others = (digits.wrapping_add(all(0x7F - 9)) | digits) & all(0x80);
            if others == 0 {
                return Some((digits, 0));
            }
            let place = others.trailing_zeros() & !7;
            let is_point = others & (others - 1) == 0 && (digits >> place) as u8 == point ^ b'0';
            if !is_point || length == 1 {
                return None;
            }
            let whole = (others >> 7) - 1;
            let fraction = !(others << 1).wrapping_sub(1);
            Some(((digits & fraction) | ((digits & whole) << 8), BYTES - 1 - place as usize / 8))
        }
    };
}

mod eight {
    digits_in!(u64);

    /// The number of eight digits.
    #[inline]
    pub(super) fn number(digits: u64) -> u64 {
        const PAIRS: u64 = 0x0000_00FF_0000_00FF;
        let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8);
        let first = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
        let second = ((pairs >> 16) & PAIRS).wrapping_mul(1 + (10_000 << 32));
        first.wrapping_add(second) >> 32
    }
}

mod sixteen {
    digits_in!(u128);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The number in a cell after others of a line.
    fn of_cell(cell: &str, point: u8) -> Option<u64> {
        let text = format!("1234567890123456,{cell},7");
        decimal(text.as_bytes(), 17..17 + cell.len(), point).map(f64::to_bits)
    }

    #[test]
    fn each_number_is_that_of_the_standard_library() {
        let mut texts: Vec<String> =
            ["0", "-0", "0.0", "-0.0", "5.", ".5", "-.5", "007", "9007199254740992", "0.1"].map(String::from).to_vec();
        let mut state = 1_u64;
        for _ in 0..100_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            let digits = ((state >> 20) % 10_u64.pow((state >> 8) as u32 % 15 + 1)).to_string();
            let point = (state >> 12) as usize % (digits.len() + 1);
            let sign = if state >> 63 == 1 { "-" } else { "" };
            texts.push(format!("{sign}{}.{}", &digits[..point], &digits[point..]));
            texts.push(format!("{sign}{digits}"));
        }
        for text in texts {
            let expected: f64 = text.parse().expect("a number");
            assert_eq!(of_cell(&text, b'.'), Some(expected.to_bits()), "{text}");
            assert_eq!(of_cell(&text.replace('.', ","), b','), Some(expected.to_bits()), "{text}");
        }
    }

    #[test]
    fn what_is_no_such_number_is_left_to_others() {
        let odd = ["", "-", ".", "-.", "+1", " 1", "1 ", "nan", "--1", "1.2.3", "1e5", "12345678901234567", "\u{e9}"];
        for text in odd.into_iter().chain(["9007199254740993", "1,5", "1/", "1:", "\u{7f}1", "1\u{ff}"]) {
            assert_eq!(of_cell(text, b'.'), None, "{text}");
        }
        assert_eq!((decimal(b"1.5,2", 0..3, b'.'), decimal(b"1", 0..2, b'.')), (None, None), "too few bytes before");
    }

    /// Any two bytes among digits are a number where the standard library says so and no longer cell would be needed.
    #[test]
    fn no_pair_of_bytes_is_taken_for_what_it_is_not() {
        for first in 0..=255_u8 {
            for second in 0..=255_u8 {
                let cell = [b'1', first, b'2', second, b'3'];
                let text = [&[b'0'; 16][..], &cell].concat();
                let found = decimal(&text, 16..21, b'.').map(f64::to_bits);
                let digits = |byte: u8| byte.is_ascii_digit();
                let plain = [first, second].iter().all(|byte| digits(*byte) || *byte == b'.') && first != second
                    || digits(first) && first == second;
                let expected = std::str::from_utf8(&cell).ok().and_then(|cell| cell.parse::<f64>().ok());
                assert_eq!(found, expected.filter(|_| plain).map(f64::to_bits), "{cell:?}");
            }
        }
    }
}
