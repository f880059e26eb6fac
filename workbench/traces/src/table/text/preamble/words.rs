//! Words for the rate of samples, for the time from row to row, for what divides them, and their units.
//!
//! A key is a rate or a step by two stems, one for sampling and one for frequency or time, in several languages, or by
//! a name that stands alone.

use crate::units::{Quantity, Unit};

/// What a key says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Rows a second.
    Rate,
    /// Time from row to row.
    Step,
    /// Time from row to row, s by its definition.
    StepInSeconds,
    /// A rate or a step by its unit.
    ByUnit,
    /// A step by its unit; a number without one counts samples.
    Period,
    /// Only one of this number of samples is a row.
    Divisor,
    /// So many samples are left out, or one of so many is a row.
    Skipped,
    /// How long the recording is.
    Duration,
    /// The decimal mark.
    DecimalMark,
}

/// Keys that stand alone, folded as [`folded`] does it.
const RATES: &str = "\
    fs sr rate lograte odr fsample fsampling fech fabtast outputdatarate updaterate samplespersecond samplespersec \
    rowspersecond frequencyofsamples samplingspeed サンプリング速度";
const STEPS: &str = "\
    ts tsample timestep timeresolution cycletime tasktime taskcycle zykluszeit taktzeit zeitraster \
    zeitschritt pasdetemps tempsdecycle サイクルタイム";
const STEPS_IN_SECONDS: &str = "\
    dt deltat deltax xincr xinc xincrement tinc tincrement increment wfincrement hresolution";
const BY_UNIT: &str = "cycle zyklus sampling sample samples abtastung echantillonnage サンプリング";
/// Ends of sentences before a rate.
const SENTENCES: &str = "\
    sampledat sampledwith recordedat recordedwith loggedat abgetastetmit aufgezeichnetmit aufzeichnungmit";
const PERIODS: &str = "period periode recordingperiod recordperiod traceperiod logperiod loggingperiod 周期";

/// Stems of sampling, and those of recording, whose time is that of the whole.
const SAMPLING: &str = "\
    sampl abtast echantillon サンプ 標本 采样 取样 muestre campion amostr bemonster probk vzork nayte orneklem";
const RECORDING: &str = "\
    record logg scan acqui erfass capture trace mess mesure aufzeichn aufnahme enregistr daq poll 測定 記録 収録";
const FREQUENCY: &str = "rate freq frecuen cadence tasso taxa 周波数 频率 速度 レート geschwindigkeit";
const INTERVAL: &str = "\
    interval period step schritt increment inkrement raster zyklus cycle takt pasde 周期 間隔 间隔";
const TIME: &str = "time zeit temps tiempo tempo tijd 時間";
const DURATION: &str = "\
    duration dauer duree duracion durata testtime totaltime recordlength recordinglength tracelength \
    timespan";
/// Stems of divisors, and of divisors of something else.
const DIVISORS: &str = "\
    downsampl undersampl subsampl decimat dezim divider divisor prescal teiler unterabtast untersetz \
    diviseur sousechantillon submuestr sottocampion 間引 分周 抽取 降采样 everyn nthsample jedern recordevery \
    logevery reductionfactor reduktionsfaktor datareduction datenreduktion";
const SKIPPED: &str = "skip gap lucke auslass ausgelassen";
const OF_SIGNALS: &str = "\
    volt spannung strom current tension courant encoder verteiler filter order ordnung delay trigger type";
/// Stems of the cycle of a control, in which its rows are recorded if nothing divides it.
const CYCLES: &str = "cycletime zykluszeit taktzeit reglertakt regeltakt tempsdecycle サイクルタイム";
/// Stems of keys that tell another time or rate.
const OTHERS: &str = "\
    start trigger filter cutoff grenz max baud pwm messag delay stamp setpoint count anzahl";
/// Stems of rates and steps behind all divisors.
const FINAL: &str = "effective effektiv effectif result after downsampled decimated stored final";

/// A key in lower case, without accents, blanks and marks.
pub(super) fn folded(key: &str) -> String {
    let fold = |c: char| match c {
        'à' | 'á' | 'â' | 'ã' | 'ä' => 'a',
        'è' | 'é' | 'ê' | 'ë' => 'e',
        'ì' | 'í' | 'î' | 'ï' => 'i',
        'ò' | 'ó' | 'ô' | 'õ' | 'ö' | 'ő' => 'o',
        'ù' | 'ú' | 'û' | 'ü' | 'ű' => 'u',
        'ç' => 'c',
        'ñ' => 'n',
        other => other,
    };
    key.chars().flat_map(char::to_lowercase).filter(|c| c.is_alphanumeric()).map(fold).collect()
}

/// What a folded key without its unit says.
pub(super) fn kind(key: &str) -> Option<Kind> {
    let has = |stems: &str| stems.split(' ').any(|stem| key.contains(stem));
    if matches!(key, "decimalseparator" | "decimalmark" | "decimalpoint" | "dezimaltrennzeichen") {
        return Some(Kind::DecimalMark);
    }
    if has(DIVISORS) {
        return (!has(OF_SIGNALS)).then_some(Kind::Divisor);
    }
    if key.is_empty() || has(OTHERS) {
        return None;
    }
    if has(SKIPPED) && (has(SAMPLING) || has(RECORDING)) {
        return Some(Kind::Skipped);
    }
    let alone = [
        (RATES, Kind::Rate),
        (STEPS, Kind::Step),
        (STEPS_IN_SECONDS, Kind::StepInSeconds),
        (BY_UNIT, Kind::ByUnit),
        (PERIODS, Kind::Period),
    ];
    if let Some((_, kind)) = alone.iter().find(|(names, _)| names.split(' ').any(|name| name == key)) {
        return Some(*kind);
    }
    // Data that were sampled at …
    if SENTENCES.split(' ').any(|end| key.ends_with(end)) {
        return Some(Kind::ByUnit);
    }
    if has(CYCLES) {
        return Some(Kind::ByUnit);
    }
    let (sampling, recording) = (has(SAMPLING), has(RECORDING));
    match () {
        () if has(DURATION) || recording && !sampling && has(TIME) => Some(Kind::Duration),
        () if sampling && key.contains("total") => Some(Kind::Duration),
        () if (sampling || recording) && has(FREQUENCY) => Some(Kind::Rate),
        () if (sampling || recording) && has(INTERVAL) || sampling && has(TIME) => Some(Kind::Step),
        () => None,
    }
}

/// Whether a folded key says that nothing divides its rate any more.
pub(super) fn is_final(key: &str) -> bool {
    FINAL.split(' ').any(|stem| key.contains(stem))
}

/// What a unit measures: rows a second, or s a row, and the factor to it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Scale {
    Hertz(f64),
    Seconds(f64),
}

/// The scale of a unit, such as `kHz`, `kS/s`, `samples/s`, `1/s`, `usec`, `ms/Sample`.
pub(super) fn scale(unit: &str) -> Option<Scale> {
    let unit: String = unit.trim().trim_matches(['[', ']', '(', ')', '"', '.']).chars().flat_map(spelled_out).collect();
    let lower = unit.to_lowercase().replace([' ', '_', '.', '\u{a0}', '\u{202f}'], "");
    // Seconds a sample; samples a second are S/s.
    let is_time = unit.ends_with("s/S");
    if let Some(hertz) = hertz(&lower).filter(|_| !is_time) {
        return Some(Scale::Hertz(hertz));
    }
    // A time for each sample.
    let time = lower.split_once('/').filter(|(_, per)| is_sample(per)).map_or(lower.as_str(), |(time, _)| time);
    seconds(time).map(Scale::Seconds)
}

/// A character that stands for a whole unit.
fn spelled_out(c: char) -> std::vec::IntoIter<char> {
    let text = match c {
        '㎐' => "Hz",
        '㎑' => "kHz",
        '㎒' => "MHz",
        '㎱' => "ns",
        '㎲' => "us",
        '㎳' => "ms",
        '⁻' => "-",
        '¹' => "1",
        other => return vec![other].into_iter(),
    };
    text.chars().collect::<Vec<_>>().into_iter()
}

fn is_sample(word: &str) -> bool {
    const SAMPLES: [&str; 16] = [
        "s",
        "sa",
        "sample",
        "samples",
        "smp",
        "smpl",
        "pt",
        "pts",
        "point",
        "points",
        "row",
        "rows",
        "wert",
        "werte",
        "messwerte",
        "ech",
    ];
    SAMPLES.contains(&word)
}

/// Hertz of a unit in lower case.
fn hertz(unit: &str) -> Option<f64> {
    let base = |unit: &str| -> Option<f64> {
        if matches!(unit, "hz" | "hertz" | "sps" | "s-1" | "s^-1") {
            return Some(1.0);
        }
        let (what, per) = unit.split_once('/').or_else(|| unit.split_once("per")).or_else(|| unit.split_once("pro"))?;
        (what.is_empty() || what == "1" || is_sample(what)).then(|| seconds(per)).flatten().map(|time| 1.0 / time)
    };
    let prefixes = [("kilo", 1e3), ("mega", 1e6), ("giga", 1e9), ("k", 1e3), ("m", 1e6), ("g", 1e9)];
    let scaled = |(prefix, factor): &(&str, f64)| Some(factor * base(unit.strip_prefix(prefix)?)?);
    base(unit).or_else(|| prefixes.iter().find_map(scaled))
}

/// Seconds of a unit of time in lower case.
fn seconds(unit: &str) -> Option<f64> {
    let short = match unit {
        "secs" | "second" | "seconds" | "sek" | "sekunde" | "sekunden" | "seconde" | "secondes" | "秒" => "s",
        "msec" | "msecs" | "millis" | "millisecond" | "milliseconds" | "millisekunden" | "ミリ秒" | "毫秒" => "ms",
        "usec" | "usecs" | "µsec" | "μsec" | "mus" | "mks" | "micros" | "microsec" | "microsecond" | "microseconds"
        | "mikrosekunden" | "microsecondes" | "マイクロ秒" | "微秒" => "us",
        "nsec" | "nsecs" | "nanosecond" | "nanoseconds" | "nanosekunden" => "ns",
        "minute" | "minutes" => "min",
        other => other,
    };
    let unit = Unit::named(short).filter(|unit| unit.quantity == Quantity::Time)?;
    unit.to(&Unit::named("s")?).map(|(factor, _)| factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_say_what_they_mean_in_several_languages() {
        for (keys, expected) in [
            (
                "Sample Rate|sampling_frequency|Abtastrate|Messfrequenz|Fréquence d'échantillonnage|fs|Scan rate|\
                 サンプリング周波数|采样频率|Frecuencia de muestreo|frequenza di campionamento",
                Some(Kind::Rate),
            ),
            (
                "Sampling Time|Abtastintervall|Abtastzeit|Zykluszeit|Période d'échantillonnage|Sample interval|\
                 Recording interval|サンプリング周期|記録間隔|Sampling step",
                Some(Kind::Step),
            ),
            ("Delta_X|dt|XINCR|wf_increment|Hresolution", Some(Kind::StepInSeconds)),
            (
                "Downsampling|Decimation factor|Teiler|Prescaler|Unterabtastung|record every n-th|Vorteiler|間引き|\
                 Diviseur|Sous-échantillonnage|Jeder n-te Wert",
                Some(Kind::Divisor),
            ),
            ("Messdauer|Recording time|Durée|Record length|Total sampling time|Acquisition time", Some(Kind::Duration)),
            ("Sampling|Sampled at", Some(Kind::ByUnit)),
            ("Period|Trace period", Some(Kind::Period)),
            ("Skip samples|Recording gap", Some(Kind::Skipped)),
            ("Control cycle time|Reglertakt", Some(Kind::ByUnit)),
            (
                "Rated speed|Sample start time|Max sample rate|Baud rate|PWM frequency|Voltage divider|Samples ok|Note|\
                 Time|Message rate|Decimation filter order|Sample count|Current|Messspannung|Number of samples",
                None,
            ),
        ] {
            for key in keys.split('|') {
                assert_eq!(kind(&folded(key)), expected, "{key}");
            }
        }
        assert!(is_final(&folded("Effective sample rate")) && !is_final(&folded("Sample rate")));
    }

    #[test]
    fn units_of_rates_and_times_are_scaled() {
        let (hertz, seconds) = (Scale::Hertz, Scale::Seconds);
        for (units, expected) in [
            ("Hz|1/s|S/s|Sa/s|samples/s|samples per second|sps|s^-1|s⁻¹|HZ|Werte/s|㎐", Some(hertz(1.0))),
            ("kHz|kS/s|KHZ|ksps|kSa/s|kSamples/s|k samples/s|㎑", Some(hertz(1e3))),
            ("MHz|MS/s|Msps|MSa/s|1/us", Some(hertz(1e6))),
            ("s|sec|SEC|seconds|s/S|sec.|秒", Some(seconds(1.0))),
            ("ms|msec|ms/Sample|milliseconds|㎳|[ms]", Some(seconds(1e-3))),
            ("us|µs|μs|usec|microseconds|µs/pt|マイクロ秒", Some(seconds(1e-6))),
            ("ns|nsec", Some(seconds(1e-9))),
            ("V|rpm|bit|ticks|mm||m|k|MHz/V", None),
        ] {
            for unit in units.split('|') {
                let near = match (scale(unit), expected) {
                    (Some(Scale::Hertz(one)), Some(Scale::Hertz(other)))
                    | (Some(Scale::Seconds(one)), Some(Scale::Seconds(other))) => (one / other - 1.0).abs() < 1e-12,
                    (one, other) => one == other,
                };
                assert!(near, "{unit}: {:?}", scale(unit));
            }
        }
    }
}
