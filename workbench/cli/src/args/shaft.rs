//! Arguments of the shaft: its channels and the tracked orders.

use bearing_watch::Bearing;
use clap::{Args, ValueEnum};

use model::Error;
use model::trace::ShaftChannels;
use model::train::{ShaftPlan, VelocitySource};

/// The shaft's channels and the bearing; the shaft is watched if --angle is given.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Shaft (friction and bearing orders)")]
pub(crate) struct ShaftArgs {
    /// Angle of the shaft, rad: watches friction and bearing orders
    #[arg(long, value_name = "CHANNEL")]
    angle: Option<String>,
    /// Measured velocity, rad/s; without it, the differences of the angle
    #[arg(long, value_name = "CHANNEL", requires = "angle")]
    velocity: Option<String>,
    /// Where the shaft takes the velocity from
    #[arg(long, value_name = "SOURCE", value_enum, default_value_t = Source::Best, requires = "angle")]
    velocity_from: Source,
    /// Reference of the velocity, rad/s: without --load, training needs it for a torque balance without bias
    #[arg(long, value_name = "CHANNEL", requires = "angle")]
    velocity_ref: Option<String>,
    /// Current, A; same as --y if not given
    #[arg(long, value_name = "CHANNEL", requires = "angle")]
    current: Option<String>,
    /// Load torque, N·m; not measured if not given
    #[arg(long, value_name = "CHANNEL", requires = "angle")]
    load: Option<String>,
    /// Balls, ball and pitch diameter, contact angle in rad, e.g. 9,3,17,0.1745: tracks outer, inner, ball and cage
    #[arg(long, value_name = "N,BD,PD,ANGLE", value_delimiter = ',', num_args = 1, requires = "angle")]
    bearing: Vec<f64>,
    /// Orders to track, events per turn, e.g. outer=3.718,sideband=4.718
    #[arg(long, value_name = "NAME=ORDER", value_delimiter = ',', requires = "angle")]
    orders: Vec<String>,
    /// Weights of an order's first three harmonics [default: 1,0.5,0.25, or the first of them that find more]
    #[arg(long, value_name = "W1,W2,W3", value_delimiter = ',', num_args = 1, requires = "angle")]
    harmonics: Vec<f64>,
    /// Largest relative slip of the bearing's cage that is searched [default: 0.008]
    #[arg(long, value_name = "PART", requires = "angle")]
    slip: Option<f64>,
    /// Lag of the current behind velocity and load, samples; without it, the lags of all three are estimated from the
    /// nominal class
    #[arg(long, value_name = "SAMPLES", requires = "angle")]
    current_delay: Option<f64>,
    /// Cut-off of the torque balance's filter, Hz
    #[arg(long, value_name = "HZ", requires = "angle")]
    balance_cutoff_hz: Option<f64>,
}

/// [`VelocitySource`].
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Source {
    /// Channel or angle, whichever leaves less noise at the bearing orders
    Best,
    /// --velocity
    Channel,
    /// Differences of --angle
    Angle,
}

impl From<Source> for VelocitySource {
    fn from(source: Source) -> Self {
        match source {
            Source::Best => Self::Best,
            Source::Channel => Self::Channel,
            Source::Angle => Self::Angle,
        }
    }
}

impl ShaftArgs {
    /// Returns the channels and the plan if the shaft is watched.
    pub(crate) fn shaft(&self, y: &str) -> Result<Option<(ShaftChannels, ShaftPlan)>, Error> {
        let Some(angle) = &self.angle else {
            return Ok(None);
        };
        let source = match (&self.velocity, self.velocity_from) {
            (Some(_), source) => source,
            (None, Source::Channel) => {
                return Err(Error::Usage("--velocity-from channel needs the channel: --velocity NAME".into()));
            }
            (None, Source::Best | Source::Angle) => Source::Angle,
        };
        let channels = ShaftChannels {
            current: self.current.clone().unwrap_or_else(|| y.into()),
            velocity: self.velocity.clone(),
            load: self.load.clone(),
            angle: angle.clone(),
            reference: self.velocity_ref.clone(),
        };
        let mut plan = ShaftPlan { load: self.load.is_some(), ..ShaftPlan::new(self.orders()?) };
        plan.current_delay = self.current_delay;
        plan.velocity = source.into();
        plan.slip = self.slip.unwrap_or(plan.slip);
        plan.cutoff_hz = self.balance_cutoff_hz.unwrap_or(plan.cutoff_hz);
        if self.harmonics.len() > 3 {
            return Err(Error::Usage("--harmonics takes at most three weights".into()));
        }
        if !self.harmonics.is_empty() {
            plan.weights = [0.0; 3];
            plan.fewer_harmonics = false;
            plan.weights.iter_mut().zip(&self.harmonics).for_each(|(cell, w)| *cell = *w);
        }
        Ok(Some((channels, plan)))
    }

    fn orders(&self) -> Result<Vec<(String, f64)>, Error> {
        let mut orders = match self.bearing[..] {
            [] => vec![],
            [balls, ball, pitch, contact] if (1.0..=255.0).contains(&balls) && 0.0 < ball && ball < pitch => {
                let bearing = Bearing {
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
                return Err(Error::Usage(
                    "--bearing takes balls, ball diameter, pitch diameter, contact angle in rad, e.g. 9,3,17,0.1745"
                        .into(),
                ));
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
