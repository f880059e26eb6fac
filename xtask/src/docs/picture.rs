//! Pictures of documents: figures of the workbench's pages, drawn by Chromium and saved as SVG.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, setup, workspace};

/// Draws a figure of the page on white, with ids that are the same each time, and shows its text.
const SAVE: &str = "<script>
reportPlots.ready.then(async () => {
  const named = (figure) => figure.querySelector('figcaption').textContent === TITLE;
  const plot = [...document.querySelectorAll('figure')].find(named).querySelector('.plot');
  await Plotly.relayout(plot, { paper_bgcolor: '#fff' });
  const svg = await Plotly.toImage(plot, { format: 'svg', width: 800, height: plot.offsetHeight, imageDataOnly: true });
  const shown = document.createElement('pre');
  shown.id = 'picture';
  shown.textContent = svg.replaceAll(/clip([0-9a-f]{6})/.exec(svg)[1], 'figure');
  document.body.replaceChildren(shown);
});
</script>";

/// Saves the figure of this title of a page.
pub fn save(page: &Path, title: &str, picture: &str) -> Result<()> {
    let browser = setup::ensure_chromium()?;
    let html = fs::read_to_string(page).with_context(|| format!("cannot read {}", page.display()))?;
    let figure = html.split("<figure>").find(|own| own.contains(&format!("<figcaption>{title}</figcaption>")));
    ensure!(figure.is_some(), "{} has no figure “{title}”", page.display());
    let script = SAVE.replace("TITLE", &format!("{title:?}"));
    let copy = page.with_extension("picture.html");
    fs::write(&copy, html.replace("</body>", &format!("{script}</body>")))?;
    let mut command = Command::new(browser);
    // Its own sandbox does not work for root; the page is ours.
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]);
    let drawn = child::output(command.arg(format!("file://{}", copy.display())));
    let drawn = drawn.context("Chromium drew nothing")?;
    let shown = drawn.split("<pre id=\"picture\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let svg = shown.context("Chromium drew no picture")?;
    let svg = svg.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    fs::write(workspace::root().join(picture), svg + "\n").with_context(|| format!("cannot write {picture}"))
}
