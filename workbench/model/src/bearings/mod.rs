//! Dimensions of rolling bearings by their designation.
//!
//! ```text
//! "SKF 6205-2RS/C3" ─► maker SKF, 6205, suffixes that change no dimension ─► rows of table.csv
//! ```
//!
//! `table.csv` has a bearing of one maker a row, each with its source. ISO 15 gives bore, outside diameter and width of
//! a designation; number and size of the rolling elements are each maker's own choice, and the orders with them. The
//! first row of a designation is taken unless the maker is named.
//!
//! Angular contact bearings: C for 15 degrees and AC for 25 degrees, as SKF and ISO have them; other marks of these
//! angles (CD, ACD, A5, E) are understood. These rows are of spindle bearings, which have more balls than the usual
//! ones of 40 degrees (B).

use std::sync::OnceLock;

use crate::near::nearest;

/// A bearing of one maker.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Designation without suffixes that change no dimension.
    pub designation: &'static str,
    /// Its maker, or `unknown`.
    pub maker: &'static str,
    /// What rolls: `ball` or `roller`.
    pub kind: &'static str,
    /// Number of rolling elements in a row.
    pub elements: u8,
    /// Their diameter, mm.
    pub diameter_mm: f64,
    /// Pitch diameter, mm.
    pub pitch_mm: f64,
    /// Contact angle, degrees.
    pub contact_deg: f64,
    /// Where these numbers are published.
    pub source: &'static str,
}

/// The rows of the table.
pub fn rows() -> &'static [Row] {
    static ROWS: OnceLock<Vec<Row>> = OnceLock::new();
    ROWS.get_or_init(|| include_str!("table.csv").lines().skip(1).filter_map(row).collect())
}

fn row(line: &'static str) -> Option<Row> {
    let mut cells = line.splitn(8, ',');
    let mut next = || cells.next();
    Some(Row {
        designation: next()?,
        maker: next()?,
        kind: next()?,
        elements: next()?.parse().ok()?,
        diameter_mm: next()?.parse().ok()?,
        pitch_mm: next()?.parse().ok()?,
        contact_deg: next()?.parse().ok()?,
        source: next()?,
    })
}

/// Suffixes of seals, shields, clearance, cage, precision, grease, groove, tapered bore and pairs.
const SUFFIXES: &[&str] = &[
    "2RS1", "2RS2", "2RSH", "2RSL", "2RSR", "2RSC", "2RS", "2RZ", "2ZR", "2Z", "RS1", "RSH", "RSL", "RSR", "RS", "RZ",
    "ZZ", "ZR", "Z", "LLU", "LLB", "LLH", "LU", "LB", "DDU", "DDW", "DD", "DU", "VV", "2NSE", "NSE", "C2", "C3", "C4",
    "C5", "CN", "CM", "TN9", "TN1", "TNH", "TNG", "TN", "TVP2", "TVP", "TVH", "TPA", "TA", "T", "M1", "M2", "MA", "MB",
    "M", "JEM", "J", "P2", "P4A", "P4S", "P4", "P5", "P6", "ABEC", "MT33", "MT47", "WT", "LHT", "GJN", "NR", "N", "K",
    "DB", "DF", "DT", "DGA", "DGB", "UL", "UM", "UH", "U", "SN24", "HC", "D", "P",
];

/// Suffixes of cylindrical roller bearings with the set of rollers that all makers supply today.
const REINFORCED: &[&str] = &["EXL", "ECP", "ECJ", "ECM", "ECML", "EC", "EW", "EM", "ET", "E"];

/// Names of makers before or behind a designation.
const MAKERS: &[&str] = &[
    "SKF",
    "FAG",
    "INA",
    "NSK",
    "NTN",
    "SNR",
    "KOYO",
    "NACHI",
    "TIMKEN",
    "GMN",
    "NMB",
    "MB",
    "LDK",
    "ZKL",
    "NKE",
    "IBU",
    "MTK",
    "MOCHU",
    "REXNORD",
    "FAFNIR",
    "SCHAEFFLER",
    "RHP",
    "MRC",
];

/// The rows of a designation, that of the named maker first.
///
/// # Errors
/// The designations that are nearest, if it is unknown.
pub fn find(text: &str) -> Result<Vec<&'static Row>, Vec<&'static str>> {
    let (maker, key) = maker_and_key(text);
    let designation =
        rows().iter().map(|own| own.designation).filter(|own| is_of(own, &key)).max_by_key(|own| own.len());
    let Some(designation) = designation else { return Err(near(&key)) };
    let mut alike: Vec<&Row> = rows().iter().filter(|row| row.designation == designation).collect();
    if let Some(maker) = maker {
        alike.sort_by_key(|row| !row.maker.eq_ignore_ascii_case(&maker));
    }
    Ok(alike)
}

/// The maker, if it is named, and the designation in capitals, without marks between its parts.
fn maker_and_key(text: &str) -> (Option<String>, String) {
    let text = text.to_uppercase();
    let is_mark = |c: char| c.is_whitespace() || "/.,_()".contains(c);
    let (makers, words): (Vec<&str>, Vec<&str>) =
        text.split(is_mark).filter(|word| !word.is_empty()).partition(|word| MAKERS.contains(word));
    let joined: String = words.concat().chars().filter(char::is_ascii_alphanumeric).collect();
    (makers.first().map(ToString::to_string), usual(joined))
}

/// The usual form of older and of makers' own designations: 6804 is 61804, 7205A5 is 7205AC, B7205E is 7205AC.
fn usual(key: String) -> String {
    let thin = ["68", "69"].iter().any(|own| key.starts_with(own)) && digits(&key) >= 4;
    if thin {
        return format!("61{}", &key[1..]);
    }
    let angular = key.strip_prefix('B').unwrap_or(&key);
    if !angular.starts_with('7') {
        return key;
    }
    let angular = if angular.starts_with("78") || angular.starts_with("79") {
        format!("71{}", &angular[1..])
    } else {
        angular.into()
    };
    let (number, suffix) = angular.split_at(digits(&angular));
    let angle_25 = ["A5", "ACD", "AC", "E"].iter().find_map(|own| suffix.strip_prefix(own));
    angle_25.map_or_else(|| angular.clone(), |rest| format!("{number}AC{rest}"))
}

fn digits(text: &str) -> usize {
    text.bytes().take_while(u8::is_ascii_digit).count()
}

/// Whether this is the designation with suffixes that change no dimension.
fn is_of(designation: &str, key: &str) -> bool {
    let Some(rest) = key.strip_prefix(designation) else { return false };
    let rest = if designation.starts_with('N') {
        REINFORCED.iter().find_map(|own| rest.strip_prefix(own)).unwrap_or(rest)
    } else {
        rest
    };
    are_suffixes(rest)
}

/// Whether a text is suffixes without an effect, one behind the other.
fn are_suffixes(text: &str) -> bool {
    text.is_empty() || SUFFIXES.iter().filter_map(|own| text.strip_prefix(own)).any(are_suffixes)
}

/// Series of usual bearings, by the digits before those of the bore: deep groove, angular contact, self-aligning,
/// tapered and spherical ones, and behind letters cylindrical rollers and four-point contact.
const SERIES: [&str; 32] = [
    "60", "62", "63", "64", "160", "617", "618", "619", "622", "623", "630", "70", "72", "73", "718", "719", "12",
    "13", "22", "23", "32", "33", "302", "303", "313", "320", "322", "323", "213", "222", "223", "232",
];
const LETTERED: [&str; 7] = ["2", "3", "4", "10", "19", "22", "23"];
const LETTERS: [&str; 7] = ["N", "NU", "NJ", "NUP", "NF", "RNU", "QJ"];
/// Largest code of the bore of a usual bearing: 200 mm.
const MOST_BORE: u32 = 40;

/// Whether this is the designation of a usual bearing, so that a similar one is not meant.
fn is_designation(key: &str) -> bool {
    let letters = key.bytes().take_while(u8::is_ascii_alphabetic).count();
    let (prefix, rest) = key.split_at(letters);
    let number = &rest[..digits(rest)];
    let series = match prefix {
        "" | "B" => &SERIES[..],
        _ if LETTERS.contains(&prefix) => &LETTERED[..],
        _ => return false,
    };
    let is_bore = |bore: &str| match bore.len() {
        // 608, 626: miniature bearings have the bore in mm.
        1 => prefix.is_empty() && bore != "0",
        2 => bore.parse().is_ok_and(|bore: u32| bore <= MOST_BORE),
        _ => false,
    };
    series.iter().any(|series| number.strip_prefix(series).is_some_and(is_bore))
}

/// The nearest designations, those that begin alike first; none if the designation is that of another bearing.
fn near(key: &str) -> Vec<&'static str> {
    let known = || rows().iter().map(|own| own.designation);
    let letters = key.bytes().take_while(u8::is_ascii_alphabetic).count();
    let stem = &key[..letters + digits(&key[letters..])];
    let mut near: Vec<&str> = known().filter(|own| stem.len() > 2 && own.starts_with(stem)).collect();
    if !is_designation(key) {
        near.extend(nearest(key, known()));
    } else if key.starts_with('7') && key[stem.len()..].starts_with(['A', 'B']) {
        // Of 30 and 40 degrees, with other balls than the ones of spindles.
        near.clear();
    }
    let mut unique: Vec<&str> = Vec::new();
    near.into_iter().for_each(|own| {
        if !unique.contains(&own) {
            unique.push(own);
        }
    });
    unique.truncate(3);
    unique
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Orders by the formula of the text books: outer, inner, rolling element, cage.
    fn orders(row: &Row) -> [f64; 4] {
        let ratio = row.diameter_mm / row.pitch_mm;
        let (n, gamma) = (f64::from(row.elements), ratio * row.contact_deg.to_radians().cos());
        [n / 2.0 * (1.0 - gamma), n / 2.0 * (1.0 + gamma), (1.0 - gamma * gamma) / (2.0 * ratio), (1.0 - gamma) / 2.0]
    }

    fn first(text: &str) -> &'static Row {
        find(text).unwrap_or_else(|near| panic!("{text}: {near:?}"))[0]
    }

    #[test]
    fn each_row_is_a_bearing_with_a_source() {
        let lines = include_str!("table.csv").lines().count() - 1;
        assert_eq!((rows().len(), rows().len() > 150), (lines, true));
        for (k, row) in rows().iter().enumerate() {
            let [outer, inner, spin, cage] = orders(row);
            let n = f64::from(row.elements);
            assert!((3.0..=100.0).contains(&n) && ["ball", "roller"].contains(&row.kind), "{row:?}");
            assert!(cage > 0.3 && cage < 0.5 && outer < inner && spin > 1.0 && row.source.len() > 15, "{row:?}");
            assert!((outer + inner - n).abs() < 1e-9 && (cage * n - outer).abs() < 1e-9, "{row:?}");
            let twin = |own: &Row| (own.designation, own.maker) == (row.designation, row.maker);
            assert!(!rows()[..k].iter().any(twin), "{row:?}");
            assert_eq!(first(row.designation).designation, row.designation);
        }
    }

    /// Published orders: by CWRU, Curtin University, Schaeffler (Schnur et al. 2025), Hou et al. 2025, IMS.
    #[test]
    fn orders_are_the_published_ones() {
        let published = [
            ("6205", [3.5848, 5.4152, 4.7135 / 2.0, 0.398_28], 2e-4),
            ("6203", [3.0530, 4.9469, 3.9874 / 2.0, 0.3817], 4e-4),
            ("ER-16K", [3.572, 5.428, 2.32, 0.3969], 2e-3),
            ("NU206-E-XL-TVP2", [5.24, 7.76, 2.49, 0.40], 1e-2),
            // The spin by a roller of two digits.
            ("NU205", [5.2325, 7.7675, 2.4666, 0.4025], 2e-3),
            // 236.4, 296.9, 139.9 and 14.78 Hz at 2000 revolutions a minute.
            ("ZA-2115", [7.092, 8.908, 4.2, 0.4433], 2e-2),
        ];
        for (name, expected, within) in published {
            for (own, expected) in orders(first(name)).into_iter().zip(expected) {
                assert!((own / expected - 1.0).abs() < within, "{name}: {own} {expected}");
            }
        }
    }

    #[test]
    fn suffixes_that_change_no_dimension_are_left_out() {
        for text in
            ["6205", "6205-2RS", "6205-2RS1/C3", "6205 ZZ C3", "6205ZZ", "6205-2Z/C3", "6205 2RS JEM", "6205LLU"]
        {
            assert_eq!((first(text).designation, first(text).maker), ("6205", "SKF"), "{text}");
        }
        assert_eq!(first("nsk 6205 DDU").maker, "NSK");
        assert_eq!(first("6205 (GMN)").maker, "GMN");
        assert_eq!(first("6804").designation, "61804");
        assert_eq!(first("61806-2RS").elements, 19);
        for (text, angle) in
            [("7205 C", 15.0), ("7205 CD/P4A", 15.0), ("7205A5TYNP4", f64::NAN), ("B7205-E-T-P4S-UL", 25.0)]
        {
            let angle_of = find(text).map_or(f64::NAN, |rows| rows[0].contact_deg);
            assert!(angle_of == angle || angle.is_nan(), "{text}: {angle_of}");
        }
    }

    #[test]
    fn other_sets_of_balls_and_unknown_bearings_are_not_guessed() {
        for (text, near) in
            [("6241", "6201"), ("7205", "7205C"), ("620", "6200"), ("6205ETN9", "6205"), ("1205", "1205ETN9")]
        {
            let unknown = find(text).expect_err(text);
            assert!(unknown.contains(&near), "{text}: {unknown:?}");
        }
        for other in ["6214", "6308-2RS", "NU308", "7205BEP", "7308B", "7205A", "16008", "NJ 2210 EC", "22212"] {
            assert_eq!(find(other), Err(vec![]), "{other}");
        }
        assert_eq!(find("washer"), Err(vec![]));
        assert_eq!(find(""), Err(vec![]));
    }
}
