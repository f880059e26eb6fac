//! Projections and discriminants against scikit-learn 1.9.1 and numpy, by these lines (x, y, q as below):
//!
//! ```text
//! s = StandardScaler().fit_transform(x); PCA().fit(s).explained_variance_ratio_, abs(PCA().fit(s).components_)
//! PCA().fit(x).explained_variance_ratio_, abs(PCA().fit(x).components_)
//! f = LinearDiscriminantAnalysis().fit(x, y); abs(np.diff(f.transform(q), axis=0))
//! log_softmax([log(prior[k]) - (d := q - x[y == k].mean(0)) @ inv(C) @ d / 2 - slogdet(C)[1] / 2 for k in range(3)])
//!   with C = P below for the linear one, S[k] for the quadratic one, and C for the shrunk one
//! l, g, nu = .25, .1, np.bincount(y) - 1; S = [np.cov(x[y == k].T) for k in range(3)]; P = sum(nu * S) / 21
//! C = ((1 - l) * nu[k] * S[k] + l * 21 * P) / ((1 - l) * nu[k] + l * 21); C = (1 - g) * C + g * np.diag(np.diag(C))
//! ```
//!
//! scikit-learn's discriminants divide scatters by N and N_k, this crate and numpy by N − C and N_k − 1. Therefore
//! scikit-learn's Fisher coordinates are √(24/21) times those of this crate, and its posteriors are slightly more
//! extreme (the lines above with S * nu / (nu + 1) and P * 21 / 24 compute its `predict_log_proba`).

use bearing_watch::plan::Kind;
use nalgebra::{DMatrix, DVector};

use super::fit::fit;
use crate::identify::Structure;
use crate::train::{Candidates, ClassStatistics, FeatureTable, Keep, ProjectionKind, Recipe, Shrink, Shrinkage};

/// Seven, eight and nine rows of three classes.
const X: [[f64; 3]; 24] = [
    [4.41, 0.66, 1.08],
    [-2.52, -0.54, 0.84],
    [-9.09, -3.91, -0.14],
    [-3.30, -3.38, -0.58],
    [-3.59, 0.13, -0.59],
    [-7.00, 0.20, 1.39],
    [-15.11, -3.24, -0.23],
    [6.43, -3.31, -1.06],
    [24.96, 5.41, -0.19],
    [11.37, -0.08, -0.55],
    [22.93, 2.12, -0.76],
    [13.99, 0.59, -0.40],
    [16.98, 4.26, -0.01],
    [30.62, 5.07, -0.86],
    [16.01, 2.01, -0.22],
    [15.92, 4.15, 1.20],
    [-0.36, -3.21, 1.17],
    [5.21, -3.96, -0.37],
    [-2.78, -1.43, 0.91],
    [25.60, 6.09, 0.83],
    [-1.36, -1.36, 0.77],
    [-5.24, -3.34, 0.73],
    [14.89, 1.42, -0.96],
    [10.89, -3.39, 0.52],
];
const Q: [[f64; 3]; 2] = [[5.0, 0.5, 0.2], [-8.0, -3.0, -0.6]];
/// The constants have ten decimals.
const CLOSE: f64 = 1e-9;

fn candidates() -> Candidates {
    let classes = (0..24).map(|k| if k < 7 { 0 } else { usize::from(k >= 15) + 1 }).collect();
    let rows = X.iter().map(|row| DVector::from_column_slice(row)).collect();
    let table = FeatureTable::exact(rows, classes, ["a", "b", "c"].map(String::from).into());
    Candidates {
        table,
        features: ["x1", "x2", "x3"].map(String::from).into(),
        groups: (0..24).collect(),
        covariates: None,
    }
}

fn recipe(projection: ProjectionKind) -> Recipe {
    let structure = Structure::new(1, 1, 1, 1, 1);
    Recipe { projection, priors: vec![0.5, 0.3, 0.2], ..Recipe::new(structure) }
}

fn principal(standardised: bool, ratios: [f64; 3], components: [f64; 9]) {
    let whole = recipe(ProjectionKind::Pca { keep: Keep::Variance(1.0), standardised });
    let fitted = fit(&candidates(), &whole).expect("regular");
    let variances = ClassStatistics::new(&fitted.coordinates).total.diagonal();
    let found = &variances / variances.sum();
    assert!((found - DVector::from_column_slice(&ratios)).amax() < CLOSE);
    let deviations = ClassStatistics::new(&candidates().table).total.diagonal().map(f64::sqrt);
    let scale = if standardised { deviations } else { DVector::from_element(3, 1.0) };
    let vectors = (&fitted.projection.matrix * DMatrix::from_diagonal(&scale)).abs();
    assert!((vectors - DMatrix::from_row_slice(3, 3, &components)).amax() < CLOSE);
    // The number of components for parts of the variance just below and just above the first ratio, and just above the
    // sum of the first two.
    for (part, count) in [(ratios[0] - 1e-6, 1), (ratios[0] + 1e-6, 2), (1.0 - ratios[2] + 1e-6, 3)] {
        let some = recipe(ProjectionKind::Pca { keep: Keep::Variance(part), standardised });
        assert_eq!(fit(&candidates(), &some).expect("regular").projection.matrix.nrows(), count, "{part}");
    }
}

#[test]
fn principal_components_of_standardised_features() {
    let components = [
        0.7053796183,
        0.6626025820,
        0.2517884279,
        0.0111994419,
        0.3447546374,
        0.9386260238,
        0.7087412551,
        0.6649075562,
        0.2357621154,
    ];
    principal(true, [0.6172529725, 0.3306457262, 0.0521013013], components);
}

#[test]
fn principal_components_of_centred_features() {
    let components = [
        0.9779606949,
        0.2080616047,
        0.0174140114,
        0.2020714913,
        0.9641842877,
        0.1718015474,
        0.0525356218,
        0.1644962854,
        0.9849776548,
    ];
    principal(false, [0.9742280645, 0.0229306141, 0.0028413214], components);
}

#[test]
fn fisher_directions() {
    let fitted = fit(&candidates(), &recipe(ProjectionKind::Fisher { components: None })).expect("regular");
    let [p, q] = Q.map(|q| fitted.projection.apply(&DVector::from_column_slice(&q)));
    let apart = (q - p).abs() * (24.0_f64 / 21.0).sqrt();
    assert!((apart - DVector::from_vec(vec![1.2954414557, 1.3514939417])).amax() < CLOSE);
}

fn log_posteriors(recipe: &Recipe, expected: [[f64; 3]; 2]) {
    let fitted = fit(&candidates(), recipe).expect("regular");
    for (q, expected) in Q.iter().zip(expected) {
        let z = fitted.projection.apply(&DVector::from_column_slice(q));
        let found = DVector::from_vec(fitted.densities.log_posteriors(&z, &DVector::zeros(z.len())));
        // Sums of a few tens lose two more digits.
        assert!((&found - DVector::from_column_slice(&expected)).amax() < 10.0 * CLOSE, "{found}");
    }
}

#[test]
fn posteriors_of_linear_quadratic_and_shrunk_discriminants() {
    const LINEAR: [[f64; 3]; 2] =
        [[-0.4258279833, -2.0831075166, -1.5040482056], [-0.0096626050, -5.4458701124, -5.2396735401]];
    const QUADRATIC: [[f64; 3]; 2] =
        [[-0.6217277664, -1.4638646155, -1.4625548662], [-0.0029950443, -30.5049804097, -5.8122934008]];
    const SHRUNK: [[f64; 3]; 2] =
        [[-0.4738464431, -2.0511891732, -1.3910446526], [-0.0180705947, -5.3830302256, -4.3189075996]];
    // Invertible maps, and Fisher's directions with one covariance, do not change the posteriors.
    let all = ProjectionKind::Pca { keep: Keep::Variance(1.0), standardised: true };
    for projection in [ProjectionKind::None, all, ProjectionKind::Fisher { components: None }] {
        log_posteriors(&recipe(projection), LINEAR);
    }
    for projection in [ProjectionKind::None, all] {
        log_posteriors(&Recipe { discriminant: Kind::Quadratic, ..recipe(projection) }, QUADRATIC);
    }
    let shrink = Shrink::To(Shrinkage { lambda: 0.25, gamma: 0.1 });
    log_posteriors(&Recipe { shrink, ..recipe(ProjectionKind::None) }, SHRUNK);
}
