//! The configurations that the studies train.

use bearing_watch::plan::Kind;

use model::identify::Structure;
use model::trace::Channels;
use model::train::{Keep, ProjectionKind, Recipe, ShaftPlan, Shrink, Shrinkage};
use rig::BearingGeometry;

/// Velocity reference as input, current as output: thesis Table 4.1.
pub const REFERENCE_ORDER: Structure = Structure::new(2, 1, 2, 1, 1);

/// Spread of the sizes of a defect. In the logarithm of the drag, half the trained size is 1.4 deviations away.
pub const SIZE_SPREAD: f64 = 0.15;

/// Least squares, all of a, b, c, no projection, linear discriminant.
#[must_use]
pub fn all_parameters() -> Recipe {
    Recipe {
        columns: Channels::new("current_a", "velocity_ref_rad_s", "load_torque_nm"),
        ..Recipe::new(REFERENCE_ORDER)
    }
}

/// Logarithm of the drag and torque constant by the torque balance, and the order of the outer race; quadratic
/// discriminant with halved correlations; no gate.
///
/// Correlations estimated from twenty traces per class are uncertain. With full correlations the recipe fails under a
/// square reference in one of fifteen draws, with halved correlations in one of thirty draws of
/// [`Selection`](super::campaign::Purpose::Selection) traces.
#[must_use]
pub fn shaft() -> Recipe {
    let outer = BearingGeometry::THESIS.orders().outer;
    Recipe {
        shaft: Some(ShaftPlan::new(vec![("outer".into(), outer)])),
        features: ["drag_log", "inverse_kt", "order_outer"].map(String::from).to_vec(),
        discriminant: Kind::Quadratic,
        shrink: Shrink::To(Shrinkage { lambda: 0.0, gamma: 0.5 }),
        ..all_parameters()
    }
}

/// Least squares, only the a-parameters, PCA to two components, linear discriminant.
#[must_use]
pub fn a_only() -> Recipe {
    let projection = ProjectionKind::Pca { keep: Keep::Components(2), standardised: false };
    Recipe { features: vec!["a".into()], projection, ..all_parameters() }
}
