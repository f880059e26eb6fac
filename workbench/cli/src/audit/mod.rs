//! `bearing-watch audit`

mod asked;
mod audited;
mod command;
mod findings;
mod page;
mod words;
mod work;

pub(crate) use asked::Args;
pub(crate) use command::run;
pub(crate) use page::page_of;
