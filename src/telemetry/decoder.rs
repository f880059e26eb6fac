//! Bytes → frames.

use core::fmt;

use cobs::{DecodeResult, DecoderState};

use super::counts::{LinkStats, Order};
use super::hello::Hello;
use super::raw::RawBlock;
use super::samples::Block;
use super::sink::checksum;
use super::summary::Summary;
use super::{HELLO, Header, RAW, REPORT, SAMPLES, VERSION, split};

/// What a frame has after its header.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Body<'a> {
    /// Names and constants of the stream.
    Hello(Hello<'a>),
    /// The result of a segment.
    Report(Summary<'a>),
    /// A block of samples.
    Samples(Block<'a>),
    /// A block of raw samples; it needs no hello.
    Raw(RawBlock<'a>),
}

/// A right frame. It refers to the decoder's buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct Frame<'a> {
    /// The stream: frames of equal numbers share a hello.
    pub stream: u32,
    /// Number of the frame in its stream.
    pub sequence: u32,
    /// The content.
    pub body: Body<'a>,
}

/// Why a content is no frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Refusal {
    Bad,
    Unknown,
}

/// Takes bytes one by one, in any pieces and from any place of the stream on; contents have at most `N` bytes with
/// their checksum.
pub struct Decoder<const N: usize> {
    stuffing: DecoderState,
    content: [u8; N],
    used: usize,
    /// Whether the content is longer than the buffer.
    oversize: bool,
    order: Order,
    counts: LinkStats,
}

impl<const N: usize> Default for Decoder<N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<const N: usize> Decoder<N> {
    /// Nothing received yet.
    #[must_use]
    pub fn new() -> Self {
        Self {
            stuffing: DecoderState::Idle,
            content: [0; N],
            used: 0,
            oversize: false,
            order: Order::default(),
            counts: LinkStats::default(),
        }
    }

    /// What came so far.
    #[must_use]
    pub const fn counts(&self) -> LinkStats {
        self.counts
    }

    /// Takes a byte; returns the frame that it completes.
    pub fn push(&mut self, byte: u8) -> Option<Frame<'_>> {
        let whole = match self.stuffing.feed(byte) {
            Ok(DecodeResult::NoData) => return None,
            Ok(DecodeResult::DataContinue(data)) => {
                match self.content.get_mut(self.used) {
                    Some(cell) => {
                        *cell = data;
                        self.used = self.used.saturating_add(1);
                    }
                    None => self.oversize = true,
                }
                return None;
            }
            Ok(DecodeResult::DataComplete) => true,
            Err(_) => false,
        };
        let used = core::mem::take(&mut self.used);
        if core::mem::take(&mut self.oversize) {
            self.counts.oversize = self.counts.oversize.saturating_add(1);
            return None;
        }
        let content = self.content.get(..used).unwrap_or(&[]);
        let read = if whole { read(content) } else { Err(Refusal::Bad) };
        match read {
            Ok((header, check, body)) => {
                let new = self.order.take(&header, check, &mut self.counts);
                new.then_some(Frame { stream: header.stream, sequence: header.sequence, body })
            }
            Err(refusal) => {
                let count = match refusal {
                    Refusal::Bad => &mut self.counts.bad,
                    Refusal::Unknown => &mut self.counts.unknown,
                };
                *count = count.saturating_add(1);
                None
            }
        }
    }
}

/// Checks and reads a content with its checksum, and returns that too.
fn read(content: &[u8]) -> Result<(Header, u32, Body<'_>), Refusal> {
    let (content, sum) = content.split_last_chunk().ok_or(Refusal::Bad)?;
    let check = u32::from_le_bytes(*sum);
    // The checksum of nothing is zero: four zeros are no frame of another version.
    if content.is_empty() || checksum(content) != check {
        return Err(Refusal::Bad);
    }
    if content.first() != Some(&VERSION) {
        return Err(Refusal::Unknown);
    }
    let (header, rest): (Header, _) = split(content).ok_or(Refusal::Bad)?;
    let body = match header.kind {
        HELLO => Hello::read(rest).map(Body::Hello),
        REPORT => Summary::read(rest).map(Body::Report),
        SAMPLES => Block::read(rest).map(Body::Samples),
        RAW => RawBlock::read(rest).map(Body::Raw),
        _ => return Err(Refusal::Unknown),
    };
    body.map(|body| (header, check, body)).ok_or(Refusal::Bad)
}

impl<const N: usize> fmt::Debug for Decoder<N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Decoder").field("used", &self.used).field("counts", &self.counts).finish_non_exhaustive()
    }
}

#[cfg(feature = "defmt")]
impl<const N: usize> defmt::Format for Decoder<N> {
    fn format(&self, formatter: defmt::Formatter<'_>) {
        self.counts.format(formatter);
    }
}
