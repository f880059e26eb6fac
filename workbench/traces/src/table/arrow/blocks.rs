//! The blocks of an Arrow file or stream, checked before a reader takes them, which reserves the memory that they name.
//!
//! ```text
//! file    "ARROW1" …, blocks, footer, length of the footer i32, "ARROW1"
//! footer  of each block its place, and the lengths of its message and its body
//! stream  of each block its length i32 behind a mark, its message and its body; a length of 0 at the end
//! body    of a packed block each buffer starts with the length i64 of what it holds, −1 if it is not packed
//! ```

use std::fs::File;
use std::io::{Read, Seek, SeekFrom};

use arrow_ipc::reader::read_footer_length;
use arrow_ipc::{Block, RecordBatch, root_as_footer, root_as_message};

use crate::table::limit::Limit;

/// Bytes behind the footer.
const END: u64 = 10;
/// Bytes of a message without its body, at most: it describes some buffers, or all columns.
const LONGEST: u64 = 64 << 20;
/// What a message may start with, before its length.
const CONTINUATION: [u8; 4] = [0xFF; 4];

/// Checks that blocks are within the file and apart from each other, and that packed ones unpack to a bounded size.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn check(file: &mut File) -> Result<(), String> {
    let size = file.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
    let mut end = [0; END as usize];
    read(file, size.checked_sub(END), &mut end)?;
    let length = read_footer_length(end).map_err(|error| error.to_string())?;
    let at = size.checked_sub(END + length as u64).ok_or("its footer is longer than the file")?;
    let mut footer = vec![0; length];
    read(file, Some(at), &mut footer)?;
    let footer = root_as_footer(&footer).map_err(|error| format!("its footer is damaged: {error}"))?;
    let blocks = [footer.dictionaries(), footer.recordBatches()].into_iter().flatten().flat_map(|list| list.iter());
    let (mut packed, mut limit) = (0_u64, Limit::of(size));
    for block in blocks {
        let lengths = [u64::try_from(block.metaDataLength()), u64::try_from(block.bodyLength())];
        let [Ok(message), Ok(body)] = lengths else { return Err("a block has a negative length".into()) };
        packed = packed.saturating_add(message).saturating_add(body);
        let end = u64::try_from(block.offset()).map_or(u64::MAX, |at| at.saturating_add(message).saturating_add(body));
        if end > size || packed > size {
            return Err("its blocks are longer than the file".into());
        }
        limit.claim(unpacked_size(file, block)?)?;
    }
    Ok(())
}

/// Checks the blocks of a stream in the same way.
///
/// # Errors
/// What is wrong, in words.
pub(super) fn check_stream(file: &mut File) -> Result<(), String> {
    let size = file.seek(SeekFrom::End(0)).map_err(|error| error.to_string())?;
    let mut limit = Limit::of(size);
    let mut at = 0_u64;
    while at < size {
        let mut word = [0; 4];
        read(file, Some(at), &mut word)?;
        let start: u64 = if word == CONTINUATION { 8 } else { 4 };
        if start == 8 {
            read(file, Some(at + 4), &mut word)?;
        }
        let length = u64::try_from(i32::from_le_bytes(word)).map_err(|_negative| "a message has a negative length")?;
        if length == 0 {
            break;
        }
        // A file of something else may be large, and its first bytes any number.
        if length > LONGEST.min(size - at) {
            return Err("it has neither the mark of a file nor the messages of a stream".into());
        }
        let mut message = vec![0; length as usize];
        read(file, Some(at + start), &mut message)?;
        let message = root_as_message(&message).map_err(|error| format!("a message is damaged: {error}"))?;
        let body = u64::try_from(message.bodyLength()).map_err(|_negative| "a body has a negative length")?;
        let end = (at + start + length).saturating_add(body);
        if end > size {
            return Err("its messages are longer than the file".into());
        }
        let (place, length) = (at as i64, (start + length) as i32);
        limit.claim(unpacked_size(file, &Block::new(place, length, body as i64))?)?;
        at = end;
    }
    if at == 0 { Err("it has no message".into()) } else { Ok(()) }
}

/// Bytes to which the buffers of a block are unpacked; 0 if they are not packed.
fn unpacked_size(file: &mut File, block: &Block) -> Result<u64, String> {
    let at = u64::try_from(block.offset()).unwrap_or(u64::MAX);
    let mut message = vec![0; usize::try_from(block.metaDataLength()).unwrap_or(0)];
    read(file, Some(at), &mut message)?;
    let start = if message.starts_with(&CONTINUATION) { 8 } else { 4 };
    let message = message.get(start..).ok_or("a block has no message")?;
    let message = root_as_message(message).map_err(|error| format!("a block is damaged: {error}"))?;
    let dictionary = || message.header_as_dictionary_batch().and_then(|own| own.data());
    let batch: Option<RecordBatch<'_>> = message.header_as_record_batch().or_else(dictionary);
    let Some(batch) = batch.filter(|batch| batch.compression().is_some()) else { return Ok(0) };
    let body = at.saturating_add(u64::try_from(block.metaDataLength()).unwrap_or(0));
    let mut sum = 0_u64;
    for buffer in batch.buffers().iter().flat_map(|list| list.iter()).filter(|buffer| buffer.length() > 0) {
        let mut size = [0; 8];
        read(file, u64::try_from(buffer.offset()).ok().map(|offset| body.saturating_add(offset)), &mut size)?;
        sum = sum.saturating_add(u64::try_from(i64::from_le_bytes(size)).unwrap_or(0));
    }
    Ok(sum)
}

fn read(file: &mut File, at: Option<u64>, bytes: &mut [u8]) -> Result<(), String> {
    let at = at.ok_or("it is too short")?;
    file.seek(SeekFrom::Start(at)).and_then(|_| file.read_exact(bytes)).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use std::io::Write as _;

    use super::*;

    fn checked(bytes: &[u8]) -> Result<(), String> {
        let mut file = tempfile::tempfile().expect("a file");
        file.write_all(bytes).expect("writable");
        check(&mut file)
    }

    /// A file of one column.
    fn good() -> Vec<u8> {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("t.arrow");
        crate::table::write(&path, &["a".into()], &[vec![1.0; 100]]).expect("written");
        std::fs::read(&path).expect("read")
    }

    #[test]
    fn lengths_beyond_the_file_are_refused() {
        let good = good();
        assert_eq!(checked(&good), Ok(()));
        let end = good.len() - 10;
        for length in [good.len() as i32, i32::MAX, -1] {
            let mut forged = good.clone();
            forged[end..end + 4].copy_from_slice(&length.to_le_bytes());
            assert!(checked(&forged).is_err(), "{length}");
        }
        // The length of the body, 800 bytes and those of the validity, is in the footer.
        let footer = end - i32::from_le_bytes(*good[end..].first_chunk().expect("a length")) as usize;
        let is_body = |place: &usize| {
            let length = i64::from_le_bytes(*good[*place..].first_chunk().expect("bytes"));
            (800..2000).contains(&length)
        };
        let body = (footer..end - 8).find(is_body);
        let mut forged = good.clone();
        forged[body.expect("the body") + 3] = 1;
        assert_eq!(checked(&forged), Err("its blocks are longer than the file".into()));
        assert!(checked(b"ARROW1").is_err() && checked(&[]).is_err());
    }
}
