//! The value of a MATLAB variable, from either format.

use std::fmt;

use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

/// A value, as far as it is used here.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// An array of numbers, column by column.
    Numbers {
        rows: usize,
        values: Vec<f64>,
    },
    /// An array of complex numbers, column by column.
    Complex {
        rows: usize,
        re: Vec<f64>,
        im: Vec<f64>,
    },
    Text(String),
    /// The fields of a structure.
    Fields(Vec<(String, Self)>),
    /// The elements of a structure array or cell array.
    List(Vec<Self>),
    /// What is not read, and why.
    Other(&'static str),
}

/// Why an object is not read.
pub(super) const OBJECT: &str = "a table object: save it with table2struct or parquetwrite";
pub(super) const SPARSE: &str = "sparse numbers: save it with full";
const DIMENSIONS: &str = "more than two dimensions: save its columns as a matrix";
pub(super) const EMPTY: &str = "it is empty";

impl Value {
    /// An array of numbers, column by column; sides of one are left out.
    pub(super) fn array(sides: &[usize], values: Vec<f64>) -> Self {
        let mut long = sides.iter().filter(|side| **side != 1);
        match (long.next(), long.next(), long.next()) {
            _ if values.is_empty() => Self::Other(EMPTY),
            (_, _, Some(_)) => Self::Other(DIMENSIONS),
            // A row is a column.
            (rows, across, None) => {
                Self::Numbers { rows: rows.filter(|_| across.is_some()).copied().unwrap_or(values.len()), values }
            }
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Any)
    }
}

/// Numbers of a vector, or rows of a matrix, in the order in which a reader gives them.
#[derive(Default)]
struct Rows {
    /// Numbers in a row, and whether they are complex.
    kind: Option<(usize, bool)>,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Rows {
    /// Adds a row; gives back what is none, or none of the same length.
    fn add(&mut self, element: Value) -> Option<Value> {
        let own = match &element {
            Value::Numbers { rows, values } if *rows == values.len() => (*rows, false),
            Value::Complex { rows, re, .. } if *rows == re.len() => (*rows, true),
            _ => return Some(element),
        };
        if *self.kind.get_or_insert(own) != own {
            return Some(element);
        }
        if let Value::Numbers { values, .. } = element {
            self.re.extend(values);
        } else if let Value::Complex { re, im, .. } = element {
            self.re.extend(re);
            self.im.extend(im);
        }
        None
    }

    /// The rows, each by itself.
    fn list(self) -> Vec<Value> {
        let Some((rows, is_complex)) = self.kind else { return vec![] };
        let re = self.re.chunks(rows.max(1)).map(<[f64]>::to_vec);
        if !is_complex {
            return re.map(|values| Value::Numbers { rows, values }).collect();
        }
        let im = self.im.chunks(rows.max(1)).map(<[f64]>::to_vec);
        re.zip(im).map(|(re, im)| Value::Complex { rows, re, im }).collect()
    }

    /// All of them, column by column.
    fn matrix(self) -> Value {
        let Some((columns, is_complex)) = self.kind.filter(|(columns, _)| *columns > 0) else {
            return Value::Other(EMPTY);
        };
        let rows = self.re.len() / columns;
        let by_column = |part: Vec<f64>| {
            if columns == 1 { part } else { (0..part.len()).map(|k| part[k % rows * columns + k / rows]).collect() }
        };
        match is_complex {
            true => Value::Complex { rows, re: by_column(self.re), im: by_column(self.im) },
            false => Value::Numbers { rows, values: by_column(self.re) },
        }
    }
}

struct Any;

fn scalar(value: f64) -> Value {
    Value::Numbers { rows: 1, values: vec![value] }
}

impl<'de> Visitor<'de> for Any {
    type Value = Value;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a MATLAB value")
    }

    fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
        Ok(scalar(f64::from(u8::from(value))))
    }

    fn visit_i64<E>(self, value: i64) -> Result<Value, E> {
        Ok(scalar(value as f64))
    }

    fn visit_u64<E>(self, value: u64) -> Result<Value, E> {
        Ok(scalar(value as f64))
    }

    fn visit_f64<E>(self, value: f64) -> Result<Value, E> {
        Ok(scalar(value))
    }

    fn visit_str<E>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.to_string()))
    }

    fn visit_none<E>(self) -> Result<Value, E> {
        Ok(Value::Other(EMPTY))
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Other(EMPTY))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let mut rows = Rows::default();
        let mut others = Vec::new();
        while let Some(element) = list.next_element::<Value>()? {
            if !others.is_empty() {
                others.push(element);
            } else if let Some(other) = rows.add(element) {
                others = std::mem::take(&mut rows).list();
                others.push(other);
            }
        }
        Ok(if others.is_empty() { rows.matrix() } else { Value::List(others) })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut fields = Vec::new();
        while let Some(field) = map.next_entry()? {
            fields.push(field);
        }
        // A complex number; its reader gives each one of an array as a structure.
        Ok(match &fields[..] {
            [(real, Value::Numbers { values: re, .. }), (imag, Value::Numbers { values: im, .. })]
                if real == "real" && imag == "imag" && re.len() == 1 && im.len() == 1 =>
            {
                Value::Complex { rows: 1, re: re.clone(), im: im.clone() }
            }
            _ => Value::Fields(fields),
        })
    }
}
