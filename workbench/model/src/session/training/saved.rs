//! What a training has chosen, as settings: a training by these gives the same model.

use super::result::Training;
use crate::session::selection::INDEPENDENT;
use crate::settings::{Geometry, Order, Settings, VelocityFrom};
use crate::train::{Dependence, Recipe, ShaftPlan, Shrink, VelocitySource};

impl Training {
    /// The settings of this training with what it has chosen in place of what was not given.
    #[must_use]
    pub fn settings(&self, given: &Settings) -> Settings {
        let Recipe { structure, estimation, features, covariates, rising, size_spread, .. } = &self.trained.recipe;
        let mut own = given.clone();
        let model = &mut own.model;
        (model.order, model.offset) = (Some(Order(*structure)), structure.offset);
        model.segment = estimation.segment;
        model.features = if features.is_empty() { self.trained.feature_names.clone() } else { features.clone() };
        (model.covariates, model.rising) = (covariates.clone(), rising.clone());
        if let (Shrink::To(chosen), true) = (self.trained.recipe.shrink, model.shrinkage.is_empty()) {
            (model.shrinkage, model.discriminant) = (vec![chosen.lambda, chosen.gamma], None);
        }
        if *size_spread > 0.0 {
            model.size_spread = Some(*size_spread);
        }
        if let Some(plan) = &self.trained.recipe.shaft {
            self.shaft(plan, given, &mut own);
        }
        self.group(&mut own);
        own
    }

    /// Source of the velocity, axis, slip, orders and harmonics.
    fn shaft(&self, plan: &ShaftPlan, given: &Settings, own: &mut Settings) {
        own.model.velocity_from = Some(match plan.velocity {
            VelocitySource::Angle => VelocityFrom::Angle,
            VelocitySource::Channel | VelocitySource::Best => VelocityFrom::Channel,
        });
        own.model.gear_ratio = (!plan.load).then(|| plan.axis.turns().unwrap_or(0.0));
        if plan.orders.is_empty() {
            return;
        }
        let bearing = &mut own.bearing;
        bearing.slip = Some(plan.slip);
        if given.chooses_features() && !bearing.bearing.is_empty() {
            // A bearing alone would track balls and cage too.
            bearing.bearing = Geometry::default();
            bearing.orders = plan.orders.iter().map(|(name, order)| format!("{name}={order}")).collect();
        }
        if let (Some((layout, _)), true) = (&self.trained.parts.shaft, bearing.harmonics.is_empty()) {
            bearing.harmonics = plan.weights[..usize::from(layout.harmonics).min(plan.weights.len())].to_vec();
        }
    }

    /// The column that tells runs, or that none does, if training has looked for one.
    fn group(&self, own: &mut Settings) {
        let validation = &self.trained.recipe.validation;
        if validation.columns.is_none() {
            return;
        }
        own.validation.group = match &self.trained.dependence {
            Some(Dependence { column, .. }) => column.clone(),
            None => validation.groups.is_empty().then(|| INDEPENDENT.to_string()),
        };
    }
}
