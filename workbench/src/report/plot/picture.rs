//! Stacked panels over one axis as one SVG file, for a document.

use super::super::ReportError;
use super::axis::{Axis, LABEL_HEIGHT};
use super::frame::{Area, RIGHT, WIDTH, grid};
use super::series::{x_range, y_range};
use super::signals::Panel;
use super::svg::{Anchor, Svg, num};

const HEAD: f64 = 26.0;
const LEGEND_LINE: f64 = 18.0;
const PANEL: f64 = 150.0;
/// Above each panel, for the title of its axis.
const LABEL: f64 = 24.0;
/// Below the last panel: tick labels and the title of the axis.
const FOOT: f64 = 2.0 * LABEL_HEIGHT + 8.0;
const LEFT: f64 = 62.0;
const STYLE: &str = "text{font:12px sans-serif;fill:#222}.head{font-weight:bold}.grid{stroke:#ddd;fill:none}.frame{stroke:#888;fill:none}\
                     .line{fill:none;stroke-width:1.3}.dashed{stroke-dasharray:6 4}.paper{fill:#fff}";

/// A standalone picture with the legend of the first panel, whose series all panels have.
///
/// # Errors
/// [`ReportError::Empty`] if a panel has no finite point.
pub fn picture(title: &str, x_label: &str, panels: &[Panel]) -> Result<String, ReportError> {
    let empty = || ReportError::Empty { title: title.to_owned() };
    let x_range = x_range(panels.iter().flat_map(|panel| &panel.series)).ok_or_else(empty)?.padded(0.0);
    let names = panels.first().map(|panel| panel.series.as_slice()).unwrap_or_default();
    let top = HEAD + LEGEND_LINE * names.len().div_ceil(2) as f64;
    let height = top + (PANEL + LABEL) * panels.len() as f64 + FOOT;
    let x = Axis::horizontal(x_range, LEFT, WIDTH - RIGHT);

    let mut svg = Svg::new();
    svg.rect("class=\"paper\"", 0.0, 0.0, WIDTH, height);
    svg.text("class=\"head\"", Anchor::Middle, 0.5 * WIDTH, 12.0, title);
    for (k, series) in names.iter().enumerate() {
        let (at, y) = (LEFT + 0.5 * WIDTH * (k % 2) as f64, HEAD + LEGEND_LINE * (0.5 + (k / 2) as f64));
        let line = format!("M{} {}h24", num(at), num(y));
        svg.path(&format!("class=\"line\" stroke=\"{}\"", series.color), &line);
        svg.text("", Anchor::Start, at + 30.0, y, &series.name);
    }
    for (k, panel) in panels.iter().enumerate() {
        let bottom = top + (PANEL + LABEL) * (k + 1) as f64;
        let area = Area { left: LEFT, top: bottom - PANEL, right: WIDTH - RIGHT, bottom };
        let y = Axis::vertical(y_range(&panel.series).ok_or_else(empty)?.padded(0.06), area.top, area.bottom);
        svg.text("", Anchor::Start, LEFT, area.top - 11.0, &y.title(&panel.label));
        grid(&mut svg, area, &x, &y, k + 1 == panels.len());
        for series in &panel.series {
            series.draw(&mut svg, area, &x, &y);
        }
    }
    svg.text("", Anchor::Middle, 0.5 * (LEFT + WIDTH - RIGHT), height - 12.0, &x.title(x_label));
    Ok(svg.standalone(title, (WIDTH, height), STYLE))
}

#[cfg(test)]
mod tests {
    use super::super::super::palette::Color;
    use super::super::super::well_formed::check;
    use super::super::Series;
    use super::*;

    #[test]
    fn a_picture_is_well_formed_and_has_its_legend_and_every_panel() {
        let series = |k: usize, y: f64| Series::new(format!("<{k}>"), Color::of(k), [(0.0, y), (1.0, -y)]);
        let panel = |label: &str| Panel::new(label, vec![series(0, 2.0), series(1, 3.0), series(2, 1.0)]);
        let drawn = picture("a & b", "time / s", &[panel("angle / °"), panel("iq / A")]).expect("finite points");
        assert_eq!(check(&drawn), Ok(()), "{drawn}");
        assert!(drawn.starts_with("<svg xmlns=") && drawn.contains(">&lt;1&gt;</text>") && drawn.contains("iq / A"));
        assert_eq!(drawn.matches("class=\"frame\"").count(), 2);
        // Three curves in each of two panels, and three keys.
        assert_eq!(drawn.matches("class=\"line\"").count(), 9);
        assert!(picture("t", "x", &[]).is_err());
    }
}
