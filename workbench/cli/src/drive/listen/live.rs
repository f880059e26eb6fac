//! The page that shows a drive while it is listened to.

use std::sync::atomic::AtomicBool;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use bearing_watch::Verdict;
use bearing_watch::telemetry::{Block, Summary};

use super::names::Names;
use super::{alarm, report_text};
use crate::server::{Local, Reply};
use model::Error;
use pages::live::{Live, LiveReport, news, page};
use pages::segments::{Judged, trouble};

/// Reports, and samples of each channel, that the page shows.
const REPORTS: usize = 2000;
const SAMPLES: usize = 5000;

/// What the page shows, shared with the threads that answer.
pub(super) struct View {
    shared: Arc<Mutex<Live>>,
    /// Number of the sample that continues the last ones.
    next: Option<u32>,
}

impl View {
    /// Serves the page until the flag is set; returns its address too.
    pub(super) fn open(port: u16, stopped: &Arc<AtomicBool>) -> Result<(Self, String), Error> {
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
        Ok((Self { shared, next: None }, address))
    }

    /// A page without a server.
    pub(super) fn unserved() -> Self {
        Self { shared: Arc::default(), next: None }
    }

    /// A new stream, or other names of the same.
    pub(super) fn hello(&mut self, names: &Names) {
        let channels = names.channels.iter().map(|(name, unit)| format!("{name} / {unit}")).collect();
        let line = report_text::hello_line(names);
        let (classes, interval_s) = (names.classes.clone(), names.interval_s);
        let healthy = names.healthy.map(usize::from);
        *lock(&self.shared) = Live { classes, healthy, channels, interval_s, line, ..Live::default() };
        self.next = None;
    }

    pub(super) fn report(&self, names: &Names, summary: &Summary<'_>) {
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
    }

    pub(super) fn samples(&mut self, block: &Block<'_>) {
        let mut live = lock(&self.shared);
        let channels = usize::from(block.channels);
        if channels != live.channels.len() {
            return;
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
    }
}

/// A page that failed while it was drawn leaves what it shows intact.
fn lock(shared: &Mutex<Live>) -> MutexGuard<'_, Live> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}
