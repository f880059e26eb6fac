//! Decimal numbers of up to 15 characters, such as −0.125, without a loop over their digits.
//!
//! Sixteen bytes are looked at as one integer. A byte with 0x30 removed is a digit if it is at most 9; the first byte
//! that is none is the point or the end. The digits are moved together, and three products make a number of each eight
//! of them. Below 2⁵³ the number and the power of ten are exact, so that their quotient is the nearest number, as that
//! of a reader of any number is (Clinger 1990, *How to read floating point numbers accurately*).

/// Powers of ten that divide the digits.
const POWERS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];
/// Integers up to here are exact.
const EXACT: u64 = 1 << 53;

const fn bytes(byte: u8) -> u128 {
    u128::from_ne_bytes([byte; 16])
}

/// Returns the number at the start of a text and its length, if it is such a number and another character follows.
pub(super) fn decimal(text: &[u8]) -> Option<(f64, usize)> {
    let word = u128::from_le_bytes(*text.first_chunk()?);
    let minus = word as u8 == b'-';
    let digits = (word >> (8 * u32::from(minus))) ^ bytes(b'0');
    // The carry of a byte that is no digit only reaches those after it.
    let others = (digits.wrapping_add(bytes(0x7F - 9)) | digits) & bytes(0x80);
    let point = others.trailing_zeros() & !7;
    let (end, count, fraction) = if (digits >> point.min(120)) as u8 == b'.' ^ b'0' {
        let end = (others & others.wrapping_sub(1)).trailing_zeros() & !7;
        (end, end.checked_sub(8)?, end - point - 8)
    } else {
        (point, point, 0)
    };
    if end == 128 || count == 0 {
        return None;
    }
    let whole = (1 << point) - 1;
    let together = (digits & whole) | ((digits >> 8) & !whole);
    let aligned = together << (128 - count);
    let number = eight(aligned as u64) * 100_000_000 + eight((aligned >> 64) as u64);
    if number > EXACT {
        return None;
    }
    let value = number as f64 / POWERS[fraction as usize / 8];
    Some((if minus { -value } else { value }, end as usize / 8 + usize::from(minus)))
}

/// The number of eight digits, the first one in the lowest byte.
fn eight(digits: u64) -> u64 {
    const PAIRS: u64 = 0x0000_00FF_0000_00FF;
    let pairs = digits.wrapping_mul(10).wrapping_add(digits >> 8);
    let first = (pairs & PAIRS).wrapping_mul(100 + (1_000_000 << 32));
    let second = ((pairs >> 16) & PAIRS).wrapping_mul(1 + (10_000 << 32));
    first.wrapping_add(second) >> 32
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let mut quick = 0;
        for text in texts {
            let expected: f64 = text.parse().expect("a number");
            for end in [",1234567890123456", "\n-0.5,0.25,1.5,7.5", ";;;;;;;;;;;;;;;;;;;;", "e5,1.5,2.5,3.5,4.5"] {
                let found = decimal(format!("{text}{end}").as_bytes());
                quick += usize::from(found.is_some());
                if let Some((value, length)) = found {
                    assert_eq!((value.to_bits(), length), (expected.to_bits(), text.len()), "{text}");
                }
                assert!(found.is_some() || text.len() > 15, "{text}");
            }
        }
        assert!(quick > 700_000, "{quick}");
    }

    #[test]
    fn what_is_no_such_number_is_left_to_others() {
        for text in ["", "1", "-,", ".,", "-.,", ",", "+1,", " 1,", "nan,", "--1,", "1234567890123456,", "\u{e9},"] {
            let padded = if text.len() < 2 { text.to_string() } else { format!("{text}0000000000000000") };
            assert_eq!(decimal(padded.as_bytes()), None, "{text}");
        }
        assert_eq!(decimal(b"1.2.3,0000000000"), Some((1.2, 3)), "the caller looks at what follows");
    }
}
