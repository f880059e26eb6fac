//! Settings that follow from others.

use super::order::Order;
use super::whole::Settings;
use crate::identify::Structure;

/// Order of the difference model that is tried first on a new drive: the source's Table 4.1.
const ORDER: Structure = Structure::new(2, 1, 2, 1, 1);
/// The same without a second input.
const ORDER_OF_ONE: Structure = Structure::new(2, 1, 0, 1, 1);

impl Settings {
    /// These settings with those that follow: output, inputs and order from the signals of the shaft.
    #[must_use]
    pub fn completed(mut self) -> Self {
        let own = &mut self.channels;
        own.y = own.y.take().or_else(|| own.current.clone());
        own.u1 = own.u1.take().or_else(|| own.velocity_ref.clone()).or_else(|| own.velocity.clone());
        own.u2 = own.u2.take().or_else(|| own.load.clone());
        let order = if own.u2.is_some() { ORDER } else { ORDER_OF_ONE };
        self.model.order = self.model.order.or(Some(Order(order)));
        // An output without an input is described by its own past: no order of it reads the first input.
        if self.model.order.as_ref().is_some_and(|Order(order)| order.nb == 0) {
            own.u1 = own.u1.take().or_else(|| own.y.clone());
        }
        self
    }
}
