//! Pictures of documents: figures of the workbench's pages, drawn by Chromium and saved as SVG.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::{child, setup, workspace};

/// Draws a figure of the page on white, leaves out what is not seen, gives ids that are the same each time, and shows
/// its text. The font is named once, and no clip path is kept that nothing uses: plotly writes one for each pair of
/// axes.
const SAVE: &str = r#"<script>
const small = (text) => {
  const svg = new DOMParser().parseFromString(text, 'image/svg+xml').documentElement;
  svg.querySelectorAll('clipPath').forEach((own) => { if (!text.includes(`url(#${own.id})`)) own.remove(); });
  svg.querySelectorAll('rect').forEach((own) => {
    if (!own.closest('clipPath') && /fill-opacity: 0;/.test(own.getAttribute('style')) &&
        /stroke-width: 0|stroke-opacity: 0/.test(own.getAttribute('style'))) own.remove();
  });
  for (let empty = true; empty;) {
    const groups = [...svg.querySelectorAll('g, defs')].filter((own) => !own.childNodes.length);
    groups.forEach((own) => own.remove());
    empty = groups.length > 0;
  }
  const font = getComputedStyle(document.documentElement).fontFamily;
  svg.setAttribute('font-family', font.replaceAll('"', "'"));
  svg.querySelectorAll('[style]').forEach((own) => {
    const plain = /^(font-family|white-space|vector-effect|pointer-events|opacity: 1$|.*-opacity: 1$|stroke-miterlimit)/;
    const kept = own.getAttribute('style').split(';').map((part) => part.trim())
      .filter((part) => part && !plain.test(part));
    if (kept.length) own.setAttribute('style', kept.join(';').replaceAll(': ', ':').replaceAll(', ', ','));
    else own.removeAttribute('style');
  });
  const round = (number) => String(Math.round(10 * number) / 10);
  for (const name of ['d', 'transform', 'x', 'y', 'width', 'height']) {
    svg.querySelectorAll(`[${name}]`).forEach((own) => {
      own.setAttribute(name, own.getAttribute(name).replace(/-?\d+\.\d{2,}/g, round));
    });
  }
  return new XMLSerializer().serializeToString(svg);
};
reportPlots.ready.then(async () => {
  const named = (figure) => figure.querySelector('figcaption').textContent.startsWith(TITLE);
  const plot = [...document.querySelectorAll('figure')].find(named).querySelector('.plot');
  await Plotly.relayout(plot, { paper_bgcolor: '#fff' });
  const svg = await Plotly.toImage(plot, { format: 'svg', width: 800, height: plot.offsetHeight, imageDataOnly: true });
  const shown = document.createElement('pre');
  shown.id = 'picture';
  shown.textContent = small(svg.replaceAll(/clip([0-9a-f]{6})/.exec(svg)[1], 'figure'));
  document.body.replaceChildren(shown);
});
</script>"#;

/// Saves the first figure of a page whose title starts so.
pub fn save(page: &Path, title: &str, picture: &str) -> Result<()> {
    let browser = setup::browser()?;
    let html = fs::read_to_string(page).with_context(|| format!("cannot read {}", page.display()))?;
    let figure = html.split("<figure>").find(|own| own.contains(&format!("<figcaption>{title}")));
    ensure!(figure.is_some(), "{} has no figure “{title}”", page.display());
    let script = SAVE.replace("TITLE", &format!("{title:?}"));
    let copy = page.with_extension("picture.html");
    fs::write(&copy, html.replace("</body>", &format!("{script}</body>")))?;
    let mut command = Command::new(browser);
    // Its own sandbox does not work for root; the page is ours.
    command.args(["--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=20000", "--dump-dom"]);
    // A profile of its own: a browser does not start while another one with its profile ends.
    let profile = workspace::target_dir().join("chromium").join(Path::new(picture).file_stem().unwrap_or_default());
    command.arg(format!("--user-data-dir={}", profile.display()));
    let drawn = child::output(command.arg(format!("file://{}", copy.display())));
    // What a process of the browser still holds is removed next time.
    let _ = fs::remove_dir_all(&profile);
    let drawn = drawn.context("Chromium drew nothing")?;
    let shown = drawn.split("<pre id=\"picture\">").nth(1).and_then(|rest| rest.split("</pre>").next());
    let svg = shown.context("Chromium drew no picture")?;
    let svg = svg.replace("&lt;", "<").replace("&gt;", ">").replace("&nbsp;", "\u{a0}").replace("&amp;", "&");
    let path = workspace::root().join(picture);
    fs::create_dir_all(path.parent().unwrap_or(&path))?;
    fs::write(path, svg + "\n").with_context(|| format!("cannot write {picture}"))
}
