//! Priors and costs by the names of classes.

use crate::Error;
use crate::near::among;

pub(super) fn priors(asked: &[String], classes: &[String]) -> Result<Vec<f64>, Error> {
    if asked.is_empty() {
        return Ok(vec![]);
    }
    let mut priors = vec![f64::NAN; classes.len()];
    for item in asked {
        let (name, value) = item.split_once('=').unwrap_or((item, ""));
        let prior = &mut priors[class(classes, name, "--priors")?];
        if !prior.is_nan() {
            return Err(Error::Usage(format!("--priors names {name} twice")));
        }
        *prior = number(value, "--priors", item)?;
    }
    if let Some(k) = priors.iter().position(|p| p.is_nan()) {
        return Err(Error::Usage(format!("--priors says nothing of class {}", classes[k])));
    }
    Ok(priors)
}

pub(super) fn costs(asked: &[String], classes: &[String]) -> Result<Vec<Vec<f64>>, Error> {
    if asked.is_empty() {
        return Ok(vec![]);
    }
    let n = classes.len();
    let mut costs: Vec<Vec<f64>> = (0..n).map(|i| (0..n).map(|k| f64::from(u8::from(i != k))).collect()).collect();
    for item in asked {
        let (pair, value) = item.split_once('=').unwrap_or((item, ""));
        let (decided, truth) = pair.split_once(':').ok_or_else(|| {
            Error::Usage(format!("--cost \"{item}\": write DECIDED:TRUE=COST, e.g. healthy:spall=50"))
        })?;
        let (decided, truth) = (class(classes, decided, "--cost")?, class(classes, truth, "--cost")?);
        if decided == truth {
            return Err(Error::Usage(format!("--cost \"{item}\": a right decision costs nothing")));
        }
        costs[decided][truth] = number(value, "--cost", item)?;
    }
    Ok(costs)
}

fn class(classes: &[String], name: &str, option: &str) -> Result<usize, Error> {
    let near = || among(name, classes);
    let place = classes.iter().position(|class| class == name.trim());
    place.ok_or_else(|| Error::Usage(format!("{option}: unknown class {name}{}", near())))
}

fn number(text: &str, option: &str, item: &str) -> Result<f64, Error> {
    let value = text.trim().parse().ok().filter(|x: &f64| x.is_finite() && *x >= 0.0);
    value.ok_or_else(|| Error::Usage(format!("{option} \"{item}\": after = comes a number that is not negative")))
}
