//! The nominal life of the bearing in `replay`.

use std::path::Path;

use serde_json::Value;

use crate::command_line::output;
use model::Error;
use model::life::Collective;
use model::session::Notes;
use model::settings::{DriveFile, Settings, WantedLife};
use model::trace::Trace;
use pages::Page;

/// The nominal life of a replay, if the settings or the drive file of the training say something of the bearing.
#[derive(Debug)]
pub(crate) enum Life {
    /// Nothing is said.
    None,
    /// What has to be given.
    Lacks(String),
    /// Turns and loads so far.
    Of(Collective),
}

impl Life {
    /// Before the first trace.
    pub(crate) fn new(settings: &Settings, notes: &Notes) -> Result<Self, Error> {
        // A geometry alone was given for the bearing orders.
        let trained = notes.drive().and_then(|text| DriveFile::of(Path::new("drive.toml"), text.into()).ok());
        let trained = trained.filter(|drive| drive.settings.bearing.is_loaded());
        let given = settings.clone();
        let all = trained.map_or_else(|| given.clone(), |drive| given.clone().over(drive.settings));
        all.bearing.bearing.note().iter().for_each(output::warn);
        Ok(match all.life(&notes.channels)? {
            WantedLife::None => Self::None,
            WantedLife::Lacks(words) => Self::Lacks(words),
            WantedLife::Of(bearing) => Self::Of(Collective::new(bearing)),
        })
    }

    /// Adds a trace as recorded.
    pub(crate) fn take(&mut self, trace: &Trace) {
        if let Self::Of(collective) = self {
            collective.take(trace);
        }
    }

    /// As lines.
    pub(crate) fn lines(&self) -> Vec<String> {
        match self {
            Self::None => vec![],
            Self::Lacks(words) => vec![words.clone()],
            Self::Of(collective) => collective.lines(),
        }
    }

    /// As JSON, null if nothing is said.
    pub(crate) fn to_json(&self) -> Value {
        match self {
            Self::None => Value::Null,
            Self::Lacks(words) => serde_json::json!({ "lacks": words }),
            Self::Of(collective) => collective.to_json(),
        }
    }

    /// The page with a section of it.
    pub(crate) fn on_page(&self, page: Page) -> Page {
        match self {
            Self::None => page,
            Self::Lacks(words) => page.section(SECTION, &pages::page::paragraph(words)),
            Self::Of(collective) => page.section(SECTION, &pages::life::html(collective)),
        }
    }
}

/// Title of the section.
const SECTION: &str = "Nominal life of the bearing";
