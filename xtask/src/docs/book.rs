//! The pictures of the book: one of each kind of plot, from traces that the workbench simulates.
//!
//! Enters: the binary `bearing-watch`. Leaves: pictures in `book/src/pictures`, and the block with the commands that
//! made their pages.

use std::fs;
use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use super::block::Block;
use super::picture;
use crate::{child, workspace};

/// The name of the block.
pub const NAME: &str = "book";
/// The chapter that shows the pictures.
const CHAPTER: &str = "book/src/plots.md";

/// What all commands have that identify: the current, the error of the velocity and the load.
const CHANNELS: &str = "--y current_a --u1 velocity_ref_rad_s-velocity_rad_s --u2 load_torque_nm";

/// The commands in their order; `CHANNELS` stands for [`CHANNELS`].
const COMMANDS: [&str; 12] = [
    "simulate --class healthy,spall --count 1 --seed 3 --condition duty-constant --out constant",
    "simulate --class healthy --count 60 --seed 1 --condition mix --out bench",
    "simulate --class spall,roughness --count 24 --seed 1 --condition mix --severity 0.5 --out bench",
    "simulate --class healthy,spall,roughness --count 24 --seed 2 --condition mix --severity 0.5 --out bench",
    "simulate --class healthy --count 8 --seed 4 --condition mix --out later",
    "simulate --class spall --count 8 --seed 4 --condition mix --severity 0.08 --out later",
    "audit constant --report audit.html",
    "structure bench/healthy_mix_1_000.csv bench/healthy_mix_1_001.csv CHANNELS --max 3,3,3,2,2 --compare 2,2,2,1,1 \
     --report structure.html",
    "validate bench/healthy_mix_1_001.csv CHANNELS --order 3,2,3,1,1 --method oe --report validate.html",
    "train --labels bench/labels.csv --train-where seed=1 --test-where seed=2 --y current_a --u1 velocity_ref_rad_s \
     --u2 load_torque_nm --order 2,1,2,1,1 --features a --discriminant quadratic --model a.bwm --report train.html",
    "train --labels bench/labels.csv --train-where seed=1 --classes healthy --y current_a --u1 velocity_ref_rad_s \
     --u2 load_torque_nm --order 2,1,2,1,1 --angle angle_rad --velocity velocity_rad_s --load load_torque_nm \
     --bearing 9,3,17,10 --features inverse_kt,drag_log,order_outer --rising drag_log --model gate.bwm",
    "replay --model gate.bwm later --report replay.html",
];

/// Page, start of the figure's title, and picture.
const PICTURES: [(&str, &str, &str); 15] = [
    ("audit", "Signals", "signals"),
    ("audit", "Amplitude of the current", "orders"),
    ("structure", "Free-run fit on the validation traces", "fit"),
    ("validate", "Output from the inputs alone", "free-run"),
    ("validate", "Cross-correlation of the residuals", "independence"),
    ("validate", "Autocorrelation of the residuals", "whiteness"),
    ("validate", "Poles and zeros", "poles"),
    ("validate", "Frequency response from u2", "frequency"),
    ("train", "Distribution of a1", "distribution"),
    ("train", "Features in the plane", "regions"),
    ("train", "Features over runs", "runs"),
    ("train", "Posterior of each segment", "posteriors"),
    ("train", "Posteriors beside what came true", "reliability"),
    ("replay", "Signals and verdicts", "verdicts"),
    ("replay", "Distance and evidence", "evidence"),
];

/// Simulates, trains, and saves the pictures; the block with the commands.
pub fn blocks() -> Result<Vec<Block>> {
    let folder = workspace::target_dir().join("book-pages");
    if folder.exists() {
        fs::remove_dir_all(&folder)?;
    }
    fs::create_dir_all(&folder).with_context(|| format!("cannot create {}", folder.display()))?;
    child::succeed(&mut workspace::cargo(&["build", "--release", "--quiet", "-p", "bearing-watch-workbench"]))?;
    let program = workspace::target_dir().join("release/bearing-watch");
    for command in COMMANDS {
        let mut workbench = Command::new(&program);
        let status = child::lines(workbench.args(arguments(command)).current_dir(&folder), |_| ())?;
        // An audit that has found something ends with 1.
        ensure!(status.code().is_some_and(|code| code < 2), "bearing-watch {command}: {status}");
    }
    for (page, title, name) in PICTURES {
        picture::save(&folder.join(page).with_extension("html"), title, &format!("book/src/pictures/{name}.svg"))?;
    }
    remove(&folder)?;
    Ok(vec![Block::new(CHAPTER, NAME, &shown())])
}

/// The traces take tens of megabytes.
fn remove(folder: &Path) -> Result<()> {
    fs::remove_dir_all(folder).with_context(|| format!("cannot remove {}", folder.display()))
}

fn arguments(command: &str) -> Vec<String> {
    command.replace("CHANNELS", CHANNELS).split_whitespace().map(ToOwned::to_owned).collect()
}

/// The commands as a shell takes them, in lines of at most 100 characters.
fn shown() -> String {
    let mut text = String::from("```sh\n");
    for command in COMMANDS {
        let mut width = 0;
        for (place, word) in ["bearing-watch".to_owned()].into_iter().chain(arguments(command)).enumerate() {
            if place > 0 && width + word.len() > 100 {
                text += " \\\n   ";
                width = 3;
            }
            text += if place > 0 { " " } else { "" };
            text += &word;
            width += word.len() + 1;
        }
        text.push('\n');
    }
    text + "```"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_picture_of_the_chapter_is_made_and_every_page_is_written() -> Result<()> {
        let chapter = fs::read_to_string(workspace::root().join(CHAPTER))?;
        let shown = chapter.lines().filter(|line| line.contains("](pictures/")).count();
        assert_eq!(shown, PICTURES.len());
        for (page, title, name) in PICTURES {
            assert!(chapter.contains(&format!("](pictures/{name}.svg)")), "{name} is not shown");
            assert!(COMMANDS.iter().any(|command| command.ends_with(&format!("--report {page}.html"))), "{title}");
        }
        Ok(())
    }

    #[test]
    fn the_chapter_has_the_commands() -> Result<()> {
        let chapter = fs::read_to_string(workspace::root().join(CHAPTER))?;
        assert!(chapter.contains(&shown()), "run `cargo xtask docs book`");
        Ok(())
    }
}
