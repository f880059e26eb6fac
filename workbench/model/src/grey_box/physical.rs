//! R, L, Ke, Kt, J, B from the five-parameter difference model of the current.
//!
//! Input: current, voltage, velocity and external torque at a constant rate T. Output: the five parameters of (1) and
//! the physical constants computed from them.
//!
//! ```text
//! i(k+1) = θ₁ i(k) + θ₂ i(k−1) + θ₃ v(k) + θ₄ ω(k−1) + θ₅ Tex(k−1)                           (1)
//! θ₁ = 1 − RT/L,  θ₂ = −Ke Kt T²/(L J),  θ₃ = T/L,
//! θ₄ = −(Ke T/L)(1 − BT/J),  θ₅ = Ke T²/(L J)                                                (2)
//! L = T/θ₃,  R = (1 − θ₁)/θ₃,  Kt = −θ₂/θ₅                                                   (3)
//! Ke = Kt,  J = Ke T θ₃/θ₅,  B = (J/T)(1 + θ₄/(Ke θ₃))                                       (4)
//! ```
//!
//! (1) is thesis Eq. 2.41 with forward Euler and with L J instead of the printed J². Five numbers contain six
//! constants: (3) needs no assumption, but Ke, J and B can be separated only if Ke = Kt is *assumed* (4), which holds
//! for one motor in SI units. Tex opposes positive rotation. Standard deviations are propagated through (3), (4) by the
//! Jacobian.
//!
//! Euler's rule requires T well below L/R, and BT/J well above rounding: R and L have an error of about RT/(2L), and B
//! is a small difference of large numbers; [`GreyBox::notes`] lists the constants that are not determined.

use nalgebra::{DMatrix, DVector, SMatrix, SVector};

use super::{GreyBox, regression};
use crate::Error;

/// Signals of a motor including its voltage.
#[derive(Clone, Copy, Debug)]
pub struct ElectricalRecord<'a> {
    /// Name of the trace, for messages.
    pub id: &'a str,
    /// Sampling interval.
    pub interval_s: f64,
    /// Current.
    pub current_a: &'a [f64],
    /// Terminal voltage, held over the interval after its sample.
    pub voltage_v: &'a [f64],
    /// Velocity.
    pub velocity_rad_s: &'a [f64],
    /// External torque.
    pub load_torque_nm: &'a [f64],
}

/// Parameters of (1).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiveParameters {
    /// θ₁ … θ₅.
    pub theta: [f64; 5],
    /// Their covariance.
    pub covariance: SMatrix<f64, 5, 5>,
    /// Sampling interval T.
    pub interval_s: f64,
    /// ‖residual‖ / ‖current‖.
    pub relative_error: f64,
    /// Rows of the regression.
    pub rows: usize,
}

const NAMES: [(&str, &str); 6] =
    [("R", "Ω"), ("L", "H"), ("Kt", "N·m/A"), ("Ke", "V·s/rad"), ("J", "kg·m²"), ("B", "N·m·s/rad")];

/// Largest RT/L for which Euler's rule is usable; the bias of R and L is half of it.
const COARSE: f64 = 0.5;

/// Estimates (1) by least squares.
///
/// # Errors
/// Too few samples, or signals that do not determine a parameter.
pub fn five_parameters(record: &ElectricalRecord) -> Result<FiveParameters, Error> {
    let signals = [record.current_a, record.voltage_v, record.velocity_rad_s, record.load_torque_nm];
    let count = signals.iter().map(|x| x.len()).min().unwrap_or(0);
    if count < 22 {
        return Err(Error::trace(record.id, format!("{count} samples for five parameters; record more")));
    }
    let [i, v, w, load] = signals;
    let rows = count - 2;
    let x = DMatrix::from_fn(rows, 5, |row, column| {
        let k = row + 1;
        [i[k], i[k - 1], v[k], w[k - 1], load[k - 1]][column] // (1)
    });
    let y = DVector::from_column_slice(&i[2..count]);
    let lags = (4.0 * (rows as f64 / 100.0).powf(2.0 / 9.0)).ceil() as usize;
    let solution = regression::solve(&x, &x, &y, lags).map_err(|column| {
        let of = ["i(k)", "i(k−1)", "v(k)", "ω(k−1)", "Tex(k−1)"][column];
        let problem = format!(
            "the parameter of {of} is not determined: its column depends on the earlier ones, as where the current \
             settles within a sample (T ≫ L/R) or a signal is constant; sample faster or vary voltage and load"
        );
        Error::trace(record.id, problem)
    })?;
    let mut theta = [0.0; 5];
    theta.copy_from_slice(solution.theta.as_slice());
    let covariance = SMatrix::from_fn(|row, column| solution.covariance[(row, column)]);
    let relative_error = solution.relative_error;
    Ok(FiveParameters { theta, covariance, interval_s: record.interval_s, relative_error, rows })
}

impl FiveParameters {
    /// The constants computed from the parameters by (3) and (4).
    ///
    /// # Errors
    /// Parameters with signs that are impossible for a motor.
    pub fn physical(&self, id: &str) -> Result<GreyBox, Error> {
        let [t1, t2, t3, t4, t5] = self.theta;
        let step = self.interval_s;
        if !(t3 > 0.0 && t2 / t5 < 0.0) {
            let told = |k: usize| format!("{:.2e} ± {:.1e}", self.theta[k], self.covariance[(k, k)].sqrt());
            let problem = format!(
                "no motor has these parameters: θ₂ {}, θ₃ {}, θ₅ {} (standard deviations); check the signs of voltage \
                 and load torque (which opposes rotation), record longer, or sample faster than L/R",
                told(1),
                told(2),
                told(4)
            );
            return Err(Error::trace(id, problem));
        }
        let (l, r, kt) = (step / t3, (1.0 - t1) / t3, -t2 / t5); // (3)
        let ke = kt;
        let j = ke * step * t3 / t5; // (4)
        let q = t4 / (ke * t3);
        let b = j / step * (1.0 + q);
        // Rows of the Jacobian by the chain rule, each a gradient in θ.
        let unit = |k: usize, value: f64| SVector::<f64, 5>::from_fn(|row, _| if row == k { value } else { 0.0 });
        let dl = unit(2, -l / t3);
        let dr = unit(0, -1.0 / t3) + unit(2, -r / t3);
        let dkt = unit(1, -1.0 / t5) + unit(4, -kt / t5);
        let dj = dkt * (j / kt) + unit(2, j / t3) + unit(4, -j / t5);
        let dq = unit(3, 1.0 / (ke * t3)) - dkt * (q / ke) + unit(2, -q / t3);
        let db = dj * (b / j) + dq * (j / step);
        let gradients = [dr, dl, dkt, dkt, dj, db];
        let jacobian = DMatrix::from_fn(6, 5, |row, column| gradients[row][column]);
        let cov_theta = DMatrix::from_fn(5, 5, |row, column| self.covariance[(row, column)]);
        let covariance = &jacobian * cov_theta * jacobian.transpose();
        let found = (self.relative_error, self.rows);
        let mut grey_box = GreyBox::new(&NAMES, &[r, l, kt, ke, j, b], covariance, found);
        grey_box.notes.push("Ke, J and B assume Ke = Kt in SI units; R, L and Kt do not".into());
        if !(0.0..=COARSE).contains(&(1.0 - t1)) {
            grey_box.notes.push(format!(
                "ill-conditioned: RT/L = {:.2}, where Euler's rule needs it well below one; R and L mean nothing, \
                 sample faster",
                1.0 - t1
            ));
        }
        grey_box.note_undetermined();
        Ok(grey_box)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng as _;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution as _, StandardNormal};

    const STEP_S: f64 = 1e-4;
    /// R, L, Kt, Ke, J, B.
    const TRUTH: [f64; 6] = [0.5, 4.5e-3, 0.12, 0.12, 2.7e-5, 5e-3];

    fn parameters() -> [f64; 5] {
        let [r, l, kt, ke, j, b] = TRUTH;
        let t = STEP_S;
        let common = ke * t * t / (l * j);
        [1.0 - r * t / l, -kt * common, t / l, -(ke * t / l) * (1.0 - b * t / j), common]
    }

    /// Euler model of a motor driven by white voltage and torque, with noise of `noise_a` on the current equation.
    fn record(seed: u64, noise_a: f64) -> [Vec<f64>; 4] {
        let [r, l, kt, ke, j, b] = TRUTH;
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut white = || -> f64 { StandardNormal.sample(&mut rng) };
        let mut signals: [Vec<f64>; 4] = Default::default();
        let (mut i, mut w) = (0.0, 0.0);
        for _ in 0..4000 {
            let (v, load) = (5.0 * white(), 0.5 * white());
            for (signal, value) in signals.iter_mut().zip([i, v, w, load]) {
                signal.push(value);
            }
            (i, w) =
                (i + STEP_S / l * (v - r * i - ke * w) + noise_a * white(), w + STEP_S / j * (kt * i - b * w - load));
        }
        signals
    }

    fn found(seed: u64, noise_a: f64) -> GreyBox {
        let [i, v, w, load] = record(seed, noise_a);
        let record = ElectricalRecord {
            id: "x",
            interval_s: STEP_S,
            current_a: &i,
            voltage_v: &v,
            velocity_rad_s: &w,
            load_torque_nm: &load,
        };
        five_parameters(&record).expect("excited").physical("x").expect("a motor")
    }

    #[test]
    fn constants_come_back_through_the_parameters() {
        let exact = FiveParameters {
            theta: parameters(),
            covariance: SMatrix::zeros(),
            interval_s: STEP_S,
            relative_error: 0.0,
            rows: 100,
        };
        let algebra = exact.physical("x").expect("a motor");
        let simulated = found(1, 0.0);
        for (k, truth) in TRUTH.into_iter().enumerate() {
            // B is a difference of numbers 54 times larger; both are exact to rounding.
            assert!((algebra.quantities[k].value / truth - 1.0).abs() < 1e-11, "{:?}", algebra.quantities[k]);
            assert!((simulated.quantities[k].value / truth - 1.0).abs() < 1e-8, "{:?}", simulated.quantities[k]);
        }
        assert!(algebra.notes[0].contains("assume Ke = Kt"));
    }

    #[test]
    fn propagated_deviations_are_the_scatter() {
        let runs: Vec<GreyBox> = (0..200).map(|seed| found(100 + seed, 1e-4)).collect();
        for (k, truth) in TRUTH.into_iter().enumerate() {
            let n = runs.len() as f64;
            let mean = runs.iter().map(|run| run.quantities[k].value).sum::<f64>() / n;
            let scatter = (runs.iter().map(|run| (run.quantities[k].value - mean).powi(2)).sum::<f64>() / n).sqrt();
            let told = runs.iter().map(|run| run.quantities[k].sd).sum::<f64>() / n;
            let name = NAMES[k].0;
            println!("{name}: {mean:.5e} (truth {truth:.5e}), scatter {scatter:.2e}, told {told:.2e}");
            assert!((mean - truth).abs() < 0.3 * scatter, "{name}"); // four standard errors of the mean
            assert!((0.8..1.2).contains(&(told / scatter)), "{name}: {}", told / scatter); // 4 × 5 % of 200 runs
        }
    }

    #[test]
    fn what_is_not_determined_is_said() {
        let noisy = found(3, 3e-4);
        assert!(noisy.notes.iter().any(|note| note.contains("hardly told from zero") && note.contains("B ±")));
        let mut theta = parameters();
        theta[0] = -2.0; // RT/L = 3
        let slow =
            FiveParameters { theta, covariance: SMatrix::zeros(), interval_s: STEP_S, relative_error: 0.0, rows: 100 };
        assert!(slow.physical("x").expect("a motor").notes.iter().any(|note| note.contains("RT/L = 3.00")));
        theta[2] = -1.0;
        assert!(FiveParameters { theta, ..slow }.physical("x").is_err());
    }
}
