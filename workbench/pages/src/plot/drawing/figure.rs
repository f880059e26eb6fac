//! One figure: plotly's traces and layout as JSON inside a `<figure>`, which the script of the page draws.

use std::fmt::Write as _;

use serde_json::{Map, Value, json};

use super::described::described;
use super::plotly::{Axis, Trace};
use super::theme;
use crate::page::escape::escape;

/// A figure under construction.
pub(in crate::plot) struct Figure {
    title: String,
    traces: Vec<Trace>,
    layout: Map<String, Value>,
    height: u32,
    pub(in crate::plot) notes: Vec<String>,
}

impl Figure {
    pub(in crate::plot) fn new(title: &str, height: u32) -> Self {
        let layout = theme::layout().as_object().cloned().unwrap_or_default();
        Self { title: title.to_owned(), traces: Vec::new(), layout, height, notes: Vec::new() }
    }

    pub(in crate::plot) fn add(&mut self, trace: impl Into<Trace>) {
        self.traces.push(trace.into());
    }

    /// Sets a part of the layout.
    pub(in crate::plot) fn set(&mut self, key: impl Into<String>, value: Value) {
        self.layout.insert(key.into(), value);
    }

    /// Sets an axis, named as in plotly's layout: `xaxis`, `yaxis2`.
    pub(in crate::plot) fn axis(&mut self, key: impl Into<String>, axis: Axis, further: &Value) {
        let mut value = serde_json::to_value(axis).unwrap_or_default();
        merge(&mut value, further);
        self.set(key, value);
    }

    /// Appends to a list of the layout, `shapes` or `annotations`.
    pub(in crate::plot) fn push(&mut self, list: &str, value: Value) {
        if let Value::Array(list) = self.layout.entry(list).or_insert_with(|| json!([])) {
            list.push(value);
        }
    }

    pub(in crate::plot) fn height(&mut self, pixels: u32) {
        self.height = pixels;
    }

    /// Shows the legend between the top of the plots, which are `inner` pixels high, and the top of the figure.
    pub(in crate::plot) fn legend(&mut self, inner: f64, above: f64) {
        self.set("legend", theme::legend(above / inner));
        self.set("showlegend", json!(true));
    }

    /// Adds a note on values that are not finite, if there are any.
    pub(in crate::plot) fn note_gaps(&mut self, missing: usize) {
        match missing {
            0 => {}
            1 => self.notes.push("1 point is not finite and is left out.".to_owned()),
            n => self.notes.push(format!("{n} points are not finite and are left out.")),
        }
    }

    /// Adds a note on points outside the first view, if there are any.
    pub(in crate::plot) fn note_outside(&mut self, outside: usize) {
        match outside {
            0 => {}
            1 => self.notes.push("1 point lies outside the first view; Autoscale shows it.".to_owned()),
            n => self.notes.push(format!("{n} points lie outside the first view; Autoscale shows them.")),
        }
    }

    pub(in crate::plot) fn html(mut self) -> String {
        self.layout.entry("showlegend").or_insert(json!(false));
        let drawn = json!({ "data": self.traces, "layout": self.layout, "config": theme::config(&self.title) });
        // No bracket of a name can end the script.
        let json = drawn.to_string().replace('<', "\\u003c").replace('>', "\\u003e");
        let words = escape(&described(&self.title, &drawn["data"], &drawn["layout"]));
        let (title, height) = (escape(&self.title), self.height);
        let mut out = format!(
            "<figure><figcaption>{title}</figcaption><div class=\"plot\" role=\"img\" aria-label=\"{words}\" style=\"height:{height}px\">\
             <script type=\"application/json\">{json}</script></div>"
        );
        for note in &self.notes {
            let _ = write!(out, "<p class=\"note\">{}</p>", escape(note));
        }
        out.push_str("</figure>");
        out
    }
}

fn merge(value: &mut Value, further: &Value) {
    if let (Value::Object(own), Value::Object(further)) = (value, further) {
        own.extend(further.clone());
    }
}

/// Text of a user for plotly, which reads a few tags in titles, names and hover texts.
pub(in crate::plot) fn text(own: &str) -> String {
    own.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

/// The JSON of a figure, for tests of what is drawn.
#[cfg(test)]
pub(in crate::plot) fn drawn(html: &str) -> Value {
    let json = html.split("application/json\">").nth(1).and_then(|rest| rest.split("</script>").next());
    serde_json::from_str(json.expect("a figure")).expect("valid JSON")
}

/// The traces of a figure with this name, for tests.
#[cfg(test)]
pub(in crate::plot) fn named(html: &str, name: &str) -> Vec<Value> {
    let drawn = drawn(html);
    let traces = drawn["data"].as_array().expect("traces").iter();
    traces.filter(|trace| trace["name"] == name).cloned().collect()
}

#[cfg(test)]
mod tests {
    use super::super::plotly::Scatter;
    use super::*;
    use crate::page::well_formed::check;

    #[test]
    fn names_of_users_leave_neither_the_script_nor_the_page() {
        let mut figure = Figure::new("</script><b>", 100);
        figure.add(Scatter::new(vec![1.0, f64::NAN], vec![2.0, 3.0]).name(text("<i>a & b</i>")));
        let html = figure.html();
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("role=\"img\" aria-label=\"&lt;/script&gt;&lt;b&gt;."), "{html}");
        let trace = &drawn(&html)["data"][0];
        assert_eq!((&trace["x"][1], &trace["name"]), (&Value::Null, &json!("&lt;i&gt;a &amp; b&lt;/i&gt;")));
    }
}
