//! Models that watch a shaft: which are accepted, and what is read back.

use bearing_watch::model::{
    Channel, Constants, Feature, Field, KNOTS, Lags, Novelty, Rise, ShaftConstants, TrackedOrder,
};
use bearing_watch::plan::{Layout, LayoutError, Plan, RunTime, ShaftLayout};
use bearing_watch::{FrictionTerm, Model, ModelError};

use crate::shaft::dc_motor::{lag, model, model_of_angle};

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
                let checked = Model::new(model.plan(), constants).map(|_| ());
                assert_eq!(checked, expected, "cell {cell}, limit {limit}, scale {scale:e}");
            }
        }
    }
}

#[test]
fn binary_model_keeps_the_shaft_and_refuses_nonsense() {
    let good = model(lag(0.7), true, 5000);
    let mut buffer = vec![0; 4096];
    let length = good.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).as_ref(), Ok(&good));

    let refused = |field: Field, change: fn(&mut ShaftConstants<RunTime>, &mut [Channel])| {
        let mut bad = good.constants().clone();
        let Constants { shaft, channels, .. } = &mut bad;
        change(&mut shaft[0], channels);
        let error = Err(ModelError::OutOfRange(field));
        assert_eq!(Model::new(good.plan(), bad.clone()).map(|_| ()), error, "{field:?} is accepted");
        let mut buffer = vec![0; 4096];
        let length = Model::identified(good.plan(), bad, good.id()).to_bytes("", &mut buffer).expect("fits");
        assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).map(|_| ()), error, "{field:?} is read");
    };
    refused(Field::SignalLag, |m, _| m.lags.current = 5.1);
    refused(Field::SignalLag, |m, _| m.lags.velocity = -0.1);
    refused(Field::SignalLag, |m, _| m.lags.load = f32::NAN);
    refused(Field::BalanceInterval, |m, _| m.balance.interval_s = 0.0);
    refused(Field::BalanceFilter, |m, _| m.balance.filter.gain = 0.0);
    // The damping of another cut-off.
    refused(Field::BalanceFilter, |m, _| m.balance.filter.damping *= 1.1);
    refused(Field::RowInterval, |m, _| m.balance.row_interval = 0);
    refused(Field::RowInterval, |m, _| m.balance.row_spread = 0.9);
    refused(Field::BalanceVelocity, |m, _| m.balance.sign_velocity_rad_s = 0.0);
    refused(Field::BalanceVelocity, |m, _| m.balance.stribeck_velocity_rad_s = f32::INFINITY);
    refused(Field::BalanceScale, |m, _| m.balance.scale[0] = 0.3);
    refused(Field::LimitTimesScale, |m, _| m.balance.scale[3] = 2.0_f32.powi(50));
    refused(Field::LimitTimesScale, |m, _| m.balance.scale[7] = 2.0_f32.powi(50));
    refused(Field::BalanceNominal, |m, _| m.balance.nominal[4] = f32::INFINITY);
    refused(Field::BalancePrior, |m, _| m.balance.prior[6] = 0.0);
    refused(Field::BalancePrior, |m, _| m.balance.deviation = f32::NAN);
    refused(Field::LargestChange, |m, _| m.balance.largest_change_rad = 0.0);
    refused(Field::LargestChange, |m, _| m.balance.largest_change_rad = f32::NAN);
    refused(Field::ChannelLimit, |_, channels| channels[0].limit = f32::INFINITY);
    refused(Field::StuckSamples, |_, channels| channels[1].stuck_samples = 1);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].order_q16 = 0);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].order_q16 = -70_000);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[0].weights = [0.0; 3]);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[0].weights[1] = -0.1);
    refused(Field::BearingOrder, |m, _| m.tracking.orders[1].slip_ratio = 11.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[0] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[1] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[2] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[3] = 0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[0] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[1] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[2] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.controls[3] = i32::MAX);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.cell_turns_log2 = -7);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.cell_turns_log2 = 11);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.slip = 0.2);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.slowest_rad_s = 0.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.pole = 1.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.high_pass = 1.0);
    refused(Field::OrderBlock, |m, _| m.tracking.blocks.high_pass = -0.01);

    let with = |change: fn(&mut Constants<RunTime>)| {
        let mut constants = good.constants().clone();
        change(&mut constants);
        Model::new(good.plan(), constants).map(|_| ())
    };
    // A gate whose only coordinate rises.
    let gated = |rising: u8, change: fn(&mut Novelty<RunTime>)| {
        let mut constants = good.constants().clone();
        let line = std::array::from_fn(|k| [k as f32; 2]);
        let novelty = &mut constants.classifier.novelty;
        (novelty.class, novelty.limit, novelty.knots) = (Some(0), 4.6, line);
        novelty.factor.fill(1.0);
        (novelty.freedom, novelty.laws) = (20.0, vec![[[0.0; 2]; KNOTS], line]);
        (novelty.acceptable, novelty.rises) = (2.0, vec![Rise { fall: 1.0, reach: 4.0 }; 2]);
        change(novelty);
        Model::new(RunTime::of(Layout { rising, ..good.plan().layout() }).expect("a plan"), constants)
    };
    let rising = gated(1, |_| ()).expect("good");
    let length = rising.to_bytes("", &mut buffer).expect("fits");
    assert_eq!(Model::<RunTime>::from_bytes(&buffer[..length]).as_ref(), Ok(&rising));
    let error = |change: fn(&mut Novelty<RunTime>)| gated(1, change).map(|_| ());
    let place = Err(ModelError::OutOfRange(Field::RisingCoordinates));
    let absent = Err(ModelError::Length(Field::RisingCoordinates));
    assert_eq!(error(|novelty| novelty.laws.clear()), absent);
    assert_eq!(gated(0, |_| ()).map(|_| ()), absent);
    assert_eq!(error(|novelty| novelty.rises.clear()), absent);
    assert_eq!(error(|novelty| novelty.freedom = f32::NAN), place);
    assert_eq!(error(|novelty| novelty.acceptable = 1.0), place);
    assert_eq!(error(|novelty| novelty.rises[1].fall = -1.0), place);
    assert_eq!(error(|novelty| novelty.rises[1].reach = f32::NAN), place);
    assert_eq!(error(|novelty| novelty.laws[1][4] = [3.0; 2]), Err(ModelError::OutOfRange(Field::SurpriseCurve)));

    let count = with(|c| c.shaft[0].tracking.orders.push(TrackedOrder::new(2.0, [1.0, 0.0, 0.0])));
    assert_eq!(count, Err(ModelError::Length(Field::BearingOrder)));
    let unwatched = with(|c| c.shaft.clear());
    assert!(matches!(unwatched, Err(ModelError::Length(_))), "{unwatched:?}");
    let untracked = with(|c| c.classifier.features[0] = Feature::OrderScore(3));
    assert_eq!(untracked, Err(ModelError::OutOfRange(Field::Feature)), "an order that is not tracked");
    let absent = with(|c| c.classifier.features[0] = Feature::LogVariance);
    assert_eq!(absent, Err(ModelError::OutOfRange(Field::Feature)), "a regression that there is not");
    let layout = good.plan().layout();
    for (orders, harmonics) in [(3, 4), (3, 0), (33, 3)] {
        let shaft = layout.shaft.map(|shaft| ShaftLayout { orders, harmonics, ..shaft });
        assert_eq!(Layout { shaft, ..layout }.check(), Err(LayoutError::Orders));
    }
}
