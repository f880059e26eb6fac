//! A classifier of nine features, three coordinates and three classes for the example models. It is not from a
//! training: it only has to tell a plant from others. With rising coordinates it computes the surprise of the first
//! class, but calls nothing novel.

/// The classifier of these features, for any plan of its size.
macro_rules! classifier {
    ($features:expr) => {
        classifier!($features, None, [[0.0; 2]; bearing_watch::model::KNOTS], [])
    };
    ($features:expr, $healthy:expr, $knots:expr, $laws:expr) => {
        bearing_watch::model::Classifier {
            features: $features,
            covariates: bearing_watch::model::Covariates { list: [], map: [] },
            projection: bearing_watch::model::Projection {
                #[rustfmt::skip]
                                                                matrix: [
                                                                    40.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
                                                                    0.0, 0.0, 8.0, 0.0, 0.0, 8.0, 0.0, 0.0, 0.0,
                                                                    0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.5,
                                                                ],
                mean: [-0.1, 0.6, 0.5, -0.2, -0.05, -0.25, 0.05, -0.05, -4.5],
                usual: [0.0; 9],
            },
            discriminant: bearing_watch::model::Discriminant {
                means: [0.0, 0.0, 0.0, 2.0, 0.0, 1.0, -2.0, 1.0, 0.0],
                #[rustfmt::skip]
                factors: [
                    1.0, -0.1, -0.01, 1.0, 0.1, 1.0,
                    1.0, -0.1, -0.01, 1.0, 0.1, 1.0,
                    1.0, -0.1, -0.01, 1.0, 0.1, 1.0,
                ],
                log_prior: [-1.098_612_3; 3],
                costs: [0.0, 1.0, 1.0, 1.0, 0.0, 1.0, 1.0, 1.0, 0.0],
                reject_cost: f32::INFINITY,
            },
            novelty: bearing_watch::model::Novelty {
                class: $healthy,
                mean: [0.0; 3],
                factor: [1.0, 0.0, 0.0, 1.0, 0.0, 1.0],
                knots: $knots,
                laws: $laws,
                rises: [bearing_watch::model::Rise::NONE; _],
                freedom: 100.0,
                acceptable: f32::INFINITY,
                limit: f32::INFINITY,
                directions: bearing_watch::model::Directions::NONE,
            },
        }
    };
}

pub(crate) use classifier;
