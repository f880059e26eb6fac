//! The section of the runs: how far each direction lies above what is usual for the drive, and the size of a defect.

use bearing_watch::alarm::{Contribution, Growth};
use model::core::Embedded;

use crate::Color;
use crate::conclusion::replay::Conclusion;
use crate::page::table::table;
use crate::page::{counted, or_reason, paragraph};
use crate::plot::{self, Series};

/// How far each direction of the alarm lies above what is usual for this drive, run by run, and the size of a defect;
/// empty without such runs.
pub(crate) fn section(model: &Embedded, conclusion: &Conclusion) -> String {
    let runs = conclusion.runs().list();
    let Some(last) = runs.last() else { return String::new() };
    let name = |direction: u8| model.direction_name(conclusion.orders(), direction);
    let series = |(k, one): (usize, &Contribution)| {
        let values = runs.iter().map(|run| run.contributions.get(k).map(|one| f64::from(one.deviations)));
        Series::new(name(one.direction), Color::of(k), over_runs(values))
    };
    let all: Vec<Series> = last.contributions.iter().enumerate().map(series).collect();
    let chart = plot::lines("Features over the runs", "run", "above the usual mean of this drive / sd of runs", &all);
    let size = conclusion.runs().direction().map_or_else(String::new, |direction| {
        let place = usize::from(direction);
        let growths: Vec<Growth> = runs.iter().filter_map(|run| run.growths.get(place).copied()).collect();
        size(&name(direction), Color::of(place), &growths)
    });
    let row = |one: &Contribution| {
        let since = conclusion.risen_since(one).map_or("–", |segment| conclusion.place(segment)).to_owned();
        vec![name(one.direction), format!("{:+.1}", one.deviations), format!("{:.1}", one.score), since]
    };
    let limit = model.evidence_constants().limit;
    let lead = paragraph(&format!(
        "After {}, in {}. The alarm is raised where a score reaches {limit:.1} nats; one run alone never does.",
        counted(runs.len(), "run"),
        conclusion.place(last.last),
    ));
    let head = ["feature", "last run / sd", "score / nats", "risen since"];
    or_reason(chart) + &size + &lead + &table(&head, &last.contributions.iter().map(row).collect::<Vec<_>>())
}

/// Values over the number of their run.
fn over_runs(values: impl Iterator<Item = Option<f64>>) -> Vec<(f64, f64)> {
    values.enumerate().filter_map(|(place, value)| value.map(|value| (place as f64 + 1.0, value))).collect()
}

/// The size of a defect in a direction, at the end of each run, with its interval and the named size.
fn size(name: &str, color: Color, growths: &[Growth]) -> String {
    let Some(last) = growths.last() else { return String::new() };
    let points = over_runs(growths.iter().map(|growth| Some(f64::from(growth.size.value))));
    let ends = growths.iter().map(|growth| [growth.size.low, growth.size.high].map(f64::from));
    let band: Vec<(f64, f64, f64)> = points.iter().zip(ends).map(|((run, _), [low, high])| (*run, low, high)).collect();
    let named = [1.0, growths.len() as f64].map(|run| (run, f64::from(last.named)));
    let series = [
        Series::new(format!("{name}, with its 90 % interval"), color, points).with_band(band),
        Series::new("size that a single segment shows", Color::of(6), named).dashed(),
    ];
    let axis = "above the usual mean of this drive / sd of usual runs";
    or_reason(plot::lines("Size of a defect over the runs", "run", axis, &series))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use bearing_watch::alarm::Interval;

    #[test]
    fn the_size_has_its_band_and_the_named_size() {
        let growth = |value: f32| Growth {
            size: Interval { value, low: value - 1.0, high: value + 2.0 },
            named: 9.5,
            ..Growth::default()
        };
        let html = size("outer <order>", Color::of(2), &[0.0, 0.5, 4.0].map(growth));
        assert_eq!(check(&html), Ok(()));
        let json = html.split("application/json\">").nth(1).and_then(|rest| rest.split("</script>").next());
        let drawn: serde_json::Value = serde_json::from_str(json.expect("a figure")).expect("JSON");
        let [band, line, named] = &drawn["data"].as_array().expect("traces")[..] else { panic!("{drawn}") };
        assert_eq!(band["x"], serde_json::json!([1.0, 2.0, 3.0, 3.0, 2.0, 1.0]));
        assert_eq!(band["y"], serde_json::json!([-1.0, -0.5, 3.0, 6.0, 2.5, 2.0]));
        assert_eq!(
            (&line["x"], &line["y"]),
            (&serde_json::json!([1.0, 2.0, 3.0]), &serde_json::json!([0.0, 0.5, 4.0]))
        );
        assert_eq!((&named["y"], &named["line"]["dash"]), (&serde_json::json!([9.5, 9.5]), &"dash".into()));
        assert!(drawn["layout"]["yaxis"]["range"][1].as_f64().is_some_and(|high| high > 9.5), "{}", drawn["layout"]);
    }

    #[test]
    fn without_runs_nothing_is_drawn() {
        assert_eq!(size("outer order", Color::of(0), &[]), "");
    }
}
