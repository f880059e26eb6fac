//! Reports, blocks of samples and of raw samples → frames.

use super::hello::{self, Source};
use super::raw::RawBlock;
use super::samples::Block;
use super::sink::{Sink, TooSmall};
use super::{HELLO, Header, RAW, REPORT, SAMPLES, VERSION, summary};
use crate::alarm::Evidence;
use crate::model::Model;
use crate::plan::Plan;
use crate::report::Report;

/// Makes frames and counts them.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Encoder<'m, P: Plan> {
    model: &'m Model<P>,
    source: Source,
    line: Line,
}

impl<'m, P: Plan> Encoder<'m, P> {
    /// No frame sent yet. Another model needs another encoder.
    #[must_use]
    pub fn new(model: &'m Model<P>, source: Source) -> Self {
        let mut sum = Sink::sum();
        // Never too small: nothing is stored.
        let _stored = hello::write(model, source, &mut sum);
        Self { model, source, line: Line::new(&sum) }
    }

    /// The names and constants that a receiver needs for the other frames.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn hello<'b>(&mut self, buffer: &'b mut [u8]) -> Result<&'b [u8], TooSmall> {
        let (model, source) = (self.model, self.source);
        self.line.frame(HELLO, buffer, |sink| hello::write(model, source, sink))
    }

    /// The report of a segment, and the evidence that has observed it.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn report<'b>(
        &mut self,
        report: &Report<P>,
        evidence: &Evidence<P>,
        buffer: &'b mut [u8],
    ) -> Result<&'b [u8], TooSmall> {
        let model = self.model;
        self.line.frame(REPORT, buffer, |sink| summary::write(model, report, evidence, sink))
    }

    /// A block of samples.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn samples<'b>(&mut self, block: &Block<'_>, buffer: &'b mut [u8]) -> Result<&'b [u8], TooSmall> {
        self.line.frame(SAMPLES, buffer, |sink| block.write(sink))
    }

    /// A block of raw samples.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn raw<'b>(&mut self, block: &RawBlock<'_>, buffer: &'b mut [u8]) -> Result<&'b [u8], TooSmall> {
        self.line.frame(RAW, buffer, |sink| block.write(sink))
    }
}

/// Makes frames of raw samples in a drive that has no model yet.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct RawEncoder {
    line: Line,
}

impl RawEncoder {
    /// No frame sent yet; the number of the model is 0 or any other.
    #[must_use]
    pub fn new(source: Source) -> Self {
        let mut sum = Sink::sum();
        for number in [source.model_id, source.session] {
            // Never too small: nothing is stored.
            let _stored = sum.bytes(&number.to_le_bytes());
        }
        Self { line: Line::new(&sum) }
    }

    /// A block of raw samples.
    ///
    /// # Errors
    /// [`TooSmall`].
    pub fn raw<'b>(&mut self, block: &RawBlock<'_>, buffer: &'b mut [u8]) -> Result<&'b [u8], TooSmall> {
        self.line.frame(RAW, buffer, |sink| block.write(sink))
    }
}

/// A stream of frames, and the number of the next one.
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Line {
    stream: u32,
    sequence: u32,
}

impl Line {
    /// Of the source whose checksum this is.
    fn new(source: &Sink<'_>) -> Self {
        Self { stream: source.checksum(), sequence: 0 }
    }

    /// A frame with this content after the header. One that does not fit is not counted.
    fn frame<'b>(
        &mut self,
        kind: u8,
        buffer: &'b mut [u8],
        content: impl FnOnce(&mut Sink<'_>) -> Result<(), TooSmall>,
    ) -> Result<&'b [u8], TooSmall> {
        let mut sink = Sink::frame(buffer);
        sink.fields(&Header { version: VERSION, kind, stream: self.stream, sequence: self.sequence })?;
        content(&mut sink)?;
        let end = sink.close()?;
        *buffer.get_mut(end).ok_or(TooSmall)? = 0;
        self.sequence = self.sequence.wrapping_add(1);
        buffer.get(..=end).ok_or(TooSmall)
    }
}
