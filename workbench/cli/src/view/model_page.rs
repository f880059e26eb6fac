//! The page of a model.

use std::path::Path;

use model::Error;
use model::session::ModelFile;
use pages::Page;
use pages::escape::escape;
use pages::page::paragraph;
use pages::table::table;

pub(super) fn page(file: &Path) -> Result<Page, Error> {
    let ModelFile { model, notes } = ModelFile::read(file)?;
    let sampling = model.sampling();
    let limit = |value: f32| if value.is_finite() { format!("{value:.2} nats") } else { "none".into() };
    let healthy = model.healthy().and_then(|class| model.classes.get(class)).cloned();
    let gate = model.model().constants().classifier.novelty.limit;
    let rows = [
        ("classes", model.classes.join(", ")),
        ("healthy class", healthy.clone().unwrap_or_else(|| "none".into())),
        ("channels", model.channel_names().join(", ")),
        ("estimates", model.estimates(&notes.orders)),
        ("features", notes.features.join(", ")),
        ("sampling interval", format!("{} s", sampling.interval_s)),
        ("samples a segment", sampling.segment_samples.to_string()),
        ("limit of the surprise", if healthy.is_some() { limit(gate) } else { "none".into() }),
        ("limit of the evidence", limit(model.evidence_constants().limit)),
        ("trained on", format!("{} traces", notes.trained_on.len())),
    ];
    let rows = rows.map(|(name, value)| vec![name.to_owned(), value]);
    let name = file.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let mut page = Page::new(format!("Model {name}")).section("What it is", &table(&["", ""], &rows));
    let priors: Vec<Vec<String>> =
        model.classes.iter().zip(model.priors()).map(|(class, p)| vec![class.clone(), format!("{p:.4}")]).collect();
    page = page.section("Prior probabilities", &table(&["class", "prior"], &priors));
    if let Some(drive) = notes.drive() {
        page = page.section("Drive file", &format!("<pre>{}</pre>", escape(drive)));
    }
    let trained_on = notes.trained_on.join(", ");
    Ok(page.section("Training traces", &paragraph(&trained_on)))
}
