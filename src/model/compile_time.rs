//! The view of constants as slices, and their check at compile time.

/// The [`Parts`](crate::model::Parts) of constants with this layout and these names. An array becomes a slice by the
/// macro's rule of the first name: `coerced` in a constant, where every length is known, and `viewed` by `Cells`.
#[doc(hidden)]
#[macro_export]
macro_rules! model_parts {
    (@coerced $array:expr) => { &$array };
    (@viewed $array:expr) => { $crate::plan::Cells::cells(&$array) };
    ($slice:ident, $plan:ty, $constants:expr, $layout:expr, $names:expr) => {{
        let constants: &$crate::model::Constants<$plan> = $constants;
        let classifier = &constants.classifier;
        let (novelty, discriminant) = (&classifier.novelty, &classifier.discriminant);
        let regression: &[$crate::model::Regression<$plan>] = $crate::model_parts!(@$slice constants.regression);
        let shaft: &[$crate::model::ShaftConstants<$plan>] = $crate::model_parts!(@$slice constants.shaft);
        $crate::model::Parts {
            layout: $layout,
            names: $names,
            sampling: &constants.sampling,
            channels: $crate::model_parts!(@$slice constants.channels),
            regression: match regression {
                [regression, ..] => Some($crate::model::RegressionParts {
                    scale: $crate::model_parts!(@$slice regression.scale),
                    nominal: $crate::model_parts!(@$slice regression.nominal),
                    deviation: regression.deviation,
                    forgetting: regression.forgetting,
                    huber: regression.huber,
                    rest: regression.rest,
                    settle: regression.settle,
                    handover: regression.handover,
                }),
                [] => None,
            },
            shaft: match shaft {
                [shaft, ..] => Some($crate::model::ShaftParts {
                    lags: shaft.lags,
                    balance: &shaft.balance,
                    orders: $crate::model_parts!(@$slice shaft.tracking.orders),
                    blocks: shaft.tracking.blocks,
                }),
                [] => None,
            },
            features: $crate::model_parts!(@$slice classifier.features),
            covariates: $crate::model_parts!(@$slice classifier.covariates.list),
            explained: $crate::model_parts!(@$slice classifier.covariates.map),
            map: $crate::model_parts!(@$slice classifier.projection.matrix),
            feature_means: $crate::model_parts!(@$slice classifier.projection.mean),
            usual: $crate::model_parts!(@$slice classifier.projection.usual),
            means: $crate::model_parts!(@$slice discriminant.means),
            factors: $crate::model_parts!(@$slice discriminant.factors),
            log_prior: $crate::model_parts!(@$slice discriminant.log_prior),
            costs: $crate::model_parts!(@$slice discriminant.costs),
            reject_cost: discriminant.reject_cost,
            healthy: novelty.class,
            novelty_mean: $crate::model_parts!(@$slice novelty.mean),
            novelty_factor: $crate::model_parts!(@$slice novelty.factor),
            knots: &novelty.knots,
            laws: $crate::model_parts!(@$slice novelty.laws),
            rises: $crate::model_parts!(@$slice novelty.rises),
            freedom: novelty.freedom,
            acceptable: novelty.acceptable,
            limit: novelty.limit,
            directions: $crate::model_parts!(@$slice novelty.directions.list),
            runs: $crate::model::RunParts {
                usual_segments: novelty.directions.usual_segments,
                margin: novelty.directions.margin,
                most_runs: novelty.directions.most_runs,
            },
            evidence: constants.evidence,
            labels: $crate::model_parts!(@$slice constants.labels),
        }
    }};
}

/// Gives a plan the function `model`, which can check constants at compile time.
///
/// Inside the expansion every length is known, so that the slices of the view can be made in a constant.
#[doc(hidden)]
#[macro_export]
macro_rules! checked_model {
    ($plan:ident, $layout:expr, $channels:expr) => {
        impl $plan {
            /// The model of these constants. A `const` or `static` that matches the result and panics on the error
            /// does not compile if they do not fit.
            ///
            /// # Errors
            /// The first thing that does not fit.
            #[allow(dead_code, reason = "a plan may read its models from bytes only")]
            pub const fn model(
                constants: $crate::model::Constants<Self>,
            ) -> Result<$crate::Model<Self>, $crate::ModelError> {
                let mark = {
                    let parts = $crate::model_parts!(coerced, Self, &constants, $layout, $channels);
                    if let Err(error) = $crate::model::check(&parts) {
                        return Err(error);
                    }
                    $crate::model::mark(&parts)
                };
                Ok($crate::Model::marked(Self, constants, mark))
            }
        }
    };
}
