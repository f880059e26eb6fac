//! A figure in words, for readers who hear it: its title, its axis, and the range of each series.

use model::outputs::trimmed;
use serde_json::Value;

/// Series that are named; further ones are counted.
const NAMED: usize = 6;

/// The words of a figure, from its traces and layout as plotly reads them.
pub(in crate::plot) fn described(title: &str, traces: &Value, layout: &Value) -> String {
    let mut words = format!("{title}.");
    let axes = layout.as_object().into_iter().flatten().filter(|(key, _)| key.starts_with("xaxis"));
    let across = axes.filter_map(|(_, axis)| axis["title"]["text"].as_str()).find(|text| !text.is_empty());
    let traces = traces.as_array().map_or(&[][..], Vec::as_slice);
    let all = || traces.iter().filter(|trace| trace["showlegend"] != Value::Bool(false));
    if let Some((low, high)) = range(traces.iter().flat_map(|trace| numbers(&trace["x"]))) {
        words += &format!(" Over {} from {} to {}.", across.unwrap_or("x"), short(low), short(high));
    }
    let series = |trace: &Value| {
        let name = trace["name"].as_str()?;
        let (low, high) = range(numbers(&trace["y"]))?;
        (trace["type"] != "heatmap").then(|| format!("{name}: {} to {}", short(low), short(high)))
    };
    let series: Vec<String> = all().filter_map(series).collect();
    if !series.is_empty() {
        words += &format!(" {}", series[..series.len().min(NAMED)].join("; "));
        words += &if series.len() > NAMED { format!("; and {} more.", series.len() - NAMED) } else { ".".into() };
    }
    words
}

fn numbers(values: &Value) -> impl Iterator<Item = f64> + '_ {
    values.as_array().into_iter().flatten().filter_map(Value::as_f64)
}

fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |range, value| {
        Some(range.map_or((value, value), |(low, high): (f64, f64)| (low.min(value), high.max(value))))
    })
}

/// About three digits.
fn short(value: f64) -> String {
    let size = value.abs();
    let text = match size {
        _ if size > 0.0 && !(1e-3..1e5).contains(&size) => format!("{value:.2e}"),
        _ => {
            let decimals = (2.0 - size.max(1e-3).log10().floor()).clamp(0.0, 5.0) as usize;
            trimmed(value, decimals)
        }
    };
    text.replace('-', "−")
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn words_have_title_axis_and_ranges() {
        let traces = json!([
            { "type": "scatter", "name": "a", "x": [0.0, 2.0], "y": [-1.5, 1234.5] },
            { "type": "scatter", "name": "b", "x": [null, 1.0], "y": [null, 0.0000125] },
            { "type": "scatter", "name": "hidden", "showlegend": false, "x": [1.0], "y": [1.0] },
        ]);
        let layout = json!({ "xaxis": { "title": { "text": "time / s" } } });
        let text = described("Signals", &traces, &layout);
        assert_eq!(text, "Signals. Over time / s from 0 to 2. a: −1.5 to 1234; b: 1.25e−5 to 1.25e−5.");
        assert_eq!(described("t", &json!([]), &json!({})), "t.");
    }
}
