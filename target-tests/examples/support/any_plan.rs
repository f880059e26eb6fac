//! A plan whose layout is drawn at run time, without an allocator, and random models of it.

use bearing_watch::model::{
    Background, Channel, Classifier, Constants, Covariate, Covariates, Direction, Directions, Discriminant,
    EvidenceConstants, Feature, Forgetting, KNOTS, Label, Lags, Novelty, Projection, Regression, Sampling,
    ShaftConstants, TorqueBalance, TrackedOrder, Tracking,
};
use bearing_watch::plan::{
    Bounds, Cells, Kind, Layout, Load, Memory, Method, Plan, RegressionLayout, ShaftLayout, Signal, Structure,
};
use bearing_watch::{FrictionTerm, Model};

use super::support::damage::{CHANNELS, Dice};
use super::support::shaft::{BALANCE, BLOCKS};

/// Most columns of a row, cells of delays and filters, orders, features, coordinates, directions and classes.
const COLUMNS: usize = 20;
const DELAYS: usize = 20;
const FILTERS: usize = 12;
const ORDERS: usize = 4;
const FEATURES: usize = 6;
const COORDINATES: usize = 3;
const DIRECTIONS: usize = 3;
const CLASSES: usize = 3;

bearing_watch::plan! {
    /// A layout up to these lengths.
    pub struct AnyPlan(Bounds {
        channels: CHANNELS,
        columns: COLUMNS,
        parameters: COLUMNS,
        delays: DELAYS,
        filters: FILTERS,
        orders: ORDERS,
        averages: CHANNELS,
        features: FEATURES,
        covariates: 0,
        coordinates: COORDINATES,
        rising: COORDINATES,
        directions: DIRECTIONS,
        classes: CLASSES,
        map: COORDINATES * FEATURES,
        densities: CLASSES * COORDINATES * (COORDINATES + 1) / 2,
    });
}

/// Values of current, velocity, load and reference, and the angle.
pub type Values = bearing_watch::plan::Values<[f32; CHANNELS]>;

/// A number below `end`, as a count.
fn below(dice: &mut Dice, end: u8) -> u8 {
    dice.below(u32::from(end)) as u8
}

/// One of a list.
fn one_of<T: Copy, const N: usize>(dice: &mut Dice, list: [T; N]) -> T {
    list[dice.below(N as u32) as usize]
}

/// A random layout, whose parts fit each other in most cases.
fn layout(dice: &mut Dice) -> Layout {
    let [current, velocity, load, reference] = [0, 1, 2, 3].map(Signal::channel);
    let parts = dice.below(8);
    let regression = (parts != 0).then(|| {
        let counts = [below(dice, 5), below(dice, 4), below(dice, 4), below(dice, 6), below(dice, 6)];
        let [na, nb, nc, nkb, nkc] = counts;
        let structure = Structure::new(na, nb, nc, nkb, nkc);
        RegressionLayout {
            structure: if dice.below(2) == 0 { structure } else { structure.with_offset() },
            method: one_of(dice, [Method::LeastSquares, Method::Instruments]),
            memory: one_of(dice, [Memory::Segment, Memory::Fading]),
            y: current,
            u1: if dice.below(4) == 0 { reference.minus(velocity) } else { reference },
            u2: load,
        }
    });
    let shaft = (parts < 5).then(|| ShaftLayout {
        current,
        velocity: (dice.below(3) > 0).then_some(velocity),
        load: match dice.below(4) {
            0 => Load::Unknown,
            1 => Load::Weight { axis_q32: dice.roll(), changes: dice.roll().is_multiple_of(2) },
            _ => Load::Measured(load),
        },
        orders: below(dice, 5),
        harmonics: 1 + below(dice, 3),
        decimation: 1 + below(dice, 2),
    });
    let coordinates = 1 + below(dice, 3);
    Layout {
        channels: CHANNELS as u8,
        regression,
        shaft,
        // All channels are averaged, so that none is without use.
        averaged: 0b1111,
        features: coordinates + below(dice, 4),
        covariates: 0,
        coordinates,
        rising: below(dice, coordinates + 1),
        directions: below(dice, DIRECTIONS as u8 + 1),
        classes: 1 + below(dice, 3),
        discriminant: one_of(dice, [Kind::Linear, Kind::Quadratic]),
    }
}

fn feature(dice: &mut Dice, layout: &Layout) -> Feature {
    let channel = below(dice, CHANNELS as u8);
    let averaged = one_of(dice, [Feature::ChannelMean(channel), Feature::ChannelRms(channel)]);
    let regressed = match layout.parameters() as u8 {
        0 => averaged,
        n => {
            let parameter = Feature::Parameter(below(dice, n));
            one_of(dice, [parameter, Feature::LogVariance])
        }
    };
    let friction = match layout.shaft {
        None => averaged,
        Some(_) => {
            let term = one_of(dice, [FrictionTerm::Inertia, FrictionTerm::Viscous, FrictionTerm::Drag]);
            let own = [Feature::Friction(term), Feature::FrictionScore(term), Feature::LogFriction(term)];
            let own = one_of(dice, own);
            one_of(dice, [own, own, own, Feature::LogFrictionVariance])
        }
    };
    let order = match layout.orders() as u8 {
        0 => friction,
        orders => {
            let order = below(dice, orders);
            one_of(dice, [Feature::OrderScore(order), Feature::LogOrderAmplitude(order)])
        }
    };
    one_of(dice, [regressed, regressed, friction, order, averaged])
}

/// Factors of covariances, packed by rows, the pivot of each row first.
fn factors<C: Cells<f32>>(dice: &mut Dice, count: usize, coordinates: usize) -> C {
    let packed = coordinates * (coordinates + 1) / 2;
    let pivot = |place: usize| (0..coordinates).any(|i| place % packed == i * (2 * coordinates + 1 - i) / 2);
    C::from_fn(count, |place| if pivot(place) { 1.5 + dice.unit() } else { 0.3 * dice.unit() })
}

/// Directions along and across coordinates, of skewed and of other laws.
fn directions(dice: &mut Dice, plan: AnyPlan) -> Directions<AnyPlan> {
    let layout = plan.layout();
    let direction = |dice: &mut Dice| {
        let mut direction = Direction {
            coordinate: below(dice, layout.coordinates),
            centre: dice.unit(),
            between: 0.7 + 0.6 * dice.unit(),
            run: 0.5 + 0.4 * dice.unit(),
            segment: 1.5 + dice.unit(),
            skewness: one_of(dice, [0.0, 0.8]),
            ..Direction::UNIT
        };
        if let Some(background) = direction.background.first_mut() {
            *background = Background { coordinate: below(dice, layout.coordinates), weight: dice.unit() };
        }
        direction
    };
    Directions {
        list: Cells::from_fn(layout.directions as usize, |_| direction(dice)),
        usual_segments: 2.0,
        ..Directions::none(plan)
    }
}

fn classifier(dice: &mut Dice, plan: AnyPlan) -> Classifier<AnyPlan> {
    let layout = plan.layout();
    let (count, coordinates, classes) =
        (layout.features as usize, layout.coordinates as usize, layout.classes as usize);
    let line = core::array::from_fn::<_, KNOTS, _>(|k| [2.0 * k as f32, k as f32]);
    let mut novelty = Novelty::none(plan);
    if dice.below(3) > 0 || layout.rising > 0 || layout.directions > 0 {
        novelty.class = Some(0);
        novelty.factor = factors(dice, layout.density(), coordinates);
        (novelty.knots, novelty.freedom, novelty.limit) = (line, 30.0, 5.0);
        novelty.laws = Cells::filled(layout.laws(), line);
        novelty.directions = directions(dice, plan);
    }
    Classifier {
        features: Cells::from_fn(count, |_| feature(dice, &layout)),
        covariates: Covariates { list: Cells::filled(0, Covariate::BLANK), map: Cells::filled(0, [0.0; 2]) },
        projection: Projection {
            matrix: Cells::from_fn(layout.map(), |_| dice.unit()),
            mean: Cells::from_fn(count, |_| dice.unit()),
            usual: Cells::from_fn(count, |_| 0.5 + 0.5 * dice.unit()),
        },
        discriminant: Discriminant {
            means: Cells::from_fn(layout.means(), |_| 3.0 * dice.unit()),
            factors: factors(dice, layout.densities(), coordinates),
            log_prior: Cells::filled(classes, [0.0, -core::f32::consts::LN_2, -1.098_612_3][(classes - 1) % 3]),
            costs: Cells::from_fn(layout.costs(), |k| if k / classes == k % classes { 0.0 } else { 1.0 }),
            reject_cost: if dice.below(2) == 0 { f32::INFINITY } else { 0.4 },
        },
        novelty,
    }
}

/// A slow pole with quick ones, in δ-form, and small inputs.
fn regression(dice: &mut Dice, plan: AnyPlan, layout: &RegressionLayout) -> Regression<AnyPlan> {
    let Structure { na, nb, nc, .. } = layout.structure;
    let t: &[f32] = match na {
        1 => &[-0.1],
        2 => &[-0.1, 0.5],
        3 => &[-0.08, 0.4, 0.1],
        _ => &[-0.08, 0.4, 0.1, 0.02],
    };
    let mut constants = Regression::new(plan);
    let nominal = constants.nominal.cells_mut();
    nominal.iter_mut().zip(t).for_each(|(cell, t)| *cell = *t);
    nominal.iter_mut().skip(na as usize).take((nb + nc) as usize).for_each(|cell| *cell = 0.3 * dice.unit());
    (constants.settle, constants.handover) = (dice.below(20) as u16, dice.below(30) as u16);
    if layout.memory == Memory::Fading {
        (constants.forgetting, constants.rest) = (Forgetting { lambda: 0.995, floor: 1.0 }, 1e-4);
    }
    constants
}

fn shaft(dice: &mut Dice, plan: AnyPlan) -> ShaftConstants<AnyPlan> {
    let order = |dice: &mut Dice| {
        let weights = [1.0, 0.5 + 0.5 * dice.unit(), 0.25];
        TrackedOrder { slip_ratio: dice.unit(), ..TrackedOrder::new(4.0 + 3.5 * dice.unit(), weights) }
    };
    ShaftConstants {
        lags: Lags { current: 2.0 + 2.0 * dice.unit(), velocity: 1.0 + dice.unit(), load: 1.5 + 1.5 * dice.unit() },
        balance: TorqueBalance {
            settle: 16,
            row_interval: 2 + below(dice, 8),
            adapt_after_rows: one_of(dice, [8, 48, u16::MAX]),
            ..BALANCE
        },
        tracking: Tracking { orders: Cells::from_fn(plan.layout().orders(), |_| order(dice)), blocks: BLOCKS },
    }
}

/// A random model; `None` if its parts do not fit each other.
pub fn model(dice: &mut Dice) -> Option<Model<AnyPlan>> {
    let layout = layout(dice);
    let plan = AnyPlan::of(layout)?;
    let channel = |name, unit, limit| Channel {
        stuck_samples: if limit < 200.0 { 40 } else { 0 },
        ..Channel::within(name, unit, limit)
    };
    let channels = [
        channel("current_a", "A", 100.0),
        channel("velocity_rad_s", "rad/s", 500.0),
        channel("load_nm", "N·m", 2.0),
        channel("velocity_ref_rad_s", "rad/s", 500.0),
    ];
    let labels = ["healthy", "spall", "roughness"].map(Label::constant);
    let block_mean = if layout.regression.is_some() { 1 + dice.below(3) as u16 } else { 1 };
    let constants = Constants {
        sampling: Sampling { interval_s: BALANCE.interval_s, park: None, block_mean, segment_samples: 300 },
        channels: Cells::from_fn(CHANNELS, |k| channels[k % CHANNELS]),
        regression: Cells::from_fn(layout.regressed(), |_| match &layout.regression {
            Some(own) => regression(dice, plan, own),
            None => Regression::new(plan),
        }),
        shaft: Cells::from_fn(layout.watched(), |_| shaft(dice, plan)),
        classifier: classifier(dice, plan),
        evidence: EvidenceConstants { limit: 12.0, cap: 5.0, segments_a_run: 2, ..EvidenceConstants::NONE },
        labels: Cells::from_fn(layout.classes as usize, |k| labels[k % CLASSES]),
    };
    Model::new(plan, constants).ok()
}
