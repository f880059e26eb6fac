//! From the settings to the bearing whose nominal life is computed.

use crate::Error;
use crate::life::{LoadedBearing, Rolling, Torque};
use crate::settings::sections::bearing::Bearing;
use crate::settings::sections::settings::Settings;
use crate::trace::Channels;

/// The nominal life that the settings want.
#[derive(Clone, Debug, PartialEq)]
pub enum WantedLife {
    /// Nothing is said of a bearing.
    None,
    /// What has to be given.
    Lacks(String),
    /// Of this bearing.
    Of(LoadedBearing),
}

impl Settings {
    /// The bearing whose life is wanted, in recordings of these channels.
    ///
    /// # Errors
    /// A rating, factor or constant that is not positive, or a geometry that is none.
    pub fn life(&self, channels: &Channels) -> Result<WantedLife, Error> {
        let loads = &self.bearing;
        let wrong =
            loads.given().into_iter().find(|(_, value)| value.is_some_and(|value| !value.is_finite() || value <= 0.0));
        if let Some((name, _)) = wrong {
            return Err(Error::Usage(format!("--{name} is a number above 0")));
        }
        if loads.bearing.is_empty() && !loads.is_loaded() {
            return Ok(WantedLife::None);
        }
        let outer_order = loads.orders()?.into_iter().find(|(name, _)| name == "outer").map(|(_, order)| order);
        Ok(match loads.loaded(channels) {
            Ok(bearing) => WantedLife::Of(LoadedBearing { outer_order, ..bearing }),
            Err(lacks) => WantedLife::Lacks(format!("no nominal life: {lacks}")),
        })
    }
}

impl Bearing {
    fn given(&self) -> [(&'static str, Option<f64>); 4] {
        [
            ("load-rating-n", self.load_rating_n),
            ("bearing-load-n", self.bearing_load_n),
            ("bearing-load-per-nm", self.bearing_load_per_nm),
            ("torque-constant-nm-a", self.torque_constant_nm_a),
        ]
    }

    /// Whether a rating or a load is given, beside the geometry.
    #[must_use]
    pub fn is_loaded(&self) -> bool {
        self.given().iter().any(|(_, value)| value.is_some())
    }

    /// The bearing without its geometry, or what has to be given.
    fn loaded(&self, channels: &Channels) -> Result<LoadedBearing, String> {
        let Some(rating_n) = self.load_rating_n else {
            return Err(
                "give the bearing's basic dynamic load rating C of the catalogue, --load-rating-n NEWTON".into()
            );
        };
        let Some(shaft) = &channels.shaft else {
            return Err("the model has no angle of the shaft, by which turns are counted; train with --angle".into());
        };
        let by_torque = match (self.bearing_load_per_nm, &shaft.load, self.torque_constant_nm_a) {
            (None, ..) if self.bearing_load_n.is_none() => {
                return Err("give the bearing's load, --bearing-load-n NEWTON for a constant one or \
                            --bearing-load-per-nm FACTOR for one that follows the torque"
                    .into());
            }
            (None, ..) => None,
            (Some(factor), _, Some(constant)) => Some((factor, Torque::Current(constant))),
            (Some(factor), Some(_), None) => Some((factor, Torque::Sensor)),
            (Some(_), None, None) => {
                return Err("the model has no load sensor; give the motor's --torque-constant-nm-a".into());
            }
        };
        Ok(LoadedBearing {
            rating_n,
            rolling: if self.rollers { Rolling::Rollers } else { Rolling::Balls },
            constant_n: self.bearing_load_n.unwrap_or(0.0),
            by_torque,
            outer_order: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::sections::geometry::Geometry;
    use crate::trace::ShaftChannels;

    fn channels(load: bool) -> Channels {
        let rig = ShaftChannels::rig();
        let shaft = ShaftChannels { load: rig.load.clone().filter(|_| load), ..rig };
        Channels { shaft: Some(shaft), ..Channels::new("i", "v", "t") }
    }

    fn wanted(bearing: Bearing, channels: &Channels) -> WantedLife {
        Settings { bearing, ..Settings::default() }.life(channels).expect("settings that fit")
    }

    #[test]
    fn what_lacks_is_named() {
        let numbers = ["9", "3", "17", "10"].map(String::from);
        let geometry = Bearing { bearing: Geometry::of_words(&numbers).expect("a bearing"), ..Bearing::default() };
        let rated = Bearing { load_rating_n: Some(13_500.0), ..geometry.clone() };
        let loaded = Bearing { bearing_load_per_nm: Some(40.0), ..rated.clone() };
        let lacks = |bearing: &Bearing, channels: &Channels, part: &str| match wanted(bearing.clone(), channels) {
            WantedLife::Lacks(words) => assert!(words.contains(part), "{words}"),
            other => panic!("{other:?}"),
        };
        lacks(&geometry, &channels(true), "--load-rating-n");
        lacks(&rated, &channels(true), "--bearing-load-n NEWTON");
        lacks(&loaded, &channels(false), "--torque-constant-nm-a");
        lacks(&loaded, &Channels::new("i", "v", "t"), "--angle");
        assert_eq!(wanted(Bearing::default(), &channels(true)), WantedLife::None);
        let negative = Bearing { bearing_load_n: Some(-1.0), ..rated };
        let refused = Settings { bearing: negative, ..Settings::default() }.life(&channels(true));
        assert!(refused.is_err_and(|error| error.to_string().contains("--bearing-load-n")));
    }

    #[test]
    fn the_torque_is_of_the_constant_if_it_is_given_or_of_the_sensor() {
        let bearing = Bearing { load_rating_n: Some(1e4), bearing_load_per_nm: Some(40.0), ..Bearing::default() };
        let by = |bearing: &Bearing, load: bool| match wanted(bearing.clone(), &channels(load)) {
            WantedLife::Of(LoadedBearing { by_torque, outer_order: None, .. }) => by_torque,
            other => panic!("{other:?}"),
        };
        assert_eq!(by(&bearing, true), Some((40.0, Torque::Sensor)));
        let motor = Bearing { torque_constant_nm_a: Some(0.05), ..bearing };
        assert_eq!([true, false].map(|load| by(&motor, load)), [Some((40.0, Torque::Current(0.05))); 2]);
    }
}
