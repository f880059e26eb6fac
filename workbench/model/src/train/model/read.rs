//! What the detector of a trained model computes: nothing that no feature reads.
//!
//! Training tries the features of all parts. A detector whose features are drag and the orders of a bearing does not
//! need the difference model, nor the inputs that only this takes. The shaft stays, since its balance finds signals
//! that contradict each other. What is left gives the same bits as in training.

use bearing_watch::model::{Channel, Covariates, Feature};
use bearing_watch::plan::{Load, RegressionLayout, RunTime, ShaftLayout, Signal};

use crate::core::Parts;
use crate::core::features::Catalogue;
use crate::identify::Structure;
use crate::train::Trained;

/// The parts that a detector computes, with its features by their places there.
pub(crate) struct Read {
    pub(crate) parts: Parts,
    pub(crate) features: Vec<Feature>,
    pub(crate) covariates: Covariates<RunTime>,
}

impl Trained {
    /// What the detector computes.
    pub(crate) fn read(&self) -> Read {
        let (parts, mut features) = (self.sight.parts(&self.parts), self.core_features.clone());
        let mut covariates = self.core_covariates.clone();
        if self.identifies() {
            return Read { parts, features, covariates };
        }
        let places = self.places();
        let to = |place: u8| places[usize::from(place)].unwrap_or(0);
        let moved = |feature: &mut Feature| match feature {
            Feature::ChannelMean(place) | Feature::ChannelRms(place) => *place = to(*place),
            _ => {}
        };
        features.iter_mut().chain(covariates.list.iter_mut().map(|covariate| &mut covariate.feature)).for_each(moved);
        Read { parts: parts.without_regression(&places), features, covariates }
    }

    /// Whether the detector estimates the parameters of the difference model: a feature reads it, or it is asked for.
    #[must_use]
    pub fn identifies(&self) -> bool {
        let (Some((regression, _)), Some((shaft, _))) = (&self.parts.regression, &self.parts.shaft) else {
            return self.parts.regression.is_some();
        };
        let explaining = self.core_covariates.list.iter().map(|covariate| &covariate.feature);
        let is_read = |feature: &Feature| matches!(feature, Feature::Parameter(_) | Feature::LogVariance);
        // An input whose mean is a feature has its column by the difference model; means of blocks are its rows.
        let averages_input = self.parts.averaged & of_regression(regression) & !of_shaft(shaft) != 0;
        let is_needed =
            averages_input || self.block_mean > 1 || self.core_features.iter().chain(explaining).any(is_read);
        self.recipe.identify || is_needed
    }

    /// The features that the detector can tell, in the order of its reports.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        let all = self.recipe.catalogue();
        if self.identifies() {
            return all;
        }
        let places = self.places();
        let moved = |(name, place): (String, u8)| Some((name, places[usize::from(place)]?));
        Catalogue {
            structure: Structure::new(0, 0, 0, 0, 0),
            orders: all.orders,
            averaged: all.averaged.into_iter().filter_map(moved).collect(),
        }
    }

    /// The place of each channel without those that only the difference model takes.
    fn places(&self) -> Vec<Option<u8>> {
        let kept = self.parts.averaged | self.parts.shaft.as_ref().map_or(0, |(shaft, _)| of_shaft(shaft));
        let mut next = 0..;
        (0..self.parts.channels.len())
            .map(|channel| if kept >> channel & 1 == 1 { next.next() } else { None })
            .collect()
    }
}

impl Parts {
    /// The parts without the regression, whose channels have these new places.
    fn without_regression(&self, places: &[Option<u8>]) -> Self {
        let to = |place: u8| places[usize::from(place)].unwrap_or(0);
        let signal = |own: Signal| Signal { channel: to(own.channel), minus: own.minus.map(to) };
        let shaft = self.shaft.clone().map(|(layout, constants)| {
            let ShaftLayout { current, velocity, load, .. } = layout;
            let load = match load {
                Load::Measured(own) => Load::Measured(signal(own)),
                Load::Unknown | Load::Weight { .. } => load,
            };
            (ShaftLayout { current: signal(current), velocity: velocity.map(signal), load, ..layout }, constants)
        });
        let there = |(channel, place): (&Channel, &Option<u8>)| place.map(|_| *channel);
        let averaged = (0..self.channels.len()).filter(|place| self.averaged >> place & 1 == 1);
        Self {
            channels: self.channels.iter().zip(places).filter_map(there).collect(),
            regression: None,
            shaft,
            averaged: averaged.filter_map(|place| places[place]).fold(0, |mask, place| mask | 1 << place),
        }
    }
}

fn of_shaft(layout: &ShaftLayout) -> u16 {
    channels([Some(layout.current), layout.velocity, layout.load.measured()])
}

fn of_regression(layout: &RegressionLayout) -> u16 {
    let RegressionLayout { structure, y, u1, u2, .. } = layout;
    channels([Some(*y), (structure.nb > 0).then_some(*u1), (structure.nc > 0).then_some(*u2)])
}

/// The channels of these signals, as a bit mask.
fn channels(signals: [Option<Signal>; 3]) -> u16 {
    let of_signal = |signal: Signal| [Some(signal.channel), signal.minus];
    signals.into_iter().flatten().flat_map(of_signal).flatten().fold(0, |mask, place| mask | 1 << place)
}
