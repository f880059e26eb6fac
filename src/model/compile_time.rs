//! The check of constants at compile time.

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
                    let $crate::model::Constants { sampling, channels, regression, shaft, classifier, .. } = &constants;
                    let regression: &[$crate::model::Regression<Self>] = regression;
                    let shaft: &[$crate::model::ShaftConstants<Self>] = shaft;
                    let parts = $crate::model::Parts {
                        layout: $layout,
                        names: $channels,
                        sampling,
                        channels,
                        regression: match regression {
                            [first, ..] => Some($crate::model::RegressionParts {
                                scale: &first.scale,
                                nominal: &first.nominal,
                                deviation: first.deviation,
                                forgetting: first.forgetting,
                                huber: first.huber,
                                rest: first.rest,
                                settle: first.settle,
                                handover: first.handover,
                            }),
                            [] => None,
                        },
                        shaft: match shaft {
                            [first, ..] => Some($crate::model::ShaftParts {
                                lags: first.lags,
                                balance: &first.balance,
                                orders: &first.tracking.orders,
                                blocks: first.tracking.blocks,
                            }),
                            [] => None,
                        },
                        features: &classifier.features,
                        covariates: &classifier.covariates.list,
                        explained: &classifier.covariates.map,
                        map: &classifier.projection.matrix,
                        feature_means: &classifier.projection.mean,
                        usual: &classifier.projection.usual,
                        means: &classifier.discriminant.means,
                        factors: &classifier.discriminant.factors,
                        log_prior: &classifier.discriminant.log_prior,
                        costs: &classifier.discriminant.costs,
                        reject_cost: classifier.discriminant.reject_cost,
                        healthy: classifier.novelty.class,
                        novelty_mean: &classifier.novelty.mean,
                        novelty_factor: &classifier.novelty.factor,
                        knots: &classifier.novelty.knots,
                        laws: &classifier.novelty.laws,
                        freedom: classifier.novelty.freedom,
                        limit: classifier.novelty.limit,
                        directions: &classifier.novelty.directions.list,
                        runs: $crate::model::RunParts {
                            usual_segments: classifier.novelty.directions.usual_segments,
                            margin: classifier.novelty.directions.margin,
                            most_runs: classifier.novelty.directions.most_runs,
                        },
                        evidence: constants.evidence,
                        labels: &constants.labels,
                    };
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
