//! What a training says of its model.

use model::evaluate::Confusion;
use model::train::{Scores, Trained};

use super::{listed, percent};

/// The sentences; `healthy` is whether the model has a healthy class, `held_out` the result on other traces, and
/// `validated` the cross-validated scores.
#[must_use]
pub fn words(trained: &Trained, healthy: bool, held_out: Option<&Confusion>, validated: Option<&Scores>) -> String {
    let classes = trained.classes.len();
    let names = listed(&trained.feature_names);
    let mut text = match classes {
        1 if healthy => format!("A model of the healthy drive is trained, on {names}."),
        _ => format!("A model that tells {} apart is trained, on {names}.", listed(&trained.classes)),
    };
    if !healthy {
        text += " It has no healthy class: it cannot say that a drive is healthy, and raises no alarm.";
    }
    text += &found(trained);
    text += &sure(classes, held_out, validated);
    if trained.doubted.is_some() || trained.dependence.is_some() {
        text += " There are doubts about the healthy records: read them below first.";
    }
    text
}

/// Sizes of defects that the chosen features find.
fn found(trained: &Trained) -> String {
    let Some(chosen) = &trained.automatic else { return String::new() };
    let own = chosen.winner();
    let known = |half: f64, sizes: &[f64]| sizes.last().is_some_and(|last| half <= *last);
    let seen = own.detected.iter().filter(|one| known(one.half_a, &one.sizes_a));
    let seen: Vec<String> = seen.map(|one| format!("{} from {:.2e} A", one.kind, one.half_a)).collect();
    let hidden = own.detected.iter().filter(|one| !known(one.half_a, &one.sizes_a));
    let hidden: Vec<String> = hidden.map(|one| one.kind.clone()).collect();
    let mut text = String::new();
    if !seen.is_empty() {
        text += &format!(" Of defects added to healthy records it finds half: {}.", listed(&seen));
    }
    if !hidden.is_empty() {
        text += &format!(" It does not find half of these at any compared size: {}.", listed(&hidden));
    }
    text
}

/// The error rate, and what to do next.
fn sure(classes: usize, held_out: Option<&Confusion>, validated: Option<&Scores>) -> String {
    if let Some(confusion) = held_out.filter(|confusion| confusion.total() > 0) {
        let rate = confusion.error_rate();
        let next =
            if confusion.wrong() == 0 { "Use it with bearing-watch replay." } else { "Look at the wrong ones below." };
        return format!(
            " Of {} held-out decisions {} are wrong, {} (95 % interval {:.1} to {:.1} %). {next}",
            confusion.total(),
            confusion.wrong(),
            percent(rate.value),
            100.0 * rate.low,
            100.0 * rate.high,
        );
    }
    match validated.filter(|_| classes > 1) {
        Some(scores) => format!(
            " Cross-validated on the training records, {} of {} decisions are wrong. Test it with bearing-watch evaluate on records of \
             another day.",
            percent(scores.error),
            scores.count,
        ),
        None => " No held-out record tests it: run bearing-watch evaluate on records of another day.".into(),
    }
}
