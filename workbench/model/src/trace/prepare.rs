//! From the recorded rate to the rate of identification: block means, then decimation; also resampling from irregular
//! to regular times.

use super::Trace;
use crate::Error;

/// Processing of a trace before identification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Preparation {
    /// First step: non-overlapping means of this number of samples; 1 for none.
    pub block_mean: usize,
    /// Second step: every n-th sample after a zero-phase anti-alias filter; 1 for none.
    pub decimate: usize,
}

impl Preparation {
    /// Signals as recorded.
    pub const NONE: Self = Self { block_mean: 1, decimate: 1 };

    /// Number of recorded samples per prepared sample.
    ///
    /// # Errors
    /// A factor of zero, or a product of both factors above 1 000 000.
    pub fn factor(&self) -> Result<usize, Error> {
        let factor = self.block_mean.checked_mul(self.decimate).filter(|&factor| factor <= 1_000_000);
        match factor {
            Some(factor @ 1..) => Ok(factor),
            _ => Err(Error::Usage(
                "--block-mean and --decimate take whole numbers from 1, together up to 1000000".into(),
            )),
        }
    }

    /// Prepares a trace. A prepared sample is missing if one of the samples is that it is made of.
    ///
    /// # Errors
    /// A factor of zero, or a trace that is too short, or lacks too much, for one prepared sample.
    pub fn apply(&self, trace: &Trace) -> Result<Trace, Error> {
        let factor = self.factor()?;
        if self.decimate > 1 && trace.motion.is_some() {
            return Err(Error::Usage(
                "--decimate does not go with the shaft's channels: an angle must not be filtered; record at the wanted rate".into(),
            ));
        }
        if trace.y.len() < factor {
            let problem = format!("{} samples are fewer than one block of {factor}", trace.y.len());
            return Err(Error::trace(&trace.id, problem));
        }
        let prepare = |x: &[f64]| decimate(&block_mean(x, self.block_mean), self.decimate);
        let y = prepare(&trace.y);
        if y.iter().all(|x| x.is_nan()) && trace.y.iter().any(|x| x.is_finite()) {
            let problem = format!(
                "no sample is left by --block-mean and --decimate: each is made of samples of which some are missing ({}); \
                 use --block-mean alone, a lower factor, or resample the recording",
                trace.missing.words()
            );
            return Err(Error::trace(&trace.id, problem));
        }
        Ok(Trace {
            id: trace.id.clone(),
            interval_s: trace.interval_s.map(|step| step * factor as f64),
            irregular_steps: trace.irregular_steps,
            y,
            u1: prepare(&trace.u1),
            u2: prepare(&trace.u2),
            motion: if factor == 1 { trace.motion.clone() } else { None },
            further: trace.further.iter().map(|x| prepare(x)).collect(),
            refused: trace.refused,
            missing: trace.missing,
            found_late: trace.found_late.iter().map(|row| row / factor).collect(),
            wiring: trace.wiring.iter().map(|(row, known)| (row / factor, *known)).collect(),
        })
    }
}

/// Means of complete blocks; a last partial block is dropped, as in the core.
fn block_mean(x: &[f64], block: usize) -> Vec<f64> {
    x.chunks_exact(block).map(|chunk| chunk.iter().sum::<f64>() / block as f64).collect()
}

/// Every `factor`-th sample after a linear-phase FIR filter whose delay is compensated. Ends are extended by point
/// reflection, so that a ramp remains a ramp.
#[must_use]
pub fn decimate(x: &[f64], factor: usize) -> Vec<f64> {
    if factor == 1 {
        return x.to_vec();
    }
    let taps = anti_alias(factor);
    let half = (taps.len() / 2) as isize;
    let last = x.len() as isize - 1;
    let at = |k: isize| -> f64 {
        if k < 0 {
            2.0 * x[0] - x[(-k).min(last) as usize]
        } else if k > last {
            2.0 * x[last as usize] - x[(2 * last - k).max(0) as usize]
        } else {
            x[k as usize]
        }
    };
    let centres = (0..=last).step_by(factor);
    centres.map(|centre| taps.iter().enumerate().map(|(k, tap)| tap * at(centre + k as isize - half)).sum()).collect()
}

/// Linear interpolation from irregular times to a constant rate, starting at the first time.
///
/// Interpolation does not limit the bandwidth: choose a rate near the recorded one and decimate afterwards.
///
/// # Errors
/// Different numbers of times and values, times that do not increase, or a rate that results in fewer than two samples.
pub fn resample(times_s: &[f64], values: &[f64], rate_hz: f64) -> Result<Vec<f64>, Error> {
    let (Some(first), Some(last)) = (times_s.first(), times_s.last()) else {
        return Err(Error::Usage("no samples to resample".into()));
    };
    if times_s.len() != values.len() {
        let (times, values) = (times_s.len(), values.len());
        return Err(Error::Usage(format!("{times} times for {values} values; give one time a value")));
    }
    if let Some(k) =
        times_s.windows(2).position(|pair| pair[1].partial_cmp(&pair[0]) != Some(std::cmp::Ordering::Greater))
    {
        let place = k + 1;
        return Err(Error::Usage(format!("time {} s at sample {place} does not grow; remove it", times_s[place])));
    }
    // Rounding must not drop the last sample of a whole number of intervals.
    let count = ((last - first) * rate_hz + 1e-9).floor() + 1.0;
    if !(2.0..=1e9).contains(&count) {
        return Err(Error::Usage(format!("{rate_hz} Hz over {} s gives no usable record", last - first)));
    }
    let mut segment = 0;
    let at = |k: usize| {
        let t = (first + k as f64 / rate_hz).min(*last);
        while segment + 2 < times_s.len() && times_s[segment + 1] < t {
            segment += 1;
        }
        let part = (t - times_s[segment]) / (times_s[segment + 1] - times_s[segment]);
        values[segment] + part * (values[segment + 1] - values[segment])
    };
    Ok((0..count as usize).map(at).collect())
}

/// Kaiser-windowed sinc: pass band to 0.8 of the new Nyquist frequency, attenuation of at least 60 dB from that
/// frequency. About 43 taps per unit of `factor`, symmetric, with sum one; converted to single precision they are the
/// coefficients of [`bearing_watch::drive::FirDecimator`].
#[must_use]
pub fn anti_alias(factor: usize) -> Vec<f64> {
    const ATTENUATION_DB: f64 = 70.0;
    let nyquist = 0.5 / factor as f64;
    let transition = 0.2 * nyquist;
    // Kaiser's formulas for the shape and the length of the window.
    let beta = 0.1102 * (ATTENUATION_DB - 8.7);
    let half = ((ATTENUATION_DB - 7.95) / (14.36 * transition) / 2.0).ceil() as i32;
    let cutoff = nyquist - transition / 2.0;
    let mut taps: Vec<f64> = (-half..=half)
        .map(|k| {
            let (k, half) = (f64::from(k), f64::from(half));
            let sinc = if k == 0.0 {
                2.0 * cutoff
            } else {
                (std::f64::consts::TAU * cutoff * k).sin() / (std::f64::consts::PI * k)
            };
            sinc * bessel_i0(beta * (1.0 - (k / half).powi(2)).max(0.0).sqrt()) / bessel_i0(beta)
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    taps.iter_mut().for_each(|tap| *tap /= sum);
    taps
}

/// Modified Bessel function I₀ by its power series, which converges for every argument of the window.
fn bessel_i0(x: f64) -> f64 {
    let mut term = 1.0;
    let mut sum = 1.0;
    for k in 1..60 {
        term *= (x / (2.0 * f64::from(k))).powi(2);
        sum += term;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tone(frequency: f64, count: usize) -> Vec<f64> {
        (0..count).map(|k| (std::f64::consts::TAU * frequency * k as f64).cos()).collect()
    }

    fn rms(x: &[f64]) -> f64 {
        (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt()
    }

    #[test]
    fn stop_band_is_sixty_decibels_down_and_pass_band_is_flat() {
        for factor in [2, 3, 5, 10] {
            let nyquist = 0.5 / factor as f64;
            let inner = |x: Vec<f64>| x[40..x.len() - 40].to_vec();
            for above in [1.001, 1.1, 1.5, 1.9] {
                let gain = rms(&inner(decimate(&tone(nyquist * above, 4000), factor))) * 2f64.sqrt();
                assert!(gain < 1e-3, "factor {factor}, {above} of Nyquist: {gain}");
            }
            let slow = inner(decimate(&tone(0.7 * nyquist, 4000), factor));
            assert!((rms(&slow) * 2f64.sqrt() - 1.0).abs() < 0.01, "pass band");
        }
    }

    #[test]
    fn ramp_stays_a_ramp_up_to_its_ends() {
        let ramp: Vec<f64> = (0..500).map(f64::from).collect();
        for (k, value) in decimate(&ramp, 5).into_iter().enumerate() {
            assert!((value - 5.0 * k as f64).abs() < 1e-9, "{k}: {value}"); // symmetric taps: rounding only
        }
    }

    #[test]
    fn resampling_keeps_lines_and_refuses_disorder() {
        let times = [0.0, 0.3, 0.4, 1.1, 2.0];
        let line: Vec<f64> = times.iter().map(|t| 5.0 - 2.0 * t).collect();
        let even = resample(&times, &line, 10.0).expect("ordered");
        assert_eq!(even.len(), 21, "the last time is one of them");
        for (k, value) in even.iter().enumerate() {
            assert!((value - (5.0 - 0.2 * k as f64)).abs() < 1e-12, "{k}: {value}"); // rounding
        }
        let kink = resample(&[1.0, 2.0, 3.0], &[0.0, 1.0, 0.0], 2.0).expect("ordered");
        assert_eq!(kink, [0.0, 0.5, 1.0, 0.5, 0.0]);
        assert!(resample(&[0.0, 1.0, 1.0], &[0.0; 3], 2.0).expect_err("stands").to_string().contains("sample 2"));
        assert!(resample(&[0.0, 1.0], &[0.0; 3], 2.0).is_err() && resample(&[], &[], 2.0).is_err());
        assert!(resample(&[0.0, 1.0], &[0.0; 2], 0.5).is_err() && resample(&[0.0, 1.0], &[0.0; 2], f64::NAN).is_err());
    }

    #[test]
    fn block_mean_drops_the_partial_block() {
        let trace = Trace {
            id: "x".into(),
            interval_s: Some(0.1),
            irregular_steps: 0,
            y: vec![1.0, 3.0, 5.0],
            u1: vec![0.0; 3],
            u2: vec![1.0; 3],
            motion: None,
            ..Trace::default()
        };
        let out = Preparation { block_mean: 2, decimate: 1 }.apply(&trace).expect("long enough");
        assert_eq!((out.y, out.interval_s), (vec![2.0], Some(0.2)));
        assert!(Preparation { block_mean: 4, decimate: 1 }.apply(&trace).is_err());
        assert!(Preparation { block_mean: 1, decimate: 0 }.apply(&trace).is_err());
        assert!(Preparation { block_mean: usize::MAX / 2, decimate: 3 }.apply(&trace).is_err(), "an overflow");
    }
}
