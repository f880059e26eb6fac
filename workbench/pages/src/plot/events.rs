//! Moments that are marked in all panels of a figure, with their names in lanes above it, where none covers another.

use serde_json::json;

use super::drawing::figure::{Figure, text};
use super::drawing::numbers::{Range, usable};
use super::drawing::stack::axis_name;
use super::drawing::theme::{INK, LABEL, LANE, SOFT};

/// Width of the panels on a phone, pixels, for which the names are placed; what is free beside them, before the
/// buttons.
const WIDTH: f64 = 260.0;
const BESIDE: f64 = 12.0;
/// Width of a letter, and the space between two names.
const LETTER: f64 = 6.5;
const SPACE: f64 = 8.0;
/// Letters of a name; so many fit on one side of every place.
const LETTERS: usize = 24;

/// A moment that is marked in all panels.
#[derive(Debug, Clone, PartialEq)]
pub struct Event {
    /// Place on the horizontal axis.
    pub at: f64,
    /// Short text at the mark; may be empty.
    pub name: String,
}

/// Marks the events by vertical lines through every panel, not through their labels; returns the number of lanes of
/// names.
pub(super) fn mark(figure: &mut Figure, events: &[Event], (x, rows): (Range, usize)) -> u32 {
    let mut lanes: Vec<Vec<(f64, f64)>> = vec![];
    for event in events.iter().filter(|event| usable(event.at)) {
        let at = x.rounded(event.at);
        for row in 0..rows {
            figure.push(
                "shapes",
                json!({ "type": "line", "x0": at, "x1": at, "xref": "x", "y0": 0, "y1": 1,
                        "yref": format!("{} domain", axis_name(row)),
                        "line": { "color": SOFT, "width": 1, "dash": "dot" } }),
            );
        }
        if event.name.is_empty() {
            continue;
        }
        let name = shortened(&event.name);
        let (place, width) = (WIDTH * (at - x.lo) / x.width(), LETTER * name.chars().count() as f64);
        let is_left = place + width <= WIDTH + BESIDE;
        let own = if is_left { (place, place + width) } else { (place - width, place) };
        let is_free = |lane: &Vec<(f64, f64)>| lane.iter().all(|one| own.0 > one.1 + SPACE || one.0 > own.1 + SPACE);
        let lane = lanes.iter().position(is_free).unwrap_or_else(|| {
            lanes.push(vec![]);
            lanes.len() - 1
        });
        lanes[lane].push(own);
        figure.push(
            "annotations",
            json!({ "text": text(&name), "x": at, "xref": "x", "xanchor": if is_left { "left" } else { "right" },
                    "y": 1, "yref": "paper", "yanchor": "bottom", "yshift": LABEL + LANE * lane as u32,
                    "showarrow": false, "textangle": 0, "font": { "color": INK, "size": 11 } }),
        );
    }
    u32::try_from(lanes.len()).unwrap_or(u32::MAX)
}

/// A name with so many letters.
fn shortened(name: &str) -> String {
    if name.chars().count() <= LETTERS {
        return name.to_owned();
    }
    name.chars().take(LETTERS - 1).chain(['…']).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{Panel, Series, timeline};
    use super::*;
    use crate::page::palette::Color;
    use crate::plot::drawing::figure::drawn;

    fn layout(events: &[Event]) -> serde_json::Value {
        let points = (0..100).map(|k| (f64::from(k), 1.0));
        let panels = ["x", "y"].map(|label| Panel::new(label, vec![Series::new("a", Color::of(0), points.clone())]));
        drawn(&timeline("t", "time / s", &panels, &[], events).expect("finite"))["layout"].clone()
    }

    #[test]
    fn events_are_marked_in_every_panel_and_named_once() {
        let layout = layout(&[Event { at: 1.5, name: "ALARM".into() }]);
        let places: Vec<_> = layout["shapes"].as_array().expect("lines").iter().map(|line| &line["yref"]).collect();
        assert_eq!(places, ["y domain", "y2 domain"]);
        let names = layout["annotations"].as_array().expect("texts").iter().filter(|own| own["text"] == "ALARM");
        assert_eq!(names.count(), 1);
    }

    #[test]
    fn names_do_not_cover_each_other_on_a_phone() {
        let event = |at: f64, name: &str| Event { at, name: name.into() };
        let events = [
            event(0.0, "healthy_1_000.csv"),
            event(25.0, "healthy_1_001.csv"),
            event(50.0, "spall_1_000_with_a_long_name_of_its_own.csv"),
            event(51.0, ""),
            event(52.0, "ALARM: spall"),
            event(99.0, "spall_1_001.csv"),
        ];
        let layout = layout(&events);
        let own = layout["annotations"].as_array().expect("texts").iter().filter(|own| own["yshift"].is_u64());
        let span = |own: &serde_json::Value| {
            let width = LETTER * own["text"].as_str().expect("a name").chars().count() as f64;
            let at = WIDTH * own["x"].as_f64().expect("a place") / 99.0;
            let from = if own["xanchor"] == "left" { at } else { at - width };
            (own["yshift"].as_u64().expect("a lane"), from, from + width)
        };
        let spans: Vec<_> = own.map(span).collect();
        assert_eq!(spans.len(), 5);
        for (k, one) in spans.iter().enumerate() {
            assert!(one.1 >= -56.0 && one.2 <= WIDTH + BESIDE, "{one:?}");
            let covered = spans[..k].iter().any(|other| other.0 == one.0 && other.1 < one.2 && one.1 < other.2);
            assert!(!covered, "{spans:?}");
        }
        // Room for the lanes above the label of the first panel.
        let above = layout["margin"]["t"].as_u64().expect("a margin");
        assert!(above > spans.iter().map(|own| own.0).max().expect("lanes") + u64::from(LANE), "{layout}");
    }
}
