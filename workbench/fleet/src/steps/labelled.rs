//! What the labels say of each trace.

use std::collections::HashMap;

use crate::{Plan, RESERVED};
use model::Error;
use model::session::Selection;

/// What the labels say of the traces.
pub(super) struct Labelled {
    /// Further columns of the labels.
    pub(super) columns: Vec<String>,
    /// Class, unit, run and further cells of each trace.
    pub(super) of: HashMap<String, ([String; 3], Vec<String>)>,
}

impl Labelled {
    /// Of the chosen traces; unit and run are those of the plan.
    pub(super) fn new(selection: &Selection, chosen: &[(String, String)], plan: &Plan) -> Result<Self, Error> {
        let labels = selection.labels();
        let ids = || chosen.iter().map(|(id, _)| id.as_str());
        let given = [&plan.unit, &plan.group].map(Option::as_deref);
        let own = |name: &&String| {
            !RESERVED[..3].contains(&name.as_str())
                && (!RESERVED.contains(&name.as_str()) || !given.contains(&Some(name)))
        };
        let columns: Vec<String> = labels.columns().iter().filter(own).cloned().collect();
        let cells = columns.iter().map(|name| labels.cells(name, ids())).collect::<Result<Vec<_>, _>>()?;
        let column = |name: &Option<String>| name.as_ref().map(|name| labels.cells(name, ids())).transpose();
        let (units, runs) = (column(&plan.unit)?, column(&plan.group)?);
        let each = |(k, (id, class)): (usize, &(String, String))| {
            let cell = |of: &Option<Vec<String>>| of.as_ref().map(|cells| cells[k].clone());
            let (unit, run) = (cell(&units), cell(&runs));
            if unit.as_deref() == Some("") || run.as_deref() == Some("") {
                let name = if unit.as_deref() == Some("") { &plan.unit } else { &plan.group };
                let problem = format!("nothing in column {} of the labels", name.as_deref().unwrap_or_default());
                return Err(Error::trace(id, problem));
            }
            let own = unit.clone().or_else(|| run.clone()).unwrap_or_else(|| id.clone());
            let run = run.or(unit).unwrap_or_else(|| id.clone());
            Ok((id.clone(), ([class.clone(), own, run], cells.iter().map(|cells| cells[k].clone()).collect())))
        };
        Ok(Self { columns, of: chosen.iter().enumerate().map(each).collect::<Result<_, _>>()? })
    }
}
