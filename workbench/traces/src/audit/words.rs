//! What an audit found, as text and as JSON.

use serde_json::{Value, json};

use super::audited::{Audited, Finding, Line, Outcome};
use model::audit::column::Column;
use model::audit::friction::Excited;
use model::audit::signs::Signs;
use model::trace::Tally;
use model::trace::median;

impl Outcome {
    /// The report as lines.
    #[must_use]
    pub fn lines(&self, false_alarm: f64) -> Vec<String> {
        let Self { traces, findings, rotor, lines, terms, weight } = self;
        let mut report: Vec<String> = Vec::new();
        let rows: usize = traces.iter().map(|trace| trace.rows()).sum();
        report.push(format!("{} traces, {rows} rows", traces.len()));
        let times = || traces.iter().filter_map(|trace| trace.times);
        let rates: Vec<f64> = times().map(|times| times.rate_hz).collect();
        match (rates.is_empty(), rotor) {
            (false, _) => {
                let jitters: Vec<f64> = times().map(|times| times.jitter).collect();
                let (rate, jitter) = (median(&rates), 100.0 * median(&jitters));
                report.push(format!("rate: {rate:.4} rows a second, steps scatter by {jitter:.2} %"));
            }
            (true, Some(rate)) => {
                report.push(format!("rate: no time; {rate:.1} rows a second by the lines of the rotor"));
            }
            (true, None) => {
                report.push(
                    "rate: no time column, and no given rate_hz near which the lines of the rotor are sharp".into(),
                );
            }
        }
        let mut missing = Tally::default();
        traces.iter().for_each(|trace| missing.add(&trace.id, trace.missing));
        report.extend(missing.line());
        let first = &traces[0];
        let width = first.names.iter().map(|name| name.chars().count()).max().unwrap_or(0).max("column".len());
        let head = format!(
            "{:width$}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}",
            "column", "mean", "deviation", "least", "largest", "step"
        );
        report.push(format!("\n{head}   ({})", first.id));
        for (name, column) in first.names.iter().zip(&first.columns) {
            let Column { mean, deviation, range: [least, largest], step, .. } = column;
            report.push(format!(
                "{name:width$}  {mean:>12.5}  {deviation:>12.5}  {least:>12.5}  {largest:>12.5}  {step:>12.3e}"
            ));
        }
        if !lines.is_empty() {
            let all = |pick: fn(&Line) -> f64| median(lines.iter().map(pick).collect::<Vec<_>>());
            let (turns, floor, smallest) = (all(|line| line.turns), all(|line| line.floor), all(|line| line.smallest));
            report.push(format!(
                "\nlines of orders, median of {} traces of {turns:.0} turns: floor {floor:.4}; a line of {smallest:.4} stands \
                 out at a false-alarm rate of {false_alarm} (units of the current)",
                lines.len()
            ));
            let firsts: Vec<f64> = lines.iter().map(|line| line.first / line.floor).collect();
            let most = firsts.iter().copied().fold(0.0, f64::max);
            report.push(format!("order 1 over the floor: median {:.1}, largest {most:.1}", median(&firsts)));
        }
        if !terms.is_empty() {
            report
                .push(format!("\nfriction and inertia, at a false-alarm rate of {false_alarm} (units of the current)"));
            report.push(Excited::heading());
            report.extend(terms.iter().map(ToString::to_string));
        }
        report.extend(weight.map(|own| format!("\n{}", own.words())));
        report.push(if findings.is_empty() { "\nnothing found".into() } else { "\nfound:".into() });
        for Finding { what, traces: own } in findings {
            let which = match &own[..] {
                [one] => one.clone(),
                [first, ..] => format!("{} traces, first {first}", own.len()),
                [] => String::new(),
            };
            report.push(format!("  {what}: {which}"));
        }
        report
    }

    /// The report as JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let Self { traces, findings, rotor, lines, terms, weight } = self;
        let column = |(name, column): (&String, &Column)| {
            let Column {
                mean,
                deviation,
                range: [least, largest],
                step,
                every,
                changing,
                held,
                saturated,
                missing,
                outside,
                signs,
            } = column;
            json!({
                "column": name, "mean": mean, "deviation": deviation, "least": least, "largest": largest, "step": step,
                "changes_every_rows": every, "changing": changing, "held": held, "saturated": saturated,
                "missing": missing, "rows_outside": outside.map_or(0, |(_, count)| count), "signs": signs.map(Signs::word)
            })
        };
        let trace = |trace: &Audited| {
            let times = trace.times.map(|times| {
                json!({
                    "rate_hz": times.rate_hz, "jitter": times.jitter, "gaps": times.gaps,
                    "longest_gap_s": times.longest_gap_s, "missing_rows": times.missing, "standing": times.standing
                })
            });
            json!({
                "trace": trace.id, "rows": trace.rows(), "times": times,
                "missing_samples": trace.missing.to_json(),
                "columns": trace.names.iter().zip(&trace.columns).map(column).collect::<Vec<_>>()
            })
        };
        let line = |line: &Line| {
            json!({
                "trace": line.trace, "turns": line.turns, "floor": line.floor, "smallest_line": line.smallest,
                "order_1": line.first
            })
        };
        let finding = |finding: &Finding| json!({ "finding": finding.what, "traces": finding.traces });
        json!({
            "rotor_rate_hz": rotor,
            "traces": traces.iter().map(trace).collect::<Vec<_>>(),
            "lines": lines.iter().map(line).collect::<Vec<_>>(),
            "findings": findings.iter().map(finding).collect::<Vec<_>>(),
            "friction": terms.iter().map(Excited::to_json).collect::<Vec<_>>(),
            "weight": weight.map(|own| own.to_json()),
        })
    }
}
