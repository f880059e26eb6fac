//! What the detector of a trained model computes: nothing that no feature reads.
//!
//! Training tries the features of all parts. A detector whose features are drag and the orders of a bearing does not
//! need the difference model, nor the inputs that only this takes. The shaft stays, since its balance finds signals that
//! contradict each other. What is left gives the same bits as in training.

use bearing_watch::model::{Channel, Covariates, Feature};
use bearing_watch::plan::{RegressionLayout, RunTime, ShaftLayout, Signal};

use crate::core::Parts;
use crate::core::features::Catalogue;
use crate::identify::Structure;
use crate::train::Trained;

/// The parts that a detector computes, with its features by their places there.
pub(crate) struct Read {
    pub(crate) parts: Parts,
    pub(crate) features: Vec<Feature>,
    pub(crate) covariates: Covariates<RunTime>,
    /// Place of each channel of the training.
    channels: Vec<Option<u8>>,
}

impl Trained {
    /// What the detector computes.
    pub(crate) fn read(&self) -> Read {
        let mut read = Read {
            parts: self.sight.parts(&self.parts),
            features: self.core_features.clone(),
            covariates: self.core_covariates.clone(),
            channels: (0..self.parts.channels.len()).map(|place| u8::try_from(place).ok()).collect(),
        };
        if !self.recipe.identify && self.block_mean == 1 {
            read.leave_regression_out();
        }
        read
    }

    /// Whether the detector estimates the parameters of the difference model.
    #[must_use]
    pub fn identifies(&self) -> bool {
        self.read().parts.regression.is_some()
    }

    /// The features that the detector can tell, in the order of its reports.
    #[must_use]
    pub fn catalogue(&self) -> Catalogue {
        let (read, all) = (self.read(), self.recipe.catalogue());
        let place = |(name, place): (String, u8)| Some((name, read.channels[usize::from(place)]?));
        Catalogue {
            structure: if read.parts.regression.is_some() { all.structure } else { Structure::new(0, 0, 0, 0, 0) },
            orders: all.orders,
            averaged: all.averaged.into_iter().filter_map(place).collect(),
        }
    }
}

impl Read {
    fn all(&self) -> impl Iterator<Item = Feature> {
        self.features.iter().copied().chain(self.covariates.list.iter().map(|own| own.feature))
    }

    /// Gives features and covariates their new places.
    fn replace(&mut self, moved: impl Fn(Feature) -> Feature) {
        self.features.iter_mut().for_each(|feature| *feature = moved(*feature));
        self.covariates.list.iter_mut().for_each(|own| own.feature = moved(own.feature));
    }

    /// Leaves the difference model out, with the channels that no other part takes.
    fn leave_regression_out(&mut self) {
        let is_read = self.all().any(|feature| matches!(feature, Feature::Parameter(_) | Feature::LogVariance));
        let (Some((regression, _)), Some((shaft, _))) = (&self.parts.regression, &self.parts.shaft) else { return };
        let of_shaft = channels([Some(shaft.current), shaft.velocity, shaft.load]);
        // An input whose mean is a feature has its column by the difference model.
        if is_read || self.parts.averaged & of_regression(regression) & !of_shaft != 0 {
            return;
        }
        let kept = of_shaft | self.parts.averaged;
        let places = (0..self.parts.channels.len()).scan(0, |next, place| {
            let own = (kept >> place & 1 == 1).then_some(*next);
            *next += u8::from(own.is_some());
            Some(own)
        });
        self.channels = places.collect();
        self.parts = self.parts.without_regression(&self.channels);
        let places = self.channels.clone();
        let to = |place: u8| places[usize::from(place)].unwrap_or(0);
        self.replace(|feature| match feature {
            Feature::ChannelMean(place) => Feature::ChannelMean(to(place)),
            Feature::ChannelRms(place) => Feature::ChannelRms(to(place)),
            other => other,
        });
    }
}

impl Parts {
    /// The parts without the regression, whose channels have these new places.
    fn without_regression(&self, places: &[Option<u8>]) -> Self {
        let to = |place: u8| places[usize::from(place)].unwrap_or(0);
        let signal = |own: Signal| Signal { channel: to(own.channel), minus: own.minus.map(to) };
        let shaft = self.shaft.clone().map(|(layout, constants)| {
            let ShaftLayout { current, velocity, load, .. } = layout;
            let signals = (signal(current), velocity.map(signal), load.map(signal));
            (ShaftLayout { current: signals.0, velocity: signals.1, load: signals.2, ..layout }, constants)
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

fn of_regression(layout: &RegressionLayout) -> u16 {
    let RegressionLayout { structure, y, u1, u2, .. } = layout;
    channels([Some(*y), (structure.nb > 0).then_some(*u1), (structure.nc > 0).then_some(*u2)])
}

/// The channels of these signals, as a bit mask.
fn channels(signals: [Option<Signal>; 3]) -> u16 {
    let of_signal = |signal: Signal| [Some(signal.channel), signal.minus];
    signals.into_iter().flatten().flat_map(of_signal).flatten().fold(0, |mask, place| mask | 1 << place)
}
