//! Names, polynomials and text form of a model structure.

use bearing_watch::plan::Structure;

/// Names and polynomials of a model structure.
pub trait Terms {
    /// Names of the parameters: a1…, b1…, c1…, offset.
    fn names(&self) -> Vec<String>;

    /// A, B and C of a parameter vector, and the constant. A is monic from q⁰; B and C have their delays as leading
    /// zeros.
    fn polynomials(&self, theta: &[f64]) -> ([Vec<f64>; 3], f64);
}

impl Terms for Structure {
    fn names(&self) -> Vec<String> {
        let group = |letter: char, count: u8| (1..=count).map(move |k| format!("{letter}{k}"));
        let offset = self.offset.then(|| "offset".to_string());
        group('a', self.na).chain(group('b', self.nb)).chain(group('c', self.nc)).chain(offset).collect()
    }

    fn polynomials(&self, theta: &[f64]) -> ([Vec<f64>; 3], f64) {
        let Self { na, nb, nc, nkb, nkc, .. } = *self;
        let (a, rest) = theta.split_at(na as usize);
        let (b, rest) = rest.split_at(nb as usize);
        let (c, rest) = rest.split_at(nc as usize);
        let delayed = |delay: u8, terms: &[f64]| [vec![0.0; delay as usize], terms.to_vec()].concat();
        ([[&[1.0], a].concat(), delayed(nkb, b), delayed(nkc, c)], rest.first().copied().unwrap_or(0.0))
    }
}

/// Parses `2,2,2,1,1`.
///
/// # Errors
/// A message that describes the format.
pub fn parse_order(text: &str) -> Result<Structure, String> {
    let wrong = || format!("\"{text}\" is no order; write na,nb,nc,nkb,nkc, e.g. 2,2,2,1,1");
    let trimmed = text.trim().trim_start_matches('[').trim_end_matches(']');
    let numbers = trimmed.split([',', ' ']).filter(|part| !part.is_empty()).map(str::parse::<u8>);
    let numbers: Vec<u8> = numbers.collect::<Result<_, _>>().map_err(|_| wrong())?;
    let numbers: [u8; 5] = numbers.try_into().map_err(|_| wrong())?;
    let order = Structure::from_orders(numbers);
    if order.terms() == 0 {
        return Err(format!("order {text} has no terms; give at least one of na, nb, nc"));
    }
    if numbers.iter().any(|&x| x > 32) {
        return Err(format!("order {text} has a number above 32; the detector cannot hold it"));
    }
    Ok(order)
}
