//! Models that watch a shaft: which are accepted, and what is read back.

use bearing_watch::model::{Feature, Field, Lags};
use bearing_watch::plan::RunTime;
use bearing_watch::{FrictionTerm, Model, ModelError};

use crate::rig::{model, model_of_angle};

#[test]
fn every_feature_of_the_shaft_is_read_back() {
    let good = model(Lags::default(), true, 5000);
    let of_terms = [Feature::Friction, Feature::FrictionScore, Feature::LogFriction];
    let terms = of_terms.into_iter().flat_map(|of| FrictionTerm::ALL.map(of));
    let others = [Feature::LogFrictionVariance, Feature::OrderScore(2), Feature::LogOrderAmplitude(1)];
    let mut buffer = vec![0; 4096];
    for feature in terms.chain(others) {
        let mut constants = good.constants().clone();
        constants.classifier.features[0] = feature;
        let model = Model::new(good.plan(), constants).expect("a good model");
        let length = model.to_bytes("", &mut buffer).expect("fits");
        assert_eq!(Model::from_bytes(&buffer[..length]), Ok(model), "{feature:?}");
    }
}

/// Scales are powers of two, and the scale of a cell times the limit of its signal is at most 1e14.
#[test]
fn scales_are_bounded_by_the_limit_of_their_own_signal() {
    let measured = model(Lags::default(), true, 5000);
    let differenced = model_of_angle(Lags::default(), 5000);
    let limit = |model: &Model<RunTime>, channel: usize| model.constants().channels[channel].limit;
    let [current, velocity, load] = [0, 1, 2].map(|channel| limit(&measured, channel));
    assert!(current != velocity && velocity != load, "limits that tell the signals apart");
    // Half a turn a sample.
    let fastest = std::f32::consts::PI / differenced.constants().shaft[0].balance.interval_s;
    for (model, velocity, [current, load]) in
        [(&measured, velocity, [current, load]), (&differenced, fastest, [0, 1].map(|k| limit(&differenced, k)))]
    {
        let rate = model.constants().shaft[0].balance.filter.rate_per_s;
        for (cell, limit) in [(0, velocity * rate), (1, velocity), (3, load), (5, load), (7, current)] {
            let largest = (1e14 / limit).log2().floor().exp2();
            for (scale, expected) in
                [(largest, Ok(())), (2.0 * largest, Err(ModelError::OutOfRange(Field::LimitTimesScale)))]
            {
                let mut constants = model.constants().clone();
                constants.shaft[0].balance.scale[cell] = scale;
                let found = Model::new(model.plan(), constants).map(|_| ());
                assert_eq!(found, expected, "cell {cell}, limit {limit}, scale {scale:e}");
            }
        }
    }
}
