mod laboratory;
mod layout;

use super::*;
use crate::table::Table;

fn table(name: &str, content: &[u8]) -> Result<(Vec<String>, Columns), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, content).expect("writable");
    let table = Table::open(&path).map_err(|error| error.to_string())?;
    let numbers: Vec<usize> = (0..table.names().len()).collect();
    let wanted = Wanted { numbers: &numbers, text: None, row: &|_| true };
    let columns = table.read(wanted).map_err(|error| error.to_string())?;
    Ok((table.names().to_vec(), columns))
}

#[test]
fn the_same_numbers_in_every_layout() {
    let layouts = [
        ("a.csv", "t,i\n0.5,-1\n1.5,2e-3\n"),
        ("a.csv", "\u{feff}t;i\r\n0,5;-1\r\n1,5;2e-3\r\n"),
        ("a.tsv", "t\ti\n0.5\t-1\n1.5\t0.002\n"),
        ("a.txt", "  t   i \n 0.5  -1\n1.5 \t 0.002  \n"),
        ("a.dat", "# logger\n# t i\n0.5 -1\n1.5 0.002\n"),
        ("a.csv", "% logger\nt|i\n0.5|-1\n\n% gap\n1.5|0.002\n"),
    ];
    for (name, text) in layouts {
        let (names, columns) = table(name, text.as_bytes()).expect(text);
        assert_eq!(names, ["t", "i"], "{text}");
        assert_eq!(columns.numbers, [vec![0.5, 1.5], vec![-1.0, 0.002]], "{text}");
    }
    let (names, columns) = table("a.csv", b"1,2\n3,4\n").expect("without a header");
    assert_eq!((names, columns.numbers[0].len()), (vec!["c1".to_string(), "c2".into()], 2));
}

#[test]
fn words_behind_the_rows_are_left_out_and_archives_are_told() {
    let (_, columns) = table("a.txt", b" t | i\n---+---\n 0.5 | 1\n 1.5 | 2\n(2 rows)\n\n").expect("a table");
    assert_eq!(columns.numbers, [[0.5, 1.5], [1.0, 2.0]]);
    let inside = table("a.csv", b"t,i\n0.5,1\n1.5,1\n2.5,1\nbuffer overrun\n3.5,2\n").expect_err("inside");
    assert!(inside.contains("line 5: 1 cells"), "{inside}");
    assert!(table("a.csv", b"PK\x03\x04....").expect_err("packed").contains("a ZIP archive; unpack it"));
}

/// A large file is read in pieces, and as one text if it has to be; the numbers and messages are the same.
#[test]
fn large_files_are_read_like_small_ones() {
    let rows: String = (0..400_000).map(|k| format!("{k},{}.25\n", k % 97)).collect();
    assert!(rows.len() as u64 > LARGE);
    for (head, count) in [("# a logger\nt,i\n", 400_000), ("t,i\n1,\"2\"\n", 400_001)] {
        let (names, columns) = table("a.csv", format!("{head}{rows}").as_bytes()).expect("good");
        assert_eq!((names, columns.numbers[0].len()), (vec!["t".to_string(), "i".into()], count));
        assert_eq!((columns.numbers[0][count - 1], columns.numbers[1][count - 1]), (399_999.0, 68.25));
        assert_eq!(columns.lines.of(count - 1), Some(400_002));
        let wrong = format!("{head}{rows}1,2\n3,x\n");
        let message = table("a.csv", wrong.as_bytes()).expect_err("a word");
        assert!(message.contains("line 400004, column i: \"x\" is not a number"), "{message}");
    }
    let mut bytes = format!("t,i\n{rows}").into_bytes();
    bytes[5_000_000] = 0xb0;
    assert!(table("a.csv", &bytes).expect_err("a degree in a number").contains("°"));
}

#[test]
fn compressed_text_is_unpacked_and_broken_text_refused() {
    use std::io::Write as _;
    let text = b"t,i\n0.5,-1\n";
    let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    gzip.write_all(text).expect("in memory");
    let packed = gzip.finish().expect("in memory");
    assert_eq!(table("a.csv.gz", &packed).expect("gzip").1.numbers[1], [-1.0]);
    let zst = zstd::encode_all(&text[..], 1).expect("in memory");
    assert_eq!(table("a.csv.zst", &zst).expect("zstd").1.numbers[0], [0.5]);
    assert!(table("a.csv.gz", &packed[..packed.len() - 9]).expect_err("cut").contains("cannot be unpacked"));
    assert_eq!(table("a.csv", b"t,\xb0C\n1,2\n").expect("Latin-1").0, ["t", "°C"]);
    let wrong = table("a.csv", b"# note\nt;i\n0,5;1\n0,6;x\n").expect_err("a word");
    assert!(wrong.contains("line 4, column i: \"x\" is not a number"), "{wrong}");
}

#[test]
fn records_of_json_are_named() {
    for text in
        ["{\"t\": 0.0, \"i\": 1.5}\n{\"t\": 0.1, \"i\": 1.6}\n", "\n[{\"t\": 0.0}]\n", "{\n  \"rows\": [[0, 1]]\n}\n"]
    {
        let refused = table("a.csv", text.as_bytes()).map(drop).expect_err(text);
        assert!(refused.contains("JSON; write its records as CSV"), "{refused}");
    }
}
