//! Values that an effect draws from its ranges.

use crate::NoiseSource;

/// A draw from the uniform distribution over a range.
pub(crate) fn between(source: &mut NoiseSource, [from, to]: [f64; 2]) -> f64 {
    source.uniform(from, to)
}

/// A draw from the whole numbers below `count`, all equally probable.
#[expect(
    clippy::cast_possible_truncation,
    clippy::cast_sign_loss,
    reason = "a uniform draw from 0 to below count, cut to a whole number"
)]
pub(super) fn choice(source: &mut NoiseSource, count: u32) -> u32 {
    source.uniform(0.0, f64::from(count)) as u32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Stream;

    #[test]
    fn choices_are_equally_probable() {
        let mut source = NoiseSource::new(1, Stream::Duty);
        let mut counts = [0_u32; 6];
        for _ in 0..6000 {
            counts[choice(&mut source, 6) as usize] += 1;
        }
        // Four standard deviations of a binomial count: √(6000/6 · 5/6) = 29.
        assert!(counts.iter().all(|count| count.abs_diff(1000) < 116), "{counts:?}");
    }
}
