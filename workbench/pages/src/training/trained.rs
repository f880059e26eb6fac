//! Sections of a report on a trained model.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::chosen;
use super::worth;
use crate::conclusion;
use crate::page::table::{ConfusionRow, confusion_table, table};
use crate::page::{or_reason, paragraph};
use crate::plot::{self, Density, Panel, ScatterClass, Series};
use crate::segments::{self, Chosen, points};
use crate::{Class, Color, Page};
use model::Error;
use model::core::{Embedded, Finding, SegmentReport};
use model::evaluate::{Confusion, TraceVerdict};
use model::trace::{Channels, Trace};
use model::train::covariance::whitening;
use model::train::{ClassStatistics, Ranking, Scores, Trained};

/// Available results on the quality of a model.
#[derive(Clone, Debug, Default)]
pub struct Worth<'a> {
    /// Verdicts of the embedded detector on the training traces.
    pub training: &'a [TraceVerdict],
    /// Results of the embedded detector on held-out traces.
    pub held_out: Option<(&'a Confusion, &'a [TraceVerdict], &'a Scores)>,
    /// Cross-validated scores on the training segments, or the error.
    pub cross_validated: Option<Result<&'a Scores, &'a Error>>,
    /// Ranking of the features.
    pub ranking: Option<&'a Ranking>,
    /// What is missing in the recordings, if anything is.
    pub missing: Option<String>,
}

/// Page of a training: signals, features with decision regions, and the quality of the model.
///
/// # Errors
/// Returns an error if the model cannot be embedded.
pub fn training(
    trained: &Trained,
    channels: &Channels,
    examples: &[(&Trace, usize)],
    worth: Worth,
) -> Result<String, Error> {
    let verdicts = worth.held_out.map_or(&[][..], |(_, verdicts, _)| verdicts);
    let coordinates = trained.core_projection.matrix.nrows();
    let mut page = Page::new("bearing-watch: training report").lead(format!(
        "{} training segments of {}; features {}; {} discriminant over {coordinates} {}.",
        trained.coordinates.rows.len(),
        trained.classes.join(", "),
        trained.feature_names.join(", "),
        trained.kind_name(),
        if coordinates == 1 { "coordinate" } else { "coordinates" },
    ));
    let healthy = trained.embed()?.healthy().is_some();
    let validated = worth.cross_validated.and_then(Result::ok);
    let held_out = worth.held_out.map(|(confusion, ..)| confusion);
    page = page.conclusion(conclusion::training::words(trained, healthy, held_out, validated));
    if let Some(missing) = &worth.missing {
        page = page.section("Missing samples", &paragraph(&format!("{missing}.")));
    }
    if let Some(automatic) = &trained.automatic {
        page = page.section("Choice of the features", &chosen::choice(automatic));
    }
    if let Some(doubts) = chosen::doubts(trained) {
        page = page.section("Doubts about the healthy records", &doubts);
    }
    page = page.section("Signals, one trace of each class", &signals(trained, channels, examples));
    page = page.section("Features and decision regions", &scatter(trained, worth.training, verdicts)?);
    page = page.section("Features over runs", &over_runs(trained, worth.training, verdicts));
    page = page.section("Distribution of each feature", &distributions(trained));
    if let Some((confusion, verdicts, scores)) = worth.held_out {
        page = page.section("Held-out traces, through the embedded detector", &confusion_html(confusion));
        let calibration = worth::calibration(&trained.classes, scores, "held-out traces");
        page = page.section("Calibration on the held-out traces", &calibration);
        page = page.section("Posteriors, segment after segment", &posteriors_by_trace(&trained.classes, verdicts));
    }
    if let Some(validated) = worth.cross_validated {
        let html = match validated {
            Ok(scores) => worth::calibration(&trained.classes, scores, "training segments"),
            Err(reason) => paragraph(&format!("Not cross-validated: {reason}.")),
        };
        page = page.section("Calibration, cross-validated", &html);
    }
    if let Some(ranking) = worth.ranking {
        page = page.section("Ranking of the features", &worth::ranking(ranking));
    }
    if let Some(choice) = &trained.choice {
        page = page.section("Shrinkage of the covariances", &worth::shrinkage(choice));
    }
    Ok(page.section("Features of the training segments", &feature_table(trained)).render())
}

/// Output and inputs of one trace of each class.
#[must_use]
pub fn signals(trained: &Trained, channels: &Channels, examples: &[(&Trace, usize)]) -> String {
    let panel = |label: &str, channel: &str, pick: fn(&Trace) -> &[f64]| {
        let series = examples.iter().map(|(trace, class)| {
            let step = trace.interval_s.unwrap_or(1.0);
            let points = pick(trace).iter().enumerate().map(move |(k, x)| (k as f64 * step, *x));
            Series::new(trained.classes[*class].clone(), Color::of(*class), points)
        });
        Panel::new(format!("{label} = {channel}"), series.collect())
    };
    let panels =
        [panel("y", &channels.y, |t| &t.y), panel("u1", &channels.u1, |t| &t.u1), panel("u2", &channels.u2, |t| &t.u2)];
    let timed = examples.iter().all(|(trace, _)| trace.interval_s.is_some());
    or_reason(plot::signals("Signals as identified", if timed { "time / s" } else { "sample" }, &panels))
}

/// Training and held-out traces in the plane in which the classes are farthest apart, with the decision regions.
///
/// # Errors
/// Returns an error if the model cannot be embedded.
pub fn scatter(trained: &Trained, seen: &[TraceVerdict], held_out: &[TraceVerdict]) -> Result<String, Error> {
    let model = trained.embed()?;
    let Some(plane) = Plane::new(trained) else {
        return Ok(paragraph("The features of the training set do not span a plane."));
    };
    let classes = Class::all(&trained.classes);
    let of_class = |k: usize| {
        let table = &trained.coordinates;
        let own = |row: &usize| table.classes[*row] == k && !table.is_partial(*row);
        let training = (0..table.rows.len()).filter(own).map(|row| table.rows[row].clone());
        let of = |verdicts: &[TraceVerdict], novel: bool| -> Vec<DVector<f64>> {
            let own = verdicts.iter().filter(|v| v.class == k).flat_map(|v| &v.segments);
            let own = own.filter(|s| s.verdict.is_ok() && (s.verdict == Ok(Finding::Novel)) == novel);
            own.filter_map(|s| coordinates(trained, s)).collect()
        };
        let novel = [of(held_out, true), of(seen, true)].concat();
        ScatterClass {
            class: classes[k].clone(),
            training: plane.points(training),
            held_out: plane.points(of(held_out, false).into_iter()),
            novel: plane.points(novel.into_iter()),
        }
    };
    let scattered: Vec<ScatterClass> = (0..classes.len()).map(of_class).collect();
    let decide = |x, y| decide(&model, &plane, x, y, classes.len());
    let dimensions = trained.coordinates.rows.first().map_or(0, DVector::len);
    let (title, second) = match dimensions {
        1 => ("The feature, and the decision at each value", "segment of its class (held out and training)"),
        _ => ("Features in the plane that separates the classes best", "second direction / sd within"),
    };
    let plot = or_reason(plot::scatter_regions(title, "first direction / sd within", second, &scattered, decide));
    let mut note = "Points are segments; the rates of the tables may count whole traces.".to_string();
    if dimensions > 2 {
        note += &format!(
            " The plane is a section through {dimensions} dimensions: a point off it may lie in the colour of another class than the one decided."
        );
    }
    let partial = (0..trained.coordinates.rows.len()).filter(|&row| trained.coordinates.is_partial(row)).count();
    if partial > 0 {
        note += &format!(" {partial} of the training segments lack a coordinate and are not drawn.");
    }
    Ok(plot + &paragraph(&note))
}

/// The features of the training segments in the order of their runs, then those of the held-out ones.
#[must_use]
pub fn over_runs(trained: &Trained, training: &[TraceVerdict], held_out: &[TraceVerdict]) -> String {
    let catalogue = trained.catalogue();
    let chosen = Chosen { catalogue: &catalogue, names: &trained.feature_names };
    let groups = &trained.recipe.validation.groups;
    let later = vec!["held out".to_owned(); held_out.len()];
    let mut all = points(chosen, training, Some(groups.as_slice()).filter(|groups| !groups.is_empty()));
    all.extend(points(chosen, held_out, Some(&later)));
    segments::over_runs(chosen.names, &trained.classes, &all)
}

/// Normal density of each feature in every class, from the training segments.
#[must_use]
pub fn distributions(trained: &Trained) -> String {
    let classes = Class::all(&trained.classes);
    let of_feature = |(feature, name): (usize, &String)| {
        let samples = |k: usize| trained.raw.with(k, feature).map(|row| trained.raw.rows[row][feature]).collect();
        let one = |(k, class): (usize, &Class)| Density { class: class.clone(), samples: samples(k) };
        let densities: Vec<Density> = classes.iter().enumerate().map(one).collect();
        or_reason(plot::densities(&format!("Distribution of {name}"), name, &densities))
    };
    trained.feature_names.iter().enumerate().map(of_feature).collect()
}

fn decide(model: &Embedded, plane: &Plane, x: f64, y: f64, undetermined: usize) -> usize {
    let z: Vec<f32> = plane.lift(x, y).iter().map(|z| *z as f32).collect();
    model.decide_at(&z).unwrap_or(undetermined)
}

/// Projected coordinates of the features that the detector estimated; `None` if a coordinate is missing.
fn coordinates(trained: &Trained, segment: &SegmentReport) -> Option<DVector<f64>> {
    if !segment.missing.is_empty() {
        return None;
    }
    let variance = f64::from(segment.variance.max(f32::MIN_POSITIVE));
    let own = segment.raw.iter().map(|x| f64::from(*x)).chain([variance.ln()]);
    let raw: Vec<f64> = own.chain(segment.shaft_features.iter().map(|x| f64::from(x.value))).collect();
    let names = trained.catalogue().names();
    let chosen = trained.feature_names.iter().filter_map(|name| names.iter().position(|n| n == name));
    let chosen: Vec<f64> = chosen.map(|k| raw[k]).collect();
    Some(trained.projection.apply(&DVector::from_vec(chosen)))
}

/// Table of the counts, and rates.
#[must_use]
pub fn confusion_html(confusion: &Confusion) -> String {
    let n = confusion.classes.len();
    let unnamed = |row: &[usize]| row[n..].iter().sum::<usize>();
    let any = confusion.counts.iter().any(|row| unnamed(row) > 0);
    let rows = confusion.counts.iter().zip(confusion.recalls()).map(|(row, correct)| ConfusionRow {
        counts: row[..n].iter().map(|&count| count as u64).collect(),
        undetermined: any.then_some(unnamed(row) as u64),
        correct,
    });
    let rows: Vec<ConfusionRow> = rows.collect();
    let (error, balanced) = (confusion.error_rate(), confusion.balanced_accuracy());
    let mut summary = format!(
        "Error rate {error} of {} decisions; balanced accuracy {balanced} (95 % intervals).",
        confusion.total()
    );
    let [novel, ambiguous] = [n + 1, n + 2].map(|k| confusion.counts.iter().map(|row| row[k]).sum::<usize>());
    if novel + ambiguous > 0 {
        summary += &format!(" Undetermined includes {novel} novel and {ambiguous} ambiguous.");
    }
    or_reason(confusion_table(&confusion.classes, &rows)) + &paragraph(&summary)
}

/// Posterior of every segment, with the traces one after the other.
#[must_use]
pub fn posteriors_by_trace(classes: &[String], verdicts: &[TraceVerdict]) -> String {
    let mut segments = Vec::new();
    for verdict in verdicts {
        for segment in &verdict.segments {
            let start = segments.len() as f64;
            segments.push(plot::Segment {
                start,
                end: start + 1.0,
                truth: Some(verdict.class),
                decided: segment.verdict.clone().ok().and_then(Finding::class),
                posteriors: segment.posteriors.iter().map(|p| f64::from(*p)).collect(),
            });
        }
    }
    or_reason(plot::posteriors("Posterior of each segment", "segment", &Class::all(classes), &segments))
}

fn feature_table(trained: &Trained) -> String {
    let statistics = match ClassStatistics::of(&trained.raw, &trained.feature_names) {
        Ok(statistics) => statistics,
        Err(reason) => return paragraph(&format!("No means and deviations: {reason}.")),
    };
    let classes = trained.classes.iter().zip(&statistics.counts).map(|(class, count)| format!("{class} ({count})"));
    let header: Vec<String> = std::iter::once("feature".to_string()).chain(classes).collect();
    let row = |(place, name): (usize, &String)| {
        let cells = statistics.means.iter().zip(&statistics.covariances);
        let cells = cells.map(|(mean, covariance)| mean_sd(mean[place], covariance[(place, place)].sqrt()));
        std::iter::once(name.clone()).chain(cells).collect()
    };
    let rows: Vec<Vec<String>> = trained.feature_names.iter().enumerate().map(row).collect();
    paragraph("Mean ± standard deviation over the training segments of each class (their number).")
        + &table(&header, &rows)
}

/// Standard deviation with two digits, and the mean with the same number of decimals.
fn mean_sd(mean: f64, sd: f64) -> String {
    let place = sd.log10().floor();
    let text = if (-6.0..5.0).contains(&place) {
        let decimals = (1.0 - place).max(0.0) as usize;
        format!("{mean:.decimals$} ± {sd:.decimals$}")
    } else {
        format!("{mean:.4e} ± {sd:.1e}")
    };
    // A minus sign and no-break spaces keep the cell on one line.
    text.replace('-', "−").replace(' ', "\u{a0}")
}

/// The plane through the grand mean, in whitened coordinates, along the directions that separate the class means
/// most; with only two classes, the second direction is that of the largest variance orthogonal to the first.
///
/// Points outside the plane are replaced by their conditional mean. For a linear discriminant of up to three classes
/// the drawn regions are therefore exactly the decision regions. With one coordinate the second axis only spreads the
/// points.
#[derive(Clone, Debug)]
struct Plane {
    centre: DVector<f64>,
    /// 2 × Z
    to: DMatrix<f64>,
    /// Z × 2
    back: DMatrix<f64>,
}

impl Plane {
    fn new(trained: &Trained) -> Option<Self> {
        let statistics = &trained.statistics;
        let z = statistics.total_mean.len();
        let (white, _) = whitening(&statistics.pooled).ok()?;
        let mut between = DMatrix::zeros(z, z);
        for mean in &statistics.means {
            let away = &white * (mean - &statistics.total_mean);
            between += &away * away.transpose();
        }
        let first = leading(&between);
        let mut directions = DMatrix::from_columns(std::slice::from_ref(&first));
        if z > 1 {
            let across = DMatrix::identity(z, z) - &first * first.transpose();
            let total = &white * &statistics.total * white.transpose();
            let remaining = if statistics.means.len() > 2 { between } else { total };
            directions = DMatrix::from_columns(&[first, leading(&(&across * remaining * &across))]);
        }
        let back = white.solve_lower_triangular(&directions)?;
        Some(Self { centre: statistics.total_mean.clone(), to: directions.transpose() * white, back })
    }

    fn points(&self, coordinates: impl Iterator<Item = DVector<f64>>) -> Vec<(f64, f64)> {
        let point = |(k, z): (usize, DVector<f64>)| {
            let p = &self.to * (z - &self.centre);
            (p[0], if p.len() > 1 { p[1] } else { k as f64 })
        };
        coordinates.enumerate().map(point).collect()
    }

    fn lift(&self, x: f64, y: f64) -> DVector<f64> {
        let p = DVector::from_vec(if self.back.ncols() > 1 { vec![x, y] } else { vec![x] });
        &self.centre + &self.back * p
    }
}

fn leading(matrix: &DMatrix<f64>) -> DVector<f64> {
    let eigen = SymmetricEigen::new(matrix.clone());
    let vector = eigen.eigenvectors.column(eigen.eigenvalues.imax()).into_owned();
    // The sign is fixed, so that a retrained model is drawn with the same orientation.
    if vector[vector.iamax()] < 0.0 { -vector } else { vector }
}
