//! Arrays of a file → columns of one length.

use std::path::Path;

use model::Error;

/// Names and columns of arrays: the longest ones, and those of one number, which are constant.
pub(super) fn of_one_length(
    path: &Path,
    arrays: Vec<(String, Vec<f64>)>,
) -> Result<(Vec<String>, Vec<Vec<f64>>), Error> {
    let Some(rows) = arrays.iter().map(|(_, column)| column.len()).max().filter(|rows| *rows > 0) else {
        return Err(Error::content(path, "content", "no arrays of numbers"));
    };
    let each = |(name, column): (String, Vec<f64>)| match column[..] {
        [one] => Some((name, vec![one; rows])),
        _ => (column.len() == rows).then_some((name, column)),
    };
    Ok(arrays.into_iter().filter_map(each).unzip())
}
