//! The triangular factor of a matrix, computed in blocks of rows.
//!
//! ```text
//! [R; X] = Q [R'; 0]     Householder reflections on one row of R and the whole block at a time     (1)
//! ```
//!
//! Only the first `eliminated` columns are reduced. The reflections are also applied to the other columns, so that
//! their leading rows are Qᵀ times them. R and the blocks are column-major. Cost: 4 flops per entry of the block and
//! eliminated column.

use super::sums::dot;

/// Diagonal of R, relative to the norm of its column, below which a column counts as linearly dependent. Rounding in
/// double precision leaves 1e-15.
pub(crate) const DEPENDENT: f64 = 1e-11;

/// Numbers in a cache line.
const LINE: usize = 8;

/// Number of rows of a block with this number of columns, so that the block fits into the first-level cache.
pub(crate) fn block_rows(columns: usize) -> usize {
    (2560 / columns.max(1)).clamp(64, 512) & !7
}

/// R of (1), `eliminated` × `columns`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangle {
    eliminated: usize,
    columns: usize,
    r: Vec<f64>,
}

impl Triangle {
    pub(crate) fn new(eliminated: usize, columns: usize) -> Self {
        Self { eliminated, columns, r: vec![0.0; eliminated * columns] }
    }

    /// Resets R and reuses its memory.
    pub(crate) fn reset(&mut self, eliminated: usize, columns: usize) {
        (self.eliminated, self.columns) = (eliminated, columns);
        self.r.clear();
        self.r.resize(eliminated * columns, 0.0);
    }

    /// Rows of R: the number of reduced columns.
    pub(crate) fn rows(&self) -> usize {
        self.eliminated
    }

    /// A column of R, `eliminated` long.
    pub(crate) fn column(&self, k: usize) -> &[f64] {
        &self.r[k * self.eliminated..][..self.eliminated]
    }

    /// Adds columns of equal length, one for each column of R; `block` is working memory for their blocks of rows.
    pub(crate) fn absorb_columns(&mut self, columns: &[&[f64]], block: &mut Vec<f64>) {
        let length = columns.first().map_or(0, |column| column.len());
        let rows = block_rows(columns.len());
        block.resize(columns.len() * rows + LINE, 0.0);
        // In blocks of full height every column starts at the beginning of a cache line.
        let offset = block.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        let block = &mut block[offset..];
        for t in (0..length).step_by(rows) {
            let height = rows.min(length - t);
            for (column, copy) in columns.iter().zip(block.chunks_exact_mut(height)) {
                copy.copy_from_slice(&column[t..][..height]);
            }
            self.absorb(block, height);
        }
    }

    /// The first of the reduced columns that depends linearly on the columns before it.
    pub(crate) fn dependent(&self) -> Option<usize> {
        (0..self.eliminated).find(|&k| {
            let column = &self.column(k)[..=k];
            let norm = dot(column, column).sqrt();
            norm == 0.0 || column[k].abs() < DEPENDENT * norm
        })
    }

    /// Solves R x = `right` in place, with the leading triangle of R of the size of `right`.
    pub(crate) fn substitute(&self, right: &mut [f64]) {
        substitute(&self.r, self.eliminated, right);
    }

    /// Adds the columns of a block of `height` rows; the block is overwritten.
    pub(crate) fn absorb(&mut self, block: &mut [f64], height: usize) {
        #[cfg(target_arch = "x86_64")]
        if std::arch::is_x86_feature_detected!("avx512f") {
            // SAFETY: the processor supports AVX-512, as checked above.
            return unsafe { rotate_avx512(self, block, height) };
        } else if std::arch::is_x86_feature_detected!("avx2") {
            // SAFETY: the processor supports AVX2, as checked above.
            return unsafe { rotate_avx2(self, block, height) };
        }
        self.rotate(block, height);
    }

    #[inline(always)]
    fn rotate(&mut self, block: &mut [f64], height: usize) {
        let stride = self.eliminated;
        for k in 0..self.eliminated {
            let (head, rest) = block[k * height..self.columns * height].split_at_mut(height);
            let below = dot(head, head);
            if below == 0.0 {
                continue;
            }
            let diagonal = self.r[k * stride + k];
            let norm = diagonal.hypot(below.sqrt());
            // The sign that avoids cancellation.
            let reflected = if diagonal > 0.0 { -norm } else { norm };
            let top = diagonal - reflected;
            let scale = -1.0 / (reflected * top);
            self.r[k * stride + k] = reflected;
            for (j, column) in rest.chunks_exact_mut(height).enumerate() {
                let upper = &mut self.r[(k + 1 + j) * stride + k];
                let share = scale * (top * *upper + dot(head, column));
                *upper -= share * top;
                for (x, v) in column.iter_mut().zip(head.iter()) {
                    *x -= share * v;
                }
            }
        }
    }
}

/// The same operations in the same order, eight at a time: the results are identical bit by bit.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f")]
fn rotate_avx512(triangle: &mut Triangle, block: &mut [f64], height: usize) {
    triangle.rotate(block, height);
}

/// The same operations in the same order, four at a time: the results are identical bit by bit.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn rotate_avx2(triangle: &mut Triangle, block: &mut [f64], height: usize) {
    triangle.rotate(block, height);
}

/// Solves min ‖target − Xθ‖. Columns and target (last) are column-major; each column is zero below its height, and the
/// heights do not decrease. Returns the residual sum of squares and writes θ to the head of the target column.
///
/// # Errors
/// The first column that depends linearly on the columns before it: its diagonal is below `dependent` times its norm.
pub(crate) fn solve_staircase(
    columns: &mut [f64],
    stride: usize,
    heights: &[usize],
    dependent: f64,
) -> Result<f64, usize> {
    let n = heights.len() - 1;
    for k in 0..n {
        let (left, right) = columns.split_at_mut((k + 1) * stride);
        let head = &mut left[k * stride..][..heights[k]];
        let before: f64 = head.iter().map(|x| x * x).sum();
        let below: f64 = head[k..].iter().map(|x| x * x).sum();
        let norm = below.sqrt();
        // The previous reflections preserved the norm of the column.
        if norm < dependent * before.sqrt() || norm == 0.0 || norm.is_nan() {
            return Err(k);
        }
        let reflected = if head[k] > 0.0 { -norm } else { norm };
        let top = head[k] - reflected;
        let scale = -1.0 / (reflected * top);
        head[k] = top;
        for column in right.chunks_exact_mut(stride).take(n - k) {
            let share: f64 = scale * head[k..].iter().zip(&column[k..]).map(|(v, x)| v * x).sum::<f64>();
            for (x, v) in column[k..].iter_mut().zip(&head[k..]) {
                *x -= share * v;
            }
        }
        head[k] = reflected;
    }
    let (matrix, target) = columns.split_at_mut(n * stride);
    let residual_sum = target[n..heights[n]].iter().map(|x| x * x).sum();
    substitute(matrix, stride, &mut target[..n]);
    Ok(residual_sum)
}

/// Solves R x = `right` in place, R column-major.
fn substitute(r: &[f64], stride: usize, right: &mut [f64]) {
    for k in (0..right.len()).rev() {
        let column = &r[k * stride..][..=k];
        right[k] /= column[k];
        let value = right[k];
        for (x, r) in right[..k].iter_mut().zip(column) {
            *x -= r * value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The solution is θ = (2, −1) exactly; the blocks have different heights.
    #[test]
    fn blocks_give_the_solution_of_the_whole() {
        let x = [[1.0, 2.0], [3.0, -1.0], [0.5, 4.0], [2.0, 2.0], [-1.0, 0.25]];
        let off = [0.0, 0.0, 0.0, 0.0, 1.0];
        let rows: Vec<[f64; 3]> = x.iter().zip(off).map(|(x, e)| [x[0], x[1], 2.0 * x[0] - x[1] + e]).collect();
        let mut triangle = Triangle::new(3, 3);
        for part in rows.chunks(2) {
            let mut block: Vec<f64> = (0..3).flat_map(|c| part.iter().map(move |row| row[c])).collect();
            triangle.absorb(&mut block, part.len());
        }
        let mut all: Vec<f64> = (0..3).flat_map(|c| rows.iter().map(move |row| row[c])).collect();
        let whole = solve_staircase(&mut all, 5, &[5, 5, 5], 1e-11).expect("independent columns");
        let mut factored: Vec<f64> = (0..3).flat_map(|c| triangle.column(c).to_vec()).collect();
        let blocks = solve_staircase(&mut factored, 3, &[1, 2, 3], 1e-11).expect("independent columns");
        assert!(whole > 0.1 && (whole - blocks).abs() < 1e-13, "{whole} {blocks}"); // rounding of a dozen operations
        for k in 0..2 {
            assert!((all[10 + k] - factored[6 + k]).abs() < 1e-13);
        }
    }

    #[test]
    fn a_dependent_column_is_named() {
        let mut columns = [1.0, 2.0, 3.0, 2.0, 4.0, 6.0, 1.0, 0.0, 0.0];
        assert_eq!(solve_staircase(&mut columns, 3, &[3, 3, 3], 1e-11), Err(1));
    }

    /// y = 2 x₁ − x₂ in several blocks, the last one short; x₃ = x₁ + x₂ is dependent.
    #[test]
    fn columns_of_any_length_are_factored() {
        let wave = |step: f64| (0..1300).map(|t| (step * (t * t) as f64).sin()).collect::<Vec<f64>>();
        let (x1, x2) = (wave(0.3), wave(0.7));
        let combined = |a: f64, b: f64| x1.iter().zip(&x2).map(|(x, z)| a * x + b * z).collect::<Vec<f64>>();
        let (y, x3) = (combined(2.0, -1.0), combined(1.0, 1.0));
        let mut triangle = Triangle::new(2, 3);
        triangle.absorb_columns(&[&x1, &x2, &y], &mut Vec::new());
        assert_eq!(triangle.dependent(), None);
        let mut theta = triangle.column(2).to_vec();
        triangle.substitute(&mut theta);
        assert!((theta[0] - 2.0).abs() < 1e-13 && (theta[1] + 1.0).abs() < 1e-13, "{theta:?}"); // rounding
        triangle.reset(3, 3);
        triangle.absorb_columns(&[&x1, &x2, &x3], &mut Vec::new());
        assert_eq!(triangle.dependent(), Some(2));
    }

    #[test]
    fn every_instruction_set_gives_the_same_bits() {
        let block: Vec<f64> = (0..4 * 75).map(|t| (0.37 * f64::from(t * t)).sin()).collect();
        let (mut wide, mut plain) = (Triangle::new(3, 4), Triangle::new(3, 4));
        wide.absorb(&mut block.clone(), 75);
        plain.rotate(&mut block.clone(), 75);
        assert_eq!(wide.r, plain.r);
    }
}
