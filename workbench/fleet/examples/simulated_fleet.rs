//! Simulates a fleet as features, to measure training from them.
//!
//! `simulated_fleet DRIVES SEGMENTS PARTS SEED DIR` writes parts of drives with so many segments each, in ten runs.
//! Eight of ten drives are healthy, one has a spall, one lost its lubrication. Drives and runs have offsets. The
//! detector and the classes are those of the DC rig, so that a model of the fleet runs on its traces.

#[path = "../tests/fleet/simulated.rs"]
mod simulated;

use std::error::Error;
use std::path::Path;

use bearing_watch_fleet::Writer;
use rayon::prelude::*;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [drives, segments, parts, seed, folder] = &arguments[..] else {
        return Err("usage: simulated_fleet DRIVES SEGMENTS PARTS SEED DIR".into());
    };
    let (drives, parts): (u64, u64) = (drives.parse()?, parts.parse()?);
    let fleet = simulated::Fleet::new(segments.parse()?, 10, seed.parse()?)?;
    std::fs::create_dir_all(folder)?;
    let write = |part: u64| {
        let path = Path::new(folder).join(format!("part{part:03}.parquet"));
        let file = std::fs::File::create(&path).map_err(model::Error::io(&path))?;
        let mut writer = Writer::new(file, &path, &fleet.plan, &[])?;
        for drive in part * drives / parts..(part + 1) * drives / parts {
            fleet.drive(drive).try_for_each(|row| writer.add(row))?;
        }
        writer.finish().map(drop)
    };
    (0..parts).into_par_iter().try_for_each(write)?;
    Ok(())
}
