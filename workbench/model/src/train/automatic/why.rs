//! Why training took its recipe, in words and as JSON.

use serde_json::{Value, json};

use crate::train::Recipe;

/// What a recipe finds of one kind of defect.
#[derive(Clone, Debug)]
pub struct Detected {
    /// The kind of defect.
    pub kind: String,
    /// Sizes, A.
    pub sizes_a: Vec<f64>,
    /// Share of the records with each size that is found.
    pub found: Vec<f64>,
    /// Size that is found in half of the records, A.
    pub half_a: f64,
}

/// A column that is a temperature by its name or unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Temperature {
    /// Its name.
    pub column: String,
    /// Features with the part of their variance in left-out segments that it explains, largest first.
    pub explained: Vec<(String, f64)>,
    /// Why its mean is no covariate; `None` if it is one.
    pub refused: Option<String>,
}

/// A recipe that was compared.
#[derive(Clone, Debug)]
pub struct Rival {
    /// Its features.
    pub features: Vec<String>,
    /// Its covariates.
    pub covariates: Vec<String>,
    /// Rate of held-out healthy segments called novel, or of wrong decisions with classes.
    pub rate: f64,
    /// What it finds of each kind of defect; empty with classes.
    pub detected: Vec<Detected>,
    /// Why it cannot be trained.
    pub refused: Option<String>,
}

impl Rival {
    /// Of a recipe, judged by rate and what is found, refused, or neither.
    pub(super) fn of(recipe: &Recipe, judged: Option<Result<(f64, Vec<Detected>), String>>) -> Self {
        let (rate, detected, refused) = match judged {
            Some(Ok((rate, detected))) => (rate, detected, None),
            Some(Err(reason)) => (f64::NAN, vec![], Some(reason)),
            None => (f64::NAN, vec![], None),
        };
        let (features, covariates) = (recipe.features.clone(), recipe.covariates.clone());
        Self { features, covariates, rate, detected, refused }
    }

    /// The features, and what covariates they are less of.
    #[must_use]
    pub fn words(&self) -> String {
        let features = self.features.join(", ");
        match &self.covariates[..] {
            [] => features,
            covariates => format!("{features} less what {} explains", covariates.join(" and ")),
        }
    }

    /// The mean logarithm of the smallest sizes that it finds.
    fn log_size(&self) -> f64 {
        self.detected.iter().map(|one| one.half_a.ln()).sum::<f64>() / self.detected.len().max(1) as f64
    }
}

impl Temperature {
    /// One that is not used.
    pub(crate) fn refused(column: &str, why: String) -> Self {
        Self { column: column.into(), explained: vec![], refused: Some(why) }
    }

    fn words(&self) -> String {
        let Self { column, explained, refused } = self;
        if let Some(why) = refused {
            return format!("temperature {column} is not used: {why}");
        }
        let parts: Vec<String> =
            explained.iter().take(3).map(|(name, part)| format!("{:.0} % of {name}", 100.0 * part)).collect();
        format!(
            "temperature {column} is used: it explains, of the variance of left-out segments, {}; the firmware must \
             give it with each sample, in the unit of the recordings",
            parts.join(", ")
        )
    }

    fn to_json(&self) -> Value {
        let part = |(feature, part): &(String, f64)| json!({ "feature": feature, "part": part });
        let explained: Vec<Value> = self.explained.iter().map(part).collect();
        json!({
            "column": self.column, "taken": self.refused.is_none(), "explained": explained, "refused": self.refused,
        })
    }
}

/// Why training took its recipe.
#[derive(Clone, Debug)]
pub struct Automatic {
    /// The compared recipes, in the order of preference.
    pub rivals: Vec<Rival>,
    /// The place of the chosen one.
    pub chosen: usize,
    /// Whether every rate is of segments that the fit has not seen.
    pub held_out: bool,
    /// Whether classes of defects decided, not defects that were added.
    pub by_classes: bool,
    /// What the situation excludes, in words.
    pub notes: Vec<String>,
    /// The temperatures among the columns.
    pub temperatures: Vec<Temperature>,
}

impl Automatic {
    /// Why the covariates are left out, if recipes with them are not clearly better.
    pub(crate) fn without_covariates(&self) -> Option<String> {
        let with = self.rivals.iter().any(|own| !own.covariates.is_empty());
        let why = if self.by_classes { "decisions are as good" } else { "defects as small are found" };
        (with && self.winner().covariates.is_empty()).then(|| format!("{why} without it"))
    }

    /// The chosen recipe.
    #[must_use]
    pub fn winner(&self) -> &Rival {
        &self.rivals[self.chosen]
    }

    /// The best recipe beside the chosen one.
    #[must_use]
    pub fn next(&self) -> Option<&Rival> {
        let others = self.rivals.iter().enumerate().filter(|(k, own)| *k != self.chosen && own.refused.is_none());
        let worse = |own: &Rival| if self.by_classes { own.rate } else { own.log_size() };
        others.map(|(_, own)| own).min_by(|a, b| worse(a).total_cmp(&worse(b)))
    }

    /// Three lines: what was chosen, what it finds, and what was not chosen.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let own = self.winner();
        let seen = if self.held_out { "cross-validated" } else { "on the segments of training itself" };
        let mut lines = vec![match self.rivals.len() {
            1 => "features chosen by the program: the only set that the signals allow".to_string(),
            count => format!("features chosen by the program among {count} sets"),
        }];
        if self.by_classes {
            lines.push(format!("wrong decisions: {:.1} %, {seen}", 100.0 * own.rate));
        } else if !own.detected.is_empty() {
            let sizes: Vec<String> = own.detected.iter().map(Detected::words).collect();
            let rate = 100.0 * own.rate;
            lines.push(format!(
                "defects added to healthy traces are found in half of them from this size on ({seen}; {rate:.1} % of \
                 healthy segments are novel): {}",
                sizes.join("; ")
            ));
        }
        lines.extend(self.next().map(|other| {
            let names = other.words();
            if self.by_classes {
                return format!("next best: {names}, {:.1} % wrong", 100.0 * other.rate);
            }
            let sizes: Vec<String> = other.detected.iter().map(|one| format!("{:.2e} A", one.half_a)).collect();
            format!("next best: {names} ({})", sizes.join("; "))
        }));
        lines.extend(self.notes.iter().cloned());
        lines.extend(self.temperatures.iter().map(Temperature::words));
        lines.extend(self.smaller());
        lines
    }

    /// How much smaller the defects are that covariates let it find.
    fn smaller(&self) -> Option<String> {
        let own = self.winner();
        let without = self.rivals.iter().filter(|other| other.covariates.is_empty() && other.refused.is_none());
        let best = without.map(Rival::log_size).min_by(f64::total_cmp)?;
        let is_told = !own.covariates.is_empty() && !own.detected.is_empty();
        is_told.then(|| {
            let ratio = (own.log_size() - best).exp();
            format!("the defects found with it are {ratio:.2} times as large as those found without it, in the mean")
        })
    }

    /// As JSON.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let rival = |own: &Rival| {
            let detected: Vec<Value> = own.detected.iter().map(Detected::to_json).collect();
            json!({
                "features": own.features, "covariates": own.covariates, "rate": own.rate, "detected": detected,
                "refused": own.refused,
            })
        };
        json!({
            "chosen": self.chosen,
            "compared": self.rivals.iter().map(rival).collect::<Vec<_>>(),
            "cross_validated": self.held_out,
            "by_classes": self.by_classes,
            "notes": self.notes,
            "temperatures": self.temperatures.iter().map(Temperature::to_json).collect::<Vec<_>>(),
        })
    }
}

impl Detected {
    fn words(&self) -> String {
        let Self { kind, sizes_a, half_a, .. } = self;
        let beyond = sizes_a.last().is_some_and(|last| half_a > last);
        if beyond {
            format!("{kind} not up to {:.2e} A", sizes_a.last().unwrap_or(&0.0))
        } else {
            format!("{kind} {half_a:.2e} A")
        }
    }

    fn to_json(&self) -> Value {
        json!({ "kind": self.kind, "sizes_a": self.sizes_a, "found": self.found, "half_a": self.half_a })
    }
}
