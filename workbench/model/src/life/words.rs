//! The nominal life in words and as JSON.

use serde_json::{Value, json};

use super::{CLASSES, Collective, NominalLife};

/// A caution is not worth a line if it concerns a smaller part of the turns.
const LITTLE: f64 = 0.001;

impl Collective {
    /// The nominal life as lines: the figures, what they mean, and where they do not hold.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let Some(life) = self.life() else {
            return vec!["no nominal life: no turn of the shaft with a known load".into()];
        };
        let mut lines = vec![
            self.figures(&life),
            "  that is, nine of ten such bearings reach it under this load, clean and lubricated; it does not tell \
             the state of this one"
                .into(),
        ];
        lines.extend(self.cautions().into_iter().map(|caution| format!("  {caution}")));
        lines
    }

    /// The figures as a sentence.
    #[must_use]
    pub fn figures(&self, life: &NominalLife) -> String {
        let hours =
            life.hours.map_or_else(String::new, |hours| format!(" or {} h at the recorded speed", thousands(hours)));
        format!(
            "nominal life L10 by ISO 281: {} million turns{hours}; mean load {:.0} N of C = {:.0} N; {} of it used in \
             {:.0} turns",
            thousands(life.turns / 1e6),
            life.mean_load_n,
            self.bearing.rating_n,
            percent(life.used),
            self.turns,
        )
    }

    /// Where the figures do not hold.
    pub(crate) fn cautions(&self) -> Vec<String> {
        let all = self.turns + self.without_load;
        let part = |turns: f64| Some(turns / all).filter(|part| *part > LITTLE).map(percent);
        let mut cautions = vec![];
        if let Some(part) = part(self.above_half()) {
            cautions.push(format!("{part} of the turns have a load above C/2, where ISO 281 does not hold"));
        }
        match (part(self.short.1), self.bearing.outer_order) {
            (Some(part), Some(order)) => cautions.push(format!(
                "{part} of the motion is {:.0} swings of less than {:.0}°, in which a ball does not reach its \
                 neighbour's place: such bearings fail by false brinelling rather than fatigue, and L10 does not apply",
                self.short.0,
                360.0 / order,
            )),
            (_, None) => cautions.push(
                "which swings are too short for L10 is not known: give the bearing's geometry (--bearing)".into(),
            ),
            _ => (),
        }
        if let Some(part) = part(self.without_load) {
            cautions.push(format!("{part} of the turns have no torque and are left out"));
        }
        if self.fast > 0 {
            cautions.push(format!(
                "in {} samples the angle moves by more than 0.4 turns: turns may be miscounted, record it faster",
                self.fast
            ));
        }
        cautions
    }

    /// Turns at more than C/2.
    fn above_half(&self) -> f64 {
        self.by_class[CLASSES - 2..].iter().sum()
    }

    /// JSON object with the keys `rating_n`, `mean_load_n`, `l10_million_turns`, `l10_hours`, `used`, `turns`,
    /// `collective`, `turns_above_half_rating`, `turns_without_load`, `short_swings`, `fast_samples`.
    #[must_use]
    pub fn to_json(&self) -> Value {
        let life = self.life();
        let short = self.bearing.outer_order.map(|order| {
            let (count, turns) = self.short;
            json!({ "below_deg": 360.0 / order, "count": count, "turns": turns })
        });
        let class = |(from, to, turns): (f64, f64, f64)| {
            let to = Some(to).filter(|to| to.is_finite());
            json!({ "from_n": from, "to_n": to, "turns": turns })
        };
        json!({
            "rating_n": self.bearing.rating_n,
            "mean_load_n": life.map(|life| life.mean_load_n),
            "l10_million_turns": life.map(|life| life.turns / 1e6),
            "l10_hours": life.and_then(|life| life.hours),
            "used": life.map(|life| life.used),
            "turns": self.turns,
            "collective": self.classes().map(class).collect::<Vec<_>>(),
            "turns_above_half_rating": self.above_half(),
            "turns_without_load": self.without_load,
            "short_swings": short,
            "fast_samples": self.fast,
        })
    }
}

/// A number with three significant digits, or all digits before the point in groups of three.
fn thousands(value: f64) -> String {
    if value < 1000.0 {
        return format!("{:.*}", if value < 10.0 { 2 } else { usize::from(value < 100.0) }, value);
    }
    let digits = format!("{value:.0}");
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(" ")
}

/// A part in percent, with digits enough for a small one.
fn percent(part: f64) -> String {
    let percent = 100.0 * part;
    if percent >= 0.1 { format!("{percent:.1} %") } else { format!("{percent:.1e} %") }
}
