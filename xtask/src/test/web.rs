//! The page for a browser: it is built, its program gives the bytes of the native one, and the whole way goes by clicks
//! in Chromium.

use std::process::Command;

use anyhow::{Context, Result};

use crate::report::Tally;
use crate::web::{self, Built, compare};
use crate::{cargo, child, python, workspace};

/// The client of ChromeDriver.
const CLIENT: &str = "selenium==4.51.0";

pub fn checks(tally: &mut Tally) {
    if child::on_path("node") {
        let mut tests = Command::new("node");
        tests.arg("--test").arg(web::sources().join("tests")).current_dir(workspace::root());
        tally.check("texts and archives of the page", child::succeed(&mut tests).map(|()| ""));
    } else {
        tally.missing("texts and archives of the page", "no Node.js on the search path");
    }
    let built = match web::page(None) {
        Ok(built) => built,
        Err(error) => return tally.check("the page is built", Err::<&str, _>(error)),
    };
    let size = std::fs::metadata(&built.page).map(|about| format!("{} bytes", about.len()));
    tally.check("the page is built", size.context("no page"));
    compare::checks(tally, &built.program);
    let title = "from a folder to a model by clicks in Chromium";
    match hindrance() {
        Some(hindrance) => tally.missing(title, hindrance),
        None => tally.check(title, by_clicks(&built)),
    }
}

fn hindrance() -> Option<&'static str> {
    if chromium().is_none() {
        return Some("no Chromium on the search path");
    }
    (!child::on_path("chromedriver")).then_some("no chromedriver on the search path")
}

fn chromium() -> Option<std::path::PathBuf> {
    ["chromium", "chromium-browser", "google-chrome"].into_iter().find_map(child::find)
}

/// Drives the page; what it prints last is its note.
fn by_clicks(built: &Built) -> Result<String> {
    let mut script = Command::new(python::with_packages("of-browser", &[CLIENT])?);
    script.arg(workspace::root().join("xtask/web.py")).arg(&built.page).arg(cargo::workbench()?.get_program());
    script.arg(chromium().context("no Chromium")?).arg(child::find("chromedriver").context("no chromedriver")?);
    script.arg(workspace::target_dir().join("web/pictures"));
    let lines = child::printed(&mut script)?;
    Ok(lines.join("; "))
}
