//! Lines of a text in pieces, from memory or from a file.
//!
//! A piece of a file is read when it is needed, into memory that is used again: the system would have to clear memory
//! for all of a large file, page by page.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use memchr::memchr;

/// Bytes of a piece.
pub(super) const PIECE: usize = 1 << 17;
/// Bytes that are read beyond a piece of a file, for the end of its last line.
const BEYOND: usize = 1 << 10;

/// A text.
#[derive(Clone, Copy, Debug)]
pub(in crate::table::text) enum Source<'a> {
    Memory(&'a str),
    /// The bytes of a file from `start` to before `end`.
    File {
        path: &'a Path,
        start: u64,
        end: u64,
    },
}

impl<'a> Source<'a> {
    /// Its length.
    pub(super) fn bytes(&self) -> u64 {
        match self {
            Self::Memory(text) => text.len() as u64,
            Self::File { start, end, .. } => end.saturating_sub(*start),
        }
    }

    /// Number of pieces.
    pub(super) fn pieces(&self) -> usize {
        self.bytes().div_ceil(PIECE as u64) as usize
    }

    /// The lines that start in a piece, with the line feeds that end them; the last line of a text may have none.
    ///
    /// # Errors
    /// A file that cannot be read any more.
    pub(super) fn piece<'b>(&self, piece: usize, buffer: &'b mut Vec<u8>) -> std::io::Result<&'b [u8]>
    where
        'a: 'b,
    {
        // The byte before a piece tells whether a line starts with the piece.
        let own = usize::from(piece > 0);
        let before = piece * PIECE - own;
        match self {
            Self::Memory(text) => Ok(lines(text.as_bytes().get(before..).unwrap_or_default(), own)),
            Self::File { path, start, end } => {
                let mut file = File::open(path)?;
                let first = start + before as u64;
                file.seek(SeekFrom::Start(first))?;
                let mut file = file.take(end.saturating_sub(first));
                buffer.clear();
                let last = own + PIECE - 1;
                let mut wanted = last + BEYOND;
                loop {
                    let read = file.by_ref().take(wanted as u64).read_to_end(buffer)?;
                    let is_ended = |tail| memchr(b'\n', tail).is_some();
                    if read < wanted || buffer.get(last..).is_some_and(is_ended) {
                        return Ok(lines(buffer, own));
                    }
                    wanted = buffer.len();
                }
            }
        }
    }
}

/// The lines that start in a piece of a text, which has `own` bytes before the piece and all of its last line.
fn lines(text: &[u8], own: usize) -> &[u8] {
    let last = own + PIECE - 1;
    let (head, tail) = text.split_at(last.min(text.len()));
    let start = if own == 0 { Some(0) } else { memchr(b'\n', head).map(|feed| feed + 1) };
    let end = head.len() + memchr(b'\n', tail).map_or(tail.len(), |feed| feed + 1);
    start.map_or(&[], |start| &text[start..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each line is in one piece, however long lines are and wherever pieces end.
    #[test]
    fn pieces_are_all_lines_of_memory_and_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.csv");
        let short: String = (0..300_000).map(|k| format!("{k},{}\n", k % 7)).collect();
        let long = "x".repeat(5 * PIECE / 2);
        let even = format!("{}\n", "y".repeat(PIECE - 1)).repeat(3);
        for text in [short.clone(), format!("{short}{long}"), format!("a\n{long}\n{short}"), even, "\n".into()] {
            std::fs::write(&path, format!("head{text}rest")).expect("writable");
            let file = Source::File { path: &path, start: 4, end: 4 + text.len() as u64 };
            for source in [Source::Memory(&text), file] {
                let mut buffer = Vec::new();
                let mut read = |k| source.piece(k, &mut buffer).map(<[u8]>::to_vec).expect("readable");
                let pieces: Vec<Vec<u8>> = (0..source.pieces()).map(&mut read).collect();
                let full: Vec<_> = pieces.iter().filter(|piece| !piece.is_empty()).collect();
                assert!(full.iter().rev().skip(1).all(|piece| piece.ends_with(b"\n")));
                assert_eq!(pieces.concat(), text.as_bytes());
            }
        }
        assert_eq!(Source::Memory("").pieces(), 0);
    }
}
