//! The value of a MATLAB variable, from either format.

use std::fmt;

use matrw::{MatVariable, MatlabType};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

/// A value, as far as it is used here.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Value {
    /// An array of numbers, column by column.
    Numbers {
        rows: usize,
        values: Vec<f64>,
    },
    Text(String),
    /// The fields of a structure.
    Fields(Vec<(String, Self)>),
    /// The elements of a structure array or cell array.
    List(Vec<Self>),
    /// Complex or sparse numbers, functions, objects.
    Other,
}

impl From<&MatVariable> for Value {
    fn from(variable: &MatVariable) -> Self {
        match variable {
            MatVariable::NumericArray(array) => {
                let (Some(own), Some(false)) = (variable.numeric_type(), variable.is_complex()) else {
                    return Self::Other;
                };
                match numbers(own) {
                    Ok(values) => Self::Numbers { rows: array.dim.first().copied().unwrap_or(0), values },
                    Err(text) => Self::Text(text),
                }
            }
            MatVariable::Structure(structure) => {
                Self::Fields(structure.value.iter().map(|(name, value)| (name.clone(), value.into())).collect())
            }
            MatVariable::StructureArray(array) => Self::List(array.value.iter().map(Self::from).collect()),
            MatVariable::CellArray(array) => Self::List(array.value.iter().map(Self::from).collect()),
            _ => Self::Other,
        }
    }
}

/// The numbers of an array, or its text.
fn numbers(array: &MatlabType) -> Result<Vec<f64>, String> {
    Ok(match array {
        MatlabType::F64(values) => values.clone(),
        MatlabType::F32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::I8(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::U8(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::I16(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::U16(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::I32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::U32(values) => values.iter().map(|x| f64::from(*x)).collect(),
        MatlabType::I64(values) => values.iter().map(|x| *x as f64).collect(),
        MatlabType::U64(values) => values.iter().map(|x| *x as f64).collect(),
        MatlabType::BOOL(values) => values.iter().map(|x| f64::from(u8::from(*x))).collect(),
        MatlabType::UTF8(text) | MatlabType::UTF16(text) => return Err(text.iter().collect()),
    })
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Any)
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
        Ok(Value::Other)
    }

    fn visit_unit<E>(self) -> Result<Value, E> {
        Ok(Value::Other)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
        let (mut numbers, mut others) = (Vec::new(), Vec::new());
        let mut columns = None;
        while let Some(element) = list.next_element::<Value>()? {
            match element {
                // A row of a matrix, or a number of a vector.
                Value::Numbers { values, .. }
                    if others.is_empty() && *columns.get_or_insert(values.len()) == values.len() =>
                {
                    numbers.extend(values);
                }
                other => others.push(other),
            }
        }
        let Some(columns) = columns.filter(|columns| others.is_empty() && *columns > 0) else {
            return Ok(Value::List(others));
        };
        let rows = numbers.len() / columns;
        let by_column = (0..numbers.len()).map(|k| numbers[k % rows * columns + k / rows]).collect();
        Ok(Value::Numbers { rows, values: by_column })
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
        let mut fields = Vec::new();
        while let Some(field) = map.next_entry()? {
            fields.push(field);
        }
        Ok(Value::Fields(fields))
    }
}
