//! The pages: results of a command enter, sections or a whole page leave.

pub mod campaign;
pub mod demo;
pub mod model;
pub mod structure;
pub mod tables;
pub mod validation;
pub mod worth;
