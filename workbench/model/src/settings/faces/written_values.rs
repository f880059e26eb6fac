//! Values as a user writes them: `0.05` or `"0.05"`, `["a", "b"]` or `"a,b"`, `{ outer = 3.58 }` or `"outer=3.58"`.
//!
//! The command line gives every value as text; a drive file and Python also give numbers and truth values. A field of
//! the settings has one type: this deserialiser converts a value to it where nothing is lost.
//! What does not fit is a [`Problem`].

use serde::de::value::{SeqDeserializer, StringDeserializer};
use serde::de::{
    self, Deserialize, DeserializeOwned, DeserializeSeed, Deserializer, IntoDeserializer, MapAccess, SeqAccess, Visitor,
};
use serde::forward_to_deserialize_any;
use serde_json::Value;

/// Converts a value as a user writes it.
///
/// # Errors
/// What does not fit.
pub fn from_value<T: DeserializeOwned>(value: Value) -> Result<T, Problem> {
    T::deserialize(Lenient(value))
}

impl de::Error for Problem {
    fn custom<T: std::fmt::Display>(text: T) -> Self {
        Self::Value(text.to_string())
    }
}

/// A value that may be written in another kind.
struct Lenient(Value);

impl<'de> IntoDeserializer<'de, Problem> for Lenient {
    type Deserializer = Self;

    fn into_deserializer(self) -> Self {
        self
    }
}

/// A number or a text as text.
fn text(value: Value) -> Result<String, Problem> {
    match value {
        Value::String(text) => Ok(text),
        Value::Number(number) => Ok(number.to_string()),
        Value::Bool(_) => Err(Problem::Kind("takes no true or false")),
        _ => Err(Problem::Kind("takes a text or a number")),
    }
}

/// The elements of a list; a text is one with commas, and a table is one of `key=value`.
fn elements(value: Value) -> Result<Vec<Value>, Problem> {
    let parts = |text: &str| text.split(',').map(|part| Value::from(part.trim())).collect::<Vec<_>>();
    match value {
        Value::String(text) => Ok(parts(&text)),
        Value::Array(list) => Ok(list
            .into_iter()
            .flat_map(|own| match own {
                Value::String(text) => parts(&text),
                other => vec![other],
            })
            .collect()),
        Value::Object(table) => {
            let pair = |(key, value): (String, Value)| Ok(Value::from(format!("{key}={}", text(value)?)));
            table.into_iter().map(pair).collect()
        }
        Value::Number(_) => Ok(vec![value]),
        Value::Bool(_) => Err(Problem::Kind("takes no true or false")),
        Value::Null => Ok(vec![]),
    }
}

/// Numbers: as they are, or from text.
macro_rules! numbers {
    ($($method:ident $kind:ty),+ $(,)?) => {
        $(fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
            match self.0 {
                Value::String(text) => match text.trim().parse::<$kind>() {
                    Ok(number) => number.into_deserializer().deserialize_any(visitor),
                    Err(problem) => Err(Problem::Value(problem.to_string())),
                },
                Value::Number(number) => {
                    // A whole number may come as one of floating point.
                    let whole = number.as_f64().filter(|x| x.fract() == 0.0 && x.abs() < 9e15).map(|x| x as i64);
                    if let Some(whole) = number.as_u64() {
                        visitor.visit_u64(whole)
                    } else if let Some(whole) = number.as_i64().or(whole) {
                        visitor.visit_i64(whole)
                    } else {
                        visitor.visit_f64(number.as_f64().unwrap_or(f64::NAN))
                    }
                }
                Value::Bool(_) => Err(Problem::Kind("takes no true or false")),
                _ => Err(Problem::Kind("takes a number")),
            }
        })+
    };
}

impl<'de> Deserializer<'de> for Lenient {
    type Error = Problem;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        match self.0 {
            Value::Null => visitor.visit_unit(),
            Value::Bool(_) => Err(Problem::Kind("takes no true or false")),
            Value::Number(_) | Value::String(_) => visitor.visit_string(text(self.0)?),
            Value::Array(list) => visitor.visit_seq(SeqDeserializer::new(list.into_iter().map(Lenient))),
            Value::Object(table) => visitor.visit_map(Table { rest: table.into_iter(), next: None }),
        }
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        self.0.as_bool().map_or(Err(Problem::Kind("is true or false")), |flag| visitor.visit_bool(flag))
    }

    fn deserialize_string<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        visitor.visit_string(text(self.0)?)
    }

    fn deserialize_str<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        self.deserialize_string(visitor)
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        if self.0.is_null() { visitor.visit_none() } else { visitor.visit_some(self) }
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Problem> {
        let elements = elements(self.0)?;
        visitor.visit_seq(SeqDeserializer::new(elements.into_iter().map(Lenient)))
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Problem> {
        let word: StringDeserializer<Problem> = text(self.0)?.into_deserializer();
        word.deserialize_enum(name, variants, visitor)
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, _: &'static str, visitor: V) -> Result<V::Value, Problem> {
        visitor.visit_newtype_struct(self)
    }

    numbers! {
        deserialize_i8 i8, deserialize_i16 i16, deserialize_i32 i32, deserialize_i64 i64, deserialize_u8 u8,
        deserialize_u16 u16, deserialize_u32 u32, deserialize_u64 u64, deserialize_f32 f32, deserialize_f64 f64,
    }

    forward_to_deserialize_any! {
        i128 u128 char bytes byte_buf unit unit_struct tuple tuple_struct map struct identifier ignored_any
    }
}

/// The fields of a table; a problem with a value has the name of its field.
struct Table {
    rest: serde_json::map::IntoIter,
    next: Option<(String, Value)>,
}

impl<'de> MapAccess<'de> for Table {
    type Error = Problem;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Problem> {
        self.next = self.rest.next();
        self.next.as_ref().map(|(key, _)| seed.deserialize(Lenient(key.clone().into()))).transpose()
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, Problem> {
        let (key, value) = self.next.take().unwrap_or_default();
        seed.deserialize(Lenient(value)).map_err(|problem| Problem::Field(key, Box::new(problem)))
    }
}

/// One value, or a list of them; a text is not taken apart.
pub(crate) fn one_or_more<'de, D: Deserializer<'de>, T: Deserialize<'de>>(deserializer: D) -> Result<Vec<T>, D::Error> {
    struct Several<T>(std::marker::PhantomData<T>);

    impl<'de, T: Deserialize<'de>> Visitor<'de> for Several<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("a text or a list of texts")
        }

        fn visit_str<E: de::Error>(self, text: &str) -> Result<Vec<T>, E> {
            T::deserialize(text.into_deserializer()).map(|one| vec![one])
        }

        fn visit_unit<E: de::Error>(self) -> Result<Vec<T>, E> {
            Ok(vec![])
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Vec<T>, A::Error> {
            let mut all = vec![];
            while let Some(one) = list.next_element()? {
                all.push(one);
            }
            Ok(all)
        }
    }

    deserializer.deserialize_any(Several(std::marker::PhantomData))
}

/// A number above zero.
pub(crate) fn above_zero<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    let refused = || de::Error::custom("give a number above 0");
    let given = Option::<f64>::deserialize(deserializer).map_err(|_| refused())?;
    if given.is_some_and(|number| number.is_nan() || number <= 0.0 || number.is_infinite()) {
        return Err(refused());
    }
    Ok(given)
}

/// Why a value does not fit its field.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Problem {
    /// It is of another kind: a verb and its object.
    #[error("{0}")]
    Kind(&'static str),
    /// It is out of range, or no such word.
    #[error("{0}")]
    Value(String),
    /// The field of a table with a value that does not fit.
    #[error("{0}: {1}")]
    Field(String, Box<Self>),
}

impl Problem {
    /// The problem without the names of tables.
    pub(crate) fn plain(self) -> Self {
        if let Self::Field(_, inner) = self { inner.plain() } else { self }
    }
}

/// A field with a value that does not fit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Refused {
    /// The field.
    pub key: String,
    /// The value, as text.
    pub value: String,
    /// Why.
    pub problem: Problem,
}

impl std::fmt::Display for Refused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { key, value, problem } = self;
        match problem {
            Problem::Kind(_) => write!(f, "{key} {problem}"),
            Problem::Value(_) | Problem::Field(..) => write!(f, "invalid value '{value}' for {key}: {problem}"),
        }
    }
}

/// A value as a user would write it on one line.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Array(list) => list.iter().map(shown).collect::<Vec<_>>().join(","),
        other => other.to_string(),
    }
}
