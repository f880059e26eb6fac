//! The page that shows a drive while it is listened to.

use std::str::FromStr;
use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use bearing_watch::Verdict;
use bearing_watch::telemetry::{Block, Summary};
use serde_json::json;

use super::names::Names;
use super::{alarm, report_text};
use crate::command_line::output;
use crate::server::{Local, Reply};
use model::Error;
use pages::live::{Live, LiveReport, news, page};
use pages::segments::{Judged, trouble};

/// Reports, and samples of each channel, that the page shows.
const REPORTS: usize = 2000;
const SAMPLES: usize = 5000;
/// News of samples alone are printed after this time.
const SAMPLES_AFTER: Duration = Duration::from_millis(500);

/// Where the page is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// Served on this port.
    Port(u16),
    /// Lines of standard output.
    Output,
}

impl FromStr for Place {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "-" => Ok(Self::Output),
            port => port.parse().map(Self::Port).map_err(|_| "a number from 0 to 65535, or -".into()),
        }
    }
}

/// What the page shows, shared with the threads that answer.
pub(super) struct View {
    shared: Arc<Mutex<Live>>,
    /// Number of the sample that continues the last ones.
    next: Option<u32>,
    /// When it was printed, if it is, and whether that page had samples.
    printed: Option<(Option<Instant>, bool)>,
}

impl View {
    /// Serves the page until the flag is set, and returns its address, or prints it.
    pub(super) fn open(place: Place, stopped: &Arc<AtomicBool>) -> Result<(Self, Option<String>), Error> {
        let Place::Port(port) = place else {
            return Ok((Self { printed: Some((None, false)), ..Self::unserved() }, None));
        };
        let local = Local::open(port)?;
        let address = format!("http://{}/", local.address);
        let shared = Arc::new(Mutex::new(Live::default()));
        let (own, stopped) = (Arc::clone(&shared), Arc::clone(stopped));
        // Not joined: it ends with the program.
        std::thread::spawn(move || {
            local.answer(&stopped, &|path, _| match path {
                "/" => Reply::html(page(&lock(&own).clone())),
                "/news" => Reply::html(news(&lock(&own).clone())),
                _ => Reply::problem(404, "There is no such page."),
            });
        });
        Ok((Self { shared, ..Self::unserved() }, Some(address)))
    }

    /// A page without a server.
    pub(super) fn unserved() -> Self {
        Self { shared: Arc::default(), next: None, printed: None }
    }

    /// A new stream, or other names of the same.
    pub(super) fn hello(&mut self, names: &Names) -> Result<(), Error> {
        let channels = names.channels.iter().map(|(name, unit)| format!("{name} / {unit}")).collect();
        let line = report_text::hello_line(names);
        let (classes, interval_s) = (names.classes.clone(), names.interval_s);
        let healthy = names.healthy.map(usize::from);
        *lock(&self.shared) = Live { classes, healthy, channels, interval_s, line, ..Live::default() };
        self.next = None;
        self.printed = self.printed.map(|_| (None, false));
        self.print()
    }

    /// Prints the page, or its news if it has the same figures as before.
    fn print(&mut self) -> Result<(), Error> {
        let Some((before, had_samples)) = self.printed else { return Ok(()) };
        let live = lock(&self.shared).clone();
        let has_samples = !live.samples.1.is_empty();
        self.printed = Some((Some(Instant::now()), has_samples));
        let is_new = before.is_none() || has_samples != had_samples;
        let (kind, html) = if is_new { ("page", page(&live)) } else { ("news", news(&live)) };
        output::json_line("listen", json!({ "kind": kind, "html": html }))
    }

    pub(super) fn report(&mut self, names: &Names, summary: &Summary<'_>) -> Result<(), Error> {
        let mut live = lock(&self.shared);
        let classes = live.classes.len();
        let place = match summary.verdict {
            Verdict::Class(class) => usize::from(class),
            Verdict::Novel => classes,
            Verdict::Ambiguous => classes + 1,
            Verdict::Undetermined(_) => classes + 2,
        };
        let decided = !matches!(summary.verdict, Verdict::Undetermined(_));
        let far = |value: f32| if decided { f64::from(value) } else { f64::NAN };
        let end = f64::from(summary.segment);
        let judged = Judged {
            span: (end - 1.0, end),
            place,
            distance: far(summary.distance),
            surprise: far(summary.surprise),
            score: Some(f64::from(summary.score)),
            trouble: trouble(&summary.counts, false),
        };
        let posteriors = summary.posteriors.iter().map(f64::from).collect();
        live.reports.push(LiveReport { judged, posteriors });
        let more = live.reports.len().saturating_sub(REPORTS);
        live.reports.drain(..more);
        live.alarm = summary.alarm.map(|raised| (f64::from(raised.segment), alarm::name(names, raised.cause)));
        live.risen = alarm::risen(names, summary).unwrap_or_default();
        live.line = report_text::report_line(names, summary);
        drop(live);
        self.print()
    }

    pub(super) fn samples(&mut self, block: &Block<'_>) -> Result<(), Error> {
        let mut live = lock(&self.shared);
        let channels = usize::from(block.channels);
        if channels != live.channels.len() {
            return Ok(());
        }
        let (first, kept) = &mut live.samples;
        if self.next != Some(block.first) || kept.len() != channels {
            (*first, *kept) = (u64::from(block.first), vec![vec![]; channels]);
        }
        for (channel, values) in kept.iter_mut().enumerate() {
            values.extend((0..block.len()).filter_map(|place| block.value(place, channel)).map(f64::from));
        }
        let more = kept.first().map_or(0, Vec::len).saturating_sub(SAMPLES);
        kept.iter_mut().for_each(|values| drop(values.drain(..more.min(values.len()))));
        *first += more as u64;
        self.next = Some(block.first.wrapping_add(block.len() as u32));
        drop(live);
        match self.printed {
            Some((Some(before), _)) if before.elapsed() >= SAMPLES_AFTER => self.print(),
            _ => Ok(()),
        }
    }
}

/// A page that failed while it was drawn leaves what it shows intact.
fn lock(shared: &Mutex<Live>) -> MutexGuard<'_, Live> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
