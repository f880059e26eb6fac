//! Normal densities of one feature in each class, and its samples in a panel below.
//!
//! ```text
//! p(x) = exp(−(x − μ)²/2σ²) / (σ √2π)        σ: the *standard deviation* of the samples, N − 1
//! ```

use std::f64::consts::TAU;

use crate::ReportError;
use crate::page::palette::Class;
use crate::plot::drawing::figure::{Figure, text};
use crate::plot::drawing::numbers::{Range, usable};
use crate::plot::drawing::plotly::{Axis, Mode, Scatter};
use crate::plot::drawing::stack::{Across, Row, stack, vertical};
use crate::plot::series::{Drawing, Series, rounded};

/// Heights in pixels: of the densities, and of the samples of one class.
const HEIGHT: f64 = 280.0;
const SAMPLES_HEIGHT: f64 = 16.0;
/// Samples of a class that are drawn.
const SAMPLES: usize = 100;

/// A class and its samples of the feature.
#[derive(Debug, Clone, PartialEq)]
pub struct Density {
    /// Name, colour and marker.
    pub class: Class,
    /// Values of the feature.
    pub samples: Vec<f64>,
}

impl Density {
    /// Mean and standard deviation of the finite samples; `None` for fewer than two samples or if all are equal.
    #[must_use]
    pub fn moments(&self) -> Option<(f64, f64)> {
        let finite: Vec<f64> = self.samples.iter().copied().filter(|&x| usable(x)).collect();
        let n = finite.len() as f64;
        let mean = finite.iter().sum::<f64>() / n;
        let sd = (finite.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt();
        (sd > 0.0 && sd.is_finite()).then_some((mean, sd))
    }
}

/// Normal densities over ± 3.5 standard deviations, and the samples of each as marks below.
///
/// # Errors
/// [`ReportError::Empty`] if no class has two different finite samples.
pub fn densities(title: &str, feature: &str, classes: &[Density]) -> Result<String, ReportError> {
    const POINTS: i32 = 100;
    let known: Vec<(&Density, f64, f64)> =
        classes.iter().filter_map(|one| one.moments().map(|(mean, sd)| (one, mean, sd))).collect();
    let peak = known.iter().map(|(_, _, sd)| 1.0 / (sd * TAU.sqrt())).fold(0.0, f64::max);
    let mut series = Vec::new();
    for &(one, mean, sd) in &known {
        let curve = (0..=POINTS).map(|k| {
            let deviations = 3.5 * (2.0 * f64::from(k) / f64::from(POINTS) - 1.0);
            (mean + deviations * sd, (-0.5 * deviations * deviations).exp() / (sd * TAU.sqrt()))
        });
        let curve: Vec<(f64, f64)> = curve.collect();
        let band = curve.iter().map(|&(x, p)| (x, 0.0, p)).collect::<Vec<_>>();
        let name = format!("{}: {}", one.class.name, with_sd(mean, sd));
        series.push(Series::new(name, one.class.color, curve).with_band(band));
    }
    let samples = known.iter().flat_map(|(one, _, _)| one.samples.iter().copied());
    let x = Range::of(samples.chain(series.iter().flat_map(|s| s.points.iter().map(|p| p.0))));
    let x = x.filter(|_| peak > 0.0).ok_or_else(|| ReportError::Empty { title: title.to_owned() })?.padded(0.02);
    let y = Range { lo: 0.0, hi: 1.05 * peak };
    // One line of marks a class, the first on top.
    let lines = Range { lo: -(known.len() as f64) + 0.5, hi: 0.5 };
    let mut figure = Figure::new(title, 0);
    for (number, ((one, _, _), series)) in known.iter().zip(&series).enumerate() {
        let at = Drawing { axis: "y", x, y, columns: None, in_legend: true };
        series.traces(at).into_iter().for_each(|trace| figure.add(trace));
        let every = one.samples.len().div_ceil(SAMPLES).max(1);
        let drawn: Vec<f64> = one.samples.iter().copied().filter(|&v| usable(v)).step_by(every).collect();
        let line = vec![-(number as f64); drawn.len()];
        figure.add(
            Scatter::new(rounded(x, drawn.into_iter()), line)
                .name(text(&one.class.name))
                .y_axis("y2")
                .legend_group(text(&series.name))
                .show_legend(false)
                .mode(Mode::Markers)
                .marker(one.class.marker.open(&one.class.color.to_string(), 7).opacity(0.75))
                .hover_template("%{x}"),
        );
        if every > 1 {
            figure.notes.push(format!("Of {}, every {every}th sample is drawn.", one.class.name));
        }
    }
    figure.note_gaps(classes.iter().flat_map(|one| &one.samples).filter(|&&v| !usable(v)).count());
    let marks = vertical(lines).show_tick_labels(false).show_grid(false).fixed_range(true);
    let rows = vec![
        Row { label: "probability density".into(), height: HEIGHT, axis: vertical(y) },
        Row { label: "samples".into(), height: SAMPLES_HEIGHT * known.len() as f64, axis: marks },
    ];
    stack(&mut figure, Across { label: feature, axis: Axis::new().range(x.axis()) }, rows, true);
    figure.set("hovermode", serde_json::json!("closest"));
    Ok(figure.html())
}

/// Mean and standard deviation, rounded to two digits of the standard deviation.
fn with_sd(mean: f64, sd: f64) -> String {
    let magnitude = sd.log10().floor();
    let decimals = (0..=12).find(|&d| f64::from(d) >= 1.0 - magnitude).unwrap_or(12);
    let decimals = usize::try_from(decimals).unwrap_or(0);
    format!("{mean:.decimals$} ± {sd:.decimals$} (sd)").replace('-', "−")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;
    use crate::plot::drawing::figure::named;

    #[test]
    fn the_spread_is_the_standard_deviation() {
        // Deviations −2, 0, 2: variance 8/2 = 4, standard deviation 2.
        let one = Density { class: Class::new(0, "<a>"), samples: vec![8.0, 10.0, 12.0] };
        assert_eq!(one.moments(), Some((10.0, 2.0)));
        let html = densities("t", "a1", &[one]).expect("two samples");
        assert_eq!(check(&html), Ok(()));
        // ± 3.5 standard deviations is 3 to 17; with the variance instead it would be −4 to 24.
        let curve = &named(&html, "&lt;a&gt;: 10.0 ± 2.0 (sd)")[1];
        assert_eq!((&curve["x"][0], &curve["x"][100]), (&3.0.into(), &17.0.into()));
        assert_eq!(named(&html, "&lt;a&gt;")[0]["x"], serde_json::json!([8.0, 10.0, 12.0]));
    }

    #[test]
    fn classes_without_spread_are_left_out() {
        let constant = Density { class: Class::new(0, "a"), samples: vec![1.0; 5] };
        assert!(densities("t", "a1", &[constant]).is_err());
    }
}
