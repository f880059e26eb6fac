//! From the settings to the channels and the plan of the shaft.

use crate::Error;
use crate::core::features;
use crate::settings::sections::bearing::{Bearing, SLIP};
use crate::settings::sections::choices::VelocityFrom;
use crate::settings::sections::geometry::Dimensions;
use crate::settings::sections::settings::Settings;
use crate::trace::ShaftChannels;
use crate::train::{Axis, ShaftPlan};

impl Settings {
    /// Returns the channels and the plan if the shaft is watched: if its angle is given.
    ///
    /// # Errors
    /// Settings of the shaft without an angle, or some that do not fit.
    pub fn shaft(&self, y: &str) -> Result<Option<(ShaftChannels, ShaftPlan)>, Error> {
        let (own, model) = (&self.channels, &self.model);
        let Some(angle) = &own.angle else { return self.refuse_shaft().map(|()| None) };
        let source = match (&own.velocity, model.velocity_from.unwrap_or_default()) {
            (Some(_), source) => source,
            (None, VelocityFrom::Channel) => {
                return Err(Error::Usage("--velocity-from channel needs the channel: --velocity NAME".into()));
            }
            (None, VelocityFrom::Best | VelocityFrom::Angle) => VelocityFrom::Angle,
        };
        let channels = ShaftChannels {
            current: own.current.clone().unwrap_or_else(|| y.into()),
            velocity: own.velocity.clone(),
            load: own.load.clone(),
            angle: angle.clone(),
            reference: own.velocity_ref.clone(),
        };
        let mut plan = ShaftPlan { load: own.load.is_some(), ..ShaftPlan::new(self.bearing.orders()?) };
        plan.current_delay = model.current_delay;
        plan.velocity = source.into();
        plan.slip = self.bearing.slip.unwrap_or(SLIP);
        plan.cutoff_hz = model.balance_cutoff_hz.unwrap_or(plan.cutoff_hz);
        plan.axis = Axis::given(model.gear_ratio);
        if plan.load && plan.axis.turns().is_some() {
            return Err(Error::Usage(
                "--gear-ratio is for an axis whose load is not measured: leave it out, or the channel of the load"
                    .into(),
            ));
        }
        if self.bearing.harmonics.len() > plan.weights.len() {
            return Err(Error::Usage("--harmonics takes at most three weights".into()));
        }
        if !self.bearing.harmonics.is_empty() {
            plan.weights = [0.0; 3];
            plan.fewer_harmonics = false;
            plan.weights.iter_mut().zip(&self.bearing.harmonics).for_each(|(cell, w)| *cell = *w);
        }
        Ok(Some((channels, plan)))
    }

    /// Returns the plan of a training: where it chooses the features, only the races of the bearing are tracked, and
    /// the orders that are named. The filter that shows the lower orders of ball and cage too hides small pulses. Where
    /// the features are given, the orders of a bearing are tracked that they read.
    pub(crate) fn watched(&self, mut plan: ShaftPlan) -> ShaftPlan {
        let named = |name: &str| {
            self.bearing.orders.iter().any(|item| item.split('=').next().is_some_and(|own| own.trim() == name))
        };
        if self.chooses_features() && !self.bearing.bearing.is_empty() {
            plan.orders.retain(|(name, _)| !["ball", "cage"].contains(&name.as_str()) || named(name));
        }
        let is_read = |name: &str| {
            self.model.features.iter().chain(&self.model.covariates).any(|word| features::chooses_order(word, name))
        };
        // Without an order among the features the angle is still checked by them.
        if !self.model.identify && plan.orders.iter().any(|(name, _)| is_read(name)) {
            plan.orders.retain(|(name, _)| is_read(name) || named(name));
        }
        plan
    }

    /// Refuses settings of a shaft whose angle is not given.
    fn refuse_shaft(&self) -> Result<(), Error> {
        let (own, model, bearing) = (&self.channels, &self.model, &self.bearing);
        let given = [
            ("velocity", own.velocity.is_some()),
            ("velocity-from", model.velocity_from.is_some()),
            ("velocity-ref", own.velocity_ref.is_some()),
            ("current", own.current.is_some()),
            ("load", own.load.is_some()),
            ("bearing", !bearing.bearing.is_empty()),
            ("orders", !bearing.orders.is_empty()),
            ("harmonics", !bearing.harmonics.is_empty()),
            ("slip", bearing.slip.is_some()),
            ("current-delay", model.current_delay.is_some()),
            ("balance-cutoff-hz", model.balance_cutoff_hz.is_some()),
            ("gear-ratio", model.gear_ratio.is_some()),
        ];
        given.iter().find(|(_, given)| *given).map_or(Ok(()), |(name, _)| {
            Err(Error::Usage(format!("--{name} watches the shaft: give its angle too, --angle CHANNEL")))
        })
    }
}

impl Bearing {
    /// Names and orders, those of the bearing first.
    pub(crate) fn orders(&self) -> Result<Vec<(String, f64)>, Error> {
        let of_bearing = |own: Dimensions| {
            let bearing = bearing_watch::shaft::Bearing {
                balls: own.balls,
                ball_diameter: own.ball as f32,
                pitch_diameter: own.pitch as f32,
                contact_angle_rad: own.contact_deg.to_radians() as f32,
            };
            let all = [("outer", bearing.outer()), ("inner", bearing.inner()), ("ball", bearing.ball())];
            let all = all.into_iter().chain([("cage", bearing.cage())]);
            all.map(|(name, order)| (name.to_string(), f64::from(order))).collect()
        };
        let mut orders: Vec<(String, f64)> = self.bearing.dimensions().map_or_else(Vec::new, of_bearing);
        for item in &self.orders {
            let order = item.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse().ok()?)));
            let (name, order) = order
                .ok_or_else(|| Error::Usage(format!("--orders \"{item}\": write NAME=ORDER, e.g. outer=3.718")))?;
            orders.push((name.to_string(), order));
        }
        in_order(&orders)?;
        Ok(orders)
    }
}

/// Refuses races and a cage in an order that no bearing has.
fn in_order(orders: &[(String, f64)]) -> Result<(), Error> {
    let of = |name: &str| orders.iter().find(|(own, _)| own == name).map(|(_, order)| *order);
    let (outer, inner, cage) = (of("outer"), of("inner"), of("cage"));
    if let Some((outer, inner)) = outer.zip(inner).filter(|(outer, inner)| outer >= inner) {
        return Err(Error::Usage(format!(
            "--orders: outer={outer} is not below inner={inner}, as it is in every bearing; are they exchanged?"
        )));
    }
    if let Some(cage) = cage.filter(|cage| *cage >= 0.5) {
        return Err(Error::Usage(format!(
            "--orders: cage={cage} is not below 0.5, as it is if the inner ring turns; if the outer one does, give it \
             another name"
        )));
    }
    let Some((outer, inner)) = outer.zip(inner) else { return Ok(()) };
    let (balls, spread) = ((outer + inner).round(), 0.05);
    if (outer + inner - balls).abs() > spread {
        return Err(Error::Usage(format!(
            "--orders: outer={outer} and inner={inner} are not of one bearing: their sum is the number of balls, a whole \
             one"
        )));
    }
    match cage.filter(|cage| (cage * balls / outer - 1.0).abs() > spread) {
        Some(cage) => Err(Error::Usage(format!(
            "--orders: cage={cage} is not of the same bearing: times its {balls} balls it is not outer={outer}"
        ))),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::sections::geometry::Geometry;

    fn orders(bearing: &str, orders: &[&str]) -> Result<Vec<f64>, String> {
        let words: Vec<String> = bearing.split(',').filter(|word| !word.is_empty()).map(String::from).collect();
        let orders = orders.iter().map(ToString::to_string).collect();
        let own = Bearing { bearing: Geometry::of_words(&words)?, orders, ..Bearing::default() };
        own.orders().map(|all| all.into_iter().map(|(_, order)| order).collect()).map_err(|error| error.to_string())
    }

    /// Published by the bearing data centre of CWRU: 5.4152 inner, 3.5848 outer, 0.39828 cage, 4.7135 = 2 times the
    /// ball.
    #[test]
    fn orders_of_a_6205_are_the_published_ones() {
        for bearing in ["6205", "SKF 6205-2RS JEM", "9,7.94,39.04,0"] {
            let found = orders(bearing, &[]).expect(bearing);
            for (order, expected) in found.iter().zip([3.5848, 5.4152, 4.7135 / 2.0, 0.398_28]) {
                assert!((order - expected).abs() < 2e-4, "{bearing}: {found:?}");
            }
        }
        let (degrees, rad) = (orders("9,3,17,10", &[]), orders("9,3,17,0.174533", &[]));
        assert!(degrees.expect("degrees").iter().zip(rad.expect("rad")).all(|(one, other)| (one - other).abs() < 1e-5));
    }

    #[test]
    fn lines_in_an_order_that_no_bearing_has_are_refused() {
        for (given, part) in [
            (&["outer=5.41", "inner=3.58"][..], "are they exchanged"),
            (&["outer=3.58", "inner=3.58"], "not below inner"),
            (&["cage=0.6"], "not below 0.5"),
            (&["outer=3.58", "inner=5.1"], "sum is the number of balls"),
            (&["outer=3.58", "inner=5.42", "cage=0.3"], "times its 9 balls"),
        ] {
            let problem = orders("", given).expect_err(part);
            assert!(problem.contains(part), "{problem}");
        }
        for given in [&["outer=3.58", "inner=5.41", "cage=0.398"][..], &["outer=3.58"], &["unbalance=1", "cage=0.4"]] {
            assert!(orders("", given).is_ok(), "{given:?}");
        }
    }
}
