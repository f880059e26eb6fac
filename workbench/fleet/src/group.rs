//! Sums of a group of rows (segments of one run, drive or class), and of many closed groups.
//!
//! ```text
//! group    n,  S = Σ x,  Q = Σ x xᵀ                                       in twice the precision ([`Double`])
//! closed   ȳ = S/n,   C = Q − S Sᵀ/n                                      rounded once                    (1)
//! level    k,  N = Σ n,  Σ 1/n,  Σ ȳ,  Σ ȳ ȳᵀ,  Σ C  over its groups       in twice the precision          (2)
//! ```
//!
//! (1) is taken only of complete groups, so that (2) does not depend on the order of the rows or on the tree of the
//! merges, but for bits that no constant of a model has. From (2) follow the scatter of the groups' means and that
//! within groups.

use nalgebra::{DMatrix, DVector};

use super::double::Double;

/// Sums of one group.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Number of rows.
    pub count: u64,
    /// S.
    first: Vec<Double>,
    /// Q, its upper triangle by rows.
    second: Vec<Double>,
}

/// Mean and scatter (1) of a complete group.
#[derive(Clone, Debug, PartialEq)]
pub struct Closed {
    /// n.
    pub count: u64,
    /// ȳ.
    pub mean: DVector<f64>,
    /// C.
    pub scatter: DMatrix<f64>,
}

/// Places of the upper triangle of a matrix of this size, by rows.
fn triangle(size: usize) -> impl Iterator<Item = (usize, usize)> {
    (0..size).flat_map(move |i| (i..size).map(move |j| (i, j)))
}

impl Group {
    /// An empty group of so many features.
    #[must_use]
    pub fn new(features: usize) -> Self {
        let zeros = |count: usize| vec![Double::default(); count];
        Self { count: 0, first: zeros(features), second: zeros(features * (features + 1) / 2) }
    }

    /// Adds a row without missing values, each of at most 1e140 in magnitude.
    pub fn add(&mut self, row: &[f64]) {
        self.count += 1;
        self.first.iter_mut().zip(row).for_each(|(sum, x)| sum.add(*x));
        let mut second = self.second.iter_mut();
        for (i, x) in row.iter().enumerate() {
            row[i..].iter().zip(&mut second).for_each(|(y, sum)| sum.add_product(*x, *y));
        }
    }

    /// Adds the rows of another group with the same features.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.first.iter_mut().zip(&other.first).for_each(|(sum, more)| sum.merge(*more));
        self.second.iter_mut().zip(&other.second).for_each(|(sum, more)| sum.merge(*more));
    }

    /// Removes all rows.
    pub fn reset(&mut self) {
        self.count = 0;
        self.first.iter_mut().chain(&mut self.second).for_each(|sum| *sum = Double::default());
    }

    /// Number of features.
    #[must_use]
    pub const fn features(&self) -> usize {
        self.first.len()
    }

    /// Returns (1) of at least one row.
    #[must_use]
    pub fn close(&self) -> Closed {
        let n = self.count.max(1) as f64;
        let first = &self.first;
        let mut scatter = DMatrix::zeros(first.len(), first.len());
        for ((i, j), sum) in triangle(first.len()).zip(&self.second) {
            let own = sum.centred(first[i], first[j], n);
            (scatter[(i, j)], scatter[(j, i)]) = (own, own);
        }
        let mean = DVector::from_iterator(first.len(), first.iter().map(|sum| sum.mean(n)));
        Closed { count: self.count, mean, scatter }
    }

    /// Returns the group of these features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let size = self.first.len();
        // Places before row i of the triangle: i (2 size − i + 1)/2.
        let of = |i: usize, j: usize| {
            let (i, j) = (i.min(j), i.max(j));
            self.second[i * (2 * size - i + 1) / 2 + j - i]
        };
        Self {
            count: self.count,
            first: places.iter().map(|&k| self.first[k]).collect(),
            second: triangle(places.len()).map(|(i, j)| of(places[i], places[j])).collect(),
        }
    }
}

/// Sums (2) over closed groups: runs, or drives.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    /// k.
    pub count: u64,
    /// Rows of the largest group.
    pub longest: u64,
    /// Groups of one row.
    pub single: u64,
    /// N.
    pub rows: u64,
    /// Σ 1/n.
    inverse: Double,
    /// The means as a group of k rows.
    means: Group,
    /// Σ C, its upper triangle by rows.
    within: Vec<Double>,
}

impl Level {
    /// No group of so many features yet.
    #[must_use]
    pub fn new(features: usize) -> Self {
        let within = vec![Double::default(); features * (features + 1) / 2];
        Self {
            count: 0,
            longest: 0,
            single: 0,
            rows: 0,
            inverse: Double::default(),
            means: Group::new(features),
            within,
        }
    }

    /// Adds a complete group.
    pub fn add(&mut self, group: &Closed) {
        self.count += 1;
        self.longest = self.longest.max(group.count);
        self.single += u64::from(group.count == 1);
        self.rows += group.count;
        self.inverse.add(1.0 / group.count as f64);
        self.means.add(group.mean.as_slice());
        let cells = triangle(group.mean.len()).zip(&mut self.within);
        cells.for_each(|(place, sum)| sum.add(group.scatter[place]));
    }

    /// Adds the groups of another level.
    pub fn merge(&mut self, other: &Self) {
        self.count += other.count;
        self.longest = self.longest.max(other.longest);
        self.single += other.single;
        self.rows += other.rows;
        self.inverse.merge(other.inverse);
        self.means.merge(&other.means);
        self.within.iter_mut().zip(&other.within).for_each(|(sum, more)| sum.merge(*more));
    }

    /// Returns the mean of 1/n over the groups.
    #[must_use]
    pub fn inverse_size(&self) -> f64 {
        self.inverse.value() / self.count.max(1) as f64
    }

    /// Returns the means of the groups as rows: their mean, and their scatter.
    #[must_use]
    pub fn means(&self) -> Closed {
        self.means.close()
    }

    /// Returns Σ C.
    #[must_use]
    pub fn within(&self) -> DMatrix<f64> {
        let size = self.means.features();
        let mut matrix = DMatrix::zeros(size, size);
        for ((i, j), sum) in triangle(size).zip(&self.within) {
            let own = sum.value();
            (matrix[(i, j)], matrix[(j, i)]) = (own, own);
        }
        matrix
    }

    /// Returns the level of these features only.
    #[must_use]
    pub fn select(&self, places: &[usize]) -> Self {
        let full =
            Group { count: 0, first: vec![Double::default(); self.means.features()], second: self.within.clone() };
        Self { means: self.means.select(places), within: full.select(places).second, ..*self }
    }
}

#[cfg(test)]
mod tests {
    use rand::{RngExt as _, SeedableRng};
    use rand_chacha::ChaCha8Rng;

    use super::*;

    fn rows(count: usize, offset: f64) -> Vec<DVector<f64>> {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        (0..count).map(|_| DVector::from_fn(3, |k, _| offset + rng.random::<f64>() * (k + 1) as f64)).collect()
    }

    /// Two passes in double precision, from values less a near constant.
    fn oracle(rows: &[DVector<f64>], near: f64) -> (DVector<f64>, DMatrix<f64>) {
        let near = DVector::repeat(3, near);
        let moved: Vec<DVector<f64>> = rows.iter().map(|row| row - &near).collect();
        let mean = moved.iter().sum::<DVector<f64>>() / rows.len() as f64;
        let scatter = moved.iter().map(|row| (row - &mean) * (row - &mean).transpose()).sum::<DMatrix<f64>>();
        (mean + near, scatter)
    }

    #[test]
    fn mean_and_scatter_are_those_of_two_passes_even_far_from_zero() {
        for offset in [0.0, 1e6] {
            let rows = rows(200, offset);
            let mut group = Group::new(3);
            rows.iter().for_each(|row| group.add(row.as_slice()));
            let (mean, scatter) = oracle(&rows, offset);
            let closed = group.close();
            assert!((&closed.mean - mean).amax() <= 1e-14 * offset.max(1.0), "{offset}");
            assert!((&closed.scatter - &scatter).amax() < 1e-12 * scatter.amax(), "{offset}");
            let two = group.select(&[2, 0]).close();
            assert_eq!((two.mean[0], two.scatter[(0, 1)]), (closed.mean[2], closed.scatter[(2, 0)]));
        }
    }

    #[test]
    fn a_level_has_the_scatter_of_means_and_within_groups() {
        let rows = rows(60, 5.0);
        let (mut one, mut other) = (Level::new(3), Level::new(3));
        let sizes = [1, 9, 20, 30];
        let (mut start, mut means, mut within) = (0, vec![], DMatrix::zeros(3, 3));
        for (k, size) in sizes.into_iter().enumerate() {
            let own = &rows[start..start + size];
            start += size;
            let mut group = Group::new(3);
            own.iter().for_each(|row| group.add(row.as_slice()));
            (if k % 2 == 0 { &mut one } else { &mut other }).add(&group.close());
            let (mean, scatter) = oracle(own, 5.0);
            means.push(mean);
            within += scatter;
        }
        one.merge(&other);
        let (mean, between) = oracle(&means, 5.0);
        assert_eq!((one.count, one.longest), (4, 30));
        assert!((one.inverse_size() - (1.0 + 1.0 / 9.0 + 0.05 + 1.0 / 30.0) / 4.0).abs() < 1e-15);
        let found = one.means();
        assert!((found.mean - mean).amax() < 1e-14 && (found.scatter - between).amax() < 1e-13);
        assert!((one.within() - within).amax() < 1e-12);
        assert_eq!(one.select(&[1]).within()[(0, 0)], one.within()[(1, 1)]);
    }

    #[test]
    fn merged_levels_have_the_counts_of_all_groups() {
        let level = |rows: &[u64]| {
            let mut level = Level::new(1);
            let (mean, scatter) = (DVector::zeros(1), DMatrix::zeros(1, 1));
            rows.iter()
                .for_each(|count| level.add(&Closed { count: *count, mean: mean.clone(), scatter: scatter.clone() }));
            level
        };
        let mut merged = level(&[1, 4]);
        merged.merge(&level(&[7, 1, 1]));
        assert_eq!((merged.count, merged.longest, merged.single, merged.rows), (5, 7, 3, 14));
    }
}
