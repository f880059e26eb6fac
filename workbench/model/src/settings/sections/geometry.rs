//! The dimensions of a bearing as a user gives them: four numbers of a data sheet, or its designation.
//!
//! ```text
//! [9, 7.94, 39.04, 0]   balls, ball diameter, pitch diameter, contact angle in degrees
//! "6205-2RS"            the same from a table, with its source
//! ```
//!
//! Earlier files give the contact angle in rad. No bearing has an angle between 0 and 1 degrees, so that a number up to
//! 1.05 is one in rad; it is taken with a warning.

use serde::ser::SerializeSeq as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

use super::merge::Given;
use crate::bearings::{Row, find};
use crate::outputs::trimmed;

/// Largest angle that is taken as one in rad.
const MOST_RAD: f64 = 1.05;

/// Largest contact angle of a radial bearing, degrees.
const MOST_DEG: f64 = 60.0;

/// What to give.
const FORM: &str = "give four numbers of its data sheet (number of balls, ball diameter, pitch diameter, contact angle \
                    in degrees, e.g. 9,7.94,39.04,0), or a designation such as 6205";

/// A bearing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Geometry(Option<Known>);

#[derive(Clone, Debug, PartialEq)]
struct Known {
    dimensions: Dimensions,
    origin: Origin,
}

/// The dimensions of a bearing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dimensions {
    /// Number of balls or rollers.
    pub balls: u8,
    /// Their diameter.
    pub ball: f64,
    /// Pitch diameter in the same unit.
    pub pitch: f64,
    /// Contact angle, degrees.
    pub contact_deg: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Origin {
    Numbers,
    /// The contact angle as it was given.
    Rad(f64),
    /// The designation as it was given, and the rows of the table, of which the first is taken.
    Table(String, Vec<&'static Row>),
}

impl Geometry {
    /// Takes the words of a user.
    ///
    /// # Errors
    /// They are no bearing.
    pub fn of_words(words: &[String]) -> Result<Self, String> {
        let numbers: Vec<f64> = words.iter().filter_map(|word| word.trim().parse().ok()).collect();
        let known = match (words, &numbers[..]) {
            ([], _) => return Ok(Self::default()),
            (_, &[balls, ball, pitch, contact]) if words.len() == 4 => of_numbers(balls, ball, pitch, contact)?,
            ([name], _) => of_name(name.trim())?,
            _ => return Err(format!("a bearing has four numbers: {FORM}")),
        };
        Ok(Self(Some(known)))
    }

    /// Of these dimensions, which are not checked.
    #[must_use]
    pub const fn of(dimensions: Dimensions) -> Self {
        Self(Some(Known { dimensions, origin: Origin::Numbers }))
    }

    /// Whether no bearing is given.
    #[must_use]
    pub const fn is_empty(&self) -> bool {
        self.0.is_none()
    }

    /// Its dimensions, if it is given.
    #[must_use]
    pub fn dimensions(&self) -> Option<Dimensions> {
        self.0.as_ref().map(|own| own.dimensions)
    }

    /// What a user should know of what was taken: dimensions of a table, or an angle in rad.
    #[must_use]
    pub fn note(&self) -> Option<String> {
        match self.0.as_ref().map(|own| (&own.origin, own.dimensions.contact_deg)) {
            None | Some((Origin::Numbers, _)) => None,
            Some((Origin::Rad(given), degrees)) => Some(format!(
                "contact angle {given} taken as rad ({} degrees); give degrees as data sheets do",
                short(degrees)
            )),
            Some((Origin::Table(name, rows), _)) => {
                let (first, others) = rows.split_first()?;
                let others: Vec<String> = others.iter().map(|row| format!("{} {}", row.maker, size(row))).collect();
                let others = if others.is_empty() {
                    "others may have other balls".into()
                } else {
                    format!("others differ ({})", others.join("; "))
                };
                let maker = if first.maker == "unknown" { "maker not stated" } else { first.maker };
                let (size, source) = (size(first), first.source);
                Some(format!("{name}: {size} ({maker}: {source}); {others}: audit shows the lines"))
            }
        }
    }

    /// What was taken, in words.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        let Dimensions { balls, ball, pitch, contact_deg } = self.dimensions()?;
        let (ball, pitch, angle) = (short(ball), short(pitch), short(contact_deg));
        Some(format!("{balls} balls of {ball} on {pitch}, contact angle {angle} degrees"))
    }
}

/// Number, diameter, pitch and angle of a row.
fn size(row: &Row) -> String {
    let Row { kind, elements, diameter_mm, pitch_mm, contact_deg, .. } = row;
    format!(
        "{elements} {kind}s of {} mm on {} mm, {} degrees",
        short(*diameter_mm),
        short(*pitch_mm),
        short(*contact_deg)
    )
}

/// A number with at most two digits behind the point.
fn short(number: f64) -> String {
    trimmed(number, 2)
}

fn of_numbers(balls: f64, ball: f64, pitch: f64, contact: f64) -> Result<Known, String> {
    if !(3.0..=100.0).contains(&balls) || balls.fract() != 0.0 {
        return Err(format!("the number of balls is a whole one from 3 to 100, not {balls}: {FORM}"));
    }
    if !(ball > 0.0 && ball < pitch && pitch.is_finite()) {
        return Err(format!("the ball diameter {ball} is not between 0 and the pitch diameter {pitch}: {FORM}"));
    }
    // Neighbours touch if each takes 2 asin(ball / pitch) of the circle; rounded numbers of a full set exceed it a bit.
    let most = std::f64::consts::PI / (ball / pitch).asin();
    if balls > 1.01 * most {
        return Err(format!(
            "{balls} balls of diameter {ball} do not fit on a pitch diameter of {pitch}, which has room for {most:.0}"
        ));
    }
    let (contact_deg, origin) = match contact {
        0.0 => (0.0, Origin::Numbers),
        rad if rad > 0.0 && rad <= MOST_RAD => (rad.to_degrees(), Origin::Rad(rad)),
        other => (other, Origin::Numbers),
    };
    if !(0.0..=MOST_DEG).contains(&contact_deg) {
        return Err(format!("the contact angle is from 0 to {MOST_DEG} degrees, not {}", short(contact_deg)));
    }
    Ok(Known { dimensions: Dimensions { balls: balls as u8, ball, pitch, contact_deg }, origin })
}

fn of_name(name: &str) -> Result<Known, String> {
    let unknown = |near: Vec<&'static str>| {
        let near = if near.is_empty() { String::new() } else { format!(" (did you mean {}?)", near.join(", ")) };
        format!(
            "{name} is not in the table of published bearings{near}: {FORM}; or the orders of its lines, which the maker's \
             search by designation gives as BPFO and BPFI: --orders outer=…,inner=…"
        )
    };
    // A whole number of Python may come as one with a point.
    let rows = find(name.strip_suffix(".0").unwrap_or(name)).map_err(unknown)?;
    let Some(row) = rows.first() else { return Err(unknown(vec![])) };
    let dimensions =
        Dimensions { balls: row.elements, ball: row.diameter_mm, pitch: row.pitch_mm, contact_deg: row.contact_deg };
    Ok(Known { dimensions, origin: Origin::Table(name.into(), rows) })
}

impl Given for Geometry {
    fn or_given(self, base: Self) -> Self {
        if self.is_empty() { base } else { self }
    }
}

impl<'de> Deserialize<'de> for Geometry {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        Self::of_words(&Vec::<String>::deserialize(deserializer)?).map_err(de::Error::custom)
    }
}

impl Serialize for Geometry {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match &self.0 {
            Some(Known { origin: Origin::Table(name, _), .. }) => serializer.serialize_str(name),
            known => {
                let numbers = known.as_ref().map(|own| {
                    let Dimensions { balls, ball, pitch, contact_deg } = own.dimensions;
                    [f64::from(balls), ball, pitch, contact_deg]
                });
                let mut list = serializer.serialize_seq(Some(if numbers.is_some() { 4 } else { 0 }))?;
                numbers.iter().flatten().try_for_each(|number| list.serialize_element(number))?;
                list.end()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> Result<Geometry, String> {
        Geometry::of_words(&text.split(',').map(String::from).collect::<Vec<_>>())
    }

    #[test]
    fn the_contact_angle_is_in_degrees_and_small_ones_are_in_rad() {
        for (text, degrees, warns) in [
            ("9,3,17,10", 10.0, false),
            ("9,3,17,0", 0.0, false),
            ("9,3,17,1.1", 1.1, false),
            ("9,3,17,25", 25.0, false),
            ("9,3,17,60", 60.0, false),
            ("9,3,17,0.1745", 9.998, true),
            ("9,3,17,1", 57.296, true),
            ("9,3,17,0.436", 24.981, true),
        ] {
            let own = of(text).expect(text);
            let found = own.dimensions().expect("a bearing").contact_deg;
            assert!((found - degrees).abs() < 1e-3 && own.note().is_some() == warns, "{text}: {own:?}");
        }
        let note = of("9,3,17,0.1745").expect("rad").note().unwrap_or_default();
        assert_eq!(note, "contact angle 0.1745 taken as rad (10 degrees); give degrees as data sheets do");
    }

    #[test]
    fn numbers_that_are_no_bearing_are_refused() {
        for (text, part) in [
            ("9,3,17,61", "from 0 to 60 degrees, not 61"),
            ("9,3,17,-10", "from 0 to 60 degrees, not -10"),
            ("9,3,17,1.05", "from 0 to 60 degrees, not 60.16"),
            ("9,3,17,nan", "from 0 to 60 degrees"),
            ("9.5,3,17,10", "a whole one from 3 to 100, not 9.5"),
            ("2,3,17,10", "from 3 to 100"),
            ("101,0.1,17,10", "from 3 to 100"),
            ("9,17,3,10", "ball diameter 17 is not between 0 and the pitch diameter 3"),
            ("9,0,17,10", "ball diameter 0"),
            ("9,3,inf,10", "pitch diameter inf"),
            ("40,3,17,10", "room for 18"),
            ("9,3,17", "four numbers"),
            ("9,3,17,10,2", "four numbers"),
            ("9,3,17,ten", "four numbers"),
            ("6250", "(did you mean 625, 6200, 6205?)"),
            ("7209", "(did you mean 7209AC, 7209C?)"),
            // No similar bearing is offered in the place of one that exists.
            ("6214", "6214 is not in the table of published bearings: give four numbers of its data sheet"),
            ("6308-2Z/C3", "published bearings: give four numbers"),
            ("NU 308 ECP", "published bearings: give four numbers"),
            ("7312 BECBP", "or the orders of its lines, which the maker's search by designation gives"),
            ("washer", "not in the table of published bearings: give four numbers"),
        ] {
            let problem = of(text).expect_err(text);
            assert!(problem.contains(part), "{text}: {problem}");
        }
    }

    #[test]
    fn a_designation_says_what_was_taken_and_from_where() {
        let own = of("6205-2RS").expect("a known one");
        let same = of("9,7.94,39.04,0").expect("its numbers");
        assert_eq!(own.dimensions(), same.dimensions());
        let note = own.note().unwrap_or_default();
        for part in
            ["6205-2RS: 9 balls of 7.94 mm on 39.04 mm, 0 degrees (SKF: CWRU", "NSK 9 balls of 7.9 mm on 38.5 mm"]
        {
            assert!(note.contains(part), "{note}");
        }
        assert!(of("61806").expect("one row").note().is_some_and(|note| note.contains("maker not stated")));
        assert!(of("N204").expect("rollers").note().is_some_and(|note| note.contains("11 rollers of 7.5 mm")));
        assert_eq!(toml::Value::try_from(&own).map(|own| own.to_string()), Ok("\"6205-2RS\"".into()));
        assert_eq!(toml::Value::try_from(&same).map(|own| own.to_string()), Ok("[9.0, 7.94, 39.04, 0.0]".into()));
    }
}
