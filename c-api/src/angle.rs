//! Counts of position sensors → angles.

use bearing_watch::{Angle, EncoderCounts};

/// Returns the angle of a converter with `resolution_bits` bits a turn as the fraction of a turn that `bw_collect`
/// takes: 2^32 is one turn.
#[unsafe(no_mangle)]
pub extern "C" fn bw_angle(counts: u32, resolution_bits: u32) -> u32 {
    Angle::from_counts(counts, resolution_bits).bits()
}

/// Returns the angle of an encoder with `counts_per_turn` counts a turn, four times its lines, as `bw_angle` does. The
/// counter may count on over turns in both directions, or be reset at each. 0 if a turn has no counts, or more than
/// 2^24 - 1.
#[unsafe(no_mangle)]
pub extern "C" fn bw_angle_from_cpr(counts: i32, counts_per_turn: u32) -> u32 {
    EncoderCounts::new(counts_per_turn).map_or(0, |turn| turn.angle(counts).bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_are_those_of_the_core() {
        assert_eq!(bw_angle(1, 2), 1 << 30);
        assert_eq!([bw_angle_from_cpr(2000, 8000), bw_angle_from_cpr(-6000, 8000)], [1 << 30; 2]);
        assert_eq!([bw_angle_from_cpr(1, 0), bw_angle_from_cpr(1, 1 << 24)], [0; 2]);
    }
}
