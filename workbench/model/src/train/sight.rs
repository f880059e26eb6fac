//! What segments show of each bearing order, which [`super::sizes`] computes.

use crate::core::Parts;

/// The constants of an order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrderSight {
    /// The place of the order.
    pub order: usize,
    /// The score that a defect needs.
    pub needed_score: f64,
    /// The usual amplitude of the smallest defect, A; `None` if no segment shows one.
    pub usual_a: Option<f64>,
    /// The largest sizes of the smallest defect with which a segment may be called healthy: the amplitude over the
    /// deviation of the noise, and the amplitude, A.
    pub most_relative: f64,
    pub most_a: f64,
}

/// The constants of all orders whose scores a gate judges.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sight {
    /// The orders.
    pub orders: Vec<OrderSight>,
}

impl Sight {
    /// Returns the parts with these constants.
    #[must_use]
    pub fn parts(&self, parts: &Parts) -> Parts {
        let mut parts = parts.clone();
        if let Some((_, shaft)) = &mut parts.shaft {
            for own in &self.orders {
                let order = &mut shaft.tracking.orders[own.order];
                order.needed_score = own.needed_score as f32;
                (order.most_relative, order.most_a) = (own.most_relative as f32, own.most_a as f32);
            }
        }
        parts
    }
}
