//! The estimators, each with the noise that it takes for given.

pub(crate) mod armax;
pub(crate) mod external;
pub(crate) mod incomplete;
pub(crate) mod instruments;
pub(crate) mod iv;
pub(crate) mod iv4;
pub(crate) mod ls;
pub(crate) mod output_error;
pub(crate) mod robust;
pub(crate) mod sriv;
pub(crate) mod steiglitz_mcbride;
