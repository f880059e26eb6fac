//! Settings as the text of a drive file.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use super::fields::sections;
use super::uses::Use;
use super::whole::Settings;
use crate::Error;

impl Settings {
    /// The text of a drive file at this path: each table of which the job takes something, with what it is for.
    ///
    /// # Errors
    /// A number that TOML does not have.
    pub fn text(&self, path: &Path, job: &Use) -> Result<String, Error> {
        let mut own = self.clone();
        let data = &mut own.data;
        let files = data.traces.iter_mut().chain(&mut data.labels).chain(&mut data.front_end);
        files.for_each(|file| *file = from_here(path, file));
        let all = toml::Table::try_from(own).map_err(|problem| Error::content(path, "content", problem.to_string()))?;
        let mut text = String::new();
        for section in sections() {
            let values = all.get(section.name).and_then(toml::Value::as_table);
            let keys = section.keys.iter().filter(|key| job.takes(key));
            let given = keys.filter_map(|key| Some((key, values?.get(*key)?)));
            let lines: String = given.map(|(key, value)| format!("{key} = {value}\n")).collect();
            if !lines.is_empty() {
                let gap = if text.is_empty() { "" } else { "\n" };
                let _never_fails = write!(text, "{gap}# {}\n[{}]\n{lines}", section.about, section.name);
            }
        }
        Ok(text)
    }
}

/// A file as it is from the folder of the drive file.
#[must_use]
pub fn from_here(path: &Path, file: &Path) -> PathBuf {
    let whole = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let (own, file) = (whole(path), whole(file));
    let folder = own.parent().unwrap_or(Path::new("/"));
    match file.strip_prefix(folder) {
        Ok(inside) if inside.as_os_str().is_empty() => PathBuf::from("."),
        Ok(inside) => inside.to_path_buf(),
        Err(_) => file,
    }
}

/// A text in quotes, as a drive file has it.
#[must_use]
pub fn literal(text: &str) -> String {
    toml::Value::String(text.to_string()).to_string()
}
