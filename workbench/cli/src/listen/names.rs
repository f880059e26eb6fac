//! What a hello says of the other frames of its stream.

use bearing_watch::model::Feature;
use bearing_watch::telemetry::{Hello, Source};

use model::core::features::Catalogue;
use model::identify::Structure;

/// Names and constants of a stream; empty before its hello.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Names {
    pub(super) stream: Option<u32>,
    pub(super) source: Source,
    pub(super) interval_s: Option<f64>,
    /// Names and units.
    pub(super) channels: Vec<(String, String)>,
    pub(super) with_angle: bool,
    pub(super) classes: Vec<String>,
    pub(super) features: Vec<String>,
    pub(super) orders: Vec<f32>,
}

impl Names {
    pub(super) fn of(stream: u32, hello: &Hello<'_>) -> Self {
        let channels: Vec<(String, String)> =
            hello.channels().map(|(name, unit)| (name.to_string(), unit.to_string())).collect();
        let orders: Vec<f32> = hello.orders.iter().collect();
        let catalogue = Catalogue {
            structure: Structure::new(0, 0, 0, 0, 0),
            orders: Some(orders.iter().map(|order| format!("{order:.3}")).collect()),
            averaged: channels.iter().map(|(name, _)| name.clone()).zip(0_u8..).collect(),
        };
        let name = |feature: Feature| match feature {
            Feature::Parameter(place) => format!("delta_{}", u16::from(place) + 1),
            other => catalogue.name(other),
        };
        let features = hello.features().flatten().map(name).collect();
        // The decimal number that single precision stands for: 0.002, not 0.0020000000949949026.
        let interval_s = hello.interval_s.to_string().parse().ok().filter(|step: &f64| *step > 0.0);
        let classes = hello.classes().map(String::from).collect();
        let (source, with_angle) = (hello.source, hello.with_angle);
        Self { stream: Some(stream), source, interval_s, channels, with_angle, classes, features, orders }
    }

    /// Name of a class.
    pub(super) fn class(&self, class: u8) -> String {
        self.classes.get(usize::from(class)).cloned().unwrap_or_else(|| format!("class {}", u16::from(class) + 1))
    }

    /// Names of the channels.
    pub(super) fn channel_names(&self) -> Vec<&str> {
        self.channels.iter().map(|(name, _)| name.as_str()).collect()
    }
}
