//! The pages: each function converts the results of a command to sections or a whole page.

pub mod campaign;
pub mod demo;
pub mod model;
pub mod structure;
pub mod tables;
pub mod validation;
pub mod worth;
