//! The macro that defines a plan, and its check of constants at compile time.

/// Defines a [`Plan`](crate::plan::Plan) and its sample: a unit struct and a struct with one field for each channel.
/// With the feature `bounded` it also defines a plan of all models up to some bounds: `pub struct Small(BOUNDS);`.
///
/// The layout is an expression in which each channel stands for its [`Signal`](crate::plan::Signal). A layout whose
/// parts do not fit does not compile. Channels are `f32` in the unit named; `with angle` adds the field `angle`, which
/// a plan with bearing orders, or with a shaft without a channel of its velocity, needs.
///
/// ```
/// use bearing_watch::plan::{Kind, Layout, Memory, Method, RegressionLayout, Structure};
/// bearing_watch::plan! {
///     /// The plan of one drive.
///     pub struct Drive;
///     /// One sample of that drive.
///     pub struct Sample { current_a: "A", velocity_ref_rad_s: "rad/s", velocity_rad_s: "rad/s", load_nm: "N·m" }
///     layout: Layout {
///         regression: Some(RegressionLayout {
///             structure: Structure::new(2, 1, 2, 1, 1),
///             method: Method::LeastSquares,
///             memory: Memory::Segment,
///             y: current_a,
///             u1: velocity_ref_rad_s.minus(velocity_rad_s),
///             u2: load_nm,
///         }),
///         features: 5,
///         coordinates: 2,
///         classes: 3,
///         discriminant: Kind::Linear,
///         ..Layout::EMPTY
///     }
/// }
/// let _sample = Sample { current_a: 1.5, velocity_ref_rad_s: 40.0, velocity_rad_s: 39.5, load_nm: 0.1 };
/// ```
///
/// A channel that the plan does not use is refused:
///
/// ```compile_fail,E0080
/// use bearing_watch::plan::{Layout, Memory, Method, RegressionLayout, Structure};
/// bearing_watch::plan! {
///     pub struct Drive;
///     pub struct Sample { current_a: "A", velocity_rad_s: "rad/s", load_nm: "N·m" }
///     layout: Layout {
///         regression: Some(RegressionLayout {
///             structure: Structure::new(2, 1, 0, 1, 1),
///             method: Method::LeastSquares,
///             memory: Memory::Segment,
///             y: current_a,
///             u1: velocity_rad_s,
///             u2: load_nm, // not used: nc is 0
///         }),
///         features: 3,
///         coordinates: 2,
///         classes: 2,
///         ..Layout::EMPTY
///     }
/// }
/// ```
#[macro_export]
macro_rules! plan {
    (
        $(#[$plan_doc:meta])* $plan_vis:vis struct $plan:ident;
        $(#[$sample_doc:meta])* $vis:vis struct $sample:ident $(with $angle:ident)? {
            $($channel:ident: $unit:literal),+ $(,)?
        }
        layout: $layout:expr
    ) => {
        $(#[$plan_doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $plan_vis struct $plan;

        $(#[$sample_doc])*
        #[derive(Clone, Copy, Debug, PartialEq)]
        #[allow(non_snake_case, reason = "channels are named as the recordings name them")]
        $vis struct $sample {
            $(#[doc = concat!("Channel in ", $unit, ".")] pub $channel: f32,)+
            $(#[doc = "Mechanical angle of the shaft."] pub $angle: $crate::Angle,)?
        }

        const _: () = {
            const CHANNELS: &[(&str, &str)] = &[$((stringify!($channel), $unit)),+];

            #[allow(non_camel_case_types, non_snake_case, clippy::upper_case_acronyms)]
            enum Place { $($channel),+ }

            #[allow(non_upper_case_globals, unused, reason = "the layout names the channels that it uses")]
            const LAYOUT: $crate::plan::Layout = {
                $(const $channel: $crate::plan::Signal = $crate::plan::Signal::channel(Place::$channel as u8);)+
                $crate::plan::Layout { channels: CHANNELS.len() as u8, ..$layout }
            };

            const _: () = {
                // Evaluated where a plan is compiled, and never in a program.
                if let Err(error) = LAYOUT.check() {
                    panic!("{}", error.message());
                }
                let angle: &[&str] = &[$(stringify!($angle))?];
                assert!(
                    LAYOUT.needs_angle() == (angle.len() == 1),
                    "a plan with bearing orders, or without a velocity, has a sample `with angle`; other plans have none"
                );
            };

            impl $crate::plan::Signals for $sample {
                #[inline(always)]
                #[allow(unused_variables, reason = "not every sample has an angle")]
                fn of(values: &[f32], angle: $crate::Angle) -> Self {
                    Self {
                        $($channel: values.get(Place::$channel as usize).copied().unwrap_or(0.0),)+
                        $($angle: angle,)?
                    }
                }

                #[inline(always)]
                fn value(&self, channel: usize) -> f32 {
                    $(if channel == Place::$channel as usize {
                        return self.$channel;
                    })+
                    0.0
                }

                #[inline(always)]
                #[allow(unreachable_code, reason = "not every sample has an angle")]
                fn angle(&self) -> $crate::Angle {
                    $(return self.$angle;)?
                    $crate::Angle::ZERO
                }
            }

            $crate::plan!(@lengths $plan, Fixed, Present, LAYOUT, |_plan| LAYOUT);

            impl $crate::plan::Plan for $plan {
                type Sample = $sample;

                fn of(layout: $crate::plan::Layout) -> Option<Self> {
                    (layout == LAYOUT).then_some(Self)
                }

                fn channels() -> Option<&'static [(&'static str, &'static str)]> {
                    Some(CHANNELS)
                }
            }

            $crate::plan!(@checked $plan, LAYOUT, CHANNELS);
            $crate::defmt_formats!($plan, $sample, $($channel)+);
        };
    };
    ($(#[$of_plan:meta])* $visibility:vis struct $plan:ident($bounds:expr);) => {
        $(#[$of_plan])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        $visibility struct $plan($crate::plan::Layout);

        const _: () = {
            const BOUNDS: $crate::plan::Bounds = $bounds;

            $crate::plan!(@lengths $plan, Bounded, Bounded, BOUNDS, |plan| plan.0);

            impl $crate::plan::Plan for $plan {
                type Sample = $crate::plan::Values<[f32; BOUNDS.channels]>;

                fn of(layout: $crate::plan::Layout) -> Option<Self> {
                    BOUNDS.hold(&layout).then_some(Self(layout))
                }

                fn channels() -> Option<&'static [(&'static str, &'static str)]> {
                    None
                }
            }

            $crate::defmt_formats!($plan);
        };
    };
    // The lengths of a plan: the results of these functions of a `Layout`, or of what has the same functions. `$layout`
    // gives the layout of a value `$of` of the plan.
    (@lengths $plan:ty, $size:ident, $presence:ident, $lengths:expr, |$of:ident| $layout:expr) => {
        impl $plan {
            /// The layout.
            #[allow(dead_code, reason = "a program may need it of the model only")]
            #[inline(always)]
            #[must_use]
            pub const fn layout(self) -> $crate::plan::Layout {
                let $of = self;
                $layout
            }
        }

        impl $crate::plan::Arranged for $plan {
            #[inline(always)]
            fn layout(self) -> $crate::plan::Layout {
                self.layout()
            }
        }

        impl $crate::plan::SignalLengths for $plan {
            type Channels = $crate::plan::$size<{ $lengths.channels as usize }>;
            type Averaged = $crate::plan::$size<{ $lengths.averages() }>;
        }

        impl $crate::plan::RegressionLengths for $plan {
            type Regressed = $crate::plan::$presence<{ $lengths.regressed() }>;
            type Squares = $crate::plan::$presence<{ $lengths.squares() }>;
            type Instruments = $crate::plan::$presence<{ $lengths.instruments() }>;
            type Columns = $crate::plan::$size<{ $lengths.columns() }>;
            type Packed = $crate::plan::$size<{ $lengths.packed() }>;
            type Parameters = $crate::plan::$size<{ $lengths.parameters() }>;
            type Covariance = $crate::plan::$size<{ $lengths.covariance() }>;
            type Delays = $crate::plan::$size<{ $lengths.delays() }>;
            type Filters = $crate::plan::$size<{ $lengths.filters() }>;
        }

        impl $crate::plan::ShaftLengths for $plan {
            type Watched = $crate::plan::$presence<{ $lengths.watched() }>;
            type Moments = $crate::plan::$size<{ $lengths.moments() }>;
            type Orders = $crate::plan::$size<{ $lengths.orders() }>;
        }

        impl $crate::plan::ClassifierLengths for $plan {
            type Features = $crate::plan::$size<{ $lengths.features as usize }>;
            type Covariates = $crate::plan::$size<{ $lengths.covariates as usize }>;
            type CovariateMap = $crate::plan::$size<{ $lengths.covariate_map_len() }>;
            type Coordinates = $crate::plan::$size<{ $lengths.coordinates as usize }>;
            type Map = $crate::plan::$size<{ $lengths.map() }>;
            type Density = $crate::plan::$size<{ $lengths.density() }>;
            type Densities = $crate::plan::$size<{ $lengths.densities() }>;
            type Laws = $crate::plan::$size<{ $lengths.laws() }>;
            type Directions = $crate::plan::$size<{ $lengths.directions as usize }>;
            type Classes = $crate::plan::$size<{ $lengths.classes as usize }>;
            type Means = $crate::plan::$size<{ $lengths.means() }>;
            type Costs = $crate::plan::$size<{ $lengths.costs() }>;
        }
    };
    // The function `model` of a plan, which can check constants at compile time: inside the expansion every length is
    // known, so that the slices of the view can be made in a constant.
    (@checked $plan:ident, $layout:expr, $channels:expr) => {
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
                let id = {
                    let parts = $crate::plan!(@parts coerced, Self, &constants, $layout, $channels);
                    if let Err(error) = $crate::model::check(&parts) {
                        return Err(error);
                    }
                    $crate::model::identity(&parts)
                };
                Ok($crate::Model::identified(Self, constants, id))
            }
        }
    };
    // The `ModelView` of constants with this layout and these names. An array becomes a slice by the rule of the first
    // name:
    // `coerced` in a constant, where every length is known, and `viewed` by `Cells`.
    (@coerced $array:expr) => { &$array };
    (@viewed $array:expr) => { $crate::plan::Cells::cells(&$array) };
    (@parts $slice:ident, $plan:ty, $constants:expr, $layout:expr, $names:expr) => {{
        let constants: &$crate::model::Constants<$plan> = $constants;
        let classifier = &constants.classifier;
        let (novelty, discriminant) = (&classifier.novelty, &classifier.discriminant);
        let regression: &[$crate::model::Regression<$plan>] = $crate::plan!(@$slice constants.regression);
        let shaft: &[$crate::model::ShaftConstants<$plan>] = $crate::plan!(@$slice constants.shaft);
        $crate::model::ModelView {
            layout: $layout,
            names: $names,
            sampling: &constants.sampling,
            channels: $crate::plan!(@$slice constants.channels),
            regression: match regression {
                [regression, ..] => Some($crate::model::RegressionView {
                    scale: $crate::plan!(@$slice regression.scale),
                    nominal: $crate::plan!(@$slice regression.nominal),
                    forgetting: regression.forgetting,
                    rest: regression.rest,
                    settle: regression.settle,
                    handover: regression.handover,
                }),
                [] => None,
            },
            shaft: match shaft {
                [shaft, ..] => Some($crate::model::ShaftView {
                    lags: shaft.lags,
                    balance: &shaft.balance,
                    orders: $crate::plan!(@$slice shaft.tracking.orders),
                    blocks: shaft.tracking.blocks,
                }),
                [] => None,
            },
            features: $crate::plan!(@$slice classifier.features),
            covariates: $crate::plan!(@$slice classifier.covariates.list),
            covariate_map: $crate::plan!(@$slice classifier.covariates.map),
            map: $crate::plan!(@$slice classifier.projection.matrix),
            feature_means: $crate::plan!(@$slice classifier.projection.mean),
            usual: $crate::plan!(@$slice classifier.projection.usual),
            means: $crate::plan!(@$slice discriminant.means),
            factors: $crate::plan!(@$slice discriminant.factors),
            log_prior: $crate::plan!(@$slice discriminant.log_prior),
            costs: $crate::plan!(@$slice discriminant.costs),
            reject_cost: discriminant.reject_cost,
            healthy: novelty.class,
            novelty_mean: $crate::plan!(@$slice novelty.mean),
            novelty_factor: $crate::plan!(@$slice novelty.factor),
            knots: &novelty.knots,
            laws: $crate::plan!(@$slice novelty.laws),
            rises: $crate::plan!(@$slice novelty.rises),
            freedom: novelty.freedom,
            acceptable: novelty.acceptable,
            limit: novelty.limit,
            directions: $crate::plan!(@$slice novelty.directions.list),
            runs: $crate::model::RunsView {
                usual_segments: novelty.directions.usual_segments,
                margin: novelty.directions.margin,
                most_runs: novelty.directions.most_runs,
            },
            evidence: constants.evidence,
            labels: $crate::plan!(@$slice constants.labels),
        }
    }};
}

/// Implements `defmt::Format` for a plan and its sample; nothing without the feature `defmt`.
#[cfg(feature = "defmt")]
#[doc(hidden)]
#[macro_export]
macro_rules! defmt_formats {
    ($plan:ident) => {
        impl $crate::defmt::Format for $plan {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                $crate::defmt::Format::format(stringify!($plan), formatter);
            }
        }
    };
    ($plan:ident, $sample:ident, $($channel:ident)+) => {
        $crate::defmt_formats!($plan);

        impl $crate::defmt::Format for $sample {
            fn format(&self, formatter: $crate::defmt::Formatter<'_>) {
                $crate::defmt::Format::format(&[$(self.$channel),+], formatter);
            }
        }
    };
}

/// Implements `defmt::Format` for a plan and its sample; nothing without the feature `defmt`.
#[cfg(not(feature = "defmt"))]
#[doc(hidden)]
#[macro_export]
macro_rules! defmt_formats {
    ($plan:ident $(, $sample:ident, $($channel:ident)+)?) => {};
}
