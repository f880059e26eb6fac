use model::trace::{Decimal, TextForm};

use crate::table::text::layout::Layout;

fn of(text: &str) -> Layout {
    Layout::of(text, &TextForm::default())
}

fn layout(text: &str) -> (char, bool, Vec<String>, usize) {
    let Layout { separator, decimal_comma, names, first, .. } = of(text);
    (char::from(separator), decimal_comma, names, first)
}

fn expect(text: &str, (separator, decimal_comma, names, first): (char, bool, &str, usize)) {
    let names = names.split(' ').map(String::from).collect();
    assert_eq!(layout(text), (separator, decimal_comma, names, first), "{text}");
}

#[test]
fn separators_and_decimal_commas_are_told_apart() {
    expect("t,i\n0.1,2.5\n", (',', false, "t i", 1));
    expect("t;i\n0,1;2,5\n0,2;1\n", (';', true, "t i", 1));
    expect("t;i\n0.1;2.5\n", (';', false, "t i", 1));
    expect("t\ti\n0,1\t2,5\n", ('\t', true, "t i", 1));
    expect("t  i\n0.1   2.5\n", (' ', false, "t i", 1));
    expect("t,i\n0,x\n1,2\n2,3\n", (',', false, "t i", 1));
    expect("t,i,late\n0,1,\n1,2,\n", (',', false, "t i late", 1));
    expect("\"a;b\",i\n1,2\n", (',', false, "a;b i", 1));
    expect("only\n1.5\n", (',', false, "only", 1));
    expect("t;n\n0,5;2,000\n1,5;3,000\n", (';', true, "t n", 1));
    expect("n;k\n2,000;1\n3,000;2\n", (';', false, "n k", 1));
    // A short row leaves the separator of the header.
    assert_eq!(layout("a,b,c\n1,2\n").0, ',');
    assert_eq!(layout("").0, ',');
}

#[test]
fn headers_are_lines_comments_or_missing() {
    expect("# logger 3\n# t, i\n0.1,2\n0.2,3\n", (',', false, "t i", 2));
    expect("% logger 3\nt,i\n0.1,2\n", (',', false, "t i", 2));
    expect("# logger 3\n0.1 2 7\n0.2 3 8\n", (' ', false, "c1 c2 c3", 1));
    expect("1,2\n3,4\n", (',', false, "c1 c2", 0));
    expect("0,1,2\n0.5,2.5,7\n0.6,2.5,7\n", (',', false, "0 1 2", 1));
    expect("a b\n1 0.5 7\n2 0.6 8\n3 0.7 9\n", (' ', false, "row a b", 1));
    assert_eq!(layout("\"t\n(s)\",i\n1,2\n3,4\n"), (',', false, vec!["t (s)".to_string(), "i".into()], 2));
}

fn rows(row: impl Fn(usize) -> String) -> String {
    (0..40).map(row).collect()
}

#[test]
fn a_time_may_be_told_by_its_unit_alone() {
    let data = rows(|k| format!("{},{}.5,{}\n", -0.02 + k as f64 / 1e3, k % 7, k % 5));
    for head in ["x-axis,1,2\nsecond,Volt,Ampere\n", "in s,C1 in V,C2 in A\n", "Source,CH1,CH2\nSecond,Value,Value\n"] {
        let found = of(&format!("{head}{data}"));
        assert_eq!(found.about.clocks, [0], "{head}");
        assert!(found.about.notes[0].contains("has a unit of time"), "{:?}", found.about.notes);
    }
    let falls = rows(|k| format!("{}.5,{}\n", 7 - k % 7, k % 5));
    assert!(of(&format!("delay [ms],i\n{falls}")).about.clocks.is_empty());
}

#[test]
fn a_second_time_of_another_rate_is_found() {
    let slow = |name: &str| {
        let data = rows(|k| format!("{:.3};1,5;{:.2};20,1\n", k as f64 / 1e3, k as f64 / 1e2).replace('.', ","));
        of(&format!("Time 1 - fast [s];i [A];{name};T\n{data}")).about.other_times
    };
    assert_eq!((slow("Time 2 - slow [s]"), slow("on [s]")), (Some((2, 3)), None));
}

#[test]
fn names_are_found_by_their_keys_and_above_the_name_of_the_first_column() {
    let data = rows(|k| format!("\"\",{}.5,{}\n", k % 7, k % 5));
    let found = of(&format!("\"TraceName\",\"i\",\"n\"\n\"VUnit\",\"A\",\"rpm\"\n\"SampleRate\",2000,2000\n{data}"));
    assert_eq!((found.names.join("|"), found.about.step_s), ("|i [A]|n [rpm]".into(), Some(5e-4)));
    let data = rows(|k| format!("{},{}.5,{}\n", k as f64 / 1e3, k % 7, k % 5));
    let found = of(&format!("signal,i,n\nunit,A,rpm\nt_s,,\n{data}"));
    assert_eq!((found.names.join("|"), found.first), ("t_s|i [A]|n [rpm]".into(), 3));
    // Words of a boot are no names.
    let data = rows(|k| format!("{},{}.5,{}\n", 533 + 2 * k, k % 7, k % 5));
    assert!(of(&format!("sensor ok, starting\n{data}")).header.is_empty());
}

#[test]
fn commas_that_separate_and_are_decimal_are_refused_but_not_in_quotes() {
    let data = rows(|k| format!("0,0{k:02},1,{}\n", k % 7));
    assert_eq!(of(&format!("t,i\n{data}")).both_commas, Some(1));
    let quoted = of(&format!("t,i\n{}", rows(|k| format!("\"0,00{k:02}\",\"1,{}\"\n", k % 7))));
    assert_eq!((quoted.both_commas, quoted.decimal_comma, quoted.number("1,5")), (None, true, Some(1.5)));
}

#[test]
fn lines_before_the_header_and_units_are_understood() {
    assert_eq!(of("t_s;i\ns;A\n0.0;1\n0.5;2\n").names, ["t_s", "i [A]"]);
    let units = of("Time;Current;Speed\n[s];[A];[rpm]\n0.000;0.1;1000.2\n0.001;1.1;1001.2\n");
    assert_eq!((units.names.join("|"), units.first), ("Time [s]|Current [A]|Speed [rpm]".into(), 2));
    let text = "Logger,3\nSample Rate,2000\nNote,a,b,c\n0,0.5,0.2\n1,1.5,1.2\n2,2.5,2.2\n";
    let found = of(text);
    assert_eq!((found.names.join("|"), found.first, found.about.step_s), ("c1|c2|c3".into(), 3, Some(1.0 / 2000.0)));
    assert_eq!(found.about.omitted[0].place, "lines 1 to 3");
    let scope = "X,CH1,Start,Increment,\nSequence,Volt,-1.2e-03,2.0e-06,\n0,0.1,\n1,1.1,\n2,2.1,\n";
    let found = of(scope);
    assert_eq!((found.names.join("|"), found.about.step_s), ("X|CH1 [V]|".into(), Some(2e-6)));
    let marked = ";Device,M2K\n;Sample rate,100000\nSample,Time(S),CH1(V)\n0,0.00000,0.1\n1,0.00001,1.1\n";
    let found = of(marked);
    assert_eq!((found.names.join("|"), found.first), ("Sample|Time(S)|CH1(V)".into(), 3));
    let labview = "LabVIEW Measurement\t\nDelta_X\t0.001\n***End_of_Header***\t\nX_Value\tVoltage\tComment\n0.000\t1.5\n0.001\t2.5\n0.002\t3.5\n";
    let found = of(labview);
    assert_eq!((found.names.join("|"), found.first), ("X_Value|Voltage".into(), 4));
}

#[test]
fn times_are_told_by_their_cells_and_steps() {
    let clocks = |text: &str| {
        let found = of(text);
        (found.about.clocks.clone(), found.about.notes.len())
    };
    assert_eq!(clocks("Datum;t_s;i\n26.10.2022 08:17:00;0,000;0,5\n26.10.2022 08:17:01;0,001;1,5\n"), (vec![0], 0));
    assert_eq!(clocks("time,i\n1764200000.00000,1\n1764200000.00005,2\n"), (vec![0], 0));
    assert_eq!(clocks("timestamp,i\n123456789,1\n123457039,2\n"), (vec![0], 1));
    assert_eq!(clocks("time_ns,i\n1764200000000000000,1\n1764200000000250000,2\n"), (vec![0], 0));
    assert_eq!(clocks("t_s,i\n0.000,1\n0.001,2\n"), (vec![], 0));
    assert_eq!(of("time,i\n0,1\n1,2\n2,5\n").about.counters, [0]);
    let rising: String = (0..20).map(|k| format!("{}.{},7\n", 3104 + k / 10, k % 10)).collect();
    assert_eq!(clocks(&rising), (vec![0], 1));
}

/// What the content does not tell is given: rows before the header, names and units that look like others, a rare
/// separator, marks between thousands.
#[test]
fn what_is_given_is_not_guessed() {
    let form = |skip: usize, units_row: bool, separator: &str, decimal: Option<Decimal>| TextForm {
        skip: Some(skip).filter(|skip| *skip > 0),
        units_row,
        separator: separator.parse().ok(),
        decimal,
    };
    let numbers = "3,17\n4,18\n5,19\nt,i\n0,1\n1,2\n2,2\n";
    let own = Layout::of(numbers, &form(3, false, "", None));
    assert_eq!((own.names.join("|"), own.first), ("t|i".into(), 4));
    let units = "7;8\nfoo;bar\n0.5;1\n1.5;2\n2.5;3\n";
    let own = Layout::of(units, &form(0, true, "", None));
    assert_eq!((own.names.join("|"), own.first), ("7|8".into(), 2));
    let own = Layout::of("t~i\n0~1\n1~2\n", &form(0, false, "~", None));
    assert_eq!((own.names.join("|"), own.separator, own.first), ("t|i".into(), b'~', 1));
    let own = Layout::of("t i;n\n0;1\n1;2\n", &form(0, false, ",", None));
    assert_eq!(own.names, ["t i;n"]);
    let thousands = "t;n\n0;2,000\n1;13,000.5\n2;4\n";
    let own = Layout::of(thousands, &form(0, false, "", Some(Decimal::Point)));
    let numbers = ["2,000", "13,000.5", "4", "1,5"].map(|cell| own.number(cell));
    assert_eq!((own.first, numbers), (1, [Some(2000.0), Some(13_000.5), Some(4.0), None]));
    let own = Layout::of("t;n\n0;2,000\n1;3,000\n", &form(0, false, "", Some(Decimal::Comma)));
    assert_eq!(["2,000", "1.000,5"].map(|cell| own.number(cell)), [Some(2.0), Some(1000.5)]);
}
