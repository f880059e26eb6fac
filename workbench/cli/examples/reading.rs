//! The workbench's part of the comparison of readers in `cargo xtask docs peers`: `reading FILE ROUNDS` reads every
//! column of a recording as `xtask/peers/reading.py` writes it, and prints the median time in seconds and a sum of the
//! values. Its allocator is that of the `bearing-watch` command.

use std::error::Error;
use std::path::PathBuf;
use std::time::Instant;

use model::trace::Channels;
use traces::read;

#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [file, rounds] = &arguments[..] else { return Err("usage: reading FILE ROUNDS".into()) };
    let further = ["voltage_v", "temperature_c", "angle_rad"].map(String::from).to_vec();
    let channels = Channels { further, ..Channels::new("current_a", "velocity_rad_s", "load_torque_nm") };
    let (mut times, mut sum) = (vec![], 0.0);
    for _ in 0..rounds.parse::<usize>()? {
        let start = Instant::now();
        let traces = read(&[PathBuf::from(file)], &channels)?;
        times.push(start.elapsed().as_secs_f64());
        let columns = [&traces[0].y, &traces[0].u1, &traces[0].u2].into_iter().chain(&traces[0].further);
        sum = columns.flatten().sum();
    }
    times.sort_by(f64::total_cmp);
    println!("{} {sum}", times[times.len() / 2]);
    Ok(())
}
