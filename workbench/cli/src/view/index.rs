//! The index of a folder: links to its files, and a choice of traces to replay through a model.

use std::fmt::Write as _;

use super::files::{Folder, Kind};
use crate::server::encoded;
use model::Error;
use pages::Page;
use pages::conclusion::folder::words;
use pages::escape::escape;
use pages::page::paragraph;

/// Lines of a list of choices.
const LINES: usize = 12;

pub(super) fn page(folder: &Folder) -> Result<Page, Error> {
    let all = folder.list();
    let of = |kind: Kind| all.iter().filter(move |(own, _)| *own == kind).map(|(_, name)| name.as_str());
    let [traces, models, pages] = Kind::ALL.map(|kind| of(kind).count());
    let mut page = Page::new("bearing-watch: recordings and models").conclusion(words(traces, models, pages));
    let (models, traces): (Vec<&str>, Vec<&str>) = (of(Kind::Model).collect(), of(Kind::Trace).collect());
    if !models.is_empty() && !traces.is_empty() {
        page = page.section("Replay traces through a model", &form(&models, &traces));
    }
    for (kind, heading) in Kind::ALL.into_iter().zip(["Traces", "Models", "Saved pages"]) {
        page = page.section(heading, &links(kind, of(kind)));
    }
    Ok(page)
}

fn links<'a>(kind: Kind, names: impl Iterator<Item = &'a str>) -> String {
    let link =
        |name: &str| format!("<li><a href=\"/{}/{}\">{}</a></li>", kind.name(), escape(&encoded(name)), escape(name));
    let items: String = names.map(link).collect();
    if items.is_empty() { paragraph("None.") } else { format!("<ul>{items}</ul>") }
}

fn form(models: &[&str], traces: &[&str]) -> String {
    let options = |names: &[&str]| {
        let mut options = String::new();
        for (k, name) in names.iter().enumerate() {
            let chosen = if k == 0 { " selected=\"selected\"" } else { "" };
            // Writing to a String cannot fail.
            let _ = write!(options, "<option{chosen}>{}</option>", escape(name));
        }
        options
    };
    format!(
        "<form action=\"/replay\" method=\"get\"><p><label>Model <select name=\"model\">{}</select></label></p>\
         <p><label>Traces <select name=\"trace\" multiple=\"multiple\" size=\"{}\">{}</select></label></p>\
         <p><button>Replay</button></p></form>",
        options(models),
        traces.len().clamp(2, LINES),
        options(traces)
    )
}
