//! The note to each table, computed from its figures.

use super::chapters::chapter3::LEAST_FIT;
use super::chapters::chapter4::LITERAL;
use super::chapters::chapter5;
use super::chapters::chapter5::published::CHAPTER_5;
use super::published::{CHAPTER_4, ERROR_WITH_PCA, ERROR_WITHOUT_PCA};
use super::result::{Cell, Digits, Statistic};
use super::{Settings, Table, ours};
use crate::ema::park::AngleFrom;

/// Paragraphs in front of the tables.
#[must_use]
pub fn intro(settings: &Settings) -> Vec<String> {
    let repetitions = settings.repetitions;
    vec![
        format!(
            "The source's tables on the simulated standard rigs, beside the published figures. Figures with ± are mean and \
             standard deviation of one draw over {repetitions} draws of training and validation traces, seeds from {}; \
             the source made one draw.",
            settings.seed
        ),
        "The source's method: iv4, the a-parameters, principal components of all classes together, linear \
         discriminants. Its program (B.5) decides twice, healthy against spall (Defect A) and healthy against \
         roughness (Defect B). The tables show one decision among three classes, each binary classifier, both pooled, \
         and traces: a trace is wrong if one of the classifiers that judge it errs. Published rates are multiples of \
         1/60, the number of validation traces; the source does not state how it counted. With na = 2, two principal \
         components are an invertible map and change no decision."
            .to_string(),
        "The source prints the motor's data, but neither controller gains nor noise nor defect sizes. The rig's were \
         chosen so that healthy traces fit as well as published."
            .to_string(),
        ours::DESCRIPTION.to_string(),
        format!(
            "Chapter 5 is reproduced on the simulated actuator with defects at full size, {} draws. The thesis says \
             neither which command and load belong to which condition, nor a size of the defects. A fit \
             far below zero is that of a model by iv4 whose simulation runs away: the signals do not determine its \
             a-parameters. The rig's velocity command is the position error times a constant, so that the a-parameters \
             of Tables 5.12 and 5.13 are the same; the source saw no difference either.",
            settings.actuator_repetitions()
        ),
        chapter5::OURS_DESCRIPTION.to_string(),
    ]
}

/// The note to a finished table; `None` if a required figure is missing.
pub(super) fn of(table: &Table) -> Option<String> {
    match table.id {
        "2.2" if table.cell("error: healthy", "a").is_some() => first_order(table),
        "2.2" => separations(table),
        "3.1" => components(table),
        "3.2" if table.cell(ours::NAME, "validation").is_some() => example(table),
        "3.2" => orders(table),
        "piecewise" => pieces(table),
        "5.35" => park(table),
        id if id.starts_with('5') => actuator(table),
        _ => chapter4(table),
    }
}

/// Mean and standard deviation of a cell, as in the table.
fn shown(table: &Table, row: &str, column: &str) -> Option<String> {
    let place = table.columns.iter().position(|c| c.name == column)?;
    Some(table.cell(row, column)?.write(table.columns[place].digits))
}

/// Mean of a cell.
fn mean(table: &Table, row: &str, column: &str) -> Option<f64> {
    Some(table.statistic(row, column)?.mean)
}

/// Compares a published figure with the mean and standard deviation of single draws of `what`.
fn place(published: f64, found: Statistic, what: &str) -> String {
    let away = published - found.mean;
    let side = if away < 0.0 { "below" } else { "above" };
    match found.sd {
        Some(sd) if away.abs() <= 2.0 * sd => format!("within two standard deviations of {what}"),
        Some(sd) if sd > 0.0 => format!("{:.1} standard deviations {side} {what}", away.abs() / sd),
        _ => format!("{:.1} points {side} {what}", away.abs()),
    }
}

fn first_order(table: &Table) -> Option<String> {
    let shift = |input: &str, class: &str, parameter: &str, variance: &str| {
        let at = |name: &str, column: &str| mean(table, &format!("{input}: {name}"), column);
        let pooled = 0.5 * (at(class, variance)? + at("healthy", variance)?);
        Some((at(class, parameter)? - at("healthy", parameter)?).abs() / pooled.sqrt())
    };
    let both = |input| -> Option<String> {
        Some(format!(
            "{:.1} (a) and {:.0} (b) with the spall, {:.1} and {:.0} with the roughness",
            shift(input, "spall", "a", "σa²")?,
            shift(input, "spall", "b", "σb²")?,
            shift(input, "roughness", "a", "σa²")?,
            shift(input, "roughness", "b", "σb²")?
        ))
    };
    Some(format!(
        "The published motor module runs in open loop and is braked; the rig runs under velocity control with a load, so \
         only the shifts of the distributions compare. In standard deviations over the traces, the classes move by {} \
         for u1 = reference, and by {} for the error.",
        both("reference")?,
        both("error")?
    ))
}

fn separations(table: &Table) -> Option<String> {
    let least = |ending: &str| {
        let rows = table.rows.iter().filter(|row| row.name.ends_with(ending));
        let means = rows.map(|row| row.cells.iter().filter_map(Cell::statistic).map(|s| s.mean));
        let least = means.map(|cells| cells.fold(f64::INFINITY, f64::min));
        let (low, high) = least.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), m| (l.min(m), h.max(m)));
        (low <= high).then(|| format!("{low:.1} to {high:.1}"))
    };
    Some(format!(
        "The harder defect of each model lies {} standard deviations from healthy along all a-parameters by iv4, and {} \
         along all of a, b and c by the same estimates. The source requires 5, and leaves b and c out where na ≥ 2.",
        least("iv4: all a")?,
        least("iv4: all a b c")?
    ))
}

fn components(table: &Table) -> Option<String> {
    let value = |row: &str| Some(Digits::Power(1).write(mean(table, row, "eigenvalue")?));
    let fitting = "e1, traces that fit";
    Some(format!(
        "Of the traces whose model fits {LEAST_FIT} % or more, as the source requires ({} %), the first component has {} % \
         of the variance, published 80.57 %, and an eigenvalue of {}, published 0.0015. On this rig the signals do not \
         determine the a-parameters of this order by iv4; by least squares the first eigenvalue is {}.",
        shown(table, fitting, "traces used, %")?,
        shown(table, fitting, "contribution, %")?,
        value(fitting)?,
        value("e1, LS")?
    ))
}

fn example(table: &Table) -> Option<String> {
    let (low, high, squares) = ("[2 2 2 1 1], a1 a2", "[3 6 3 1 2], z1 z2", "[3 6 3 1 2], z1 z2 by LS");
    let error = |row: &str| shown(table, row, "validation");
    let published = |row: &str, rate: f64| {
        Some(place(rate, table.statistic(row, "validation")?, &format!("the {} % here", error(row)?)))
    };
    Some(format!(
        "The published {ERROR_WITHOUT_PCA} % of {low} is {}; the published {ERROR_WITH_PCA} % of {high} is {}. The \
         a-parameters of [3 6 3 1 2] are undetermined by iv4 (healthy fit {} %); least squares determines them (fit {} %) \
         and errs {} %.",
        published(low, ERROR_WITHOUT_PCA)?,
        published(high, ERROR_WITH_PCA)?,
        shown(table, high, "healthy fit")?,
        shown(table, squares, "healthy fit")?,
        error(squares)?
    ))
}

fn orders(table: &Table) -> Option<String> {
    let fit = |na: u8| mean(table, &format!("best fit with na = {na}"), "fit, %");
    Some(format!(
        "The source gained about 4 points of fit from its second to its third order. Here the best third order gains \
         {:.2} points on the best second, and that {:.2} on the best first.",
        fit(3)? - fit(2)?,
        fit(2)? - fit(1)?
    ))
}

fn pieces(table: &Table) -> Option<String> {
    let of = |start: &str, column: &str| {
        let row = table.rows.iter().find(|row| row.name.starts_with(start))?;
        shown(table, &row.name, column)
    };
    let error = |start: &str| of(start, "three classes");
    Some(format!(
        "Single runs cut as in the source err {} %, the medians over a trace's runs {} %, and one first-order model of the \
         whole record {} % by the same least squares. Over healthy traces b1 scatters by {} from run to run, and by {} \
         between whole records.",
        error("as the source")?,
        error("the same cut, LS, medians")?,
        error("whole record, LS, a1 b1")?,
        of("the same cut, LS, each run", "sd of b1")?,
        of("whole record, LS, a1 b1", "sd of b1")?
    ))
}

/// The note to one of Tables 4.1–4.4.
fn chapter4(table: &Table) -> Option<String> {
    let [_, published] = CHAPTER_4.iter().find(|p| p.number == table.id)?.with_pca;
    let error = |row: &str| shown(table, row, "three classes");
    let beside = |column: &str, name: &str| {
        let what = format!("the {name} {} %", shown(table, LITERAL, column)?);
        Some(place(published, table.statistic(LITERAL, column)?, &what))
    };
    Some(format!(
        "The published {published} % is {}, and {}. If one thing is changed at a time, the three-class error becomes {} % \
         with quadratic discriminants, {} % with LS in place of iv4, {} % with b and c added, and {} % with b and c added \
         and two principal components.",
        beside("three classes", "three-class error")?,
        beside("traces", "error by trace")?,
        error("the same, quadratic")?,
        error("the same, LS in place of iv4")?,
        error("iv4, a b c, no projection")?,
        error("iv4, a b c, PCA to 2")?
    ))
}

/// The note to one of Tables 5.2–5.13.
fn actuator(table: &Table) -> Option<String> {
    let published = CHAPTER_5.iter().find(|p| p.number == table.id)?;
    let error = |row: &str| shown(table, row, "misclassified");
    let fits = format!(
        "The published fit of {} % compares with a median of {} % and a least one of {} % by iv4, and a median of {} % \
         by LS.",
        published.fit_percent,
        shown(table, LITERAL, "healthy fit")?,
        shown(table, LITERAL, "worst healthy fit")?,
        shown(table, "the same, LS in place of iv4", "healthy fit")?
    );
    let rates = match published.with_pca {
        Some([_, rate]) => {
            let what = format!("the {} % here", error(LITERAL)?);
            let found = table.statistic(LITERAL, "misclassified")?;
            format!(" The published {rate} % with PCA is {}.", place(rate, found, &what))
        }
        None => String::new(),
    };
    Some(fits + &rates)
}

/// The note to Figure 5.35.
fn park(table: &Table) -> Option<String> {
    let [exact, electrical, shaft, noise, gain] = [0, 3, 6, 7, 8].map(|place| AngleFrom::ALL[place].name());
    let error = |row: &str| shown(table, row, "error of iq, % rms");
    let wrong = |row: &str| shown(table, row, "wrong verdicts, %");
    Some(format!(
        "With the resolver's angle {} % of the verdicts are wrong. A constant error of δ takes 1 − cos δ of the current: \
         10° electrical change it by {} % and leave {} % wrong, 10° of the shaft by {} % with {} % wrong. An integrated \
         velocity with the noise of the channel alone stays near the angle ({} %, {} % wrong); a gain error of 0.2 % \
         already changes the current by {} %, with {} % wrong.",
        wrong(&exact)?,
        error(&electrical)?,
        wrong(&electrical)?,
        error(&shaft)?,
        wrong(&shaft)?,
        error(&noise)?,
        wrong(&noise)?,
        error(&gain)?,
        wrong(&gain)?
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_published_figure_beside_the_scatter() {
        let found = |sd| Statistic { mean: 30.0, sd, count: 20 };
        assert_eq!(place(28.0, found(Some(5.0)), "x"), "within two standard deviations of x");
        assert_eq!(place(15.0, found(Some(5.0)), "x"), "3.0 standard deviations below x");
        assert_eq!(place(45.0, found(Some(5.0)), "x"), "3.0 standard deviations above x");
        assert_eq!(place(31.0, found(None), "x"), "1.0 points above x");
        assert_eq!(place(31.0, found(Some(0.0)), "x"), "1.0 points above x");
    }
}
