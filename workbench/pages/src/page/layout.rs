//! Builds one self-contained page from titled sections of HTML.

use std::fmt::Write as _;

use super::escape::escape;
use crate::ReportError;

/// The style sheet, in a separate file so that editors recognise its format.
const STYLE: &str = include_str!("style.css");

/// Draws the figures.
const DRAW: &str = include_str!("plots.js");

/// The script of plotly with the figures over two axes, unchanged; `LICENSE-plotly.txt` beside it has its version and
/// licence.
const PLOTLY: &str = include_str!("plotly-cartesian.min.js");

/// Nothing is loaded from outside the page.
pub const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
                          img-src data: blob:; base-uri 'none'";

/// Smallest number of sections for which the page begins with links to them.
const LINKS_FROM: usize = 4;

/// A page under construction.
///
/// ```
/// use bearing_watch_pages::page::{Page, paragraph};
/// let html = Page::new("Run 12").section("Result", &paragraph("Nothing found.")).render();
/// assert!(html.starts_with("<!DOCTYPE html>"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Page {
    title: String,
    conclusion: String,
    lead: String,
    sections: Vec<(String, String)>,
    live: Option<&'static str>,
}

impl Page {
    /// An empty page.
    #[must_use]
    pub fn new(title: impl Into<String>) -> Self {
        Self { title: title.into(), conclusion: String::new(), lead: String::new(), sections: Vec::new(), live: None }
    }

    /// The sentences with which the page begins: what was found, where, since when, how sure, and what to do next.
    #[must_use]
    pub fn conclusion(mut self, text: impl Into<String>) -> Self {
        self.conclusion = text.into();
        self
    }

    /// A sentence below them: what was tested, when, with which data.
    #[must_use]
    pub fn lead(mut self, text: impl Into<String>) -> Self {
        self.lead = text.into();
        self
    }

    /// Adds a section. The heading is plain text; the body is HTML from the functions of this module.
    #[must_use]
    pub fn section(mut self, heading: impl Into<String>, html: &str) -> Self {
        self.sections.push((heading.into(), html.to_owned()));
        self
    }

    /// Runs a script after the figures are drawn, which may ask the server of the page for news.
    #[must_use]
    pub fn live(self, script: &'static str) -> Self {
        Self { live: Some(script), ..self }
    }

    /// The page as one HTML document.
    #[must_use]
    pub fn render(&self) -> String {
        let title = escape(&self.title);
        let own = if self.live.is_some() { "; connect-src 'self'" } else { "" };
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}{own}\">\n\
             <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<header><h1>{title}</h1>"
        );
        if !self.conclusion.is_empty() {
            let _ = write!(out, "<div class=\"conclusion\">{}</div>", paragraph(&self.conclusion));
        }
        if !self.lead.is_empty() {
            out.push_str(&paragraph(&self.lead));
        }
        out.push_str("</header>\n");
        if self.sections.len() >= LINKS_FROM {
            out.push_str("<nav><ul>");
            for (number, (heading, _)) in self.sections.iter().enumerate() {
                let _ = write!(out, "<li><a href=\"#s{number}\">{}</a></li>", escape(heading));
            }
            out.push_str("</ul></nav>\n");
        }
        for (number, (heading, html)) in self.sections.iter().enumerate() {
            let _ = writeln!(out, "<section id=\"s{number}\"><h2>{}</h2>{html}</section>", escape(heading));
        }
        out.push_str("</main>\n");
        if self.sections.iter().any(|(_, html)| html.contains("class=\"plot\"")) {
            let _ = write!(out, "<script type=\"text/javascript\">{PLOTLY}</script>");
            for script in [Some(DRAW), self.live].into_iter().flatten() {
                let _ = write!(out, "\n<script>{script}</script>");
            }
        }
        out.push_str("\n</body>\n</html>\n");
        out
    }
}

/// Running text; a blank line starts a new paragraph.
#[must_use]
pub fn paragraph(text: &str) -> String {
    text.split("\n\n").filter(|part| !part.trim().is_empty()).map(|part| format!("<p>{}</p>", escape(part))).collect()
}

/// A number of things: `1 trace`, `2 traces`.
#[must_use]
pub fn counted(count: usize, name: &str) -> String {
    format!("{count} {name}{}", if count == 1 { "" } else { "s" })
}

/// Figures that share their horizontal axis: they zoom together, and one cursor crosses them.
#[must_use]
pub fn linked(figures: &str) -> String {
    format!("<div class=\"linked\">{figures}</div>")
}

/// The plot or table, or the reason why it is missing, so that one empty plot does not make the whole report fail.
#[must_use]
pub fn or_reason(html: Result<String, ReportError>) -> String {
    html.unwrap_or_else(|error| format!("<p class=\"note\">Not drawn: {}.</p>", escape(&error.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::well_formed::check;

    #[test]
    fn page_is_well_formed_and_self_contained() {
        let mut page = Page::new("a <b> & \"c\"").lead("x < y");
        for i in 0..5 {
            page = page.section(format!("<{i}>"), &paragraph("first\n\nsecond & third"));
        }
        let html = page.render();
        assert_eq!(check(&html), Ok(()));
        assert!(html.contains("<title>a &lt;b&gt; &amp; &quot;c&quot;</title>") && html.contains("x &lt; y"));
        assert_eq!(html.matches("<p>first</p><p>second &amp; third</p>").count(), 5);
        assert!(html.contains("<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "), "{html}");
        assert!(!html.contains("://") && !html.contains("<script") && !html.contains("url("));
    }

    #[test]
    fn a_page_begins_with_its_conclusion_and_fits_a_phone() {
        let html = Page::new("t").conclusion("Nothing < found.").lead("5 traces.").render();
        let at = |text: &str| html.find(text).expect("on the page");
        assert!(at("<p>Nothing &lt; found.</p>") < at("<p>5 traces.</p>"));
        assert!(html.contains("name=\"viewport\" content=\"width=device-width") && html.contains(":focus-visible"));
        let table = crate::page::table::table(&["a"], &[vec!["b"]]);
        assert!(table.starts_with("<div class=\"scroll\" tabindex=\"0\"><table>"), "{table}");
    }

    #[test]
    fn a_page_with_a_figure_has_one_script_of_plotly_and_stays_small() {
        let html = Page::new("t").section("s", "<div class=\"plot\"></div><div class=\"plot\"></div>").render();
        assert_eq!(html.matches("* plotly.js (").count(), 1);
        assert!(html.len() < 1_400_000, "{} bytes", html.len());
    }

    #[test]
    fn the_licence_of_the_script_is_that_of_its_version() {
        let version = PLOTLY.split(" - minified) v").nth(1).and_then(|rest| rest.split_whitespace().next());
        let version = version.expect("the script names its version");
        assert!(include_str!("LICENSE-plotly.txt").contains(&format!("plotly.js {version},")), "{version}");
    }

    #[test]
    fn empty_page_is_valid() {
        assert_eq!(check(&Page::new("").render()), Ok(()));
    }

    #[test]
    fn a_missing_plot_says_why() {
        let html = or_reason(Err(ReportError::Empty { title: "<t>".into() }));
        assert_eq!(html, "<p class=\"note\">Not drawn: “&lt;t&gt;” has no finite data to draw.</p>");
    }
}
