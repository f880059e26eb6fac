//! Data frames of any driver that has the traits of embedded-can.

use embedded_can::{Frame, Id};

use super::{CanJoin, CanPiece, SegmentFrame};

impl SegmentFrame {
    /// The data frame of a driver, under an identifier of the program's choice: one for each drive of the bus. `None`
    /// if the driver refuses 8 bytes.
    pub fn to_frame<F: Frame>(self, id: impl Into<Id>) -> Option<F> {
        F::new(id, &self.to_bytes())
    }

    /// From a data frame of a driver; `None` if it is none of a segment, as for [`Self::from_bytes`].
    pub fn from_frame<F: Frame>(frame: &F) -> Option<Self> {
        let bytes = frame.data().try_into().ok().filter(|_| frame.is_data_frame())?;
        Self::from_bytes(bytes)
    }
}

impl CanPiece {
    /// The data frame of a driver, under an identifier; `None` if the driver refuses that many bytes, as one of classic
    /// CAN does for pieces of [`CanPieces::fd`](super::CanPieces::fd).
    pub fn to_frame<F: Frame>(&self, id: impl Into<Id>) -> Option<F> {
        F::new(id, self.data())
    }
}

impl CanJoin {
    /// Takes a data frame of a driver, as [`Self::take`] its data.
    pub fn take_frame<'f, F: Frame>(&mut self, frame: &'f F) -> Option<(bool, &'f [u8])> {
        frame.is_data_frame().then(|| self.take(frame.data()))?
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use embedded_can::{ExtendedId, StandardId};

    use super::*;
    use crate::telemetry::CanPieces;

    /// The frame of a driver of classic CAN.
    #[derive(Debug, PartialEq, Eq)]
    struct Classic {
        id: Id,
        remote: bool,
        data: Vec<u8>,
    }

    impl Frame for Classic {
        fn new(id: impl Into<Id>, data: &[u8]) -> Option<Self> {
            (data.len() <= 8).then(|| Self { id: id.into(), remote: false, data: data.to_vec() })
        }

        fn new_remote(id: impl Into<Id>, dlc: usize) -> Option<Self> {
            Some(Self { id: id.into(), remote: true, data: vec![0; dlc] })
        }

        fn is_extended(&self) -> bool {
            matches!(self.id, Id::Extended(_))
        }

        fn is_remote_frame(&self) -> bool {
            self.remote
        }

        fn id(&self) -> Id {
            self.id
        }

        fn dlc(&self) -> usize {
            self.data.len()
        }

        fn data(&self) -> &[u8] {
            &self.data
        }
    }

    #[test]
    fn a_segment_goes_through_a_driver_and_other_frames_are_none() {
        let segment = SegmentFrame::from_bytes([9, 4, 0, 0, 0, 0, 50, 12]).expect("a segment");
        for id in [Id::from(StandardId::MAX), ExtendedId::ZERO.into()] {
            let frame: Classic = segment.to_frame(id).expect("8 bytes");
            assert_eq!((frame.id(), SegmentFrame::from_frame(&frame)), (id, Some(segment)));
        }
        for frame in [Classic::new_remote(StandardId::ZERO, 8), Classic::new(StandardId::ZERO, &[9, 4, 0])] {
            assert_eq!(SegmentFrame::from_frame(&frame.expect("a frame")), None);
        }
    }

    #[test]
    fn pieces_go_through_a_driver_that_has_their_length() {
        let sent: Vec<u8> = (1..=40).collect();
        let (mut join, mut received) = (CanJoin::new(), vec![]);
        for piece in CanPieces::classic().cut(&sent) {
            let frame: Classic = piece.to_frame(StandardId::ZERO).expect("at most 8 bytes");
            received.extend_from_slice(join.take_frame(&frame).expect("new").1);
        }
        assert_eq!(received, sent);
        let remote = Classic::new_remote(StandardId::ZERO, 8).expect("a frame");
        assert_eq!((join.take_frame(&remote), join.lost()), (None, 0));
        let long: Vec<Option<Classic>> =
            CanPieces::fd().cut(&sent).map(|piece| piece.to_frame(StandardId::ZERO)).collect();
        assert_eq!(long, [None]);
    }
}
