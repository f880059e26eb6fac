//! What holds for every result: a number that is reported is finite, or there is a reason for none.

use bearing_watch::plan::Plan;
use bearing_watch::shaft::ShaftEstimate;
use bearing_watch::{Decision, Estimate, Evidence, FrictionTerm, Report, Verdict};

fn all(what: &str, numbers: impl IntoIterator<Item = f32>) {
    for (place, number) in numbers.into_iter().enumerate() {
        assert!(number.is_finite(), "{what} {place} is {number}");
    }
}

/// Checks every number of a report.
pub fn report<P: Plan>(report: &Report<P>) {
    if let Some(estimate) = report.estimate() {
        of_estimate(estimate);
    }
    if let Some(shaft) = report.shaft() {
        of_shaft(shaft);
    }
    for average in report.averages() {
        all("average", average.mean().into_iter().chain(average.rms()));
    }
    match (&report.verdict, &report.decision) {
        (Verdict::Undetermined(_), _) => {}
        (_, Some(decision)) => of_decision(decision),
        (verdict, None) => panic!("{verdict:?} without a decision"),
    }
}

fn of_estimate<P: Plan>(estimate: &Estimate<P>) {
    all("parameter", estimate.delta().iter().copied());
    all("covariance", estimate.packed_covariance().iter().copied());
    assert!(estimate.variance.is_finite() && estimate.variance >= 0.0, "variance {}", estimate.variance);
}

fn of_shaft<P: Plan>(shaft: &ShaftEstimate<P>) {
    let terms = [
        FrictionTerm::Inertia,
        FrictionTerm::Viscous,
        FrictionTerm::Coulomb,
        FrictionTerm::InverseTorqueConstant,
        FrictionTerm::Offset,
        FrictionTerm::LoadFriction,
        FrictionTerm::Stribeck,
        FrictionTerm::Drag,
    ];
    for parameter in terms.iter().filter_map(|term| shaft.friction.parameter(*term)) {
        all("friction", [parameter.value, parameter.deviation, parameter.score]);
    }
    all("friction variance, usable part", [shaft.friction.variance, shaft.usable]);
    all("velocity ratio", shaft.velocity_ratio);
    for order in shaft.orders() {
        all("order", [order.prominence, order.score, order.amplitude]);
    }
}

fn of_decision<P: Plan>(decision: &Decision<P>) {
    all("posterior", decision.posteriors().iter().copied());
    let sum: f32 = decision.posteriors().iter().sum();
    assert!((sum - 1.0).abs() < 1e-3, "posteriors sum to {sum}");
    all("expected cost", decision.expected_costs().iter().copied());
    all("distance and surprise", [decision.distance, decision.distance_surprise, decision.surprise]);
}

/// Checks the state of an alarm.
pub fn evidence<P: Plan>(evidence: &Evidence<P>) {
    all("score", [evidence.score()]);
}
