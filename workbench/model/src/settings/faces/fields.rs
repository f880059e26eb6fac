//! The names of the settings, as serde has them.

use std::sync::OnceLock;

use serde::de::{Deserialize, Deserializer, Error as _, Visitor};
use serde::forward_to_deserialize_any;

use crate::settings::sections::alarm::Alarm;
use crate::settings::sections::bearing::Bearing;
use crate::settings::sections::data::Data;
use crate::settings::sections::model::Model;
use crate::settings::sections::settings::Settings;
use crate::settings::sections::signals::Signals;
use crate::settings::sections::validation::Validation;

/// A table of a drive file, and its keys in the order in which they are written.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Its name.
    pub name: &'static str,
    /// What it is for.
    pub about: &'static str,
    /// Its keys.
    pub keys: &'static [&'static str],
}

/// The tables of a drive file.
pub fn sections() -> &'static [Section] {
    static ALL: OnceLock<Vec<Section>> = OnceLock::new();
    ALL.get_or_init(|| {
        let of_sections = [
            ("Recordings: files or folders, relative to this file", fields::<Data>()),
            (
                "Channels: columns, or formulas of columns such as \"a-b\", \"speed_rpm rad/s\", \
                 \"integrate(speed_rpm) rad\"",
                fields::<Signals>(),
            ),
            ("Bearing: events per turn of its defects, and its load", fields::<Bearing>()),
            ("Model and features", fields::<Model>()),
            ("Which records train, which are of one run or unit, and negative controls", fields::<Validation>()),
            ("Healthy class, rates and costs", fields::<Alarm>()),
        ];
        let names = fields::<Settings>().iter();
        names.zip(of_sections).map(|(&name, (about, keys))| Section { name, about, keys }).collect()
    })
}

/// All keys, each with its table.
pub fn keys() -> impl Iterator<Item = (&'static Section, &'static str)> {
    sections().iter().flat_map(|section| section.keys.iter().map(move |key| (section, *key)))
}

/// The table of a key.
pub(crate) fn section_of(key: &str) -> Option<&'static Section> {
    sections().iter().find(|section| section.keys.contains(&key))
}

/// The names of the fields of a struct.
pub(crate) fn fields<'de, T: Deserialize<'de>>() -> &'static [&'static str] {
    let mut names: &'static [&'static str] = &[];
    // It always ends with an error, once the names are taken.
    let _ended = T::deserialize(Names(&mut names));
    names
}

/// Takes the names that the deserialisation of a struct asks for.
struct Names<'a>(&'a mut &'static [&'static str]);

impl<'de> Deserializer<'de> for Names<'_> {
    type Error = serde::de::value::Error;

    fn deserialize_any<V: Visitor<'de>>(self, _: V) -> Result<V::Value, Self::Error> {
        Err(Self::Error::custom("only names"))
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        fields: &'static [&'static str],
        _: V,
    ) -> Result<V::Value, Self::Error> {
        *self.0 = fields;
        Err(Self::Error::custom("only names"))
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf option unit unit_struct
        newtype_struct seq tuple tuple_struct map enum identifier ignored_any
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_in_one_table_each() {
        let mut all: Vec<&str> = keys().map(|(_, key)| key).collect();
        assert_eq!((sections().len(), sections()[0].keys[2]), (6, "where"));
        all.sort_unstable();
        assert!(all.windows(2).all(|pair| pair[0] != pair[1]), "{all:?}");
    }
}
