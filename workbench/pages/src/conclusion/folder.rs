//! What a folder has, and what to do with it next.

use crate::page::counted;

/// The sentences, from the numbers of traces, models and saved pages.
#[must_use]
pub fn words(traces: usize, models: usize, pages: usize) -> String {
    let found = match (traces, models) {
        (0, 0) => "No recording and no model is in this folder.".to_owned(),
        (0, _) => format!("No recording is in this folder, and {}.", counted(models, "model")),
        (_, 0) => format!("{} and no model: nothing here is judged yet.", counted(traces, "recording")),
        _ => format!("{} and {}.", counted(traces, "recording"), counted(models, "model")),
    };
    let next = match (traces, models) {
        (0, _) => "Record the drive, or name the folder of its recordings.",
        (_, 0) => "Train one with bearing-watch train, or look at the recordings.",
        _ => "Replay recordings through a model: its page begins with what was found, since when, and what to do.",
    };
    let saved = match pages {
        0 => String::new(),
        1 => " 1 page was saved by an earlier command.".to_owned(),
        _ => format!(" {pages} pages were saved by earlier commands."),
    };
    format!("{found} {next}{saved}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_says_what_to_do_next() {
        assert!(words(0, 0, 0).starts_with("No recording and no model"));
        assert!(words(3, 0, 0).contains("nothing here is judged yet. Train one"));
        assert_eq!(
            words(1, 2, 1),
            "1 recording and 2 models. Replay recordings through a model: its page begins with what was found, since \
             when, and what to do. 1 page was saved by an earlier command."
        );
        assert!(words(1, 2, 3).ends_with("3 pages were saved by earlier commands."));
    }
}
