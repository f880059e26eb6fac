//! Quality of a model: scores and calibration of its posteriors, ranking of its features, shrinkage.

use crate::Class;
use crate::page::table::table;
use crate::page::{or_reason, paragraph};
use crate::plot::{self, ReliabilityBin, ReliabilityClass};
use model::train::{Choice, Gain, Ranked, Ranking, Scores};

/// A reliability plot and a table of the scores compared with those of the priors; `counted` names the counted items.
#[must_use]
pub fn calibration(classes: &[String], scores: &Scores, counted: &str) -> String {
    let bins = |k: usize| {
        let bins = scores.bins[k].iter();
        bins.map(|b| ReliabilityBin { middle: b.middle, posterior: b.posterior, observed: b.observed, count: b.count })
            .collect()
    };
    let of_class = |(k, class)| ReliabilityClass { class, bins: bins(k) };
    let drawn: Vec<ReliabilityClass> = Class::all(classes).into_iter().enumerate().map(of_class).collect();
    let plot = or_reason(plot::reliability("Posteriors beside what came true", counted, &drawn));
    let header = ["score", "posteriors", "priors alone", "gained"];
    let gained = |value: f64, of: f64| {
        if of > 0.0 { format!("{:.1} %", 100.0 * (1.0 - value / of)).replace('-', "−") } else { "–".into() }
    };
    let row = |name: &str, score: model::train::Score| {
        let value = format!("{:.4} ± {:.4}", score.value, score.standard_error).replace(' ', "\u{a0}");
        vec![name.to_string(), value, format!("{:.4}", score.of_prior), gained(score.value, score.of_prior)]
    };
    let rows = [
        row("log score / nats", scores.log),
        row("guarded log score / nats", scores.guarded),
        row("Brier score", scores.brier),
    ];
    let d = scores.decomposition;
    let note = format!(
        "Mean ± standard error over {} {counted}; less is better, 0 is perfect. The guarded \
         score takes a row in a hundred for an outlier, of which it knows the prior only. The Brier score is, within bins, reliability {:.4} \
         − resolution {:.4} + uncertainty {:.4}. Expected calibration error {:.2} %: the mean distance of the points \
         from the diagonal. A bin of few rows says little, as its interval shows.",
        scores.count,
        d.reliability,
        d.resolution,
        d.uncertainty,
        100.0 * scores.calibration_error
    );
    plot + &table(&header, &rows) + &paragraph(&note)
}

/// The features in order, from the first to keep to the first to drop, with reasons.
#[must_use]
pub fn ranking(ranking: &Ranking) -> String {
    let classes = &ranking.classes;
    let pairs = (0..classes.len()).flat_map(|i| (i + 1..classes.len()).map(move |j| (i, j)));
    // With two classes there is only one pair, which equals the total.
    let pairs: Vec<String> = if classes.len() > 2 {
        pairs.map(|(i, j)| format!("{} / {}", classes[i], classes[j])).collect()
    } else {
        vec![]
    };
    let header = ["feature", "Fisher ratio"].map(String::from).into_iter().chain(pairs.clone());
    let header: Vec<String> = header.chain(["gain among all".to_string()]).collect();
    let row = |feature: &Ranked| {
        let ratios = std::iter::once(&feature.fisher).chain(feature.pairs.iter().take(pairs.len()));
        let ratios = ratios.map(|ratio| format!("{ratio:.2}"));
        let among = feature.among_all.as_ref().map_or_else(|| "–".into(), gain);
        std::iter::once(feature.name.clone()).chain(ratios).chain([among]).collect()
    };
    let advice = |feature: &Ranked| {
        let what = if feature.kept { "keep" } else { "drop" };
        vec![feature.name.clone(), what.to_string(), feature.reason.clone()]
    };
    let advices: Vec<Vec<String>> = ranking.features.iter().map(advice).collect();
    let rows: Vec<Vec<String>> = ranking.features.iter().map(row).collect();
    let note = "Fisher ratio: variance of the class means over that within classes, also of each pair of classes. \
                Gain: by how much the cross-validated guarded log score rises where this feature alone is left out of \
                all (± standard error); below twice its error it may be chance. What to do follows from adding features \
                one by one; the numbers there are gains beside those kept.";
    let advices = table(&["feature", "what to do", "why"], &advices);
    paragraph(&ranking.summary()) + &table(&header, &rows) + &advices + &paragraph(note)
}

fn gain(gain: &Gain) -> String {
    let sign = if gain.log < 0.0 { "−" } else { "" };
    format!("{sign}{:.3}\u{a0}±\u{a0}{:.3}", gain.log.abs(), gain.standard_error)
}

/// The grid of cross-validated log scores with the chosen value marked.
#[must_use]
pub fn shrinkage(choice: &Choice) -> String {
    let mut gammas: Vec<f64> = choice.grid.iter().map(|p| p.shrinkage.gamma).collect();
    gammas.sort_by(f64::total_cmp);
    gammas.dedup();
    let mut lambdas: Vec<f64> = choice.grid.iter().map(|p| p.shrinkage.lambda).collect();
    lambdas.sort_by(f64::total_cmp);
    lambdas.dedup();
    let header: Vec<String> =
        std::iter::once("λ \\ γ".to_string()).chain(gammas.iter().map(ToString::to_string)).collect();
    let cell = |lambda: f64, gamma: f64| {
        let at = |s: model::train::Shrinkage| s.lambda.total_cmp(&lambda).is_eq() && s.gamma.total_cmp(&gamma).is_eq();
        let point = choice.grid.iter().find(|point| at(point.shrinkage));
        let mark = if at(choice.shrinkage) { " ←" } else { "" };
        match point {
            Some(point) if point.score.is_finite() => format!("{:.4}{mark}", point.score),
            _ => "–".into(),
        }
    };
    let rows: Vec<Vec<String>> = lambdas
        .iter()
        .map(|&l| std::iter::once(l.to_string()).chain(gammas.iter().map(|&g| cell(l, g))).collect())
        .collect();
    let note = format!(
        "Guarded log score, cross-validated in {} folds, of covariances between the classes' own (λ = 0, quadratic) and one for \
         all (λ = 1, linear), and from there to their diagonal (γ = 1); – where one is singular. Chosen: λ = {}, γ = {}.",
        choice.folds, choice.shrinkage.lambda, choice.shrinkage.gamma
    );
    table(&header, &rows) + &paragraph(&note)
}
