//! The page of a drive that is listened to: the last reports and samples, renewed while it is open.

use crate::conclusion::live::{Heard, words};
use crate::page::escape::escape;
use crate::page::paragraph;
use crate::plot::{self, Event, Panel, Series};
use crate::segments::{Judged, Limits, evidence, strips};
use crate::{Class, Color, Page};

/// Asks for news.
const SCRIPT: &str = include_str!("live.js");

/// A report of the drive.
#[derive(Clone, Debug, PartialEq)]
pub struct LiveReport {
    /// Verdict, distance, surprise and evidence; its span is the number of the segment and the next one.
    pub judged: Judged,
    /// Posterior of each class; empty without a verdict.
    pub posteriors: Vec<f64>,
}

/// What came from a drive lately.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Live {
    /// Names of the classes.
    pub classes: Vec<String>,
    /// The healthy class.
    pub healthy: Option<usize>,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Interval of the samples, s.
    pub interval_s: Option<f64>,
    /// The last reports.
    pub reports: Vec<LiveReport>,
    /// Number of the first of the last samples, and the values of each channel.
    pub samples: (u64, Vec<Vec<f64>>),
    /// The alarm: number of its segment, and cause.
    pub alarm: Option<(f64, String)>,
    /// What has risen, of an alarm by a direction ([`crate::conclusion::risen`]); else empty.
    pub risen: String,
    /// The last line that was shown.
    pub line: String,
}

/// The whole page.
#[must_use]
pub fn page(live: &Live) -> String {
    Page::new("bearing-watch: a drive, live").section("Now", &news(live)).live(SCRIPT).render()
}

/// What changes on the page.
#[must_use]
pub fn news(live: &Live) -> String {
    let judged: Vec<Judged> = live.reports.iter().map(|one| one.judged).collect();
    let Live { classes, healthy, alarm, risen, .. } = live;
    let heard = Heard { classes, healthy: *healthy, alarm: alarm.as_ref(), risen, judged: &judged };
    let conclusion = paragraph(&words(&heard));
    let line = if live.line.is_empty() { String::new() } else { format!("<p>{}</p>", escape(&live.line)) };
    format!("<div id=\"news\"><div class=\"conclusion\">{conclusion}</div>{line}</div>")
        + &reports(live)
        + &samples(live)
}

fn reports(live: &Live) -> String {
    // Before the first report the figure is there without points, so that it can be renewed.
    let nothing = Judged { span: (0.0, 1.0), distance: 0.0, surprise: 0.0, ..Judged::blank(live.classes.len()) };
    let judged: Vec<Judged> =
        if live.reports.is_empty() { vec![nothing] } else { live.reports.iter().map(|one| one.judged).collect() };
    let limits = Limits { gate: f64::INFINITY, alarm: f64::INFINITY };
    let mut panels = evidence(limits, &judged);
    let posterior = |(k, class): (usize, Class)| {
        let at = |one: &LiveReport| one.posteriors.get(k).copied().unwrap_or(f64::NAN);
        let points = live.reports.iter().flat_map(|one| [(one.judged.span.0, at(one)), (one.judged.span.1, at(one))]);
        Series::new(class.name, class.color, points.collect::<Vec<_>>())
    };
    let posteriors: Vec<Series> = Class::all(&live.classes).into_iter().enumerate().map(posterior).collect();
    panels.push(Panel::new("posterior probability", posteriors));
    let alarm = live.alarm.iter().map(|(at, cause)| Event { at: *at, name: format!("ALARM: {cause}") });
    let alarm: Vec<Event> = alarm.collect();
    let drawn = plot::timeline("Reports", "segment", &panels, &strips(&live.classes, &judged), &alarm);
    drawn.unwrap_or_default()
}

fn samples(live: &Live) -> String {
    let (first, channels) = &live.samples;
    let step = live.interval_s.unwrap_or(1.0);
    let label = if live.interval_s.is_some() { "time / s" } else { "sample" };
    let panel = |(k, (name, values)): (usize, (&String, &Vec<f64>))| {
        let points = values.iter().enumerate().map(|(row, value)| ((*first + row as u64) as f64 * step, *value));
        Panel::new(name, vec![Series::new(name, Color::of(k), points.collect::<Vec<_>>())])
    };
    let panels: Vec<Panel> = live.channels.iter().zip(channels).enumerate().map(panel).collect();
    // No samples, no figure; the page is loaded again when they come.
    plot::signals("Last samples", label, &panels).unwrap_or_default()
}
