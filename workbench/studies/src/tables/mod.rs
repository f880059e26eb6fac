//! The source's tables on the standard rigs, compared with the published figures.
//!
//! ```text
//! seed ─► draw: traces, estimates (shared) ─► distributions 2.2, chapter3, chapter4, pieces ─► Table, a value per cell
//!         once per repetition                 ours: training and verdicts of our method          │ absorb
//!         published: as printed                                           notes ─► render ◄──────┘ mean ± sd
//! ```
//!
//! Each repetition draws a training and a validation set; no two sets share a trace. Standard deviations are those of
//! one repetition, not of the mean, because the source made a single draw.

mod chapters;
pub mod draw;
pub mod notes;
pub mod ours;
mod overview;
pub mod published;
pub mod recorded;
pub mod render;
pub mod result;
mod settings;

pub use chapters::chapter5;
use chapters::{chapter3, chapter4, distributions, pieces};
use draw::Draw;
use model::Error;
pub use result::{Cell, Statistic, Table};
use rig::ema::EmaCondition;
pub use settings::{Id, Settings};

/// Computes the tables; `done` is called once per step.
///
/// The repetitions run one after the other, and each uses all processor cores for its traces: only one draw is in
/// memory at a time.
///
/// # Errors
/// Returns an error if a trace cannot be simulated or estimated, or features are singular.
pub fn run(settings: &Settings, done: impl Fn()) -> Result<Vec<Table>, Error> {
    let mut all: Vec<Table> = vec![];
    for repetition in 0..settings.repetitions {
        let mut draws = Draws::new(settings, repetition)?;
        done();
        for id in settings.of(repetition) {
            for table in draws.measure(id)? {
                match all.iter_mut().find(|known| known.title == table.title) {
                    Some(known) => known.absorb(table),
                    None => all.push(table),
                }
            }
            done();
        }
    }
    for table in &mut all {
        table.words = notes::of(table).into_iter().collect();
    }
    Ok(overview::of(&all).into_iter().chain(all).collect())
}

/// The draws of one repetition.
struct Draws {
    sets: (u32, u32),
    /// That of the DC motor, if a table needs it.
    motor: Option<Draw>,
    /// That of the actuator's last condition: tables of one condition follow each other.
    actuator: Option<chapter5::draw::Draw>,
}

impl Draws {
    fn new(settings: &Settings, repetition: u32) -> Result<Self, Error> {
        let sets = settings.sets(repetition);
        let chapter_3 = settings.tables.iter().any(|id| id.name().starts_with('3'));
        let needed = settings.tables.iter().any(|id| !id.is_chapter_5());
        let motor = needed.then(|| Draw::new(sets, chapter_3)).transpose()?;
        Ok(Self { sets, motor, actuator: None })
    }

    fn measure(&mut self, id: Id) -> Result<Vec<Table>, Error> {
        if id == Id::PARK {
            return Ok(vec![chapter5::park::measure(self.sets)?]);
        }
        if let Some(published) = chapter5::published::CHAPTER_5.iter().find(|table| table.number == id.name()) {
            return Ok(vec![chapter5::measure(published, self.actuator(published)?)?]);
        }
        self.motor.as_ref().map_or(Ok(vec![]), |draw| measure(id, draw))
    }

    fn actuator(&mut self, published: &chapter5::published::Published) -> Result<&chapter5::draw::Draw, Error> {
        let draw = match self.actuator.take().filter(|draw| draw.condition().name == published.condition) {
            Some(draw) => draw,
            None => {
                let condition = EmaCondition::named(published.condition);
                let unknown = || Error::Usage(format!("no condition {}", published.condition));
                chapter5::draw::Draw::new(&condition.ok_or_else(unknown)?, self.sets)?
            }
        };
        Ok(self.actuator.insert(draw))
    }
}

/// The tables of the DC motor.
fn measure(id: Id, draw: &Draw) -> Result<Vec<Table>, Error> {
    match id.name() {
        "2.2" => Ok(vec![distributions::first_order(draw)?, distributions::separations(draw)?]),
        "3.1" => Ok(vec![chapter3::components(draw)?]),
        "3.2" => Ok(vec![chapter3::misclassified(draw)?, chapter3::orders(draw)?]),
        "piecewise" => Ok(vec![pieces::measure(draw)?]),
        number => published::CHAPTER_4
            .iter()
            .filter(|table| table.number == number)
            .map(|table| chapter4::measure(table, draw))
            .collect(),
    }
}
