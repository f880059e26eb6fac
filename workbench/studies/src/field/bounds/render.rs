//! The bounds as text and JSON.

use serde_json::{Value, json};

use super::classes::ClassBound;
use super::roughness::RoughnessBound;
use super::{Bound, Bounded};
use crate::campaign::render::grid;
use crate::field::Settings;
use crate::field::recipe::SHARE;
use crate::field::render::{heading, percent};
use model::evaluate::Rate;
use rig::{Defect, DefectKind};

fn shown(rate: Option<Rate>) -> String {
    rate.map_or_else(|| "refused".into(), percent)
}

/// The table as plain text.
#[must_use]
pub fn text(all: &[Bounded], settings: &Settings) -> String {
    let title = format!(
        "Spalls found at 1 % false alarms, %: bounds of one record, and what is found [95 % interval]; {} draws of {} \
         records",
        settings.draws, settings.defects
    );
    let head = [
        "",
        "floor, mN·m",
        "of the core",
        "size",
        "non-centrality",
        "bound: order",
        "order searched",
        "friction",
        "together",
        "found: order",
        "detector",
    ];
    let part = |part: f64| format!("{:.1}", 100.0 * part);
    let row = |own: &Bounded, bound: &Bound| {
        vec![
            own.row.clone(),
            format!("{:.2}", 1e3 * own.floor_nm),
            format!("{:.2}", 1e3 * own.core_floor_nm),
            heading(Defect { kind: DefectKind::Spall, severity: bound.severity }),
            format!("{:.1}", bound.non_centrality),
            part(bound.order),
            part(bound.searched),
            part(bound.friction),
            part(bound.all),
            shown(bound.found_by_order),
            shown(bound.found),
        ]
    };
    let rows: Vec<Vec<String>> =
        all.iter().flat_map(|own| own.bounds.iter().map(move |bound| row(own, bound))).collect();
    [grid(&title, &head, &rows), roughness(all), classes(all)].join("\n")
}

fn roughness(all: &[Bounded]) -> String {
    let title = "Roughness found at 1 % false alarms where the temperature changes the friction, %: bounds, and what \
                 is found [95 % interval]";
    let share = format!("at {} %", 100.0 * SHARE);
    let error = "error of the core, µN·m·s/rad";
    let head = ["", error, "size", "bound: exact friction", "with this error", &share, "detector"];
    let row = |own: &Bounded, bound: &RoughnessBound| {
        vec![
            own.row.clone(),
            format!("{:.1}", 1e6 * own.viscous_error),
            heading(Defect { kind: DefectKind::Roughness, severity: bound.severity }),
            format!("{:.1}", 100.0 * bound.exact),
            format!("{:.1}", 100.0 * bound.with_error),
            format!("{:.1}", 100.0 * bound.at_share),
            shown(bound.found),
        ]
    };
    let rows: Vec<Vec<String>> =
        all.iter().flat_map(|own| own.roughness.iter().map(move |bound| row(own, bound))).collect();
    grid(title, &head, &rows)
}

fn classes(all: &[Bounded]) -> String {
    let title = "Three classes in equal parts: error, %: bounds by the best limits for each size, and that of the \
                 detector [95 % interval]";
    let head = ["", "size", "ideal order, exact friction", "order and friction of the core", "detector"];
    let row = |own: &Bounded, bound: &ClassBound| {
        vec![
            own.row.clone(),
            format!("{}", bound.severity),
            format!("{:.1}", 100.0 * bound.ideal),
            format!("{:.1}", 100.0 * bound.of_core),
            shown(bound.found),
        ]
    };
    let rows: Vec<Vec<String>> =
        all.iter().flat_map(|own| own.classes.iter().map(move |bound| row(own, bound))).collect();
    grid(title, &head, &rows)
}

/// Key `rows`, each with its floor and its bounds.
#[must_use]
pub fn to_json(all: &[Bounded]) -> Value {
    let bound = |own: &Bound| {
        json!({
            "severity": own.severity,
            "non_centrality": own.non_centrality,
            "order": own.order,
            "order_searched": own.searched,
            "friction": own.friction,
            "together": own.all,
            "found_by_order": own.found_by_order.map(|rate| rate.to_json()),
            "found": own.found.map(|rate| rate.to_json()),
        })
    };
    let rough = |own: &RoughnessBound| {
        json!({
            "severity": own.severity,
            "exact": own.exact,
            "with_error": own.with_error,
            "at_share": own.at_share,
            "found": own.found.map(|rate| rate.to_json()),
        })
    };
    let class = |own: &ClassBound| {
        json!({
            "severity": own.severity,
            "ideal": own.ideal,
            "of_core": own.of_core,
            "found": own.found.map(|rate| rate.to_json()),
        })
    };
    let row = |own: &Bounded| {
        json!({
            "row": own.row,
            "floor_nm": own.floor_nm,
            "core_floor_nm": own.core_floor_nm,
            "bounds": own.bounds.iter().map(bound).collect::<Vec<_>>(),
            "viscous_error_nm_s_rad": own.viscous_error,
            "roughness": own.roughness.iter().map(rough).collect::<Vec<_>>(),
            "classes": own.classes.iter().map(class).collect::<Vec<_>>(),
        })
    };
    json!({ "rows": all.iter().map(row).collect::<Vec<_>>() })
}
