//! The batch estimators: traces, and the model that is estimated on each.

use std::path::PathBuf;

use clap::Args;

use crate::command_line::jobs::Fit;
use crate::command_line::options::Taken;
use crate::command_line::output;
use crate::recordings::reading::read_with_gaps;
use model::Error;
use model::identify::{Estimate, Method, Options, Structure, estimate_with, robust};
use model::trace::{Channels, FrontEndFile, Preparation, Trace};
use model::validate::is_white;

/// The estimator of a difference model.
#[derive(Clone, Debug, Args)]
pub(crate) struct MethodArgs {
    /// Estimator
    #[arg(long, value_enum, default_value = "ls")]
    pub(crate) method: Method,
    /// The command of the loop, for --method iv-command: a column or a formula
    #[arg(long, value_name = "CHANNEL", required_if_eq("method", "iv-command"))]
    instruments: Option<String>,
    /// Standard deviations of --method ls that allow for coloured residuals
    #[arg(long)]
    robust: bool,
}

/// Traces, and the model that is estimated on each.
#[derive(Clone, Debug, Args)]
pub(crate) struct FitArgs {
    #[command(flatten)]
    pub(crate) taken: Taken<Fit>,
    #[command(flatten)]
    pub(crate) method: MethodArgs,
}

impl FitArgs {
    /// Checks the settings and the output, and reads the traces.
    pub(crate) fn read(&self, output: Option<&PathBuf>) -> Result<(Vec<Trace>, Preparation), Error> {
        let settings = &self.taken.settings;
        settings.channels.require(self.structure()?)?;
        let preparation = settings.model.preparation()?;
        output::plan(&output.map(PathBuf::as_path).into_iter().collect::<Vec<_>>(), &settings.data.traces)?;
        let front_end = settings.data.front_end.as_deref().map(FrontEndFile::read).transpose()?;
        let channels = self.method.with_command(settings.channels(front_end)?)?;
        Ok((read_with_gaps(&settings.data.traces, &channels)?, preparation))
    }

    /// The structure of the models.
    pub(crate) fn structure(&self) -> Result<Structure, Error> {
        self.taken.settings.model.structure()
    }
}

impl MethodArgs {
    /// Adds the command to the channels.
    fn with_command(&self, channels: Channels) -> Result<Channels, Error> {
        match (&self.instruments, self.method) {
            (Some(command), Method::IvCommand) => Ok(Channels { further: vec![command.clone()], ..channels }),
            (Some(_), _) => Err(Error::Usage("--instruments goes with --method iv-command".into())),
            (None, _) => Ok(channels),
        }
    }

    pub(crate) fn estimate(&self, trace: &Trace, structure: Structure, options: Options) -> Result<Estimate, Error> {
        if self.robust && self.method != Method::Ls {
            let problem = match self.method {
                Method::Iv | Method::IvCommand => "those of iv and iv-command allow for coloured residuals anyway",
                _ => "the other methods model the noise: choose the method whose noise fits, or iv",
            };
            return Err(Error::Usage(format!("--robust goes with --method ls; {problem}")));
        }
        let estimate = estimate_with(trace, structure, self.method, options)?;
        if self.robust { robust(trace, estimate) } else { Ok(estimate) }
    }

    /// Warns of estimates whose standard deviations rest on white residuals that are coloured.
    pub(crate) fn warn_of_colour<'a>(&self, estimates: impl Iterator<Item = (&'a str, &'a Estimate)> + Clone) {
        let remedy = match self.method {
            Method::Iv | Method::IvCommand => return,
            Method::Ls if self.robust => "they bias least squares: use --method iv or iv-command, or a higher order",
            Method::Ls => "the standard deviations are wrong: use --robust, --method iv, or a higher order",
            _ => "the standard deviations are wrong: use a higher order, or another --method",
        };
        let coloured = estimates.clone().filter(|(_, estimate)| !is_white(&estimate.residuals));
        if let Some((first, _)) = coloured.clone().next() {
            let (count, of) = (coloured.count(), estimates.count());
            output::warn(format!("the residuals of {count} of {of} models are coloured, first {first}; {remedy}"));
        }
    }
}
