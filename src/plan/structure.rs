//! The structure of the linear difference model.
//!
//! ```text
//! y(t) + a₁ y(t−1) + … = b₁ u1(t−nkb) + … + c₁ u2(t−nkc) + … [+ offset] + e(t)     (1)  thesis Eq. 2.4, 2.14
//! ```
//!
//! `a` stands on the left with a plus sign. The order vector is `[na nb nc nkb nkc]`: number of terms of y, u1, u2,
//! then the delays of the two inputs in samples. (The thesis' c belongs to the second input; it is not a noise model.)

/// The order vector `[na nb nc nkb nkc]` of (1), and whether a constant is estimated.
///
/// ```
/// use bearing_watch::plan::Structure;
/// const STRUCTURE: Structure = Structure::new(2, 2, 2, 1, 1);
/// assert_eq!(STRUCTURE.parameters(), 6);
/// assert_eq!(STRUCTURE.depth(), 2); // a row needs the two samples before it
/// assert_eq!(STRUCTURE.with_offset().parameters(), 7);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Structure {
    /// Number of terms of the output.
    pub na: u8,
    /// Number of terms of the first input.
    pub nb: u8,
    /// Number of terms of the second input.
    pub nc: u8,
    /// Delay of the first input, samples.
    pub nkb: u8,
    /// Delay of the second input, samples.
    pub nkc: u8,
    /// Whether a constant is estimated: recorded signals have operating points.
    pub offset: bool,
}

impl Structure {
    /// From the order vector in its usual order; no constant.
    #[must_use]
    pub const fn new(na: u8, nb: u8, nc: u8, nkb: u8, nkc: u8) -> Self {
        Self { na, nb, nc, nkb, nkc, offset: false }
    }

    /// The same with a constant.
    #[must_use]
    pub const fn with_offset(self) -> Self {
        Self { offset: true, ..self }
    }

    /// Number of terms a, b, c, without the constant.
    #[inline]
    #[must_use]
    pub const fn terms(self) -> usize {
        self.na as usize + self.nb as usize + self.nc as usize
    }

    /// Number of parameters, including the constant.
    #[inline]
    #[must_use]
    pub const fn parameters(self) -> usize {
        self.terms() + self.offset as usize
    }

    /// Age in samples of the oldest value in a row; the first row of a record is at t₀ = `depth()`.
    #[inline]
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

    /// The order vector as an array.
    #[must_use]
    pub const fn orders(self) -> [u8; 5] {
        [self.na, self.nb, self.nc, self.nkb, self.nkc]
    }

    /// From the order vector as an array; no constant.
    #[must_use]
    pub const fn from_orders([na, nb, nc, nkb, nkc]: [u8; 5]) -> Self {
        Self::new(na, nb, nc, nkb, nkc)
    }
}

#[inline]
const fn oldest(terms: u8, delay: u8) -> usize {
    if terms == 0 { 0 } else { (delay as usize + terms as usize).saturating_sub(1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn depth_is_the_oldest_lag_of_any_signal() {
        assert_eq!(Structure::new(2, 1, 2, 1, 1).depth(), 2);
        assert_eq!(Structure::new(1, 3, 1, 4, 0).depth(), 6);
        assert_eq!(Structure::new(1, 0, 1, 9, 0).depth(), 1, "a delay without terms needs no sample");
    }

    #[test]
    fn parameters_include_the_constant() {
        let structure = Structure::new(3, 2, 1, 1, 1).with_offset();
        assert_eq!((structure.terms(), structure.parameters()), (6, 7));
        assert_eq!(Structure::from_orders(structure.orders()).with_offset(), structure);
    }
}
