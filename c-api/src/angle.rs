//! Counts of position sensors → angles.

use bearing_watch::{Angle, EncoderCounts, TurnCounter};

use crate::memory::check;

/// Returns the angle of a converter with `resolution_bits` bits a turn as the fraction of a turn that `bw_sample`
/// takes: 2^32 is one turn.
#[unsafe(no_mangle)]
pub extern "C" fn bw_angle(counts: u32, resolution_bits: u32) -> u32 {
    Angle::from_counts(counts, resolution_bits).bits()
}

/// Returns the angle of an encoder with `counts_per_turn` counts a turn, four times its lines, as `bw_angle` does. The
/// counter may count on over turns in both directions, or be reset at each; one that may reach its end, 2^31 counts,
/// passes `bw_within_turn` before. 0 if a turn has no counts, or more than
/// 2^24 - 1.
#[unsafe(no_mangle)]
pub extern "C" fn bw_angle_from_cpr(counts: i32, counts_per_turn: u32) -> u32 {
    EncoderCounts::new(counts_per_turn).map_or(0, |turn| turn.angle(counts).bits())
}

/// A counter of an encoder that counts on over turns without an end. Zero it, as a static is.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BwTurnCounter {
    /// The last reading.
    pub last: i32,
    /// Its counts within the turn.
    pub within: i32,
}

/// Takes a reading of a counter of 32 bits; returns the counts within the turn, from 0 on, for the reading of a drive
/// or for `bw_angle_from_cpr`. The counter may wrap: what counts are its differences. 0 if a turn has no counts, or
/// more than 2^24 - 1, or if `counter` is NULL or not aligned.
///
/// # Safety
/// `counter` is NULL or readable and writable. Only one context calls this function for it.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn bw_within_turn(counter: *mut BwTurnCounter, counts: i32, counts_per_turn: u32) -> i32 {
    let (Ok(()), Some(turn)) = (check(counter), EncoderCounts::new(counts_per_turn)) else { return 0 };
    // SAFETY: aligned, and readable and writable by the contract.
    let counter = unsafe { &mut *counter };
    let mut after = TurnCounter::after(turn, counter.last, counter.within);
    *counter = BwTurnCounter { last: counts, within: after.within(counts) };
    counter.within
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

    #[test]
    fn a_counter_that_wraps_is_that_of_the_core() {
        let (mut own, mut core) = (BwTurnCounter::default(), TurnCounter::new(EncoderCounts::new(8000).unwrap()));
        let mut read = |counts, turn| {
            // SAFETY: the counter is there for the call.
            unsafe { bw_within_turn(&raw mut own, counts, turn) }
        };
        for counts in [i32::MAX - 1, i32::MAX, i32::MIN, i32::MIN + 3, i32::MAX - 5, 0, -1] {
            assert_eq!(read(counts, 8000), core.within(counts));
        }
        assert_eq!([read(1, 0), read(1, 1 << 24)], [0; 2]);
        // SAFETY: NULL is refused.
        assert_eq!(unsafe { bw_within_turn(core::ptr::null_mut(), 1, 8000) }, 0);
    }
}
