//! From the settings to the channels and the plan of the shaft.

use super::bearing::{Bearing, SLIP};
use super::choices::VelocityFrom;
use super::whole::Settings;
use crate::Error;
use crate::trace::ShaftChannels;
use crate::train::ShaftPlan;

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
    /// the orders that are named. The filter that shows the lower orders of ball and cage too hides small pulses.
    pub(super) fn watched(&self, mut plan: ShaftPlan) -> ShaftPlan {
        let named = |name: &str| {
            self.bearing.orders.iter().any(|item| item.split('=').next().is_some_and(|own| own.trim() == name))
        };
        if self.chooses_features() && !self.bearing.bearing.is_empty() {
            plan.orders.retain(|(name, _)| !["ball", "cage"].contains(&name.as_str()) || named(name));
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
        ];
        given.iter().find(|(_, given)| *given).map_or(Ok(()), |(name, _)| {
            Err(Error::Usage(format!("--{name} watches the shaft: give its angle too, --angle CHANNEL")))
        })
    }
}

impl Bearing {
    /// Names and orders, those of the bearing first.
    pub(super) fn orders(&self) -> Result<Vec<(String, f64)>, Error> {
        let mut orders = match self.bearing[..] {
            [] => vec![],
            [balls, ball, pitch, contact] if (1.0..=255.0).contains(&balls) && 0.0 < ball && ball < pitch => {
                let bearing = bearing_watch::shaft::Bearing {
                    balls: balls.round() as u8,
                    ball_diameter: ball as f32,
                    pitch_diameter: pitch as f32,
                    contact_angle_rad: contact as f32,
                };
                let all = [("outer", bearing.outer()), ("inner", bearing.inner()), ("ball", bearing.ball())];
                let all = all.into_iter().chain([("cage", bearing.cage())]);
                all.map(|(name, order)| (name.to_string(), f64::from(order))).collect()
            }
            _ => {
                let problem = "--bearing takes balls, ball diameter, pitch diameter, contact angle in rad, e.g. \
                               9,3,17,0.1745";
                return Err(Error::Usage(problem.into()));
            }
        };
        for item in &self.orders {
            let order = item.split_once('=').and_then(|(name, value)| Some((name.trim(), value.trim().parse().ok()?)));
            let (name, order) = order
                .ok_or_else(|| Error::Usage(format!("--orders \"{item}\": write NAME=ORDER, e.g. outer=3.718")))?;
            orders.push((name.to_string(), order));
        }
        Ok(orders)
    }
}
