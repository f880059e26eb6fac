//! What validation and a structure search say of models of the signals.

use model::structure::{Candidate, Search};
use model::validate::Validation;

use super::percent;

/// Loss of fit for which a smaller structure is preferred, percent.
const LOSS: f64 = 0.5;

/// The sentences on validated models: names of the traces, and the results of the tests.
#[must_use]
pub fn validated<'a>(outcomes: impl IntoIterator<Item = (&'a str, &'a Validation)>) -> String {
    let outcomes: Vec<_> = outcomes.into_iter().collect();
    let all = outcomes.len();
    let untested = outcomes.iter().filter(|(_, found)| found.independence.tested == 0).count();
    let failed: Vec<&(&str, &Validation)> = outcomes.iter().filter(|(_, found)| !found.independence.passed()).collect();
    let fits = outcomes.iter().map(|(_, found)| found.simulation_fit_percent);
    let (least, most) = fits.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), fit| (a.min(fit), b.max(fit)));
    let fit = if all == 1 { format!("{most:.1} %") } else { format!("{least:.1} to {most:.1} %") };
    let of = |count: usize| if all == 1 { "The model".to_owned() } else { format!("{count} of {all} models") };
    let residuals = match (failed.first(), untested) {
        (Some((id, _)), _) => {
            let where_ = if all == 1 { String::new() } else { format!(", the first of them that of {id}") };
            return format!(
                "{} {} not explain all that the inputs do{where_}: the residuals depend on past inputs. Simulation fit {fit}. \
                 Raise nb or nc, or correct the delay, before you interpret the parameters.",
                of(failed.len()),
                if failed.len() == 1 { "does" } else { "do" },
            );
        }
        (None, k) if k == all => "No statement: the fit itself determines every tested lag".to_owned(),
        (None, _) => format!(
            "{} pass{} the test of independence",
            of(all - untested),
            if all - untested == 1 { "es" } else { "" }
        ),
    };
    let cancels = outcomes.iter().any(|(_, found)| !found.map.removable.is_empty());
    let next = if cancels {
        "A pole cancels with zeros: try an order with one a, b and c fewer."
    } else {
        "The order can be used for training."
    };
    let next = if untested == all { "Validate with a longer record or a smaller order." } else { next };
    format!("{residuals}; simulation fit {fit}. {next} A true model fails in about 1 % of records.")
}

/// The sentences on a search; `name` writes a structure.
#[must_use]
pub fn searched(search: &Search, name: impl Fn(&Candidate) -> String) -> String {
    let Some(best) = search.best_fit() else {
        return "No structure could be estimated. Record a motion with more variation.".into();
    };
    if best.fit_percent <= 0.0 {
        return format!(
            "No structure describes the validation traces: the best, {}, is no better than their mean. Check channels, \
             units and delays with bearing-watch audit.",
            name(best)
        );
    }
    let enough =
        search.best_by_count().into_iter().find(|own| own.fit_percent >= best.fit_percent - LOSS && own.stable);
    let own = enough.unwrap_or(best);
    let than = if own.fitted.structure == best.fitted.structure {
        "the best of all".to_owned()
    } else {
        format!("at most {LOSS} less than the best, {}", name(best))
    };
    let share = percent(own.fit_percent / 100.0);
    format!(
        "Order {} is enough: {} parameters, fit {share} on the validation traces, {than}. Test it with bearing-watch validate.",
        name(own),
        own.fitted.parameters(),
    )
}
