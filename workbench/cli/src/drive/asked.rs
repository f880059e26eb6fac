//! What `init` is asked for.

use std::path::PathBuf;

use crate::jobs::Init;
use crate::options::Taken;

/// Write drive.toml: columns, rate, labels and likely channels, by looking at the files
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Example:\n  bearing-watch init recordings\n  bearing-watch train recordings/drive.toml --model m.bwm"
)]
pub(crate) struct Args {
    #[command(flatten)]
    pub(crate) taken: Taken<Init>,
    /// Labels, if they are not the labels.csv beside the traces
    #[arg(long, value_name = "FILE")]
    pub(super) labels: Option<PathBuf>,
    /// Where labels are written if there are none; by default labels.csv beside the drive file. The words of a file's
    /// name are its class: unbalanced_800_3.csv is unbalanced. If no two classes follow, all files are healthy
    #[arg(long, value_name = "FILE", conflicts_with = "labels")]
    pub(super) labels_from_names: Option<PathBuf>,
    /// The file; by default drive.toml in the folder of the first trace, or here if that cannot be written
    #[arg(long, value_name = "FILE")]
    pub(super) out: Option<PathBuf>,
    /// Replace the file if it exists
    #[arg(long)]
    pub(super) force: bool,
}
