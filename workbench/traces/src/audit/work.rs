//! The work of an audit.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::asked::Audit;
use super::audited::{Audited, Finding, Line, Outcome};
use super::findings::{add, equal_traces, session_sets};
use crate::describe::guess::Guess;
use crate::listing::{Candidate, LEFT_OUT, told_unlabelled, without};
use crate::reader::{self, Series};
use model::Error;
use model::audit::column::Column;
use model::audit::friction::{Excited, Motion, Terms, excited};
use model::audit::orders::{self, floor, rate, smallest_line, turns};
use model::audit::times::Times;
use model::session::Log;
use model::settings::{Signals, healthy_class};
use model::trace::{Labels, bridged, trace_name};

/// Rows of the shortest trace; shorter ones are tables of something else.
const FEWEST: usize = 8;

impl Audit {
    /// Audits the traces of files.
    ///
    /// # Errors
    /// No trace, or channels that cannot be read.
    pub fn audit(&self, files: &[Candidate], log: &Log<'_>) -> Result<Outcome, Error> {
        let step = log.steps("auditing", files.len());
        let each = |file: &Candidate| {
            let found = self.look(file);
            step(1);
            found
        };
        let all: Vec<Result<Vec<Audited>, Error>> = files.par_iter().map(each).collect();
        let (mut traces, mut findings) = (Vec::new(), Vec::new());
        // A file that has no label and none of the channels is a table of something else.
        let labels = self.settings.data.labels.as_deref().map(crate::read_labels).transpose()?;
        let is_other = |file: &Candidate| labels.is_some() && !file.is_labelled();
        for (file, found) in files.iter().zip(all) {
            match found {
                Ok(found) => traces.extend(found),
                Err(problem) if is_other(file) => log.warn([format!("left out {problem}")]),
                Err(problem) => add(&mut findings, problem.to_string(), &file.file.display().to_string()),
            }
        }
        if traces.is_empty() {
            let problem = findings.first().map_or_else(|| "no trace".to_string(), |finding| finding.what.clone());
            return Err(Error::Usage(problem));
        }
        let short = traces.len();
        let is_long = |trace: &Audited| trace.values.first().is_some_and(|column| column.len() >= FEWEST);
        let other = traces.iter().filter(|trace| !is_long(trace)).map(|trace| PathBuf::from(&trace.id));
        log.warn(without(other.collect::<Vec<_>>().iter(), &format!("fewer than {FEWEST} rows")));
        traces.retain(is_long);
        if traces.is_empty() {
            return Err(Error::Usage(format!("{short} traces, none of {FEWEST} rows")));
        }
        if let Some(names) = labels.as_ref().map(Labels::names) {
            let bare = traces.iter().filter(|trace| !names.has(&trace.id)).map(|trace| trace.id.clone());
            let is_chosen = !self.settings.data.conditions.is_empty();
            let then = if is_chosen { LEFT_OUT } else { "audited without a class" };
            log.warn(told_unlabelled(&bare.collect::<Vec<_>>(), then));
        }
        if let Some(labels) = labels.as_ref().filter(|_| !self.settings.data.conditions.is_empty()) {
            let chosen = labels.select(&self.settings.data.conditions)?;
            let chosen: HashSet<&str> = chosen.iter().map(|(id, _)| id.as_str()).collect();
            traces.retain(|trace| chosen.contains(trace.id.as_str()));
            if traces.is_empty() {
                return Err(Error::Usage("--where: no trace that meets the conditions was found".into()));
            }
        }
        for trace in &traces {
            trace.findings(&mut findings);
        }
        equal_traces(&traces, &mut findings);
        let rotor = self.rotor_rate(&traces, &mut findings);
        // Empty without labels, and for a trace that has none.
        let ids = traces.iter().map(|trace| trace.id.as_str());
        let classes = labels.map_or(Ok(vec![]), |labels| labels.cells("class_name", ids))?;
        session_sets(&traces, &classes, &mut findings);
        let lines = self.lines(&traces, rotor);
        let terms = self.terms(&traces, &classes, rotor)?;
        Ok(Outcome { traces, findings, rotor, lines, terms })
    }

    fn look(&self, file: &Candidate) -> Result<Vec<Audited>, Error> {
        let time = self.settings.data.time.as_deref();
        let table = file.open(&self.settings.data.text_form())?;
        let (names, problems) = reader::numeric(&table, time)?;
        let of_columns = problems.iter().map(|problem| match problem {
            Error::Content { place, problem, .. } => format!("{place}: left out: {problem}"),
            other => other.to_string(),
        });
        let left_out: Vec<String> = table.about().told().chain(of_columns).collect();
        let guess = Guess::of(&names);
        let Signals { current, velocity, angle, velocity_ref, load, .. } = &self.settings.channels;
        let chosen = [
            (current, guess.current),
            (velocity, guess.velocity),
            (angle, guess.angle),
            (velocity_ref, guess.velocity_ref),
            (load, guess.load),
        ];
        let chosen = chosen.map(|(given, likely)| given.clone().or(likely));
        // A channel that is a column is not read again.
        let computed: Vec<&String> = chosen.iter().flatten().filter(|channel| !names.contains(channel)).collect();
        let channels: Vec<String> = names.iter().chain(computed.iter().copied()).cloned().collect();
        let read = reader::series(&table, (time, self.settings.data.rate_hz), &channels)?;
        let recorded = reader::has_time(&table, time);
        let each = |series: Series| {
            let all: Vec<Arc<Vec<f64>>> = series.columns.into_iter().map(Arc::new).collect();
            let of_name = |name: &String| Some(&all[channels.iter().position(|own| own == name)?]);
            let times = series.times_s.as_deref().filter(|_| recorded).and_then(Times::of);
            let values = all[..names.len()].to_vec();
            let used: Vec<Arc<Vec<f64>>> = chosen.iter().flatten().filter_map(of_name).cloned().collect();
            let missing = Audited::missing(times.as_ref(), &values, &used);
            let [current, velocity, angle, velocity_ref, load] =
                std::array::from_fn(|k| chosen[k].as_ref().and_then(of_name).map(whole));
            Audited {
                id: trace_name(&series.id).into_owned(),
                names: names.clone(),
                left_out: left_out.clone(),
                times,
                missing,
                times_s: series.times_s.filter(|_| recorded),
                columns: values.iter().map(|column| Column::of(column)).collect(),
                values,
                current,
                velocity,
                angle,
                velocity_ref,
                load,
            }
        };
        Ok(read.into_iter().map(each).collect())
    }

    /// The rate by the lines of the rotor, for traces without a time.
    fn rotor_rate(&self, traces: &[Audited], findings: &mut Vec<Finding>) -> Option<f64> {
        let given = self.settings.data.rate_hz?;
        let pairs: Vec<(&[f64], &[f64])> = traces
            .iter()
            .filter(|trace| trace.times.is_none())
            .filter_map(|trace| Some((trace.current.as_deref()?.as_slice(), trace.velocity.as_deref()?.as_slice())))
            .collect();
        let (found, sharpness) = rate(&pairs, given)?;
        if (found / given - 1.0).abs() > 2e-3 {
            let what = format!(
                "the lines of the rotor are sharp at {found:.1} rows a second, not at the given {given} \
                 ({sharpness:.0} times the power); set rate_hz"
            );
            add(findings, what, "all without a time");
        }
        Some(found)
    }

    /// Excitation and smallest change of the terms of friction and inertia.
    fn terms(&self, traces: &[Audited], classes: &[String], rotor: Option<f64>) -> Result<Vec<Excited>, Error> {
        let mut names: Vec<String> = classes.to_vec();
        names.sort_unstable();
        names.dedup();
        let healthy = healthy_class(self.settings.alarm.healthy.as_deref(), &names)?.map(|place| names[place].clone());
        let is_healthy = |k: usize| healthy.is_some() && classes.get(k) == healthy.as_ref();
        let each = |(k, trace): (usize, &Audited)| {
            let motion = Motion {
                current: trace.current.as_deref()?,
                velocity: trace.velocity.as_deref()?,
                load: trace.load.as_deref().map(Vec::as_slice),
                rate_hz: self.rate_of(trace, rotor)?,
            };
            Some((Terms::of(&motion)?, is_healthy(k)))
        };
        let all: Vec<(Terms, bool)> = traces.par_iter().enumerate().filter_map(each).collect();
        Ok(excited(&all, self.false_alarm()))
    }

    /// Floor, smallest line and turns of each trace with a signal and an angle.
    fn lines(&self, traces: &[Audited], rotor: Option<f64>) -> Vec<Line> {
        let each = |trace: &Audited| {
            let (y, angle) = self.with_angle(trace, rotor)?;
            let turns = turns(&angle);
            let floor = floor(y, &angle);
            let first = orders::amplitude(y, &angle, 1.0);
            (turns > 3.0).then(|| Line {
                trace: trace.id.clone(),
                turns,
                floor,
                smallest: smallest_line(floor, self.false_alarm()),
                first,
            })
        };
        traces.iter().filter_map(each).collect()
    }
}

/// A channel in which the last value stands for a missing one.
fn whole(values: &Arc<Vec<f64>>) -> Arc<Vec<f64>> {
    if values.iter().all(|x| x.is_finite()) { Arc::clone(values) } else { Arc::new(bridged(values)) }
}
