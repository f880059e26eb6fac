//! oxictl's half of `cargo xtask peers`: least squares and instrumental variables of one input, two terms each.

use std::hint::black_box;
use std::time::Instant;

use oxictl::sysid::{ArxIdentifier, ArxModel, IvIdentifier, RefIvIdentifier, SysIdError};
use serde_json::{Value, json};

type Outcome = Result<ArxModel<f64, 2, 2>, SysIdError>;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).ok_or("usage: peers-oxictl DIR")?;
    let text = std::fs::read_to_string(format!("{folder}/train.csv"))?;
    let rows = text.lines().skip(1).map(|line| line.split(',').map(str::parse).collect());
    let rows: Vec<Vec<f64>> = rows.collect::<Result<_, _>>()?;
    let column = |k: usize| -> Vec<f64> { rows.iter().map(|row| row[k]).collect() };
    let y = column(0);
    let mut result = json!({});
    for (name, u) in [("error", column(1)), ("reference", column(3))] {
        result[name] = json!({
            "ls": timed(|| ArxIdentifier::<f64, 2, 2, 4, 1>::fit(&y, &u)),
            "iv": timed(|| IvIdentifier::<f64, 2, 2, 4, 1>::fit_iv(&y, &u, 1)),
            "refined_iv": timed(|| RefIvIdentifier::<f64, 2, 2, 4, 1>::fit_riv(&y, &u, 50, 1e-6)),
        });
    }
    println!("{result}");
    Ok(())
}

/// Median time and the estimate, or why there is none.
fn timed(call: impl Fn() -> Outcome) -> Value {
    let mut times: Vec<f64> = (0..201)
        .map(|_| {
            let start = Instant::now();
            let _ = black_box(call());
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    match call() {
        Ok(model) => {
            let theta = [model.a, model.b].concat();
            json!({ "s": times[100], "theta": theta })
        }
        Err(error) => json!({ "s": times[100], "failed": format!("{error:?}") }),
    }
}
