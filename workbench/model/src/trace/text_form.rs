//! How text files are written, where a user says what their content does not tell.

use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The parts of the layout of text files that the user gives; the others are guessed by their content.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct TextForm {
    /// Lines before the header, or before the rows if there is none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub skip: Option<usize>,
    /// Whether the first of the other lines has names, and the next one units.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub units_row: bool,
    /// What separates cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub separator: Option<Separator>,
    /// The decimal mark; the other one of point and comma then separates thousands.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decimal: Option<Decimal>,
}

impl TextForm {
    /// Whether nothing is given.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// What separates the cells of a line: one character of ASCII. A blank stands for any number of blanks and tabs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(with = "String"))]
#[serde(try_from = "String", into = "String")]
pub struct Separator(u8);

/// Separators whose character a shell or a file of settings hides.
const NAMED: [(&str, u8); 5] = [("tab", b'\t'), ("blank", b' '), ("comma", b','), ("semicolon", b';'), ("bar", b'|')];

impl Separator {
    /// The character.
    #[must_use]
    pub const fn byte(self) -> u8 {
        self.0
    }
}

impl FromStr for Separator {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let named = NAMED.iter().find(|(name, _)| *name == text).map(|(_, byte)| *byte);
        let single = match text.as_bytes() {
            [byte] => Some(*byte),
            br"\t" => Some(b'\t'),
            _ => None,
        };
        let of_cells = |byte: &u8| {
            byte.is_ascii_alphanumeric() || matches!(byte, b'.' | b'-' | b'+' | b'"') || byte.is_ascii_control()
        };
        let byte = named.or(single).filter(|byte| *byte == b'\t' || byte.is_ascii() && !of_cells(byte));
        byte.map(Self).ok_or_else(|| {
            format!("\"{text}\" separates no cells; give one character such as ; or tab, blank, comma, semicolon, bar")
        })
    }
}

impl TryFrom<String> for Separator {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Separator> for String {
    fn from(Separator(byte): Separator) -> Self {
        NAMED
            .iter()
            .find(|(_, named)| *named == byte)
            .map_or_else(|| char::from(byte).into(), |(name, _)| (*name).into())
    }
}

/// A decimal mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
pub enum Decimal {
    /// 1.5; a comma separates thousands
    #[serde(alias = ".")]
    Point,
    /// 1,5; a point separates thousands
    #[serde(alias = ",")]
    Comma,
}

impl Decimal {
    /// Its word in settings.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Comma => "comma",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separators_are_names_or_characters() {
        for (text, byte) in [(";", b';'), ("tab", b'\t'), ("\\t", b'\t'), ("\t", b'\t'), ("blank", b' '), ("~", b'~')] {
            let separator: Separator = text.parse().expect(text);
            assert_eq!(separator.byte(), byte);
            assert_eq!(String::from(separator).parse::<Separator>().expect(text), separator);
        }
        for wrong in ["", "ab", "1", ".", "-", "\"", "\n", "é", "e"] {
            assert!(wrong.parse::<Separator>().is_err(), "{wrong:?}");
        }
    }
}
