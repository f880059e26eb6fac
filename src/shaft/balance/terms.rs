//! Which terms of the torque balance a plan estimates, and in which columns.

use super::rows::COLUMNS;
use crate::plan::Load;
use crate::reason::FrictionTerm;

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

    /// The column of a term: that of a term without a column is another one's.
    #[inline(always)]
    pub(in crate::shaft) const fn column(self, term: FrictionTerm) -> usize {
        let [loadless, weight] = match term {
            FrictionTerm::Inertia => [0, 2],
            FrictionTerm::Viscous => [1, 3],
            FrictionTerm::Coulomb => [2, 4],
            FrictionTerm::InverseTorqueConstant => [0, 0],
            FrictionTerm::Offset => [3, 5],
            FrictionTerm::LoadFriction => [0, 1],
            FrictionTerm::Stribeck | FrictionTerm::Drag => [4, 6],
        };
        match self {
            Self::Loadless => loadless,
            Self::Measured => term as usize,
            Self::Weight { .. } => weight,
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
