//! Frames → lines and traces.

use bearing_watch::Alarm;
use bearing_watch::telemetry::{Block, Body, Frame, LinkStats, RawBlock, Summary};

use super::live::View;
use super::names::{Names, Streams};
use super::traces::{Traces, Written};
use super::{alarm, raw, report_text};
use crate::command_line::output;
use model::Error;

/// How lines are shown.
#[derive(Clone, Copy)]
pub(crate) struct Output {
    /// What happened, as a line and as a value.
    pub(crate) tell: fn(String, serde_json::Value) -> Result<(), Error>,
    /// An alarm as a line; values have it already.
    pub(crate) alarm: fn(&str) -> Result<(), Error>,
}

impl Output {
    /// On standard output.
    pub(super) fn printed(json: bool) -> Self {
        if json {
            Self { tell: |_, value| output::json_line("listen", value), alarm: |_| Ok(()) }
        } else {
            Self { tell: |line, _| output::say_line(&line), alarm: output::say_line }
        }
    }
}

/// What is known of the stream, and where its frames go.
pub(super) struct Receiver {
    output: Output,
    streams: Streams,
    /// Those of the model that is given.
    model: Option<Names>,
    /// Names of the further channels of raw samples.
    further: Vec<String>,
    traces: Option<Traces>,
    view: Option<View>,
    /// Stream and number of the last frame.
    last: Option<(u32, u32)>,
    /// The alarm that was shown.
    alarm: Option<Alarm>,
    /// Samples that came before the hello of their stream.
    unnamed: u64,
}

impl Receiver {
    pub(super) fn new(output: Output, traces: Option<Traces>, further: Vec<String>) -> Self {
        let streams = Streams::default();
        Self { output, streams, model: None, further, traces, view: None, last: None, alarm: None, unnamed: 0 }
    }

    /// With the names of this model for the drives that have it.
    pub(super) fn with_model(self, model: Option<Names>) -> Self {
        Self { model, ..self }
    }

    /// Shows what comes on a page too.
    pub(super) fn show(&mut self, view: View, address: Option<String>) -> Result<(), Error> {
        self.view = Some(view);
        let Some(address) = address else { return Ok(()) };
        self.tell(report_text::view_line(&address), report_text::view_value(&address))
    }

    pub(super) fn take(&mut self, frame: &Frame<'_>) -> Result<(), Error> {
        let Frame { stream, sequence, .. } = *frame;
        let continues = |(last, before)| last == stream && sequence > before;
        if !self.last.is_none_or(continues) {
            // A restart: its sample numbers start afresh, and could continue the old ones by chance.
            self.alarm = None;
            self.close()?;
        }
        self.last = Some((stream, sequence));
        match frame.body {
            Body::Hello(hello) => {
                let names = Names::of(stream, &hello);
                let names = self.model.iter().fold(names, Names::named_by);
                if self.streams.hello(names.clone()) {
                    self.view.iter_mut().try_for_each(|view| view.hello(&names))?;
                    self.tell(report_text::hello_line(&names), report_text::hello_value(&names))?;
                }
                Ok(())
            }
            Body::Report(summary) => self.report(stream, &summary),
            Body::Samples(block) => self.samples(stream, &block),
            Body::Raw(block) => self.raw(stream, &block),
        }
    }

    fn report(&mut self, stream: u32, summary: &Summary<'_>) -> Result<(), Error> {
        let unknown = Names::default();
        let names = self.streams.of(stream).unwrap_or(&unknown);
        self.view.iter_mut().try_for_each(|view| view.report(names, summary))?;
        self.tell(report_text::report_line(names, summary), report_text::report_value(names, summary))?;
        if summary.alarm != self.alarm {
            self.alarm = summary.alarm;
            if let Some(line) = alarm::line(names, summary) {
                (self.output.alarm)(&line)?;
            }
        }
        Ok(())
    }

    fn samples(&mut self, stream: u32, block: &Block<'_>) -> Result<(), Error> {
        self.view.iter_mut().try_for_each(|view| view.samples(block))?;
        let Some(traces) = &mut self.traces else { return Ok(()) };
        let shape = |names: &&Names| {
            (usize::from(block.channels), block.with_angle) == (names.channels.len(), names.with_angle)
        };
        let Some(names) = self.streams.of(stream).filter(shape) else {
            self.unnamed += block.len() as u64;
            return Ok(());
        };
        let written = traces.take(stream, names, block)?;
        written.iter().try_for_each(|file| self.written(file))
    }

    fn raw(&mut self, stream: u32, block: &RawBlock<'_>) -> Result<(), Error> {
        let Some(traces) = &mut self.traces else { return Ok(()) };
        let further = raw::further(block, &self.further).map_err(Error::Usage)?;
        let written = traces.take_raw(stream, &further, block)?;
        written.iter().try_for_each(|file| self.written(file))
    }

    fn close(&mut self) -> Result<(), Error> {
        let written = self.traces.as_mut().map_or_else(|| Ok(vec![]), Traces::close)?;
        written.iter().try_for_each(|file| self.written(file))
    }

    fn written(&self, file: &Written) -> Result<(), Error> {
        self.tell(report_text::trace_line(file), report_text::trace_value(file))
    }

    /// Completes the open trace and shows what was received.
    pub(super) fn end(mut self, counts: LinkStats) -> Result<(), Error> {
        self.close()?;
        let kept = self.traces.as_ref().map(|traces| [traces.samples, u64::from(traces.files), traces.unusable]);
        self.tell(report_text::end_line(counts, kept, self.unnamed), report_text::end_value(counts, kept, self.unnamed))
    }

    pub(super) fn tell(&self, line: String, value: serde_json::Value) -> Result<(), Error> {
        (self.output.tell)(line, value)
    }
}
