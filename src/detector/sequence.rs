//! Which segment follows which, and whether a fault that was found late may have begun in the one before.

/// The number of a segment in the upper bits, and in the lowest one the doubt: one word, since it is copied with the
/// sums in the interrupt.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Sequence(u32);

impl Sequence {
    /// The segment before is in doubt; returns its number.
    pub(super) const fn withdraw(&mut self) -> u32 {
        self.0 |= 1;
        (self.0 >> 1).wrapping_sub(1) & (u32::MAX >> 1)
    }

    /// Whether it has this number.
    pub(super) const fn is(self, number: u32) -> bool {
        self.0 >> 1 == number
    }

    /// It is not.
    pub(super) const fn keep(&mut self) {
        self.0 &= !1;
    }

    /// The next segment, without a doubt.
    pub(super) const fn next(self) -> Self {
        Self((self.0 | 1).wrapping_add(1))
    }

    /// Whether the segment before is in doubt.
    pub(super) const fn withdraws(self) -> bool {
        self.0 & 1 == 1
    }

    /// Whether it puts this one in doubt, which is then the one before.
    pub(super) const fn withdraws_that(self, other: Self) -> bool {
        self.withdraws() && other.next().0 == self.0 & !1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_the_segment_before_is_put_in_doubt() {
        let first = Sequence(u32::MAX - 1);
        let (mut second, mut third) = (first.next(), first.next().next());
        assert_eq!((second, third), (Sequence(0), Sequence(2)));
        assert!(!second.withdraws_that(first));
        assert!(first.is(second.withdraw()) && second.is(third.withdraw()));
        third.keep();
        assert!(second.withdraws_that(first) && !second.withdraws_that(third) && !second.withdraws_that(second));
        assert_eq!(second.next(), third, "a doubt is of one segment");
        second.keep();
        assert!(!second.withdraws());
    }
}
