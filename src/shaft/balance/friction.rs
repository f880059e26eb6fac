//! The torque balance of a segment as it is reported: inertia, viscous and Coulomb friction, torque constant.
//!
//! Its equations are those of [`super::balance`].

use crate::reason::FrictionTerm;

/// An estimated parameter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Parameter {
    /// Its value.
    pub value: f32,
    /// Its standard deviation, as if the residuals of the rows were independent.
    pub deviation: f32,
    /// (value − nominal)/deviation: comparable between segments with much and little excitation.
    pub score: f32,
}

impl Parameter {
    /// Without an estimate.
    pub(crate) const NONE: Self = Self { value: 0.0, deviation: 0.0, score: 0.0 };
}

/// The parameters of the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum LoadTerms {
    /// The load is not known.
    #[default]
    Unknown,
    /// The load is measured.
    Measured {
        /// 1/Kt, A/(N·m).
        inverse_torque_constant: Parameter,
        /// μ/Kt, friction in proportion to the load, A/(N·m).
        load_friction: Parameter,
    },
    /// The load is a weight on an axis: its amplitude W (6), A, never negative. Its nominal value is 0.
    Weight(Parameter),
}

/// The torque balance of a segment. All parameters are in amperes per unit of their signal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Friction {
    /// J/Kt, A·s²/rad.
    pub inertia: Parameter,
    /// B/Kt, A·s/rad.
    pub viscous: Parameter,
    /// Tc/Kt, A.
    pub coulomb: Parameter,
    /// Offset of current and load, A.
    pub offset: Parameter,
    /// What belongs to the load.
    pub load: LoadTerms,
    /// (Ts − Tc)/Kt, the excess of break-away friction over sliding friction, A.
    pub stribeck: Parameter,
    /// Friction at the usual velocity and load (4), A.
    pub drag: Parameter,
    /// Residual variance of the filtered balance, A².
    pub variance: f32,
    /// Number of rows.
    pub rows: u32,
}

impl Friction {
    /// The sum of all scores: a number if each is one.
    pub(crate) fn scores(&self) -> f32 {
        let of_load = match self.load {
            LoadTerms::Unknown => 0.0,
            LoadTerms::Measured { inverse_torque_constant, load_friction } => {
                inverse_torque_constant.score + load_friction.score
            }
            LoadTerms::Weight(amplitude) => amplitude.score,
        };
        let always = [&self.inertia, &self.viscous, &self.coulomb, &self.offset, &self.stribeck, &self.drag];
        always.iter().fold(of_load, |sum, term| sum + term.score)
    }

    /// A parameter by its name; `None` for torque constant and load friction if the load is not measured.
    #[must_use]
    pub const fn parameter(&self, term: FrictionTerm) -> Option<Parameter> {
        self.of(term).copied()
    }

    #[inline(never)]
    pub(crate) const fn of(&self, term: FrictionTerm) -> Option<&Parameter> {
        match (term, &self.load) {
            (FrictionTerm::Inertia, _) => Some(&self.inertia),
            (FrictionTerm::Viscous, _) => Some(&self.viscous),
            (FrictionTerm::Coulomb, _) => Some(&self.coulomb),
            (FrictionTerm::InverseTorqueConstant, LoadTerms::Measured { inverse_torque_constant, .. }) => {
                Some(inverse_torque_constant)
            }
            (FrictionTerm::LoadFriction, LoadTerms::Measured { load_friction, .. }) => Some(load_friction),
            (FrictionTerm::InverseTorqueConstant | FrictionTerm::LoadFriction, _) => None,
            (FrictionTerm::Offset, _) => Some(&self.offset),
            (FrictionTerm::Stribeck, _) => Some(&self.stribeck),
            (FrictionTerm::Drag, _) => Some(&self.drag),
        }
    }

    /// Torque constant Kt, N·m/A, with its standard deviation; `None` if the load is not measured.
    #[must_use]
    pub fn torque_constant_nm_a(&self) -> Option<(f32, f32)> {
        let inverse = self.of(FrictionTerm::InverseTorqueConstant)?;
        let value = 1.0 / inverse.value;
        Some((value, inverse.deviation * value * value))
    }

    /// The amplitude of the weight on an axis, A, with its standard deviation; `None` in other plans.
    #[must_use]
    pub const fn weight_a(&self) -> Option<(f32, f32)> {
        match self.load {
            LoadTerms::Weight(Parameter { value, deviation, .. }) => Some((value, deviation)),
            LoadTerms::Unknown | LoadTerms::Measured { .. } => None,
        }
    }

    /// Moment of inertia J, kg·m², by the estimated torque constant.
    #[must_use]
    pub fn inertia_kg_m2(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.inertia.value * kt)
    }

    /// Viscous friction B, N·m·s/rad, by the estimated torque constant.
    #[must_use]
    pub fn viscous_nm_s_rad(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.viscous.value * kt)
    }

    /// Coulomb friction Tc, N·m, by the estimated torque constant.
    #[must_use]
    pub fn coulomb_nm(&self) -> Option<f32> {
        self.torque_constant_nm_a().map(|(kt, _)| self.coulomb.value * kt)
    }
}
