//! Reports and samples as frames for a serial line, and their decoder.
//!
//! Enters: reports, samples of the detector in blocks of a [`Recorder`], and raw samples at the control rate in those
//! of a [`RawRecorder`]. Leaves: frames of [`Encoder`] in the caller's buffer; a drive without a model sends raw
//! samples by [`RawEncoder`]. At the other end [`Decoder`] takes bytes and returns [`Frame`]s; `bearing-watch listen`
//! shows and stores them. For a line of 8 bytes a frame, such as CAN, there is a [`SegmentFrame`] of each report.
//!
//! ```
//! # mod model { include!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/support/standard_rig/model.rs")); }
//! # use model::{MODEL, Sample};
//! use bearing_watch::telemetry::{Body, Decoder, Encoder, Recorder, Source};
//!
//! let mut encoder = Encoder::new(&MODEL, Source { model_id: 7, session: 1 });
//! let mut recorder: Recorder<_, 240> = Recorder::new(MODEL.plan()); // 20 samples of 12 bytes
//! let mut decoder = Decoder::<512>::new();
//! let mut buffer = [0; 512];
//! let mut line = encoder.hello(&mut buffer)?.to_vec();
//! for k in 0..20 {
//!     let sample = Sample { current_a: k as f32, velocity_ref_rad_s: 0.5, load_torque_nm: 0.0 };
//!     if recorder.push(&sample) {
//!         line.extend_from_slice(encoder.samples(&recorder.block(), &mut buffer)?);
//!         recorder.clear();
//!     }
//! }
//! let mut samples = 0;
//! for byte in line {
//!     match decoder.push(byte).map(|frame| frame.body) {
//!         Some(Body::Hello(hello)) => assert_eq!(hello.channels().next(), Some(("current_a", "A"))),
//!         Some(Body::Samples(block)) => samples += block.len(),
//!         _ => {}
//!     }
//! }
//! assert_eq!((samples, decoder.counts().bad), (20, 0));
//! # Ok::<(), bearing_watch::telemetry::TooSmall>(())
//! ```
//!
//! # Format
//!
//! ```text
//! frame     COBS(content, CRC-32 of the content), 0x00
//! content   version u8 = 3, kind u8, stream u32, sequence u32, fields and lists of the kind
//!
//! kind 0    hello    model_id u32, session u32, interval_s f32, block_mean u16, segment_samples u32,
//!                    channels u8, angle u8 (0 or 1), classes u8, healthy u8 u8, features u8, coordinates u8,
//!                    orders u8; of each feature [kind u8, place u8], of each coordinate the place u8 of its feature,
//!                    of each order f32, of each channel name and unit, of each class its name
//! kind 1    report   segment u32, verdict u8, detail u8, place u8, rows u32 (of the reason),
//!                    distance f32, distance_surprise f32, surprise f32, score f32,
//!                    alarm u8, cause u8, segment u32 (of the alarm), undetermined u32, rows u32,
//!                    rejected u32, saturated u32, resting u32, stuck u16, refused u8,
//!                    classes u8, features u8, orders u8, rising u8, most u8 (255: none), falls u8 (0 or 1);
//!                    posterior f32 of each class, value f32 of each feature, score f32 of each order,
//!                    smallest f32 of each rising coordinate;
//!                    0, or of the alarm by a direction 1 and [direction u8, deviations f32, score f32, since u32];
//!                    directions u8, of each [coordinate u8, deviations f32, score f32, since u32]
//! kind 2    samples  first u32, channels u8, angle u8;
//!                    of each sample f32 of each channel, then the angle's u32 if there is one
//! kind 3    raw      first u32, control_rate_hz f32, resolver u8 (0 or 1), further u8;
//!                    of each sample the counts of phases a, b, c u16, flags u16 (1: no sensor of phase c,
//!                    2: no position), the angle u32 or sine and cosine f32, f32 of each further channel
//! ```
//!
//! Little-endian. The fields are those of postcard 1 with integers of fixed width, so that no length is stored twice.
//! `healthy` is 1 and the place of the class, or a single 0 without one. Texts are UTF-8 and end in a zero byte. A
//! missing feature is NaN, and the place of the feature of a coordinate that is a combination is 255. Kinds of
//! features are those of [`Feature`](crate::model::Feature) in its order in the binary model; verdicts and reasons
//! have the codes of `codes.rs`. Deviations, score and since are those of a
//! [`Contribution`](crate::alarm::Contribution).
//!
//! Any change of this list raises the version; a decoder counts frames of another version as unknown.
//!
//! COBS (Cheshire and Baker 1999) removes every zero byte, so that a zero byte ends a frame and a receiver finds the
//! next frame after any error. The CRC (ISO-HDLC, that of zip) detects each error of up to three bits in a frame of up
//! to 11 kB, each burst of up to 32 bits, and all but 2⁻³² of other errors.
//!
//! *Stream* is the CRC-32 of the hello's fields and lists. A report or block of samples belongs to the hello of the
//! same stream: names of another model, drive or session are never applied to it. Send the hello at the start and again
//! every few seconds, for listeners that join later; raw samples need none. *Sequence* counts the frames of an encoder;
//! a gap is a number of lost frames. A frame that equals one of the last 64 is dropped. A gap of more than 1024,
//! numbers that go back and another stream are accepted at the second frame that continues them, so that no frame is
//! lost by one that is forged. *First* counts samples; a gap between blocks is a number of lost samples.
//!
//! A frame has at most content · 255/254 + 6 bytes; the content is 10 bytes, the fields, and the lists.

mod bus;
mod can;
mod codes;
mod counts;
mod decoder;
mod encoder;
mod filling;
mod hello;
mod pieces;
mod raw;
mod recorder;
mod risen;
mod samples;
mod sink;
mod summary;

pub use can::{CanSignal, SegmentFrame};
pub use counts::LinkStats;
pub use decoder::{Body, Decoder, Frame};
pub use encoder::{Encoder, RawEncoder};
pub use hello::{Hello, Source};
pub use pieces::{CanJoin, CanPiece, CanPieces};
pub use raw::{RawBlock, RawRecorder};
pub use recorder::Recorder;
pub use risen::Contributions;
pub use samples::{Block, Numbers};
pub use sink::TooSmall;
pub use summary::Summary;

use serde::{Deserialize, Serialize};

/// Version of the format.
pub const VERSION: u8 = 3;

/// What each content starts with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Header {
    version: u8,
    kind: u8,
    #[serde(with = "postcard::fixint::le")]
    stream: u32,
    #[serde(with = "postcard::fixint::le")]
    sequence: u32,
}

const HELLO: u8 = 0;
const REPORT: u8 = 1;
const SAMPLES: u8 = 2;
const RAW: u8 = 3;

/// Fields that a content of bytes starts with, and the lists after them; `None` if they are cut short.
fn split<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<(T, &'a [u8])> {
    postcard::take_from_bytes(bytes).ok()
}

#[cfg(test)]
mod tests;
