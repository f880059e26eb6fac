//! The names of a model's C header, so that a program can include several of them.

use crate::Error;

/// Longest name of a model in C.
const LONGEST: usize = 24;

/// What its names begin with: `BW_`, `bw_` and `Bw`, or with the name of the model behind it.
#[derive(Debug)]
pub(crate) struct CName {
    pub(crate) upper: String,
    pub(crate) lower: String,
    pub(crate) camel: String,
}

impl CName {
    /// The names of a model with this name, or of the only one of a program.
    ///
    /// # Errors
    /// A name that is not one of C.
    pub(crate) fn new(name: Option<&str>) -> Result<Self, Error> {
        let Some(name) = name else {
            return Ok(Self { upper: "BW_".into(), lower: "bw_".into(), camel: "Bw".into() });
        };
        let letter = name.starts_with(|c: char| c.is_ascii_alphabetic());
        let others = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !letter || !others || name.len() > LONGEST {
            let problem = format!(
                "--c-name {name:?}: a name has a letter, then letters, digits and underscores, at most {LONGEST} of all"
            );
            return Err(Error::Usage(problem));
        }
        let words = name.split('_').map(|word| {
            let (first, rest) = word.split_at(usize::from(!word.is_empty()));
            format!("{}{}", first.to_ascii_uppercase(), rest.to_ascii_lowercase())
        });
        Ok(Self {
            upper: format!("BW_{}_", name.to_ascii_uppercase()),
            lower: format!("bw_{}_", name.to_ascii_lowercase()),
            camel: format!("Bw{}", words.collect::<String>()),
        })
    }

    /// The macro that says that the header was included.
    pub(crate) fn guard(&self) -> String {
        format!("BEARING_WATCH_{}MODEL_H", self.upper.strip_prefix("BW_").unwrap_or_default())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_in_all_names_and_what_is_none_is_refused() {
        let name = CName::new(Some("left_Pump2")).expect("a name");
        assert_eq!([&name.upper, &name.lower, &name.camel], ["BW_LEFT_PUMP2_", "bw_left_pump2_", "BwLeftPump2"]);
        assert_eq!(name.guard(), "BEARING_WATCH_LEFT_PUMP2_MODEL_H");
        assert_eq!(CName::new(None).expect("a name").guard(), "BEARING_WATCH_MODEL_H");
        for wrong in ["", "2a", "_a", "a-b", "größe", "a_name_that_is_much_too_long"] {
            let problem = CName::new(Some(wrong)).expect_err("no name").to_string();
            assert!(problem.contains("--c-name") && problem.contains(wrong), "{problem}");
        }
    }
}
