//! Records the drive on this computer, as its engineers would over their debugger: counts of the converters at the rate
//! of the current loop, a file a record. `cargo run --release --example record -- FOLDER SECONDS COUNT`

use std::fs::{self, File};
use std::io::{self, BufWriter, Write as _};
use std::path::Path;
use std::{env, process};

use drive_foc::{Drive, Duty, RATE_HZ};

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        process::exit(1);
    }
}

fn run() -> io::Result<()> {
    let arguments: Vec<String> = env::args().skip(1).collect();
    let [folder, seconds, count] = &arguments[..] else {
        return Err(io::Error::other("usage: record FOLDER SECONDS COUNT"));
    };
    let number = |text: &str| text.parse::<u32>().map_err(|_| io::Error::other(format!("{text} is no number")));
    let (rows, count) = (number(seconds)? * RATE_HZ as u32, number(count)?);
    for (class, spall_nm, seed) in [("healthy", 0.0, 1000), ("spall", 0.02, 5000)] {
        let folder = Path::new(folder).join(class);
        fs::create_dir_all(&folder)?;
        for k in 0..count {
            let drive = Drive::new(Duty { seed: seed + k, spall_nm });
            record(drive, rows, &folder.join(format!("{class}_{k}.csv")))?;
        }
    }
    Ok(())
}

fn record(mut drive: Drive, rows: u32, path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    writeln!(file, "t_s,adc_a,adc_b,encoder,velocity_ref_rad_s")?;
    for k in 0..rows {
        let counts = drive.step();
        let [a, b] = counts.phases;
        let t_s = f64::from(k) / f64::from(RATE_HZ);
        writeln!(file, "{t_s:.6},{a},{b},{},{:.4}", counts.encoder, counts.velocity_ref_rad_s)?;
    }
    file.flush()
}
