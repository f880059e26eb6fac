//! The order of a difference model, as it is written.

use serde::de::{Deserializer, Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Serialize, Serializer};

use crate::identify::{Structure, parse_order};

/// na, nb, nc, nkb, nkc: a text such as `2,2,2,1,1`, or a list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Order(pub Structure);

impl Serialize for Order {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Structure { na, nb, nc, nkb, nkc, .. } = self.0;
        serializer.serialize_str(&format!("{na},{nb},{nc},{nkb},{nkc}"))
    }
}

impl<'de> Deserialize<'de> for Order {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Written)
    }
}

struct Written;

impl<'de> Visitor<'de> for Written {
    type Value = Order;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("na,nb,nc,nkb,nkc, e.g. 2,2,2,1,1")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Order, E> {
        parse_order(text).map(Order).map_err(E::custom)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Order, A::Error> {
        let mut numbers: Vec<String> = vec![];
        while let Some(number) = list.next_element::<i64>()? {
            numbers.push(number.to_string());
        }
        parse_order(&numbers.join(",")).map(Order).map_err(A::Error::custom)
    }
}

#[cfg(feature = "schema")]
impl schemars::JsonSchema for Order {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Order".into()
    }

    fn json_schema(_: &mut schemars::SchemaGenerator) -> schemars::Schema {
        let number = serde_json::json!({ "type": "integer", "minimum": 0, "maximum": 32 });
        schemars::json_schema!({ "type": "array", "items": number, "minItems": 5, "maxItems": 5 })
    }
}
