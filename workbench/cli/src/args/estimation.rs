//! Arguments of the core's estimator.

use bearing_watch::model::MAX_LONG_SEGMENT_ROWS;
use bearing_watch::plan::Method as CoreMethod;
use clap::{Args, ValueEnum};

use model::Error;
use model::identify::Structure;
use model::train::Estimation;

/// Settings of the detector's estimator.
#[derive(Clone, Debug, Args)]
pub(crate) struct EstimationArgs {
    /// How the detector estimates a segment's parameters
    #[arg(long, value_enum, default_value = "ls")]
    pub(crate) method: Method,
    /// The class whose mean is the nominal model, the starting point of the estimation; the healthy
    /// class if not given, or else the first
    #[arg(long, value_name = "CLASS")]
    nominal: Option<String>,
    /// Samples per segment (after averaging and decimation); the longest training trace if not given
    #[arg(long, value_name = "N")]
    segment: Option<usize>,
    /// Residuals beyond K standard deviations get less weight; 0 for none
    #[arg(long, value_name = "K", default_value_t = 0.0)]
    huber: f64,
    /// Magnitudes at which the sensors of y, u1, u2 are saturated: samples at or above them are not used
    #[arg(long, value_name = "Y,U1,U2", value_delimiter = ',')]
    saturation: Vec<f64>,
    /// Number of equal samples of y in a row that indicates a stuck sensor; the segment then has no verdict; 0 for no
    /// limit
    #[arg(long, value_name = "N", default_value_t = 0)]
    stuck: u16,
    /// Forgetting factor per sample (0.5 to 0.9999), instead of a new start at every segment
    #[arg(long, value_name = "FACTOR")]
    memory: Option<f64>,
    /// Samples into the next segment at which a segment's model takes over, for firmware that solves in its main loop
    #[arg(long, value_name = "N", default_value_t = 0)]
    handover: u16,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Least squares: cheapest, biased by output noise
    Ls,
    /// Streaming instrumental variables: consistent under output noise
    Instruments,
}

impl Method {
    pub(crate) const fn core(self) -> CoreMethod {
        match self {
            Self::Ls => CoreMethod::LeastSquares,
            Self::Instruments => CoreMethod::Instruments,
        }
    }
}

impl EstimationArgs {
    /// The length of a segment, if it is given.
    pub(crate) const fn segment(&self) -> Option<usize> {
        self.segment
    }

    /// `healthy` is the index of the healthy class, if there is one.
    pub(crate) fn estimation(
        &self,
        structure: Structure,
        classes: &[String],
        healthy: Option<usize>,
    ) -> Result<Estimation, Error> {
        let method = self.method.core();
        if let Some(segment) = self.segment {
            let outputs = if self.method == Method::Instruments { structure.na as usize } else { 0 };
            let least = structure.depth() + structure.parameters() + outputs + 2;
            if segment < least || segment > MAX_LONG_SEGMENT_ROWS as usize {
                let problem = format!("--segment {segment}: at this order it is {least} to {MAX_LONG_SEGMENT_ROWS}");
                return Err(Error::Usage(problem));
            }
        }
        let saturation = match self.saturation[..] {
            [] => None,
            [y, u1, u2] => Some([y, u1, u2]),
            _ => return Err(Error::Usage("--saturation: three magnitudes Y,U1,U2, e.g. 20,300,5".into())),
        };
        let nominal = match &self.nominal {
            None => healthy.unwrap_or(0),
            Some(name) => classes.iter().position(|class| class == name).ok_or_else(|| {
                Error::Usage(format!("--nominal: unknown class {name}; there are {}", classes.join(", ")))
            })?,
        };
        Ok(Estimation {
            method,
            nominal,
            segment: self.segment,
            huber: self.huber,
            saturation,
            stuck: self.stuck,
            memory: self.memory,
            handover: self.handover,
        })
    }
}
