//! The features of an estimate, and their relation to the core's δ-parameters.
//!
//! ```text
//! raw = T δ + k,   δ = [δ-parameters, ln σ²],   raw = [a, b, c, constant, ln σ²]            (1)
//! ```
//!
//! The workbench selects and projects raw features; the core extracts δ and applies the composed map. The features of
//! the shaft follow and are the same in both: the parameters of the torque balance, their scores, their logarithms, its
//! residual, and two numbers per order. Averages of channels come last. Parameters and logarithms have errors of known
//! variance.

use bearing_watch::model::{Feature, FeatureValue, TorqueBalance};
use bearing_watch::plan::{Plan as _, RunTime};
use bearing_watch::shaft::ShaftEstimate;
use bearing_watch::{FrictionTerm, Model};
use nalgebra::{DMatrix, DVector};

use crate::Error;
use crate::identify::{Estimate, Structure, Terms};
use crate::near::among;

/// Raw features of a structure: the names of all parameters, then `log_variance`.
#[must_use]
pub fn all_names(structure: Structure) -> Vec<String> {
    let mut names = structure.names();
    names.push("log_variance".into());
    names
}

/// All raw features of an estimate, in the order of [`all_names`].
#[must_use]
pub fn vector(estimate: &Estimate) -> DVector<f64> {
    // The residual of a noise-free simulated record can be zero.
    let log_variance = estimate.variance.max(f64::from(f32::MIN_POSITIVE)).ln();
    DVector::from_iterator(estimate.theta.len() + 1, estimate.theta.iter().copied().chain([log_variance]))
}

/// All raw features of an estimate of the core, in the order of [`all_names`].
#[must_use]
pub fn of_core(structure: Structure, delta: &[f32], variance: f32) -> DVector<f64> {
    let log_variance = f64::from(variance.max(f32::MIN_POSITIVE)).ln();
    let delta = delta.iter().map(|x| f64::from(*x)).chain([log_variance]);
    let mut raw = raw_from_delta(structure) * DVector::from_iterator(structure.parameters() + 1, delta);
    if structure.na > 0 {
        raw[0] -= 1.0; // k of (1)
    }
    raw
}

/// Prefix of the mean of a channel.
pub const MEAN: &str = "mean_";
/// Prefix of the root mean square of a channel.
pub const RMS: &str = "rms_";

/// Names of the parameters of the torque balance, in the core's order; each is in amperes per unit of its signal.
pub const FRICTION: [&str; 8] =
    ["inertia", "viscous", "coulomb", "inverse_kt", "torque_offset", "load_friction", "stribeck", "drag"];

/// The terms of a group of friction: the offset depends on the sensors, not on the bearing.
const GROUPED: usize = 4;

/// What features of a kind are named after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Of {
    /// The terms of the torque balance.
    Term,
    /// The torque balance as a whole.
    TorqueBalance,
    /// The tracked orders.
    Order,
    /// The averaged channels.
    Channel,
}

/// Features that are named alike: a kind of features is a row of [`KINDS`].
struct Kind {
    of: Of,
    /// What is before the name and behind it.
    around: [&'static str; 2],
    /// The word that chooses all of them.
    group: Option<&'static str>,
    /// The core's feature of a term, order or channel.
    feature: fn(u8) -> Feature,
}

fn term(place: u8) -> FrictionTerm {
    FrictionTerm::ALL[usize::from(place)]
}

/// The features after those of the regression, in their order.
const KINDS: [Kind; 8] = [
    Kind { of: Of::Term, around: ["", ""], group: Some("friction"), feature: |k| Feature::Friction(term(k)) },
    Kind {
        of: Of::Term,
        around: ["", "_score"],
        group: Some("friction_scores"),
        feature: |k| Feature::FrictionScore(term(k)),
    },
    Kind {
        of: Of::Term,
        around: ["", "_log"],
        group: Some("friction_logs"),
        feature: |k| Feature::LogFriction(term(k)),
    },
    Kind {
        of: Of::TorqueBalance,
        around: ["balance", "_log_variance"],
        group: None,
        feature: |_| Feature::LogFrictionVariance,
    },
    Kind { of: Of::Order, around: ["order_", ""], group: Some("orders"), feature: Feature::OrderScore },
    Kind { of: Of::Order, around: ["amplitude_", ""], group: None, feature: Feature::LogOrderAmplitude },
    Kind { of: Of::Channel, around: [MEAN, ""], group: None, feature: Feature::ChannelMean },
    Kind { of: Of::Channel, around: [RMS, ""], group: None, feature: Feature::ChannelRms },
];

impl Kind {
    /// The name that a feature of this kind is named after.
    fn named_after<'n>(&self, name: &'n str) -> Option<&'n str> {
        let [before, behind] = self.around;
        let own = name.strip_prefix(before)?.strip_suffix(behind)?;
        (self.of != Of::Term || FRICTION.contains(&own)).then_some(own)
    }

    /// Whether a word chooses this feature.
    fn is_chosen(&self, word: &str, name: &str) -> bool {
        let grouped = |own: &str| self.of != Of::Term || FRICTION[..GROUPED].contains(&own);
        self.group == Some(word) && self.named_after(name).is_some_and(grouped)
    }
}

fn kinds(of: Of) -> impl Iterator<Item = &'static Kind> {
    KINDS.iter().filter(move |kind| kind.of == of)
}

/// The channel of a feature by its name, if it is an average of a channel.
#[must_use]
pub fn averaged(name: &str) -> Option<&str> {
    kinds(Of::Channel).find_map(|kind| kind.named_after(name))
}

/// The order of a feature by its name, if it is the strength of a bearing order.
#[must_use]
pub fn order(name: &str) -> Option<&str> {
    kinds(Of::Order).find_map(|kind| kind.named_after(name))
}

/// Whether a word chooses the strength of this bearing order, alone or with its group.
pub(crate) fn chooses_order(word: &str, order: &str) -> bool {
    kinds(Of::Order).any(|kind| kind.group == Some(word) || kind.named_after(word) == Some(order))
}

/// The term of the torque balance of a feature by its name, on whatever scale.
#[must_use]
pub fn friction(name: &str) -> Option<&str> {
    kinds(Of::Term).find_map(|kind| kind.named_after(name))
}

/// All features of the shaft, in the order of [`Catalogue::shaft`]; those of a part without a result are missing.
/// Without a measured load the torque constant is not estimated, and its features are constant.
pub(crate) fn shaft_values(
    plan: RunTime,
    shaft: &ShaftEstimate<RunTime>,
    balance: &TorqueBalance,
) -> Vec<FeatureValue> {
    let orders = (0..shaft.orders().len()).map(|k| k.to_string()).collect();
    let catalogue = Catalogue { structure: Structure::new(0, 0, 0, 0, 0), orders: Some(orders), averaged: vec![] };
    let each = |(_, feature): &(String, Feature)| feature.value(plan, (None, Some((shaft, balance)), &[]));
    catalogue.shaft().iter().map(|own| each(own).unwrap_or(FeatureValue::MISSING)).collect()
}

/// All features that a model can have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Catalogue {
    /// The regression's structure.
    pub structure: Structure,
    /// Names of the tracked orders, if the shaft is watched.
    pub orders: Option<Vec<String>>,
    /// Names and places of the channels whose averages are features.
    pub averaged: Vec<(String, u8)>,
}

impl Catalogue {
    /// That of a model, by the names of its tracked orders; an order without a name has its number.
    #[must_use]
    pub fn of_model(model: &Model<RunTime>, orders: &[String]) -> Self {
        let layout = model.plan().layout();
        let structure = layout.regression.map_or_else(|| Structure::new(0, 0, 0, 0, 0), |own| own.structure);
        let number = layout.shaft.map_or(0, |shaft| usize::from(shaft.orders));
        let order = |place: usize| orders.get(place).cloned().unwrap_or_else(|| (place + 1).to_string());
        let named = model.constants().channels.iter().map(|channel| channel.name.as_str().to_string()).zip(0_u8..);
        let averaged = named.filter(|(_, place)| (layout.averaged >> place) & 1 == 1).collect();
        Self { structure, orders: Some((0..number).map(order).collect()), averaged }
    }

    /// Names and core features of the shaft.
    #[must_use]
    pub fn shaft(&self) -> Vec<(String, Feature)> {
        if self.orders.is_none() { vec![] } else { self.of_kinds(|of| of != Of::Channel) }
    }

    /// Names and core features of the kinds of these.
    fn of_kinds(&self, is_wanted: impl Fn(Of) -> bool) -> Vec<(String, Feature)> {
        let numbered = |names: &[&str]| names.iter().map(ToString::to_string).zip(0..).collect();
        let each = |Kind { of, around: [before, behind], feature, .. }: &Kind| -> Vec<(String, Feature)> {
            let names: Vec<(String, u8)> = match of {
                Of::Term => numbered(&FRICTION),
                Of::TorqueBalance => numbered(&[""]),
                Of::Order => self.orders.iter().flatten().cloned().zip(0..).collect(),
                Of::Channel => self.averaged.clone(),
            };
            names.into_iter().map(|(name, place)| (format!("{before}{name}{behind}"), feature(place))).collect()
        };
        KINDS.iter().filter(|kind| is_wanted(kind.of)).flat_map(each).collect()
    }

    /// Names and core features after those of the regression: the shaft's, then the averages of channels.
    #[must_use]
    pub fn further(&self) -> Vec<(String, Feature)> {
        let mut all = self.shaft();
        all.extend(self.of_kinds(|of| of == Of::Channel));
        all
    }

    /// Names of all features: those of the regression, the shaft's, and the averages of channels.
    #[must_use]
    pub fn names(&self) -> Vec<String> {
        all_names(self.structure).into_iter().chain(self.further().into_iter().map(|(name, _)| name)).collect()
    }

    /// Indices of the chosen features; without a choice, all parameters of the regression.
    ///
    /// # Errors
    /// The errors of [`choose`].
    pub fn choose(&self, asked: &[String]) -> Result<Vec<usize>, Error> {
        choose_from(&self.names(), self.structure, asked)
    }

    /// The core's feature at an index of δ and the features after it.
    #[must_use]
    pub fn core_feature(&self, place: usize) -> Feature {
        let n = self.structure.parameters();
        match place.checked_sub(n + 1) {
            Some(k) => self.further().get(k).map_or(Feature::LogVariance, |(_, feature)| *feature),
            None if place == n => Feature::LogVariance,
            None => Feature::Parameter(place as u8),
        }
    }

    /// The places of core features, as [`core_feature`](Self::core_feature) gives them.
    #[must_use]
    pub fn places(&self, of: &[Feature]) -> Vec<Option<usize>> {
        let (further, n) = (self.further(), self.structure.parameters());
        let place = |feature: &Feature| match feature {
            Feature::Parameter(place) => Some(usize::from(*place)).filter(|place| *place < n),
            Feature::LogVariance => Some(n),
            _ => further.iter().position(|(_, own)| own == feature).map(|place| place + n + 1),
        };
        of.iter().map(place).collect()
    }

    /// Whether the feature at a place only rises with a defect: score or amplitude of a bearing order.
    #[must_use]
    pub fn rises(&self, place: usize) -> bool {
        matches!(self.core_feature(place), Feature::OrderScore(_) | Feature::LogOrderAmplitude(_))
    }

    /// Name of a core feature; of a regression's parameter, that of the raw parameter at its place.
    #[must_use]
    pub fn name(&self, feature: Feature) -> String {
        let place = self.places(&[feature]).into_iter().next().flatten();
        place.and_then(|place| self.names().get(place).cloned()).unwrap_or_else(|| format!("{feature:?}"))
    }

    /// T of (1), extended by the identity for the features after those of the regression.
    #[must_use]
    pub fn raw_from_delta(&self) -> DMatrix<f64> {
        let own = raw_from_delta(self.structure);
        let n = own.nrows() + self.further().len();
        let mut map = DMatrix::identity(n, n);
        map.view_mut((0, 0), own.shape()).copy_from(&own);
        map
    }

    /// δ of a raw vector, and the features of the shaft after it.
    #[must_use]
    pub fn delta_from_raw(&self, raw: &DVector<f64>) -> DVector<f64> {
        let own = self.structure.parameters() + 1;
        let mut delta = raw.clone();
        delta.rows_mut(0, own).copy_from(&delta_from_raw(self.structure, &raw.rows(0, own).into_owned()));
        delta
    }
}

/// Indices in [`all_names`] of a choice, for example `a,b,log_variance` or `a1,c2`; without a choice, all parameters.
///
/// # Errors
/// An unknown name, or one that occurs twice.
pub fn choose(structure: Structure, asked: &[String]) -> Result<Vec<usize>, Error> {
    choose_from(&all_names(structure), structure, asked)
}

fn choose_from(names: &[String], structure: Structure, asked: &[String]) -> Result<Vec<usize>, Error> {
    if asked.is_empty() {
        return Ok((0..structure.parameters()).collect());
    }
    let mut chosen = Vec::new();
    for name in asked {
        let of_group = |full: &String| {
            full == name
                || match name.as_str() {
                    "a" | "b" | "c" => full[1..].parse::<u8>().is_ok() && full.starts_with(name.as_str()),
                    word => KINDS.iter().any(|kind| kind.is_chosen(word, full)),
                }
        };
        let places: Vec<usize> = (0..names.len()).filter(|&k| of_group(&names[k])).collect();
        if places.is_empty() {
            return Err(Error::Usage(format!(
                "--features: no {name} in this model{} (a, b, c, friction, friction_scores, friction_logs, orders stand \
                 for whole groups)",
                among(name, names)
            )));
        }
        if places.iter().any(|place| chosen.contains(place)) {
            return Err(Error::Usage(format!("--features: {name} is named twice")));
        }
        chosen.extend(places);
    }
    Ok(chosen)
}

/// T of (1).
#[must_use]
pub fn raw_from_delta(structure: Structure) -> DMatrix<f64> {
    let n = structure.parameters() + 1;
    let mut map = DMatrix::identity(n, n);
    let (na, nb, nc) = (structure.na as usize, structure.nb as usize, structure.nc as usize);
    for k in 0..na {
        // a₁ = −1 − t₀ − t₁, a_k = t_{k−1} − t_k
        map[(k, k)] = if k == 0 { -1.0 } else { 1.0 };
        if k + 1 < na {
            map[(k, k + 1)] = -1.0;
        }
    }
    for (start, count) in [(na, nb), (na + nb, nc)] {
        for k in 0..count {
            // b₁ = β₀ + β₁, b_k = β_k − β_{k−1}
            map[(start + k, start + k)] = if k == 0 { 1.0 } else { -1.0 };
            if k + 1 < count {
                map[(start + k, start + k + 1)] = 1.0;
            }
        }
    }
    map
}

/// δ of a raw vector, by the defining sums t₀ = −(1 + Σa), t_k = Σ_{i>k} aᵢ, β₀ = Σb, β_k = −Σ_{j>k} b_j.
#[must_use]
pub fn delta_from_raw(structure: Structure, raw: &DVector<f64>) -> DVector<f64> {
    let (na, nb, nc) = (structure.na as usize, structure.nb as usize, structure.nc as usize);
    let mut delta = raw.clone();
    for k in 0..na {
        let later: f64 = (k..na).map(|i| raw[i]).sum();
        delta[k] = if k == 0 { -(1.0 + later) } else { later };
    }
    for (start, count) in [(na, nb), (na + nb, nc)] {
        for k in 0..count {
            let later: f64 = (k..count).map(|j| raw[start + j]).sum();
            delta[start + k] = if k == 0 { later } else { -later };
        }
    }
    delta
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::Structure;

    #[test]
    fn the_two_maps_are_inverse() {
        for order in [Structure::new(2, 1, 2, 1, 1), Structure::new(3, 3, 3, 1, 1), Structure::new(0, 2, 0, 1, 1)] {
            let structure = order.with_offset();
            let n = structure.parameters() + 1;
            let raw = DVector::from_fn(n, |k, _| 0.3 * (k as f64) - 0.7);
            let mut back = raw_from_delta(structure) * delta_from_raw(structure, &raw);
            if order.na > 0 {
                back[0] -= 1.0;
            }
            assert!((back - raw).amax() < 1e-14); // sums of a few numbers near one
        }
    }

    #[test]
    fn choices_by_group_and_name() {
        let structure = Structure::new(2, 1, 1, 1, 1).with_offset();
        let pick = |names: &[&str]| choose(structure, &names.iter().map(ToString::to_string).collect::<Vec<_>>());
        assert_eq!(pick(&[]).expect("default"), [0, 1, 2, 3, 4]);
        assert_eq!(pick(&["a", "log_variance"]).expect("group"), [0, 1, 5]);
        assert_eq!(pick(&["c1", "offset"]).expect("names"), [3, 4]);
        assert!(pick(&["d"]).is_err() && pick(&["a", "a2"]).is_err());
    }
}
