//! The structure of the linear difference model.
//!
//! ```text
//! y(t) + a₁ y(t−1) + … = b₁ u1(t−nkb) + … + c₁ u2(t−nkc) + … [+ offset] + e(t)     (1)  thesis Eq. 2.4, 2.14
//! ```
//!
//! `a` stands with + on the left. The order vector is `[na nb nc nkb nkc]`: terms of y, u1, u2, then the delays of
//! the two inputs in samples (the thesis' c belongs to the second input, it is no noise model).

/// The order vector `[na nb nc nkb nkc]` of (1).
///
/// ```
/// use bearing_watch::Order;
/// const ORDER: Order = Order::new(2, 2, 2, 1, 1);
/// assert_eq!(ORDER.parameters(), 6);
/// assert_eq!(ORDER.depth(), 2); // oldest sample that a row needs
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Order {
    /// Terms of the output.
    pub na: u8,
    /// Terms of the first input.
    pub nb: u8,
    /// Terms of the second input.
    pub nc: u8,
    /// Delay of the first input, samples.
    pub nkb: u8,
    /// Delay of the second input, samples.
    pub nkc: u8,
}

impl Order {
    /// From the five numbers in the order they are always written.
    #[must_use]
    pub const fn new(na: u8, nb: u8, nc: u8, nkb: u8, nkc: u8) -> Self {
        Self { na, nb, nc, nkb, nkc }
    }

    /// Number of parameters a, b, c.
    #[must_use]
    pub const fn parameters(self) -> usize {
        self.na as usize + self.nb as usize + self.nc as usize
    }

    /// Columns of a least-squares row: parameters, the constant if there is one, and the target.
    #[must_use]
    pub const fn columns(self, offset: bool) -> usize {
        self.parameters() + offset as usize + 1
    }

    /// Age in samples of the oldest value in a row; the first row of a record is at t₀ = `depth()`.
    #[must_use]
    pub const fn depth(self) -> usize {
        let mut depth = self.na as usize;
        let b = oldest(self.nb, self.nkb);
        let c = oldest(self.nc, self.nkc);
        if b > depth {
            depth = b;
        }
        if c > depth {
            depth = c;
        }
        depth
    }

    /// The larger of the two input delays.
    #[must_use]
    pub const fn largest_delay(self) -> usize {
        if self.nkb > self.nkc { self.nkb as usize } else { self.nkc as usize }
    }

    /// The five numbers as an array.
    #[must_use]
    pub const fn to_array(self) -> [u8; 5] {
        [self.na, self.nb, self.nc, self.nkb, self.nkc]
    }

    /// From an array of the five numbers.
    #[must_use]
    pub const fn from_array([na, nb, nc, nkb, nkc]: [u8; 5]) -> Self {
        Self { na, nb, nc, nkb, nkc }
    }
}

const fn oldest(terms: u8, delay: u8) -> usize {
    if terms == 0 { 0 } else { delay as usize + terms as usize - 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_the_oldest_lag_of_any_signal() {
        assert_eq!(Order::new(2, 1, 2, 1, 1).depth(), 2);
        assert_eq!(Order::new(1, 3, 1, 4, 0).depth(), 6);
        assert_eq!(Order::new(1, 0, 1, 9, 0).depth(), 1, "a delay without terms needs nothing");
    }

    #[test]
    fn columns_count_offset_and_target() {
        let order = Order::new(3, 2, 1, 1, 1);
        assert_eq!((order.parameters(), order.columns(false), order.columns(true)), (6, 7, 8));
        assert_eq!(Order::from_array(order.to_array()), order);
    }
}
