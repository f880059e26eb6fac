//! Every kind of page, opened without a network in a browser: its figures are drawn, and they react.

use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::browser::{self, Opened};
use crate::common::{run, succeed};
use studies::demo;
use studies::pages::campaign::field_page;

const SIGNALS: &str = "--y current_a --u1 velocity_ref_rad_s --u2 load_torque_nm";
/// Largest page, bytes.
const LARGEST: u64 = 3_000_000;
/// Largest page of a replay, bytes.
const LARGEST_REPLAY: u64 = 1_500_000;

/// Marks of a figure: lines, points and bars by series, and maps.
const MARKS: &str = ".scatterlayer .trace, .barlayer .trace, .heatmaplayer .hm";

/// Writes the pages; returns their names, with the least number of figures.
fn write_pages(dir: &Path) -> Vec<(&'static str, usize)> {
    succeed(dir, "simulate --class healthy,spall,roughness --count 14 --seed 1 --out train");
    succeed(dir, "simulate --class healthy,spall,roughness --count 2 --seed 2 --out test");
    let validated = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm";
    succeed(dir, &format!("validate test/spall_2_000.csv {validated} --order 2,2,2,1,1 --report validate.html"));
    let train = format!("train --labels train/labels.csv {SIGNALS} --order 2,1,2,1,1");
    succeed(dir, &format!("{train} --model m.bwm --report train.html"));
    succeed(dir, "replay --model m.bwm test/spall_2_000.csv --report replay.html");
    succeed(dir, "evaluate --model m.bwm --labels test/labels.csv --report evaluate.html");
    let dynamic = "--max 2,2,2,1,1 --report structure.html";
    succeed(dir, &format!("structure test/healthy_2_000.csv test/healthy_2_001.csv {validated} {dynamic}"));
    std::fs::write(dir.join("demo.html"), demo_page()).expect("written");
    let table = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/field.md");
    let field = field_page(&std::fs::read_to_string(table).expect("a document")).expect("a table");
    std::fs::write(dir.join("field.html"), field).expect("written");
    std::fs::create_dir(dir.join("wide")).expect("folder");
    (0..4).for_each(|k| std::fs::write(dir.join(format!("wide/{k}.csv")), wide(k)).expect("written"));
    // The exit code tells that something was found.
    run(dir, "audit wide --report audit.html");
    vec![
        ("validate.html", 7),
        ("train.html", 8),
        ("replay.html", 3),
        ("evaluate.html", 5),
        ("structure.html", 2),
        ("demo.html", 6),
        ("field.html", 1),
        ("audit.html", 20),
    ]
}

/// The page of a small demo.
fn demo_page() -> String {
    let settings = demo::Settings { repetitions: 1, traces: 8, seed: 1 };
    let first = demo::draw(&settings, 0, || ()).expect("the standard rig");
    let rows = demo::rows(std::slice::from_ref(&first.repetition));
    studies::pages::demo::page(&settings, &first, &rows).expect("a page")
}

/// A recording of many columns and rows, whose page must stay small.
fn wide(seed: u64) -> String {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let names: Vec<String> = (0..40).map(|column| format!("sensor_{column}")).collect();
    let row = |k: u32| {
        let cells = (0..40).map(|_| format!(",{:.4}", random.random::<f64>()));
        format!("{}{}\n", f64::from(k) * 1e-3, cells.collect::<String>())
    };
    format!("t_s,{}\n{}", names.join(","), (0..4000).map(row).collect::<String>())
}

#[test]
fn every_page_is_drawn_without_a_network_and_reacts() {
    let Some(browser) = browser::start() else { return };
    let folder = tempfile::tempdir().expect("folder");
    for (name, figures) in write_pages(folder.path()) {
        let file = folder.path().join(name);
        let size = std::fs::metadata(&file).expect("a page").len();
        let largest = if name == "replay.html" { LARGEST_REPLAY } else { LARGEST };
        assert!(size <= largest, "{name}: {size} bytes");
        let page = Opened::new(&browser, &format!("file://{}", file.display()));
        drawn(&page, name, figures);
        legend_hides_a_series(&page, name);
        linked_figures_move_together(&page);
        colours_follow_the_system(&page, name);
        page.narrow();
        page.wait("document.querySelector('.plot .main-svg').clientWidth < 390");
        assert_eq!(page.value("document.documentElement.scrollWidth <= innerWidth"), true, "{name} fits a phone");
        assert!(page.errors().is_empty(), "{name}: {:?}", page.errors());
        assert_eq!(page.requests().len(), 1, "{name}: {:?}", page.requests());
        page.close();
    }
}

fn drawn(page: &Opened, name: &str, figures: usize) {
    let each = format!(
        "[...document.querySelectorAll('.plot')].map(p => [p.querySelectorAll('.main-svg').length, \
         p.querySelectorAll('{MARKS}').length])"
    );
    let found = page.value(&each);
    let found = found.as_array().expect("a list");
    assert!(found.len() >= figures, "{name}: {} figures", found.len());
    for (k, figure) in found.iter().enumerate() {
        assert!(figure[0].as_u64() > Some(0) && figure[1].as_u64() > Some(0), "{name}, figure {k}: {figure}");
    }
}

fn legend_hides_a_series(page: &Opened, name: &str) {
    let hidden = "[...document.querySelectorAll('.plot')].some(p => p.data.some(t => t.visible === 'legendonly'))";
    assert_eq!(page.value(hidden), false, "{name}");
    page.click(".plot .legendtoggle");
    page.wait(hidden);
}

fn linked_figures_move_together(page: &Opened) {
    let linked = "[...document.querySelectorAll('.linked')].map(g => [...g.querySelectorAll('.plot')])\
                  .filter(g => g.length > 1)";
    if page.value(&format!("{linked}.length")) == 0 {
        return;
    }
    let widths = format!("{linked}[0].map(p => p._fullLayout.xaxis.range).map(([a, b]) => b - a)");
    let before = page.value(&widths);
    page.value(&format!(
        "{linked}.slice(0, 1).forEach(([p]) => {{ const [a, b] = p._fullLayout.xaxis.range; \
         Plotly.relayout(p, {{ 'xaxis.range': [a + 0.25 * (b - a), a + 0.5 * (b - a)] }}); }})"
    ));
    // A quarter of the width is seen in every figure, not only in the first.
    page.wait(&format!("{widths}.every((w, k) => Math.abs(w / {before}[k] - 0.25) < 1e-3)"));
    // The cursor over the first figure shows the values in the others.
    page.hover(".linked .nsewdrag");
    page.wait(&format!("{linked}[0].every(p => p.querySelector('.hoverlayer').childElementCount > 0)"));
}

fn colours_follow_the_system(page: &Opened, name: &str) {
    let ink = "document.querySelector('.plot')._fullLayout.font.color";
    let ranges = "[...document.querySelectorAll('.plot')].map(p => p._fullLayout.xaxis.range)";
    let (color, before) = (page.value(ink), page.value(ranges));
    page.darken();
    page.wait(&format!("{ink} !== {color}"));
    // Axes of equal scale move by the rounding of a pixel.
    let kept = "(a, b) => a.every((r, k) => Math.abs(r[0] - b[k][0]) < 0.02 * (r[1] - r[0]))";
    assert_eq!(page.value(&format!("({kept})({ranges}, {before})")), true, "{name}: the zoom is kept");
}
