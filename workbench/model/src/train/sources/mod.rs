//! A trained model as source: Rust with the plan and the front end, and a header of C.

pub mod c_header;
pub(crate) mod c_name;
pub(crate) mod c_text;
pub(crate) mod drive_header;
pub mod export;
pub mod front_end_header;
pub mod front_end_source;
