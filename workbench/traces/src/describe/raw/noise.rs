//! The noise of the current sensors, apart from the currents that the control makes.
//!
//! ```text
//! b = x₋ − 2 x + x₊                    of white noise σ: variance 6 σ²; of a current that varies slowly: zero   (1)
//! x = i_a + i_b + i_c                  of three sensors: the current is not in it
//! x = i_a, i_b;  d, q                  of two: at rest, and in the frame of the rotor, where a current does not turn
//! ```
//!
//! The rms of (1) is that of its central nine tenths, in which single steps are not, of each block of rows. Of the blocks
//! the lower quartile is taken, in which the current is steady, and of several signals the least: the control makes more
//! current along q than along d, an angle with coarse steps disturbs d and q, and motion disturbs the phases.

/// Rows of a block: some hundred bends tell a deviation to a few per cent.
const BLOCK: usize = 1024;
/// Part of the bends that is taken, and the rms of this part of a normal distribution.
const CENTRAL: f64 = 0.9;
const CENTRAL_RMS: f64 = 0.789;

/// Standard deviation of the sum of three currents with the noise of these sensors; of two sensors the third has that of
/// the others. `electrical` are the angles of the rotor.
pub(super) fn of_sum(amperes: &[Vec<f64>], electrical: &[f64]) -> f64 {
    if let [a, b, c] = amperes {
        let sums: Vec<f64> = a.iter().zip(b).zip(c).map(|((a, b), c)| a + b + c).collect();
        return white(&sums);
    }
    let [a, b] = amperes else { return f64::NAN };
    let rotor: Vec<[f64; 2]> = a
        .iter()
        .zip(b)
        .zip(electrical)
        .map(|((a, b), angle)| {
            let (alpha, beta, (sin, cos)) = (*a, (a + 2.0 * b) / 3.0_f64.sqrt(), angle.sin_cos());
            [alpha * cos + beta * sin, beta * cos - alpha * sin]
        })
        .collect();
    let axis = |k: usize| white(&rotor.iter().map(|own| own[k]).collect::<Vec<f64>>());
    // Of α the variance is σ², of β 5/3 σ², and 4/3 σ² of a vector that turns.
    let turning = axis(0).min(axis(1)) * 0.75_f64.sqrt();
    3.0_f64.sqrt() * turning.min(white(a).max(white(b)))
}

/// Standard deviation of what is white in a signal.
fn white(values: &[f64]) -> f64 {
    let mut blocks: Vec<f64> = values.chunks(BLOCK).filter_map(deviation).collect();
    blocks.sort_by(f64::total_cmp);
    blocks.get(blocks.len() / 4).copied().unwrap_or(f64::NAN)
}

/// By the bends (1) of a block; `None` of a short one.
fn deviation(block: &[f64]) -> Option<f64> {
    let bends = block.windows(3).map(|own| own[0] - 2.0 * own[1] + own[2]).filter(|bend| bend.is_finite());
    let mut squares: Vec<f64> = bends.map(|bend| bend * bend).collect();
    if 4 * squares.len() < BLOCK {
        return None;
    }
    squares.sort_by(f64::total_cmp);
    let central = &squares[..(CENTRAL * squares.len() as f64) as usize];
    Some((central.iter().sum::<f64>() / central.len() as f64 / 6.0).sqrt() / CENTRAL_RMS)
}
