//! Files as loggers write them, whose rate was once taken wrongly: known, or asked with a note.

use crate::reader::of_content;

/// Rows a second of a file with this text, the names of its columns, and what is said of it.
fn of_text(name: &str, text: &str) -> (Option<f64>, Vec<String>, String) {
    with_rate(name, text, None)
}

/// The same with a rate that is given.
fn with_rate(name: &str, text: &str, rate_hz: Option<f64>) -> (Option<f64>, Vec<String>, String) {
    let (names, series, told) = of_content(name, text, rate_hz).expect("a text");
    let rate = series.times_s.map(|times| (times.len() - 1) as f64 / (times[times.len() - 1] - times[0]));
    (rate, names, told.join("\n"))
}

/// Rows of three columns.
fn rows(count: usize, separator: char, mark: char) -> String {
    let cell = |value: f64| format!("{value:.5}").replace('.', &mark.to_string());
    let row = |k: usize| {
        let k = k as f64;
        [0.5 + 0.1 * k.sin(), 32.7 - 0.1 * k, 0.033 * k].map(cell).join(&separator.to_string()) + "\n"
    };
    (0..count).map(row).collect()
}

fn german(lines: &str) -> String {
    format!("Recorder;X1\n{lines}\n\niq_A;omega_rad_s;theta_rad\n{}", rows(50, ';', ','))
}

fn english(lines: &str) -> String {
    format!("Recorder,X1\n{lines}\n\niq_A,omega_rad_s,theta_rad\n{}", rows(50, ',', '.'))
}

fn is_near(rate: Option<f64>, expected: f64) -> bool {
    rate.is_some_and(|rate| (rate / expected - 1.0).abs() < 1e-4)
}

#[test]
fn rates_of_german_and_english_files_are_right() {
    for (lines, expected) in [
        ("Abtastrate;51,2 kHz", 51_200.0),
        ("Messfrequenz: 19,2 kHz", 19_200.0),
        ("Abtastrate [kHz];25,6", 25_600.0),
        ("Abtastintervall;0,125 ms", 8000.0),
        ("Delta_X;8,138021E-5", 12_288.0),
        ("Abtastzeit;6,25E-5 s", 16_000.0),
        ("Zeitschritt [s];0,0005", 2000.0),
        ("Abtastrate;10.000 Hz", 10_000.0),
        ("Abtastfrequenz [Hz];51.200", 51_200.0),
        ("Abtastrate = 16.000,0 Hz", 16_000.0),
        ("Abtastrate;10\u{202f}000 Hz", 10_000.0),
        ("Fréquence d'échantillonnage;20\u{a0}000 Hz", 20_000.0),
        ("Abtastrate;8'000", 8000.0),
        ("Abtastrate;8000 Hz\nUnterabtastung;1:5", 1600.0),
        ("Zykluszeit;62,5 µs\nAufzeichnung;jeder 8. Zyklus", 2000.0),
        ("Abtastzeit;125 us\nTeiler;10", 800.0),
        ("Abtastrate;2000 Hz;2000 Hz;2000 Hz", 2000.0),
    ] {
        let (rate, _, told) = of_text("m.csv", &german(lines));
        assert!(is_near(rate, expected), "{lines}: {rate:?}; {told}");
    }
    for (lines, expected) in [
        ("\"Sample rate\",\"12,500\"", 12_500.0),
        ("\"Sampling Rate (Hz)\",\"51,200\"", 51_200.0),
        ("Sample rate,\"25,600 Hz\"", 25_600.0),
        ("Sampling Time [usec]:,62.5", 16_000.0),
        ("Resolution [usec]:,50\nSampling Time [microseconds]:,500", 2000.0),
        ("TS[us]:,50", 20_000.0),
        ("Sample rate: 10 000 Hz", 10_000.0),
        ("Sampling time,62.5 us\nPeriod,8", 2000.0),
        ("Sample rate,20 kHz\nDecimation,10", 2000.0),
        ("Fs,16000,Hz\nrecorded every 4th sample,yes", 4000.0),
        ("Sample rate (S/s),8192", 8192.0),
        ("サンプリング周波数,25.6 kHz", 25_600.0),
        ("サンプリング周期,50 us", 20_000.0),
        ("Sampling,10 kS/s", 10_000.0),
        ("dt,0.000333", 3000.0),
        ("Sample rate,8000 Hz\nDuration,0.00625 s", 8000.0),
    ] {
        let (rate, _, told) = of_text("m.csv", &english(lines));
        assert!(is_near(rate, expected), "{lines}: {rate:?}; {told}");
    }
}

#[test]
fn doubts_leave_the_rate_and_are_said() {
    for (lines, said) in [
        ("Sample rate,8000 Hz\nSample interval,500 us", "2000 or 8000 rows a second"),
        ("Sample rate,8000 Hz\nDuration,0.025 s", "or 2000 by 50 rows in 0.025 s of line 3"),
        ("Sample rate,2000,8000,2000", "different rates"),
        ("Sample rate,2000 Hz,8000 Hz,8000 Hz", "different rates"),
        ("Sampling Time,100", "10 or 10000 rows a second"),
        ("Sample rate,2 Hz", "which no drive is recorded with"),
        ("Sample rate,10 MHz", "which no drive is recorded with"),
        ("Sample rate,8 kFoo", "its unit is not known"),
        ("Sample rate,12,5 kHz", "a comma in it"),
        ("Sample rate,8000 Hz\nDecimation,4\nDownsampling,2", "by different numbers"),
        ("Sample rate,8000 Hz\nDecimation,some", "by an unknown number"),
    ] {
        let (rate, _, told) = of_text("m.csv", &english(lines));
        assert!(rate.is_none() && told.contains(said) && told.contains("--rate-hz"), "{lines}: {rate:?} {told}");
    }
    // No row has a decimal mark.
    let whole: String = (0..50).map(|k| format!("{};{};{}\n", 500 + k % 7, 3270 - k, 33 * k)).collect();
    for (line, said) in [
        ("Abtastrate;8.000", "8 or 8000 rows"),
        ("Sample rate;12,500 Hz", "12.5 or 12500 rows"),
        ("Rate: 50.000 Hz", "50 or 50000 rows"),
    ] {
        let (rate, _, told) = of_text("m.csv", &format!("{line}\niq;omega;theta\n{whole}"));
        assert!(rate.is_none() && told.contains(said) && told.contains("--rate-hz"), "{line}: {rate:?} {told}");
    }
}

#[test]
fn a_given_rate_stands_and_times_are_compared() {
    let text = english("Sample rate,8000 Hz");
    assert!(is_near(with_rate("m.csv", &text, Some(2000.0)).0, 2000.0) && is_near(of_text("m.csv", &text).0, 8000.0));
    let timed = |rate: u32| {
        let data: String = (0..50).map(|k| format!("{:.6},{}.5\n", f64::from(k) / 2000.0, k % 7)).collect();
        of_text("m.csv", &format!("Sample rate,{rate}\nt_s,iq_A\n{data}"))
    };
    let (rate, _, told) = timed(8000);
    assert!(is_near(rate, 2000.0) && told.contains("2000 rows a second, and line 1 8000"), "{told}");
    assert!(!timed(2000).2.contains("the time is taken"));
}

/// LabVIEW's text: marks told, two headers, units above the names, and times of none, of all, or of each channel.
#[test]
fn files_of_labview_are_read_with_and_without_times() {
    let data = |times: usize| -> String {
        let row = |k: usize| {
            let time = format!("{:.6}", k as f64 / 2000.0);
            let values = [0.5 + 0.1 * (k as f64).sin(), 3.0 - 0.01 * k as f64].map(|value| format!("{value:.6}"));
            let cells = match times {
                0 => vec![String::new(), values[0].clone(), values[1].clone()],
                1 => vec![time, values[0].clone(), values[1].clone()],
                _ => vec![time.clone(), values[0].clone(), time, values[1].clone()],
            };
            cells.join("\t").replace('.', ",") + "\n"
        };
        (0..60).map(row).collect()
    };
    for (times, columns, gap, names) in [
        (0, "No", "", "X_Value\tCurrent\tVelocity\tComment"),
        (1, "One", "", "X_Value\tCurrent\tVelocity\tComment"),
        (2, "Multi", "\t", "X_Value\tCurrent\tX_Value\tVelocity\tComment"),
    ] {
        let line = |key: &str, [one, two]: [&str; 2]| format!("{key}\t{one}{gap}\t{two}\n");
        let text = format!(
            "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\nDecimal_Separator\t,\nX_Columns\t{columns}\n\
             Time\t17:18:18,938945\n***End_of_Header***\t\n\t\nChannels\t2\t\t\n{}{}{}{}{}***End_of_Header***\t\t\t\n\
             {names}\n{}",
            line("Samples", ["100", "100"]),
            line("Y_Unit_Label", ["A", "rad/s"]),
            line("X_Dimension", ["Time", "Time"]),
            line("X0", ["0,0000000000000000E+0"; 2]),
            line("Delta_X", ["0,000500", "0,000500"]),
            data(times)
        );
        let (rate, names, told) = of_text("run.lvm", &text);
        assert!(is_near(rate, 2000.0), "{columns}: {rate:?} {told}");
        assert_eq!(names, ["Current [A]", "Velocity [rad/s]"], "{columns}: {told}");
        assert!(!told.contains("no number in any row"), "{told}");
    }
}
