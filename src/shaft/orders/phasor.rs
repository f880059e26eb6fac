//! A fraction of a turn → its cosine and sine by table, for the phasors of the bearing orders and of an axis.

use core::f32::consts::PI;

/// Points of the sine's table a turn.
const POINTS: usize = 64;

/// Sine of k/64 turns for one and a quarter turns, so that it serves for the cosine too.
static SINE: [f32; POINTS + POINTS / 4] = sine();

#[expect(clippy::indexing_slicing, clippy::cast_possible_truncation, reason = "evaluated when compiling")]
const fn sine() -> [f32; POINTS + POINTS / 4] {
    let mut table = [0.0; POINTS + POINTS / 4];
    let mut k = 0;
    while k < table.len() {
        // Within half a turn of zero, where 15 terms of the series leave less than 1e-16.
        let turns = (k as f64 - if k > POINTS / 2 { POINTS as f64 } else { 0.0 }) / POINTS as f64;
        let x = turns * core::f64::consts::TAU;
        let (mut term, mut sum, mut n) = (x, x, 1.0);
        while n < 30.0 {
            term *= -x * x / ((n + 1.0) * (n + 2.0));
            sum += term;
            n += 2.0;
        }
        table[k] = sum as f32;
        k += 1;
    }
    table
}

/// Cosine and sine of a fraction of a turn, within 2.1e-5: enough for a phasor, and less work than
/// [`Angle::sin_cos`](crate::Angle::sin_cos). From the nearest point a of the table, at distance t:
///
/// ```text
/// sin(a + t) ≈ (1 − t²/2) sin a + t cos a,   cos(a + t) ≈ (1 − t²/2) cos a − t sin a,   |t³/6| ≤ 2.0e-5
/// ```
#[inline(always)]
pub(in crate::shaft) fn phasor(bits: u32) -> (f32, f32) {
    let index = (bits.wrapping_add(0x0200_0000) >> 26) as usize;
    let entry = |index: usize| SINE.get(index).copied().unwrap_or(0.0);
    let (sin, cos) = (entry(index), entry(index.wrapping_add(POINTS / 4)));
    let t = (bits << 6).cast_signed() as f32 * (PI / 2_147_483_648.0 / 64.0);
    let less = 1.0 - 0.5 * t * t;
    (less * cos - t * sin, less * sin + t * cos)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TURN: f64 = 4_294_967_296.0;

    #[test]
    fn phasor_is_that_of_the_angle_everywhere() {
        let strided = (0..1_u32 << 20).map(|k| k.wrapping_mul(4093));
        let edges = (0..128_u32).flat_map(|half| (-64_i32..=64).map(move |k| (half << 25).wrapping_add_signed(k)));
        let error = |bits: u32| {
            let exact = core::f64::consts::TAU * f64::from(bits) / TURN;
            let (cos, sin) = phasor(bits);
            (f64::from(cos) - exact.cos()).abs().max((f64::from(sin) - exact.sin()).abs())
        };
        let worst = strided.chain(edges).map(error).fold(0.0, f64::max);
        assert!(worst < 2.1e-5 && worst > 1.8e-5, "{worst}");
    }
}
