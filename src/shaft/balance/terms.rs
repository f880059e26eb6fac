//! Which terms of the torque balance a plan estimates, and in which columns.

use super::rows::COLUMNS;
use crate::plan::Load;

/// The terms of (1) that a plan estimates.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::shaft) enum Terms {
    /// Those without a load.
    Loadless,
    /// All.
    Measured,
    /// Those of (6), first, so that [`super::sums::BalanceSums::loosen`] finds them in the first rows of the factor.
    Weight {
        /// Whether (7) is for each rest.
        changes: bool,
    },
}

impl Terms {
    #[inline(always)]
    pub(in crate::shaft) const fn of(load: Load) -> Self {
        match load {
            Load::Unknown => Self::Loadless,
            Load::Measured(_) => Self::Measured,
            Load::Weight { changes, .. } => Self::Weight { changes },
        }
    }

    /// Indices in p₀ … p₆, in the order of the columns.
    #[inline(always)]
    pub(in crate::shaft) const fn list(self) -> &'static [usize] {
        match self {
            Self::Loadless => &[0, 1, 2, 4, 6],
            Self::Measured => &[0, 1, 2, 3, 4, 5, 6],
            Self::Weight { .. } => &[3, 5, 0, 1, 2, 4, 6],
        }
    }

    /// The columns of what every plan has: inertia, viscous and Coulomb friction, offset, Stribeck part.
    #[inline(always)]
    pub(in crate::shaft) const fn always(self) -> [usize; 5] {
        match self {
            Self::Loadless => [0, 1, 2, 3, 4],
            Self::Measured => [0, 1, 2, 4, 6],
            Self::Weight { .. } => [2, 3, 4, 5, 6],
        }
    }

    /// Number of columns, with that of the current.
    #[inline(always)]
    pub(in crate::shaft) const fn columns(self) -> usize {
        match self {
            Self::Loadless => 6,
            Self::Measured | Self::Weight { .. } => COLUMNS,
        }
    }
}
