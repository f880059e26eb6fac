//! What a client of `view` and the line of `listen` send, without sockets and terminals: for the attacks of this
//! repository, not stable.

use std::path::Path;

use serde_json::Value;

use crate::view;

use crate::drive::listen::{self, receiver::Output};
use model::{Error, visible};

/// The answer of `view` over this folder to these bytes of a client; `None` if they have no whole head.
///
/// # Errors
/// A folder that cannot be read.
pub fn request(folder: &Path, bytes: &[u8]) -> Result<Option<Vec<u8>>, Error> {
    view::answer_of(folder, bytes)
}

/// Does what `listen` does with these bytes: lines and values, a page, and traces in this folder.
///
/// # Errors
/// As the command.
///
/// # Panics
/// If a line or a value would act on a terminal.
pub fn line(folder: &Path, bytes: &[u8]) -> Result<(), Error> {
    listen::taken(bytes, folder, OUTPUT)
}

/// Does what `listen --can-id 0x123` does with these bytes of a log.
///
/// # Errors
/// As the command.
///
/// # Panics
/// If a line or a value would act on a terminal.
pub fn can_log(bytes: &[u8]) -> Result<(), Error> {
    listen::taken_log(bytes, OUTPUT)
}

const OUTPUT: Output = Output { tell: looked_at, alarm: |line| looked_at(line.to_owned(), Value::Null) };

fn looked_at(line: String, value: Value) -> Result<(), Error> {
    let value = value.to_string();
    for shown in [visible::line(&line), visible::json(&value)] {
        assert!(!shown.contains(char::is_control), "{shown:?}");
    }
    Ok(())
}
