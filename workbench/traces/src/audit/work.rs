//! The work of an audit.

use std::collections::HashSet;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::asked::Audit;
use super::audited::{Audited, Finding, Line, Outcome};
use super::findings::{add, equal_traces, session_sets, several_rates};
use super::looked;
use crate::front_end::OWN;
use crate::front_end::cleaned;
use crate::listing::{Candidate, LEFT_OUT, told_unlabelled, without};
use crate::table::Table;
use model::Error;
use model::audit::friction::{Excited, Motion, Terms, excited};
use model::audit::orders::{self, floor, rate, rate_anywhere, smallest_line, turns};
use model::session::Log;
use model::settings::{Data, Settings, Signals, healthy_class};
use model::trace::front_end::FrontEndFile;
use model::trace::labels::Condition;
use model::trace::{Cells, Channels, Labels, MotionTrace, Recorded, Trace, median, same_interval, trace_name};
use model::train::{Weight, weight_in};

/// What follows the name of a trace before the front end.
const AS_RECORDED: &str = " as recorded";
/// Traces in which a weight is looked for.
const MOST_WEIGHED: usize = 64;
/// Rows of the shortest trace; shorter ones are tables of something else.
const FEWEST: usize = 8;

impl Audit {
    /// Audits the traces of files.
    ///
    /// # Errors
    /// No trace, or channels that cannot be read.
    pub fn audit(&self, files: &[Candidate], log: &Log<'_>) -> Result<Outcome, Error> {
        log.warn(self.settings.bearing.bearing.note());
        let step = log.steps("auditing", files.len());
        let front_end = self.settings.data.front_end.as_deref().map(FrontEndFile::read).transpose()?;
        let each = |file: &Candidate| {
            let found = self.look(file, front_end.as_ref());
            step(1);
            found
        };
        let all: Vec<Result<Vec<Audited>, Error>> = files.par_iter().map(each).collect();
        let (mut traces, mut findings) = (Vec::new(), Vec::new());
        // A file that has no label and none of the channels is a table of something else.
        let labels = self.settings.data.labels.as_deref().map(crate::read_labels).transpose()?;
        let is_other = |file: &Candidate| labels.is_some() && !file.is_labelled();
        let (asked, conditions): (Vec<Condition>, Vec<Condition>) =
            self.settings.data.conditions.iter().cloned().partition(Condition::is_question);
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
            let is_bare = |trace: &&Audited| !names.has(&trace.id) && !trace.id.ends_with(AS_RECORDED);
            let bare = traces.iter().filter(is_bare).map(|trace| trace.id.clone());
            let is_chosen = !conditions.is_empty();
            let then = if is_chosen { LEFT_OUT } else { "audited without a class" };
            log.warn(told_unlabelled(&bare.collect::<Vec<_>>(), then));
        }
        if let Some(labels) = labels.as_ref().filter(|_| !conditions.is_empty()) {
            let chosen = labels.select(&conditions)?;
            let chosen: HashSet<&str> = chosen.iter().map(|(id, _)| id.as_str()).collect();
            traces.retain(|trace| chosen.contains(trace.id.as_str()));
            if traces.is_empty() {
                return Err(Error::Usage("--where: no trace that meets the conditions was found".into()));
            }
        }
        for condition in asked {
            add(&mut findings, format!("where {condition} is a question: all are audited"), "all");
        }
        for trace in &traces {
            trace.findings(&mut findings);
        }
        equal_traces(&traces, &mut findings);
        several_rates(&traces, &mut findings);
        let rotor = self.rotor_rate(&traces, &mut findings);
        // Empty without labels, and for a trace that has none.
        let ids = traces.iter().map(|trace| trace.id.as_str());
        let classes = labels.map_or(Ok(vec![]), |labels| labels.cells("class_name", ids))?;
        session_sets(&traces, &classes, &mut findings);
        let lines = self.lines(&traces, rotor);
        let terms = self.terms(&traces, &classes, rotor)?;
        let weight = self.weight(&traces, rotor);
        if let Some(doubt) = weight.and_then(|own| own.doubt()) {
            add(&mut findings, doubt, "all without a load");
        }
        Ok(Outcome { traces, findings, rotor, lines, terms, weight })
    }

    /// The traces of a file: as they are recorded, and behind the front end, if there is one.
    fn look(&self, file: &Candidate, front_end: Option<&FrontEndFile>) -> Result<Vec<Audited>, Error> {
        let table = file.open(&self.settings.data.text_form())?;
        let Some(front_end) = front_end else { return looked::look(&table, &self.settings, &self.settings.channels) };
        let mut all = looked::look(&table, &self.settings, &Signals::default())?;
        all.iter_mut().for_each(|trace| trace.id += AS_RECORDED);
        let settings = Settings { data: Data::default(), ..self.settings.clone() };
        for cleaned in self.cleaned(&table, front_end)? {
            all.extend(looked::look(&Table::of(&Arc::new(cleaned)), &settings, &settings.channels)?);
        }
        Ok(all)
    }

    /// What the front end makes of the traces of a table.
    fn cleaned(&self, table: &Table, front_end: &FrontEndFile) -> Result<Vec<Recorded>, Error> {
        let Settings { data, channels, .. } = &self.settings;
        let [current, velocity, angle] = OWN.map(String::from);
        let further = [&channels.load, &channels.velocity_ref].into_iter().flatten();
        let further: Vec<String> = further.filter(|name| table.names().contains(name)).cloned().collect();
        let wanted = Channels {
            further: std::iter::once(angle).chain(further.iter().cloned()).collect(),
            time: data.time.clone(),
            rate_hz: data.rate_hz,
            text: data.text_form(),
            ..Channels::new(&current, &velocity, &velocity)
        };
        let each = |trace: Trace| {
            let times = (0..trace.y.len()).map(|row| row as f64 * front_end.interval_s()).collect();
            let names = OWN.map(String::from).into_iter().chain(further.iter().cloned());
            let columns = [trace.y, trace.u1].into_iter().chain(trace.further);
            let columns = names.zip(columns).map(|(name, values)| (name, Cells::Numbers(values)));
            let time = ("t_s".to_string(), Cells::Numbers(times));
            Recorded::new(trace_name(&trace.id), std::iter::once(time).chain(columns).collect())
        };
        let traces = cleaned::read(table, &wanted, front_end, &|_| true)?;
        traces.into_iter().map(each).collect()
    }

    /// The rate by the lines of the rotor, for traces without a time.
    fn rotor_rate(&self, traces: &[Audited], findings: &mut Vec<Finding>) -> Option<f64> {
        let pairs: Vec<(&[f64], &[f64])> = traces
            .iter()
            .filter(|trace| trace.times.is_none())
            .filter_map(|trace| Some((trace.current.as_deref()?.as_slice(), trace.velocity.as_deref()?.as_slice())))
            .collect();
        let Some(given) = self.settings.data.rate_hz else {
            if let Some((found, sharpness)) = rate_anywhere(&pairs) {
                let what = format!(
                    "no time and no rate: the lines of the rotor are sharpest at {found:.1} rows a second ({sharpness:.0} \
                     times the power); is that rate_hz?"
                );
                add(findings, what, "all without a time");
            }
            return None;
        };
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

    /// The weight on an axis in the traces of the usual rate that have no load.
    fn weight(&self, traces: &[Audited], rotor: Option<f64>) -> Option<Weight> {
        let rates: Vec<f64> = traces.iter().filter_map(|trace| self.rate_of(trace, rotor)).collect();
        let usual = median(rates);
        let bare = traces.iter().filter(|trace| {
            trace.load.is_none() && self.rate_of(trace, rotor).is_some_and(|rate| same_interval(rate, usual))
        });
        let motion = |trace: &Audited| {
            let signal = |channel: &Option<Arc<Vec<f64>>>| channel.as_deref().cloned();
            Some(MotionTrace {
                current_a: signal(&trace.current)?,
                velocity_rad_s: signal(&trace.velocity)?,
                load_nm: vec![0.0; trace.rows()],
                angle_rad: signal(&trace.angle)?,
                reference_rad_s: vec![],
            })
        };
        // Copies of so many say as much as those of all.
        let motions: Vec<MotionTrace> = bare.filter_map(motion).take(MOST_WEIGHED).collect();
        weight_in(&motions.iter().collect::<Vec<_>>(), 1.0 / usual, self.settings.model.gear_ratio)
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
