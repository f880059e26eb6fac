//! Weighted sums of columns, FIR filters, and the recursive filter 1/A.
//!
//! ```text
//! output += Σ wₖ columnₖ                          no recursion: several samples at once              (1)
//! x(t) = v(t) − Σ aₖ x(t−k)                       one sample after another                            (2)
//! [x(t) … x(t+3)] = H [v(t) … v(t+3)] + Σ gₖ x(t−k)                                                   (3)
//! ```
//!
//! (3) computes (2) for four samples at once: Hᵢⱼ = h(i−j), with h the impulse response of 1/A, and gₖ is the response
//! of the four samples to x(t−k) = 1. The product with H does not depend on samples before t, so the latency of a group
//! of four is about that of one sample of (2). (3) is used up to fourth order.

/// (1): adds columns that are as long as the output.
pub(crate) fn add_columns(weights: &[f64], columns: &[&[f64]], output: &mut [f64]) {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") {
        // SAFETY: the processor supports AVX2, as checked above.
        return unsafe { add_columns_avx2(weights, columns, output) };
    }
    add_groups(weights, columns, output);
}

/// The same operations in the same order, four at a time: the results are identical bit by bit.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn add_columns_avx2(weights: &[f64], columns: &[&[f64]], output: &mut [f64]) {
    add_groups(weights, columns, output);
}

/// Adds up to four columns per pass over the output.
#[inline(always)]
fn add_groups(weights: &[f64], columns: &[&[f64]], output: &mut [f64]) {
    for (weights, columns) in weights.chunks(4).zip(columns.chunks(4)) {
        match (weights, columns) {
            (&[w0, w1, w2, w3], &[c0, c1, c2, c3]) => add_by([w0, w1, w2, w3], [c0, c1, c2, c3], output),
            (&[w0, w1, w2], &[c0, c1, c2]) => add_by([w0, w1, w2], [c0, c1, c2], output),
            (&[w0, w1], &[c0, c1]) => add_by([w0, w1], [c0, c1], output),
            (&[w0], &[c0]) => add_by([w0], [c0], output),
            _ => {}
        }
    }
}

#[inline(always)]
fn add_by<const N: usize>(weights: [f64; N], columns: [&[f64]; N], output: &mut [f64]) {
    let columns = columns.map(|column| &column[..output.len()]);
    for (i, out) in output.iter_mut().enumerate() {
        let mut sum = *out;
        for k in 0..N {
            sum += weights[k] * columns[k][i];
        }
        *out = sum;
    }
}

/// `output(t) += Σ tapsₖ x(t − delay − k)`, with zeros before the record.
pub(crate) fn add_filtered(taps: &[f64], delay: usize, x: &[f64], output: &mut [f64]) {
    let n = output.len().min(x.len());
    let full = (delay + taps.len()).saturating_sub(1).min(n);
    for t in delay.min(n)..full {
        output[t] += taps.iter().take(t + 1 - delay).enumerate().map(|(k, tap)| tap * x[t - delay - k]).sum::<f64>();
    }
    let output = &mut output[full..n];
    if output.is_empty() {
        return;
    }
    for (first, taps) in (delay..).step_by(4).zip(taps.chunks(4)) {
        let lag = |k: usize| &x[full - first - k..][..output.len()];
        let columns: [&[f64]; 4] = std::array::from_fn(|k| lag(k.min(taps.len() - 1)));
        add_columns(taps, &columns[..taps.len()], output);
    }
}

/// FIR filter with zeros before the first sample.
pub(crate) fn fir(taps: &[f64], x: &[f64], output: &mut Vec<f64>) {
    output.clear();
    output.resize(x.len(), 0.0);
    add_filtered(taps, 0, x, output);
}

/// (2) in place, from sample `start`; `a` excludes the leading 1. Zeros before the record.
pub(crate) fn recur(a: &[f64], start: usize, x: &mut [f64]) {
    match *a {
        [] => {}
        [a1] => recur_by([a1], start, x),
        [a1, a2] => recur_by([a1, a2], start, x),
        [a1, a2, a3] => recur_by([a1, a2, a3], start, x),
        [a1, a2, a3, a4] => recur_by([a1, a2, a3, a4], start, x),
        _ => {
            for t in start..x.len() {
                let past: f64 = a.iter().zip(x[..t].iter().rev()).map(|(a, x)| a * x).sum();
                x[t] -= past;
            }
        }
    }
}

/// (3), and (2) for the remaining samples.
fn recur_by<const N: usize>(a: [f64; N], start: usize, x: &mut [f64]) {
    let mut past: [f64; N] = std::array::from_fn(|k| if k < start { x[start - 1 - k] } else { 0.0 });
    let step = |past: &mut [f64; N], value: f64| {
        let mut now = value;
        // Oldest first: only the last product depends on the previous sample.
        for k in (0..N).rev() {
            now -= a[k] * past[k];
        }
        past.copy_within(..N - 1, 1);
        past[0] = now;
        now
    };
    let response = |mut past: [f64; N], first: f64| [first, 0.0, 0.0, 0.0].map(|value| step(&mut past, value));
    let h = response([0.0; N], 1.0);
    let g: [[f64; 4]; N] = std::array::from_fn(|k| response(std::array::from_fn(|j| f64::from(u8::from(j == k))), 0.0));
    let mut groups = x[start..].chunks_exact_mut(4);
    for group in &mut groups {
        let [v0, v1, v2, v3] = [group[0], group[1], group[2], group[3]];
        let mut now = [v0, v1 + h[1] * v0, v2 + h[1] * v1 + h[2] * v0, v3 + h[1] * v2 + h[2] * v1 + h[3] * v0];
        for k in (0..N).rev() {
            for (now, g) in now.iter_mut().zip(g[k]) {
                *now += g * past[k];
            }
        }
        past = std::array::from_fn(|k| now[3 - k]);
        group.copy_from_slice(&now);
    }
    for value in groups.into_remainder() {
        *value = step(&mut past, *value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn wave(n: usize) -> Vec<f64> {
        (0..n).map(|t| (0.7 * (t * t) as f64).sin()).collect()
    }

    #[test]
    fn recursion_agrees_with_its_definition() {
        let a = [-1.1, 0.5, -0.2, 0.05, 0.01];
        for order in 0..=a.len() {
            for (n, start) in [(0, 0), (3, 2), (8, 0), (41, 3)] {
                let a = &a[..order];
                let mut want = wave(n);
                for t in start..n {
                    want[t] -= (1..=order.min(t)).map(|k| a[k - 1] * want[t - k]).sum::<f64>();
                }
                let mut got = wave(n);
                recur(a, start, &mut got);
                for (got, want) in got.iter().zip(&want) {
                    assert!((got - want).abs() < 1e-13, "{order} {n} {start}"); // rounding of a stable recursion
                }
            }
        }
    }

    #[test]
    fn taps_agree_with_their_definition() {
        for (count, delay, n) in [(0, 0, 5), (1, 0, 9), (4, 2, 30), (6, 1, 30), (9, 3, 4), (3, 7, 5)] {
            let (taps, x) = (wave(count), wave(n));
            let mut got = vec![0.5; n];
            add_filtered(&taps, delay, &x, &mut got);
            for (t, got) in got.iter().enumerate() {
                let reached = (0..count).filter(|k| delay + k <= t);
                let want = 0.5 + reached.map(|k| taps[k] * x[t - delay - k]).sum::<f64>();
                assert!((got - want).abs() < 1e-14, "{count} {delay} {n} {t}"); // rounding of nine sums
            }
        }
    }
}
