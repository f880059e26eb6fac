//! Calls of the frames of CAN by the traits of a driver, for the example `panic_free`.

use core::hint::black_box as opaque;

use bearing_watch::telemetry::{CanJoin, CanPiece, CanPieces, SegmentFrame};
use embedded_can::{Frame, Id, StandardId};

/// The frame of a driver of classic CAN.
struct Classic {
    id: Id,
    data: [u8; 8],
    length: usize,
}

impl Frame for Classic {
    fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
        let mut frame = Self { id: id.into(), data: [0; 8], length: data.len() };
        frame.data.get_mut(..data.len())?.iter_mut().zip(data).for_each(|(cell, byte)| *cell = *byte);
        Some(frame)
    }

    fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
        Some(Self { id: id.into(), data: [0; 8], length: dlc })
    }

    fn is_extended(&self) -> bool {
        matches!(self.id, Id::Extended(_))
    }

    fn is_remote_frame(&self) -> bool {
        false
    }

    fn id(&self) -> Id {
        self.id
    }

    fn dlc(&self) -> usize {
        self.length
    }

    fn data(&self) -> &[u8] {
        self.data.get(..self.length).unwrap_or(&[])
    }
}

/// A report and pieces of a frame, by a driver.
pub fn by_driver(sent: SegmentFrame) {
    let id = opaque(StandardId::ZERO);
    if let Some(frame) = SegmentFrame::to_frame::<Classic>(sent, id) {
        opaque(SegmentFrame::from_frame(&opaque(frame)));
    }
    let (mut pieces, mut join) = (CanPieces::classic(), CanJoin::new());
    for piece in CanPieces::cut(&mut pieces, &opaque([7_u8; 100])) {
        if let Some(frame) = CanPiece::to_frame::<Classic>(&piece, id) {
            opaque(CanJoin::take_frame(&mut join, &opaque(frame)));
        }
    }
}
