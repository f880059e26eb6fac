//! Frames of the telemetry over CAN or CAN FD: cut into data frames, and joined again.
//!
//! ```text
//! data frame   number u8, then up to 7 bytes of the stream of frames, or up to 63 with CAN FD
//! ```
//!
//! The number counts data frames and wraps, so that the receiver finds lost and doubled ones. Each frame of the
//! telemetry begins with a data frame, and zero bytes behind its end fill the last one up to a length that CAN FD has:
//! between frames they mean nothing. Nothing is acknowledged: a lost data frame makes the frame bad that it is a part
//! of, which is counted. The pieces come in the order in which they were sent, as those of one identifier do on CAN.
//!
//! Load: a data frame of classic CAN with 11 bits of identifier has at most 135 bits, for 7 bytes of the stream; one of
//! CAN FD at most some 680 bits at the data rate and 33 at that of the arbitration, for 63.

/// Data bytes of a frame of CAN FD at most.
const MOST: usize = 64;
/// Lengths above 8 that a data frame of CAN FD can have.
const LENGTHS: [usize; 7] = [12, 16, 20, 24, 32, 48, 64];

/// Cuts frames of an [`Encoder`](super::Encoder) into data frames.
///
/// ```
/// use bearing_watch::telemetry::{CanJoin, CanPieces};
///
/// let mut pieces = CanPieces::fd();
/// let mut join = CanJoin::new();
/// let frame = [7_u8; 100]; // of an encoder
/// let mut stream = vec![];
/// for piece in pieces.cut(&frame) {
///     // can.send(id, piece.data())
///     let (gap, bytes) = join.take(piece.data()).ok_or("doubled")?;
///     assert!(!gap);
///     stream.extend_from_slice(bytes); // for a Decoder
/// }
/// assert_eq!(stream[..100], frame);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanPieces {
    number: u8,
    most: usize,
}

/// The data of one data frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanPiece {
    bytes: [u8; MOST],
    length: usize,
}

impl CanPiece {
    /// The bytes to send: up to 8, or one of the lengths of CAN FD.
    #[must_use]
    pub fn data(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or(&[])
    }
}

impl CanPieces {
    /// Data frames of up to 8 bytes.
    #[must_use]
    pub const fn classic() -> Self {
        Self { number: 0, most: 8 }
    }

    /// Data frames of up to 64 bytes.
    #[must_use]
    pub const fn fd() -> Self {
        Self { number: 0, most: MOST }
    }

    /// Goes on behind the data frame with the number before this one.
    #[must_use]
    pub const fn with_number(self, number: u8) -> Self {
        Self { number, ..self }
    }

    /// The number of the next data frame.
    #[must_use]
    pub const fn number(&self) -> u8 {
        self.number
    }

    /// The data frames of a frame. Those that are not taken from the iterator are not numbered.
    pub fn cut<'a>(&'a mut self, frame: &'a [u8]) -> impl Iterator<Item = CanPiece> + 'a {
        frame.chunks(self.most.saturating_sub(1).max(1)).map(|part| {
            let used = part.len().saturating_add(1);
            let longer = LENGTHS.into_iter().find(|length| *length >= used);
            let length = if used <= 8 { used } else { longer.unwrap_or(MOST) };
            let mut bytes = [0; MOST];
            let cells = core::iter::once(&self.number).chain(part);
            bytes.iter_mut().zip(cells).for_each(|(cell, byte)| *cell = *byte);
            self.number = self.number.wrapping_add(1);
            CanPiece { bytes, length }
        })
    }
}

/// Joins data frames of [`CanPieces`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub struct CanJoin {
    last: Option<CanPiece>,
    lost: u32,
    repeated: u32,
}

impl CanJoin {
    /// Nothing received yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Data frames that are missing by their numbers, at least: of 256 in a row none is missed. A drive that starts
    /// again counts from 0 again.
    #[must_use]
    pub const fn lost(&self) -> u32 {
        self.lost
    }

    /// Data frames that came twice.
    #[must_use]
    pub const fn repeated(&self) -> u32 {
        self.repeated
    }

    /// Takes the data of a data frame; returns its bytes of the stream, and whether some before it are missing: give a
    /// [`Decoder`](super::Decoder) a zero byte first, which ends the frame that is cut. `None` of a data frame that
    /// came twice or is no piece.
    pub fn take<'d>(&mut self, data: &'d [u8]) -> Option<(bool, &'d [u8])> {
        let (number, bytes) = data.split_first().filter(|(_, bytes)| !bytes.is_empty())?;
        let mut piece = CanPiece { bytes: [0; MOST], length: data.len() };
        piece.bytes.get_mut(..data.len())?.iter_mut().zip(data).for_each(|(cell, byte)| *cell = *byte);
        let last = self.last.replace(piece);
        if last == Some(piece) {
            self.repeated = self.repeated.saturating_add(1);
            return None;
        }
        let before = last.and_then(|last| last.data().first().copied());
        let missing = before.map_or(0, |before| number.wrapping_sub(before).wrapping_sub(1));
        self.lost = self.lost.saturating_add(missing.into());
        Some((missing > 0, bytes))
    }
}

#[cfg(test)]
mod tests {
    use std::vec;
    use std::vec::Vec;

    use super::*;

    /// Frames of an encoder, by their look: no zero byte but the last.
    fn frame(length: usize) -> Vec<u8> {
        (1..length).map(|k| (k % 255 + 1) as u8).chain([0]).collect()
    }

    #[test]
    fn pieces_have_lengths_of_the_bus_and_give_the_frame_again() {
        for (mut pieces, lengths) in [
            (CanPieces::classic(), (2..=8).collect::<Vec<_>>()),
            (CanPieces::fd(), [(2..=8).collect::<Vec<_>>(), LENGTHS.to_vec()].concat()),
        ] {
            let (mut join, mut stream, mut sent) = (CanJoin::new(), vec![], vec![]);
            for length in 1..300 {
                let frame = frame(length);
                sent.push(frame.clone());
                for piece in pieces.cut(&frame) {
                    assert!(lengths.contains(&piece.data().len()), "{}", piece.data().len());
                    let (gap, bytes) = join.take(piece.data()).expect("new");
                    assert!(!gap);
                    stream.extend_from_slice(bytes);
                }
            }
            let received: Vec<&[u8]> = stream.split(|byte| *byte == 0).filter(|frame| !frame.is_empty()).collect();
            let sent: Vec<&[u8]> =
                sent.iter().map(|frame| &frame[..frame.len() - 1]).filter(|f| !f.is_empty()).collect();
            assert_eq!(received, sent);
            assert_eq!((join.lost(), join.repeated()), (0, 0));
        }
    }

    #[test]
    fn pieces_that_are_not_taken_are_not_numbered() {
        let mut pieces = CanPieces::classic();
        assert_eq!(pieces.cut(&frame(40)).take(2).count(), 2);
        assert_eq!(pieces.number(), 2);
        let first = pieces.cut(&frame(9)).next().map(|piece| piece.data()[0]);
        assert_eq!((first, pieces.number()), (Some(2), 3));
    }

    #[test]
    fn lost_and_doubled_pieces_are_counted() {
        let mut pieces = CanPieces::classic().with_number(254);
        let frame = frame(40);
        let data: Vec<CanPiece> = pieces.cut(&frame).collect();
        assert_eq!((data.len(), pieces.number()), (6, 4));
        let mut join = CanJoin::new();
        let mut gaps = |indices: &[usize]| -> Vec<Option<bool>> {
            indices.iter().map(|index| join.take(data[*index].data()).map(|(gap, _)| gap)).collect()
        };
        assert_eq!(gaps(&[0, 1, 1, 2, 5]), [Some(false), Some(false), None, Some(false), Some(true)]);
        assert_eq!((join.lost(), join.repeated()), (2, 1));
        for wrong in [&[] as &[u8], &[1], &[1; 65]] {
            assert_eq!(join.take(wrong), None);
        }
    }

    #[test]
    fn pieces_that_are_lost_where_the_number_wraps_are_counted() {
        let mut join = CanJoin::new();
        let gaps = [254, 1, 2].map(|number| join.take(&[number, 7]).map(|(gap, _)| gap));
        assert_eq!((gaps, join.lost()), ([Some(false), Some(true), Some(false)], 2));
    }
}
