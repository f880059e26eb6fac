//! Classes, runs and motors by the names of files.

use super::*;

fn written(files: &[&str]) -> (String, Told) {
    let files: Vec<PathBuf> = files.iter().map(PathBuf::from).collect();
    labels(&files, &Naming::of(&files, &files)).expect("labels")
}

fn of(files: &[&str]) -> (Vec<String>, Told) {
    let (text, told) = written(files);
    let class = |line: &str| line.split(',').nth(1).unwrap_or_default().to_string();
    (text.lines().skip(1).map(class).collect(), told)
}

#[test]
fn words_numbers_and_sets_are_told_apart() {
    let files = [
        "Normal_operation_1000.csv",
        "normal_800_1.csv",
        "normal_800_2_test.csv",
        "bad-load_800_1.csv",
        "bad-load_800_2.csv",
    ];
    let (text, told) = written(&files);
    let rows: Vec<&str> = text.lines().collect();
    assert_eq!(told, Told::Names);
    assert_eq!(
        rows[..3],
        ["trace,class_name,n1,n2,set", "Normal_operation_1000,normal,1000,,none", "normal_800_1,normal,800,1,none"]
    );
    assert_eq!(rows[3..5], ["normal_800_2_test,normal,800,2,test", "bad-load_800_1,bad_load,800,1,none"]);
}

#[test]
fn nothing_is_called_healthy_that_no_name_calls_so() {
    assert_eq!(of(&["park_50rpm.csv", "steps_1.csv"]), (vec![REFERENCE.into(); 2], Told::Nothing));
    assert_eq!(of(&["1.csv", "2.csv", "3.csv"]), (vec![REFERENCE.into(); 3], Told::Nothing));
    assert_eq!(of(&["a.csv"]).1, Told::Nothing);
}

#[test]
fn single_records_codes_and_folders_are_classes() {
    let one = of(&["healthy_0_100watt_1.csv", "inner_1.7_100watt_1.csv", "outer_0.7_100watt_1.csv"]);
    assert_eq!(one, (["healthy", "inner", "outer"].map(String::from).to_vec(), Told::Names));
    let codes = of(&["run_A1_01.csv", "run_A1_02.csv", "run_B0_01.csv", "run_B0_02.csv"]);
    assert_eq!(codes, (["a1", "a1", "b0", "b0"].map(String::from).to_vec(), Told::Names));
    let (text, told) = written(&["d/healthy/rec1.csv", "d/outer race/rec1.csv"]);
    assert_eq!(told, Told::Folders);
    assert_eq!(text, "trace,class_name,run,n1\nhealthy/rec1,healthy,rec1,1\nouter race/rec1,outer race,rec1,1\n");
}

#[test]
fn runs_are_told_apart_from_classes() {
    let (text, told) = written(&["gesund_Lauf01_1.csv", "gesund_Lauf01_2.csv", "gesund_Lauf02_1.csv"]);
    assert_eq!(told, Told::Names);
    assert_eq!(
        text,
        "trace,class_name,run,n1,n2\ngesund_Lauf01_1,gesund,Lauf01,01,1\ngesund_Lauf01_2,gesund,Lauf01,01,2\n\
         gesund_Lauf02_1,gesund,Lauf02,02,1\n"
    );
    let (text, _) = written(&["Schaden-Messung 7-a1.csv", "i.O.-Messung 8-a1.csv", "i.O.-Messung 9-a1.csv"]);
    let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
    assert_eq!((rows[0][2], rows[1][1], rows[1][2]), ("run", "schaden", "Messung 7"));
    let signs = written(&["正常_測定1.csv", "正常_測定2.csv", "異常_測定1.csv"]).0;
    assert!(signs.contains("正常_測定1,正常,測定1,") && signs.contains("異常_測定1,異常,測定1,"), "{signs}");
    // Sets are no runs; and runs without words of classes say no class.
    let sets = written(&["ok_train_1.csv", "ok_test_1.csv", "bad_train_1.csv", "bad_test_1.csv"]).0;
    assert!(sets.starts_with("trace,class_name,n1,set\nok_train_1,ok,1,train\n"), "{sets}");
    assert_eq!(of(&["run_1.csv", "run_2.csv", "run_3.csv"]), (vec![REFERENCE.into(); 3], Told::Nothing));
}

#[test]
fn motors_of_one_machine_are_no_classes() {
    for files in [
        ["d/axis1/ok_1.csv", "d/axis1/worn_2.csv", "d/axis2/ok_1.csv", "d/axis2/worn_2.csv"],
        ["d/axis1_ok_1.csv", "d/axis1_worn_2.csv", "d/axis2_ok_1.csv", "d/axis2_worn_2.csv"],
        ["d/ok/axis1-1.csv", "d/worn/axis1-2.csv", "d/ok/axis2-1.csv", "d/worn/axis2-2.csv"],
    ] {
        let (text, _) = written(&files);
        let rows: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').collect()).collect();
        let place = rows[0].iter().position(|name| *name == AXIS).unwrap_or_else(|| panic!("{text}"));
        let mut cells: Vec<[&str; 2]> = rows[1..].iter().map(|row| [row[1], row[place]]).collect();
        cells.sort_unstable();
        assert_eq!(cells, [["ok", "axis1"], ["ok", "axis2"], ["worn", "axis1"], ["worn", "axis2"]], "{text}");
    }
    let (text, told) = written(&["d/J1_01.csv", "d/J1_02.csv", "d/J2_01.csv", "d/J2_02.csv"]);
    assert!(told == Told::Nothing && text.contains("J1_01,reference,J1,"), "{text}");
    assert!(!written(&["motor1_ok_1.csv", "motor1_bad_1.csv"]).0.contains(AXIS));
}

#[test]
fn folders_of_keys_runs_and_conditions_are_told_apart() {
    let (text, told) = written(&[
        "d/class=healthy/run=1/load=2/a.csv",
        "d/class=healthy/run=1/load=3/a.csv",
        "d/class=outer%20race/run=2/load=2/a.csv",
    ]);
    assert_eq!(told, Told::Folders);
    let cells: Vec<Vec<&str>> = text.lines().map(|line| line.split(',').skip(1).collect()).collect();
    assert_eq!(
        cells,
        [["class_name", "run", "load"], ["healthy", "1", "2"], ["healthy", "1", "3"], ["outer race", "2", "2"]]
    );
    // The level with words of health is the class, whatever is around it.
    let around = of(&["d/m1/healthy/800rpm/a.csv", "d/m1/worn/800rpm/a.csv", "d/m2/worn/900rpm/a.csv"]);
    assert_eq!(around, (["healthy", "worn", "worn"].map(String::from).to_vec(), Told::Folders));
    // Numbers of recordings start again in each folder, and the machines are a column.
    let (text, _) = written(&["d/m1/ok/rec1.csv", "d/m1/worn/rec1.csv", "d/m2/ok/rec1.csv", "d/m2/worn/rec1.csv"]);
    assert!(text.starts_with("trace,class_name,run,folder1,n1\nm1/ok/rec1,ok,m1/ok/rec1,m1,1\n"), "{text}");
    // Runs are no classes: those are in the names.
    let (text, told) = written(&["d/run_1/gut_a.csv", "d/run_2/gut_b.csv", "d/run_2/nio_a.csv"]);
    assert_eq!(told, Told::Names);
    assert!(text.contains("gut_a,gut,run_1") && text.contains("nio_a,nio,run_2"), "{text}");
    let (_, told) = written(&["d/class_a/healthy_mix_1_000.csv", "d/class_a/run_1/healthy_mix_1_001.csv"]);
    assert_eq!(told, Told::Names);
    // Beside folders a file says its class itself, or has none.
    let (all, _) = of(&["d/healthy_3.csv", "d/7.csv", "d/outer/1.csv", "d/outer/2.csv"]);
    assert_eq!((all[1].as_str(), all[2].as_str()), (UNNAMED, "outer"));
    assert_eq!(of(&["d/sound_3.csv", "d/Sound/1.csv", "d/outer/2.csv"]).0[0], "Sound");
}
