//! The sections of a drive file as plain structs: an option is a field.

pub(crate) mod alarm;
pub(crate) mod bearing;
pub(crate) mod choices;
pub(crate) mod data;
pub(crate) mod geometry;
pub(crate) mod merge;
pub(crate) mod model;
pub(crate) mod order;
pub(crate) mod settings;
pub(crate) mod signals;
pub(crate) mod validation;

pub use alarm::{Alarm, HEALTHY_NAMES, healthy_class};
pub use bearing::Bearing;
pub use choices::{Discriminant, Method, Novelty, Park, Projection, VelocityFrom};
pub use data::Data;
pub use geometry::{Dimensions, Geometry};
pub use model::Model;
pub use order::Order;
pub use settings::Settings;
pub use signals::Signals;
pub use validation::Validation;
