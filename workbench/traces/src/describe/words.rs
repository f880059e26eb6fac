//! Words of names of files and folders: those of runs, of healthy machines, and of damage.
//!
//! ```text
//! gesund_Lauf01_1    run Lauf01, and the rest gesund_1
//! not_ok, n.i.O.     no healthy machine
//! no_fault           a healthy machine
//! ```

/// Words that a number of a run follows.
const RUNS: [&str; 34] = [
    "run",
    "lauf",
    "rec",
    "recording",
    "record",
    "aufnahme",
    "messung",
    "measurement",
    "meas",
    "mess",
    "test",
    "trial",
    "versuch",
    "experiment",
    "exp",
    "nr",
    "no",
    "num",
    "number",
    "nummer",
    "session",
    "sitzung",
    "day",
    "tag",
    "essai",
    "mesure",
    "jour",
    "serie",
    "series",
    "batch",
    "prova",
    "prueba",
    "messlauf",
    "repeat",
];
/// Words of runs at the end of compounds, such as Testlauf.
const RUN_ENDS: [&str; 4] = ["lauf", "messung", "aufnahme", "versuch"];
/// The same in scripts without blanks between words.
const RUN_SIGNS: [&str; 8] = ["測定", "测定", "測量", "测量", "試験", "试验", "実験", "回目"];
/// Words of machines without a defect.
const HEALTHY: [&str; 26] = [
    "healthy",
    "normal",
    "good",
    "ok",
    "nominal",
    "baseline",
    "sound",
    "undamaged",
    "gesund",
    "gut",
    "intakt",
    "normale",
    "sain",
    "saine",
    "sano",
    "sana",
    "bon",
    "io",
    "heil",
    "faultless",
    "fehlerfrei",
    "schadensfrei",
    "defektfrei",
    "unbeschädigt",
    "unbeschaedigt",
    "intact",
];
/// Of these, such as are names of machines only where several files have them.
const VAGUE: [&str; 6] = ["good", "ok", "gut", "io", "bon", "sound"];
/// The same in scripts without blanks between words.
const HEALTHY_SIGNS: [&str; 5] = ["正常", "健全", "良好", "良品", "健康"];
/// Signs that deny what follows.
const DENIED: [char; 3] = ['非', '不', '未'];
/// Words of defects.
const DAMAGED: [&str; 33] = [
    "fault",
    "faulty",
    "faults",
    "defect",
    "defects",
    "defective",
    "damage",
    "damaged",
    "broken",
    "worn",
    "wear",
    "bad",
    "nok",
    "nio",
    "spall",
    "crack",
    "pitting",
    "inner",
    "outer",
    "ball",
    "cage",
    "unbalance",
    "imbalance",
    "misalignment",
    "abnormal",
    "unhealthy",
    "kaputt",
    "riss",
    "fehler",
    "usé",
    "panne",
    "innen",
    "aussen",
];
/// Parts of words of defects.
const DAMAGED_PARTS: [&str; 9] =
    ["schaden", "schäd", "defekt", "defaut", "défaut", "verschlei", "endommag", "unwucht", "guasto"];
const DAMAGED_SIGNS: [&str; 8] = ["異常", "异常", "故障", "不良", "損傷", "损伤", "損耗", "傷"];
/// Words that turn the next one round.
const NOT: [&str; 10] = ["not", "no", "non", "nicht", "kein", "keine", "pas", "ohne", "without", "sans"];

/// A text in lower case, with abbreviations without their dots.
pub(super) fn plain(text: &str) -> String {
    let pairs = [("n.i.o", "nio"), ("i.o.", "io"), ("i.o_", "io_")];
    pairs.iter().fold(text.to_lowercase(), |text, (from, to)| text.replace(from, to))
}

/// The words of a text in lower case.
fn words_of(text: &str) -> Vec<String> {
    plain(text).split(|c: char| !c.is_alphabetic()).filter(|word| !word.is_empty()).map(String::from).collect()
}

fn has_sign(text: &str, signs: &[&str]) -> bool {
    let is_denied = |at: usize| text[..at].ends_with(DENIED);
    signs.iter().any(|sign| text.match_indices(sign).any(|(at, _)| !is_denied(at)))
}

fn is_damage(word: &str) -> bool {
    DAMAGED.contains(&word) || DAMAGED_PARTS.iter().any(|part| word.contains(part))
}

/// Whether a word is among these, or a word of a defect is denied.
fn has_healthy(text: &str, is_healthy: &dyn Fn(&str) -> bool) -> bool {
    let words = words_of(text);
    let is_denied = |k: usize| k > 0 && NOT.contains(&words[k - 1].as_str());
    let tells = |k: usize| {
        let (word, denied) = (words[k].as_str(), is_denied(k));
        if denied { is_damage(word) } else { is_healthy(word) }
    };
    (0..words.len()).any(tells) || has_sign(text, &HEALTHY_SIGNS)
}

/// Whether a text names a machine without a defect.
pub(super) fn is_healthy(text: &str) -> bool {
    has_healthy(text, &|word| HEALTHY.contains(&word))
}

/// The same by words that are clear even of a single file.
pub(super) fn is_clearly_healthy(text: &str) -> bool {
    has_healthy(text, &|word| HEALTHY.contains(&word) && !VAGUE.contains(&word))
}

/// Whether a text names a defect.
pub(super) fn is_damaged(text: &str) -> bool {
    words_of(text).iter().any(|word| is_damage(word)) && !is_healthy(text) || has_sign(text, &DAMAGED_SIGNS)
}

/// Whether a text tells the class of a machine.
pub(super) fn tells_class(text: &str) -> bool {
    is_healthy(text) || is_damaged(text)
}

/// Whether a key of a folder, such as `run=3`, is that of a run.
pub(super) fn is_run_key(key: &str) -> bool {
    RUNS.contains(&key.to_lowercase().as_str())
}

/// A part of a name: letters, digits, or what is between.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Part {
    Letters,
    Digits,
    Between,
}

fn part_of(c: char) -> Part {
    match c {
        _ if c.is_ascii_digit() || ('０'..='９').contains(&c) => Part::Digits,
        '#' | '№' => Part::Letters,
        _ if c.is_alphabetic() => Part::Letters,
        _ => Part::Between,
    }
}

/// The parts of a name, one after another.
fn parts_of(name: &str) -> Vec<(Part, &str)> {
    let mut all: Vec<(Part, &str)> = Vec::new();
    let mut start = 0;
    for (at, c) in name.char_indices() {
        let next = name[at..].chars().nth(1);
        // #5 has a number, a#5 too.
        let ends = next.is_none_or(|next| part_of(next) != part_of(c) || next == '#' || c == '#');
        if ends {
            let end = at + c.len_utf8();
            all.push((part_of(c), &name[start..end]));
            start = end;
        }
    }
    all
}

/// Where the word of a run starts in letters, if they end with one.
fn run_word(letters: &str, is_test_a_run: bool) -> Option<usize> {
    let lower = letters.to_lowercase();
    let is_whole =
        RUNS.contains(&lower.as_str()) && (is_test_a_run || lower != "test") || ["#", "№"].contains(&letters);
    if is_whole || RUN_ENDS.iter().any(|end| lower.ends_with(end)) {
        return Some(0);
    }
    RUN_SIGNS.iter().find_map(|sign| letters.strip_suffix(sign)).map(str::len)
}

/// The runs that a name tells, such as Lauf01 and rec 2, and the name without them.
pub(super) fn runs_of(name: &str, is_test_a_run: bool) -> (Vec<String>, String) {
    let parts = parts_of(name);
    let (mut runs, mut rest, mut k) = (Vec::new(), String::new(), 0);
    while k < parts.len() {
        let (kind, text) = parts[k];
        let start = run_word(text, is_test_a_run).filter(|_| kind == Part::Letters);
        let between = parts.get(k + 1).filter(|(kind, text)| *kind == Part::Between && text.chars().count() < 3);
        let number = k + 1 + usize::from(between.is_some());
        // A number with a unit, as of test_800rpm, is none of a run.
        let is_number = parts.get(number).is_some_and(|(kind, _)| *kind == Part::Digits)
            && parts.get(number + 1).is_none_or(|(kind, _)| *kind != Part::Letters);
        match start.filter(|_| is_number) {
            Some(start) => {
                rest += &text[..start];
                let behind: String = parts[k + 1..=number].iter().map(|(_, text)| *text).collect();
                runs.push(format!("{}{behind}", &text[start..]));
                k = number + 1;
            }
            None => {
                rest += text;
                k += 1;
            }
        }
    }
    (runs, rest)
}

/// Words of motors of one machine, which a number or a letter follows; of a joint the letter is enough.
const MOTORS: [&str; 17] = [
    "axis", "achse", "axe", "eje", "ax", "joint", "gelenk", "j", "servo", "actuator", "aktor", "motor", "drive",
    "antrieb", "spindle", "spindel", "軸",
];
/// Letters of motors, beside those that also are parts of words.
const MOTOR_LETTERS: &str = "abcdeflrxyz";

/// The motor that a name tells, such as axis1, J2 and motor_b, and the name without it.
pub(super) fn motor_of(name: &str) -> Option<(String, String)> {
    let parts = parts_of(name);
    let is_motor = |k: usize| parts[k].0 == Part::Letters && MOTORS.contains(&parts[k].1.to_lowercase().as_str());
    (0..parts.len()).filter(|k| is_motor(*k)).find_map(|k| {
        let between = parts.get(k + 1).filter(|(kind, text)| *kind == Part::Between && text.chars().count() == 1);
        let last = k + 1 + usize::from(between.is_some());
        let (kind, text) = *parts.get(last)?;
        let ends = parts.get(last + 1).is_none_or(|(kind, _)| *kind == Part::Between);
        let is_number = kind == Part::Digits && text.len() < 3;
        let is_letter = text.chars().count() == 1 && MOTOR_LETTERS.contains(&text.to_lowercase());
        (ends && (is_number || is_letter && kind == Part::Letters)).then(|| {
            let join = |own: &[(Part, &str)]| own.iter().map(|(_, text)| *text).collect::<String>();
            (join(&parts[k..=last]), join(&parts[..k]) + &join(&parts[last + 1..]))
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_are_words_with_numbers() {
        for (name, runs, rest) in [
            ("gesund_Lauf01_1", vec!["Lauf01"], "gesund__1"),
            ("outer run 3", vec!["run 3"], "outer "),
            ("inner#5", vec!["#5"], "inner"),
            ("Nr. 12 defekt", vec!["Nr. 12"], " defekt"),
            ("day2_Testlauf-04_ok", vec!["day2", "Testlauf-04"], "__ok"),
            ("正常測定3", vec!["測定3"], "正常"),
            ("session1-rec_2", vec!["session1", "rec_2"], "-"),
            ("test_800rpm", vec![], "test_800rpm"),
            ("latest3_overrun_a", vec![], "latest3_overrun_a"),
            ("run_A1_01", vec![], "run_A1_01"),
        ] {
            assert_eq!(runs_of(name, true), (runs.into_iter().map(String::from).collect(), rest.to_string()), "{name}");
        }
        assert_eq!(runs_of("test_3", false).0, Vec::<String>::new());
    }

    #[test]
    fn motors_are_words_with_a_number_or_a_letter() {
        for (name, motor, rest) in [
            ("axis1_healthy_03", "axis1", "_healthy_03"),
            ("rec_J2", "J2", "rec_"),
            ("motor_b", "motor_b", ""),
            ("ok-Achse-X-2", "Achse-X", "ok--2"),
            ("軸3_正常", "軸3", "_正常"),
        ] {
            assert_eq!(motor_of(name), Some((motor.to_string(), rest.to_string())), "{name}");
        }
        for name in ["motor_ok_1", "drive_1000rpm", "motor-2024-05", "axis", "jam_1", "servo_test_2", "adjoint1"] {
            assert_eq!(motor_of(name), None, "{name}");
        }
    }

    #[test]
    fn health_and_damage_are_told_apart_in_several_languages() {
        for text in
            ["healthy", "Gesund_A", "sain", "正常", "i.O. 3", "no_fault", "ohne Schaden", "motor_ok", "fehlerfrei"]
        {
            assert!(is_healthy(text) && !is_damaged(text), "{text}");
        }
        for text in
            ["unhealthy", "not_ok", "n.i.O.", "NiO", "friction", "Lagerschaden", "異常", "非正常", "radio", "nok"]
        {
            assert!(!is_healthy(text), "{text}");
        }
        for text in ["outer race", "Lagerschaden", "故障", "défaut", "nio", "worn_belt", "Verschleiß"] {
            assert!(is_damaged(text), "{text}");
        }
        assert!(!is_damaged("metronome") && !tells_class("friction_800") && !is_clearly_healthy("ok"));
    }
}
