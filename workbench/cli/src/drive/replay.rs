//! `bearing-watch replay`

use std::path::{Path, PathBuf};

use bearing_watch::FrictionTerm;
use bearing_watch::alarm::{Contribution, Interval};
use serde_json::{Value, json};

use crate::command_line::jobs::Replay;
use crate::command_line::options::Taken;
use crate::command_line::output;
use crate::drive::life::Life;
use model::Error;
use model::core::{AlarmState, Embedded, Finding, SegmentReport, denied, features, sight, stuck_channels};
use model::identify::Terms;
use model::session::{ModelFile, Notes, check_rate, irregular, refused};
use model::settings::Settings;
use model::trace::Trace;
use model::trace::tally::told;
use model::train::front_end_source::further_columns;
use pages::Page;
use pages::conclusion::replay::Conclusion;
use pages::replay::{Replayed, page};
use traces::Source;
use traces::front_end::raw_rows;

/// Run traces through the embedded detector and print its verdict on every segment, and the alarm
///
/// Each trace resets the detector; the evidence for the alarm continues from trace to trace, as records of one drive.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:\n  bearing-watch replay --model model.bwm traces/spall_2_000.csv")]
pub(crate) struct Args {
    /// The binary model; it contains its channels and preparation
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    #[command(flatten)]
    pub(crate) taken: Taken<Replay>,
    /// Each trace is a run, from power-up to power-up, whose segments depend on each other. Without it and without
    /// --group, a run ends after the number of segments in the model
    #[arg(long, conflicts_with = "group")]
    run_a_trace: bool,
    /// Write a page with signals, verdicts, distance and evidence over time
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Also writes the rows of one recording as the drive reads them, for `cargo xtask pil`; the model needs a front
    /// end
    #[arg(long, value_name = "FILE")]
    rows: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Args) -> Result<(), Error> {
    let inputs = [&args.taken.settings.data.traces[..], std::slice::from_ref(&args.model)].concat();
    output::plan(&args.report.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &inputs)?;
    let ModelFile { model, notes } = ModelFile::read(&args.model)?;
    let (mut values, mut replayed) = (Vec::new(), Vec::new());
    let mut stream = model.stream();
    let traces = args.traces(&notes)?;
    irregular(traces.iter()).iter().chain(&refused(traces.iter())).for_each(output::warn);
    if let Some(told) = told(traces.iter()).filter(|_| !args.json) {
        output::say(told)?;
    }
    check_rate(&model, notes.preparation(), traces.iter())?;
    args.write_rows(&model, &notes)?;
    let (mut raised, mut size) = (false, String::new());
    let mut conclusion = Conclusion::new(&model, &notes.orders);
    let ends = args.run_ends(&notes, &traces)?;
    let mut life = Life::new(&args.taken.settings, &notes)?;
    for (trace, run_ends) in traces.into_iter().zip(ends) {
        let prepared = notes.preparation().apply(&trace)?;
        let (segments, evidence): (Vec<_>, Vec<_>) = stream.run(&prepared, run_ends).into_iter().unzip();
        conclusion.take(&prepared, &segments, &evidence);
        life.take(&trace);
        for (k, (segment, watched)) in segments.iter().zip(&evidence).enumerate() {
            if args.json {
                let life = if k + 1 == segments.len() { life.to_json() } else { Value::Null };
                values.push(value(&model, (&prepared, k), (segment, watched), (&notes.orders, life)));
                continue;
            }
            let gated = model.healthy().is_some();
            output::say(
                line(&model.classes, &model.channel_names(), &prepared, segment)
                    + &without(&missing(&model, &notes.orders, segment))
                    + &beyond(&outside(&model, &notes.orders, segment))
                    + &shaft(&notes.orders, segment)
                    + &if gated { far(segment, watched) } else { "".into() }
                    + &seen(&model, &notes.orders, segment),
            )?;
            if let (Some(alarm), Some(cause), false) = (watched.alarm, model.cause(watched, &notes.orders), raised) {
                raised = true;
                output::say(format!("ALARM at segment {}: {cause}{}", alarm.segment, watched.rise()))?;
            }
            if !watched.run.is_empty() {
                output::say(run_line(&model, &notes.orders, watched))?;
            }
            size = watched.size(&|direction| model.direction_name(&notes.orders, direction));
        }
        if args.report.is_some() {
            replayed.push(Replayed { trace: prepared, segments, watched: evidence });
        }
    }
    if let Some(path) = &args.report {
        let title = format!("Replay through {}", args.model.display());
        let page = life.on_page(page(&title, (&model, &notes.channels), &replayed, &conclusion));
        output::write(path, args.taken.on_page(page.render()))?;
    }
    if args.json {
        return output::json("replay", json!(values));
    }
    if !size.is_empty() {
        output::say(size)?;
    }
    life.lines().iter().try_for_each(output::say)?;
    output::say(conclusion.words())
}

/// The page of traces through a model, with the usual settings.
pub(crate) fn page_of(file: &Path, traces: &[PathBuf]) -> Result<Page, Error> {
    let ModelFile { model, notes } = ModelFile::read(file)?;
    let traces = traces::read(traces, &notes.channels)?;
    check_rate(&model, notes.preparation(), traces.iter())?;
    let mut stream = model.stream();
    let mut judge = |trace: &Trace| {
        let trace = notes.preparation().apply(trace)?;
        let (segments, watched) = stream.run(&trace, false).into_iter().unzip();
        Ok(Replayed { trace, segments, watched })
    };
    let replayed = traces.iter().map(&mut judge).collect::<Result<Vec<_>, Error>>()?;
    let mut conclusion = Conclusion::new(&model, &notes.orders);
    replayed.iter().for_each(|own| conclusion.take(&own.trace, &own.segments, &own.watched));
    let shown = |path: &Path| path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let title = format!("Replay through {}", shown(file));
    Ok(page(&title, (&model, &notes.channels), &replayed, &conclusion))
}

/// What the run that ends says of each direction.
fn run_line(model: &Embedded, orders: &[String], watched: &AlarmState) -> String {
    let told = |one: &Contribution| {
        format!("{} {:+.1} sd (score {:.1})", model.direction_name(orders, one.direction), one.deviations, one.score)
    };
    format!("  run: {}", watched.run.iter().map(told).collect::<Vec<_>>().join(", "))
}

impl Args {
    /// Reads the traces; those that labels name have these names.
    fn traces(&self, notes: &Notes) -> Result<Vec<Trace>, Error> {
        let data = &self.taken.settings.data;
        let names = data.labels.as_deref().map(|file| Ok(traces::read_labels(file)?.names())).transpose()?;
        let source = match names {
            Some(names) => Source::Labelled(data.traces.clone(), names),
            None => Source::Files(data.traces.clone()),
        };
        source.read(&notes.channels)
    }

    /// Whether a run ends with each of these traces.
    fn run_ends(&self, notes: &Notes, traces: &[Trace]) -> Result<Vec<bool>, Error> {
        let Settings { data, validation, .. } = &self.taken.settings;
        let (Some(labels), Some(column)) = (&data.labels, validation.group.as_ref().or(notes.group.as_ref())) else {
            return match &validation.group {
                Some(column) => Err(Error::Usage(format!("--group {column} is a column of the labels: give --labels"))),
                None => Ok(vec![self.run_a_trace; traces.len()]),
            };
        };
        let ids = traces.iter().map(|trace| trace.id.as_str());
        let cells = traces::read_labels(labels)?.cells(column, ids)?;
        if let Some(place) = cells.iter().position(String::is_empty) {
            return Err(Error::trace(&traces[place].id, format!("no run in column {column} of {}", labels.display())));
        }
        Ok((1..=cells.len()).map(|next| cells.get(next) != cells.get(next - 1)).collect())
    }

    fn write_rows(&self, model: &Embedded, notes: &Notes) -> Result<(), Error> {
        let Some(file) = &self.rows else { return Ok(()) };
        let ([trace], Some(front_end), false) = (
            &self.taken.settings.data.traces[..],
            &notes.channels.front_end,
            self.taken.settings.data.traces[0].is_dir(),
        ) else {
            return Err(Error::Usage(
                "--rows takes one recording, and a model that was trained with --front-end".into(),
            ));
        };
        let further = further_columns(model.model(), &notes.channels, "--rows")?;
        output::write(file, raw_rows(trace, front_end, &further)?)
    }
}

/// Returns what a healthy segment would have shown, and by what one that is not healthy departs most.
fn seen(model: &Embedded, orders: &[String], segment: &SegmentReport) -> String {
    match &segment.verdict {
        Ok(Finding::Class(class)) if Some(*class) == model.healthy() => {
            let shown = sight::smallest(model, orders, std::iter::once(&segment.smallest[..]));
            match sight::sentences(model, &shown) {
                [found, _] if found.is_empty() => String::new(),
                [found, unseen] if unseen.is_empty() => format!("; {found} would have been found"),
                [found, unseen] => format!("; {found} would have been found; not looked at: {unseen}"),
            }
        }
        Ok(_) => sight::most(model, orders, segment).map_or_else(String::new, |most| format!(", most by {most}")),
        Err(_) => String::new(),
    }
}

/// Returns the distance from healthy, and the evidence so far.
fn far(segment: &SegmentReport, watched: &AlarmState) -> String {
    let SegmentReport { distance, surprise, .. } = segment;
    let score = watched.score;
    match segment.verdict {
        Ok(_) => format!(", distance {distance:.2}, surprise {surprise:.1} nats, score {score:.1}"),
        Err(_) => match watched.silence {
            Some(own) => format!(", score {score:.1}, no verdict for {} segments", own.segments),
            None => format!(", score {score:.1}"),
        },
    }
}

/// Returns the torque balance and the orders in physical units; empty if no shaft is watched or the balance has no
/// rows.
fn shaft(names: &[String], segment: &SegmentReport) -> String {
    let Some(friction) = segment.friction.filter(|friction| friction.rows > 0) else { return String::new() };
    // If the load is not measured, only the ratios to Kt are identifiable.
    let physical = (friction.inertia_kg_m2(), friction.viscous_nm_s_rad(), friction.coulomb_nm());
    let mut text = match (friction.torque_constant_nm_a(), physical) {
        (Some((kt, _)), (Some(j), Some(b), Some(tc))) => {
            format!(", Kt {kt:.4} N·m/A, J {j:.3e} kg·m², B {b:.2e} N·m·s, Tc {tc:.2e} N·m")
        }
        _ => {
            let [j, b, tc] = [friction.inertia, friction.viscous, friction.coulomb].map(|parameter| parameter.value);
            let weight = friction.weight_a().map_or_else(String::new, |(weight, _)| format!(", weight {weight:.2e} A"));
            format!(", J/Kt {j:.3e} A·s²/rad, B/Kt {b:.2e} A·s/rad, Tc/Kt {tc:.2e} A{weight}")
        }
    };
    for (name, order) in names.iter().zip(&segment.orders) {
        text.push_str(&format!(", {name} {:.1} × noise", order.prominence));
    }
    text
}

/// Returns the names of the features that were missing.
fn missing(model: &Embedded, orders: &[String], segment: &SegmentReport) -> Vec<String> {
    let catalogue = model.catalogue(orders);
    segment.missing.iter().map(|feature| catalogue.name(*feature)).collect()
}

/// Returns the names of the covariates that were missing or outside their range.
fn outside(model: &Embedded, orders: &[String], segment: &SegmentReport) -> Vec<String> {
    let catalogue = model.catalogue(orders);
    model.outside(segment).into_iter().map(|feature| catalogue.name(feature)).collect()
}

fn beyond(outside: &[String]) -> String {
    if outside.is_empty() { String::new() } else { format!(", {} missing or out of range", outside.join(", ")) }
}

fn without(missing: &[String]) -> String {
    if missing.is_empty() { String::new() } else { format!(", without {}", missing.join(", ")) }
}

/// Returns the place of the segment: in seconds if the trace has a time, else in samples.
fn place(trace: &Trace, segment: &SegmentReport) -> String {
    let (from, to) = (segment.start, segment.start + segment.length);
    match trace.interval_s {
        Some(step) => format!("{:.3}–{:.3} s", from as f64 * step, to as f64 * step),
        None => format!("samples {from}–{to}"),
    }
}

fn line(classes: &[String], names: &[&str], trace: &Trace, segment: &SegmentReport) -> String {
    let verdict = match &segment.verdict {
        Ok(finding) => finding.name(classes).to_string(),
        Err(reason) => format!("undetermined: {reason}"),
    };
    let posteriors: Vec<String> =
        classes.iter().zip(&segment.posteriors).map(|(class, p)| format!("{class} {p:.3}")).collect();
    let place = place(trace, segment);
    let mut line = format!("{}  {place}  {verdict}  [{}]  {} rows", trace.id, posteriors.join(", "), segment.rows);
    let denied = denied(&segment.counts, names);
    if !denied.is_empty() {
        line.push_str(&format!(", {denied}"));
    }
    line
}

fn interval(Interval { value, low, high }: Interval) -> Value {
    json!({ "value": value, "low": low, "high": high })
}

fn value(
    model: &Embedded,
    (trace, number): (&Trace, usize),
    (segment, watched): (&SegmentReport, &AlarmState),
    (orders, life): (&[String], Value),
) -> Value {
    let (missing, outside) = (missing(model, orders, segment), outside(model, orders, segment));
    let named_by = |names: &[String], values: &[f32]| -> serde_json::Map<String, Value> {
        names.iter().cloned().zip(values.iter().map(|v| json!(v))).collect()
    };
    let classes = &model.classes;
    let named = |values: &[f32]| named_by(classes, values);
    // Without an estimate the parameters are zeros without meaning.
    let estimated = segment.variance > 0.0 || segment.raw.iter().any(|x| *x != 0.0);
    json!({
        "trace": trace.id,
        "segment": number,
        "start": segment.start,
        "length": segment.length,
        "class": segment.verdict.as_ref().ok().and_then(|finding| finding.class()).map(|class| &classes[class]),
        "verdict": segment.verdict.as_ref().map_or("undetermined", |finding| finding.name(classes)),
        "undetermined": segment.verdict.as_ref().err(),
        "missing": missing,
        "missing_samples": trace.missing.to_json(),
        "covariates_out_of_range": outside,
        "posteriors": named(&segment.posteriors),
        "log_likelihoods": named(&segment.log_likelihoods),
        "distance": segment.verdict.is_ok().then_some(segment.distance),
        "surprise": segment.verdict.is_ok().then_some(segment.surprise),
        "score": watched.score,
        "alarm": watched.alarm.map(|alarm| json!({
            "segment": alarm.segment,
            "cause": model.cause(watched, orders),
            "deviations": watched.main.map(|main| main.deviations),
            "since": watched.main.map(|main| main.since + 1),
        })),
        "run": (!watched.run.is_empty()).then(|| watched.run.iter().map(|one| json!({
            "direction": model.direction_name(orders, one.direction),
            "deviations": one.deviations,
            "score": one.score,
            "since": (one.score > 0.0).then_some(one.since + 1),
        })).collect::<Vec<_>>()),
        "growth": watched.growth.map(|(direction, growth)| json!({
            "direction": model.direction_name(orders, direction),
            "size": interval(growth.size),
            "slope_per_run": interval(growth.slope),
            "slope_per_hour": (growth.run_hours > 0.0).then(|| interval(growth.slope_per_hour())),
            "named_size": growth.named,
            "growing": growth.is_growing(),
            "runs_left": growth.left.map(interval),
            "hours_left": growth.left_hours().filter(|_| growth.run_hours > 0.0).map(interval),
        })),
        "life": life,
        "most": segment.most.map(|most| json!({
            "coordinate": model.coordinate_name(orders, most.coordinate),
            "falls": most.falls,
        })),
        "smallest_found": sight::smallest(model, orders, std::iter::once(&segment.smallest[..])).iter().map(|own| json!({
            "defect": own.name,
            "size": own.size.is_finite().then_some(own.size),
            "unit": if own.is_amplitude { "A" } else { "part of the usual value" },
        })).collect::<Vec<_>>(),
        "parameters": estimated.then(|| named_by(&model.structure().map_or_else(Vec::new, |own| own.names()), &segment.raw)),
        "variance": estimated.then_some(segment.variance),
        "friction": segment.friction.filter(|friction| friction.rows > 0).map(|friction| {
            let each = FrictionTerm::ALL.map(|term| friction.parameter(term));
            json!({
                "names": features::FRICTION,
                "values": each.map(|own| own.map(|parameter| parameter.value)),
                "deviations": each.map(|own| own.map(|parameter| parameter.deviation)),
                "scores": each.map(|own| own.map(|parameter| parameter.score)),
                "weight_a": friction.weight_a().map(|(value, deviation)| json!({ "value": value, "deviation": deviation })),
            })
        }),
        "orders": segment.orders.iter().map(|o| json!({ "prominence": o.prominence, "amplitude_a": o.amplitude })).collect::<Vec<_>>(),
        "rows": segment.rows,
        "rejected": segment.counts.rejected,
        "saturated": segment.counts.saturated,
        "still": segment.counts.resting,
        "stuck": stuck_channels(segment.counts.stuck, &model.channel_names()),
    })
}
