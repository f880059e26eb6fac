//! The doors of the workbench: files of any bytes are read, or refused with a message; requests and lines are answered.
//!
//! A reader may neither panic nor hang, nor take much more memory than the file: the binary limits it
//! ([`crate::memory::LIMIT`]), and libFuzzer the time.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use fleet::Wanted;
use model::session::{Log, ModelFile, Quiet, Session};
use model::settings::DriveFile;
use model::trace::{Channels, FrontEndFile};
use traces::given::{Memory, given};

use crate::Door;
use crate::input::Input;
use crate::{checksum, served};

/// The doors.
pub static DOORS: [Door; 13] = [
    Door::new("text", "tables of text", |bytes| table("t.csv", bytes)),
    Door::new("packed", "tables of text, with gzip or zstd", |bytes| table("t.csv.gz", bytes)),
    Door::new("matlab", "MATLAB 5 to 7.3", |bytes| table("t.mat", bytes)),
    Door::new("hdf5", "HDF5", |bytes| table("t.h5", bytes)),
    Door::new("parquet", "Parquet, of traces and of features", parquet),
    Door::new("arrow", "Arrow's files", |bytes| table("t.arrow", bytes)),
    Door::new("numpy", "archives of NumPy", |bytes| table("t.npz", bytes)),
    Door::new("labels", "labels", labels),
    Door::new("settings", "drive.toml and TOML of a front end", settings),
    Door::new("model-file", "a model with its notes", model_file),
    Door::new("http", "requests to the pages of view", served::request),
    Door::new("listen", "the line of listen", served::line),
    Door::new("can-log", "logs of a CAN bus", served::can_log),
];

thread_local! {
    /// A folder of this thread, in memory where the system has such files.
    static FOLDER: RefCell<Option<PathBuf>> = const { RefCell::new(None) };
}

/// The folder of this thread.
pub(crate) fn folder() -> PathBuf {
    FOLDER.with_borrow_mut(|folder| {
        let make = || {
            let root = Path::new("/dev/shm");
            let root = if root.is_dir() { root.to_path_buf() } else { std::env::temp_dir() };
            let own = format!("attack-{}-{:?}", std::process::id(), std::thread::current().id());
            let own = root.join(own.replace(['(', ')'], ""));
            std::fs::create_dir_all(&own).expect("a folder for files");
            own
        };
        folder.get_or_insert_with(make).clone()
    })
}

/// Writes bytes to a file of this name.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder().join(name);
    std::fs::write(&path, bytes).expect("a file of the attack");
    path
}

/// Reads a table: with the columns of the seeds, and with those of a shaft.
fn table(name: &str, bytes: &[u8]) {
    let paths = [file(name, bytes)];
    let mut channels = Channels::new("a", "b-c", "c");
    match traces::read(&paths, &channels) {
        Ok(traces) => {
            for trace in traces {
                assert_eq!((trace.y.len(), trace.u1.len()), (trace.u2.len(), trace.u2.len()));
                let all = [&trace.y, &trace.u1, &trace.u2];
                assert!(all.iter().all(|column| column.iter().all(|x| !x.is_infinite())), "finite or missing");
                assert!(all.iter().all(|column| column.iter().any(|x| x.is_finite())), "some number in each");
            }
        }
        Err(error) => assert!(!error.to_string().is_empty(), "a message"),
    }
    channels.time = Some("none".into());
    let _refused = traces::read(&paths, &channels);
}

fn parquet(bytes: &[u8]) {
    table("t.parquet", bytes);
    let path = file("part.parquet", bytes);
    let Ok(part) = fleet::Part::open(&path) else { return };
    let columns: Vec<String> = part.columns().iter().map(ToString::to_string).collect();
    for group in 0..part.row_groups().min(8) {
        let _bounds = part.bounds(group);
    }
    let wanted = Wanted { features: part.plan.features.clone(), ..Wanted::default() };
    let _refused = fleet::fold(&[part], &wanted, &|_| ());
    assert!(columns.len() < 1 << 20);
}

fn labels(bytes: &[u8]) {
    if let Ok(labels) = traces::read_labels(&file("labels.csv", bytes)) {
        assert!(labels.columns().iter().any(|column| column == "trace"));
        let _count = labels.count("healthy");
    }
}

/// Settings for a training without any trace, and a front end.
fn settings(bytes: &[u8]) {
    let _refused = FrontEndFile::read(&file("front_end.toml", bytes));
    let trained = DriveFile::read(&file("drive.toml", bytes)).and_then(|drive| {
        let given = given(&drive.settings, Memory { traces: Some(vec![]), labels: None })?;
        Session::new(drive.settings, given, Some(drive.text))?.train(&Log::new(&Quiet))
    });
    assert!(trained.is_err(), "there is nothing to train on");
}

/// The bytes of a model file, as they are or under a right checksum.
fn model_file(bytes: &[u8]) {
    let mut input = Input::new(bytes);
    let mut model = if input.byte().is_multiple_of(2) {
        input.bytes(usize::MAX).to_vec()
    } else {
        let mut model = FILE.to_vec();
        for _ in 0..=input.byte() % 8 {
            let place = usize::from(input.half()) % model.len();
            model[place] = input.byte();
        }
        model
    };
    checksum::put(&mut model);
    let Ok(model) = ModelFile::new(Path::new("m.bwm"), &model) else { return };
    let _header = model.c_header(None);
    let _reason = model.refuses_pieces();
    let _preparation = model.preparation();
    let named = model.features().len() + model.orders().len() + model.trained_on().len();
    assert!(named < 1 << 20);
}

/// A model file of the command line.
static FILE: &[u8] = include_bytes!("../../examples/support/standard_rig/model.bwm");
