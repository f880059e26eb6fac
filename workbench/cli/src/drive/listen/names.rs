//! What a hello says of the other frames of its stream.

use bearing_watch::model::Feature;
use bearing_watch::telemetry::{Hello, Source};

use model::core::coordinates;
use model::core::features::Catalogue;
use model::identify::Structure;
use model::session::ModelFile;

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
    pub(super) healthy: Option<u8>,
    pub(super) features: Vec<String>,
    coordinates: Vec<String>,
    pub(super) orders: Vec<f32>,
    /// Length of a segment.
    segment_s: Option<f64>,
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
        let features: Vec<String> = hello.features().flatten().map(name).collect();
        let coordinate = |(place, feature): (usize, Option<u8>)| {
            coordinates::name(place, feature.and_then(|feature| Some(features.get(usize::from(feature))?.as_str())))
        };
        let coordinates = hello.coordinates().enumerate().map(coordinate).collect();
        // The decimal number that single precision stands for: 0.002, not 0.0020000000949949026.
        let interval_s = hello.interval_s.to_string().parse().ok().filter(|step: &f64| *step > 0.0);
        let classes = hello.classes().map(String::from).collect();
        let samples = f64::from(hello.segment_samples) * f64::from(hello.block_mean);
        let segment_s = interval_s.map(|step| samples * step);
        let (source, with_angle, healthy) = (hello.source, hello.with_angle, hello.healthy);
        let stream = Some(stream);
        Self {
            stream,
            source,
            interval_s,
            channels,
            with_angle,
            classes,
            healthy,
            features,
            coordinates,
            orders,
            segment_s,
        }
    }

    /// Those of a drive with this model, of which no hello comes.
    pub(super) fn of_model(ModelFile { model, notes }: &ModelFile) -> Self {
        let features =
            (0..model.model().plan().layout().features).map(|place| model.feature_name(&notes.orders, place));
        let shaft = model.model().constants().shaft.first();
        let orders = shaft.map_or(&[][..], |shaft| &shaft.tracking.orders);
        let orders = orders.iter().map(|order| order.order()).collect();
        let (features, coordinates) = (features.collect(), model.coordinate_names(&notes.orders));
        Self { classes: model.classes.clone(), features, coordinates, orders, ..Self::default() }
    }

    /// With the names of features and coordinates of the model, which has names of its orders, if classes, orders and
    /// numbers of features and coordinates are those of the drive.
    pub(super) fn named_by(self, of_model: &Self) -> Self {
        let sizes = |own: &Self| [own.features.len(), own.coordinates.len()];
        let same =
            (&self.classes, &self.orders, sizes(&self)) == (&of_model.classes, &of_model.orders, sizes(of_model));
        let Self { features, coordinates, .. } = of_model.clone();
        if same { Self { features, coordinates, ..self } } else { self }
    }

    /// Length of so many segments.
    pub(super) fn time_s(&self, segments: u32) -> Option<f64> {
        self.segment_s.map(|segment_s| f64::from(segments) * segment_s)
    }

    /// Name of a class.
    pub(super) fn class(&self, class: u8) -> String {
        self.classes.get(usize::from(class)).cloned().unwrap_or_else(|| format!("class {}", u16::from(class) + 1))
    }

    /// Name of a coordinate.
    pub(super) fn coordinate(&self, place: u8) -> String {
        let place = usize::from(place);
        coordinates::name(place, self.coordinates.get(place).map(String::as_str))
    }

    /// Names of the channels.
    pub(super) fn channel_names(&self) -> Vec<&str> {
        self.channels.iter().map(|(name, _)| name.as_str()).collect()
    }
}

/// Streams whose names are kept.
const STREAMS: usize = 16;

/// The names of the streams of a line, of which one is shown.
#[derive(Debug, Default)]
pub(super) struct Streams {
    /// The stream that is shown is the last one.
    known: Vec<Names>,
    /// Other names of a known stream, which one frame alone does not change.
    doubted: Option<Names>,
}

impl Streams {
    /// The names of the stream that is shown; empty before the first hello.
    pub(super) fn shown(&self) -> Option<&Names> {
        self.known.last()
    }

    /// The names of a stream.
    pub(super) fn of(&self, stream: u32) -> Option<&Names> {
        self.known.iter().find(|own| own.stream == Some(stream))
    }

    /// Takes the names of a hello; returns whether others are shown now.
    pub(super) fn hello(&mut self, names: Names) -> bool {
        if self.shown() == Some(&names) {
            self.doubted = None;
            return false;
        }
        let place = self.known.iter().position(|own| own.stream == names.stream);
        if place.is_some_and(|place| self.known[place] != names) && self.doubted.as_ref() != Some(&names) {
            self.doubted = Some(names);
            return false;
        }
        self.doubted = None;
        place.map(|place| self.known.remove(place));
        if self.known.len() == STREAMS {
            self.known.remove(0);
        }
        self.known.push(names);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_of_the_same_drive_names_its_orders() {
        let names = |features: &[&str], orders: &[f32]| Names {
            classes: vec!["healthy".into()],
            features: features.iter().map(|name| (*name).to_owned()).collect(),
            orders: orders.to_vec(),
            ..Names::default()
        };
        let (drive, model) = (names(&["order_5.41"], &[5.41]), names(&["order_outer"], &[5.41]));
        assert_eq!(drive.clone().named_by(&model).features, ["order_outer"]);
        for other in [names(&["order_outer"], &[5.4]), names(&["drag", "order_outer"], &[5.41])] {
            assert_eq!(drive.clone().named_by(&other), drive);
        }
        assert_eq!(drive.clone().named_by(&Names { classes: vec![], ..model }), drive);
    }

    #[test]
    fn a_single_hello_changes_no_stream() {
        let names =
            |stream, class: &str| Names { stream: Some(stream), classes: vec![class.into()], ..Names::default() };
        let mut streams = Streams::default();
        assert!(streams.hello(names(1, "a")) && !streams.hello(names(1, "a")));
        assert!(!streams.hello(names(1, "forged")) && !streams.hello(names(1, "a")));
        assert!(!streams.hello(names(1, "b")) && streams.hello(names(1, "b")), "said twice");
        assert!(streams.hello(names(2, "forged")));
        assert_eq!(streams.of(1), Some(&names(1, "b")));
        assert_eq!((streams.shown(), streams.of(3)), (Some(&names(2, "forged")), None));
        for stream in 3..60 {
            assert!(streams.hello(names(stream, "x")));
        }
        assert_eq!(streams.known.len(), STREAMS);
    }
}
