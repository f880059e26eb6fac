//! The scores of one direction: its run as it stands, what is known of the drive, and the sums of its bets.
//!
//! Enters: y of each segment, and where a run ends. Leaves: T of each bet, what the direction contributes, and its
//! growth. The numbers of equations are those of [`super`].

use crate::alarm::growth::{self, Contribution, Course, Growth};
use crate::decide::{Direction, FeatureValue};
use crate::logarithm::cube_root;
use crate::regression::factor::pairs;

/// δ of (5), in standard deviations of a usual run.
const BETS: [f32; 3] = [1.0, 2.0, 4.0];
/// The variance of runs is wider by this factor for each alarm of a direction that was denied, and by so many at most.
/// Half as wide again each time, the law is then 3.4 times as wide: it hides no defect that is larger.
const WIDER: f32 = 2.25;
const MOST_DENIED: u8 = 3;
/// A smaller skewness has no effect.
const SKEWED: f32 = 0.05;
/// An offset that is unexpected by more than so many deviations lasts as if it were by these: a defect, or a disturbed
/// run, is no offset that comes and goes.
const LASTS: f32 = 4.0;
/// Standard deviations by which a size is plain in a segment.
const PLAIN: f32 = 4.0;
/// A bet counts for the onset if its score is at least this part of the direction's largest.
const SUPPORTS: f32 = 0.7;

/// A direction.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub(super) struct Scores {
    /// The coordinate that a defect raises.
    coordinate: u8,
    order: bool,
    /// U, B as trained, W, γ and ρ.
    between: f32,
    run: f32,
    segment: f32,
    skewness: f32,
    correlation: f32,
    /// N and Y of (1).
    count: f32,
    sum: f32,
    /// Λ and Q of (3).
    precision: f32,
    weighted: f32,
    /// α, c and P of (10) after the last run.
    lasting: Lasting,
    /// Λ and Q when no bet had evidence of a change; from the first denial on it stays.
    sure: [f32; 2],
    /// S of (6), and the number of the last segment at which it held no evidence.
    scores: [f32; BETS.len()],
    since: [u32; BETS.len()],
    /// (x − û)/s of the last run.
    deviations: f32,
    /// How many alarms were denied, up to [`MOST_DENIED`].
    denied: u8,
    course: Course,
}

/// Words of a direction in a saved state.
pub(in crate::alarm) const WORDS: usize = 17 + growth::WORDS;

/// What the bets of a run are judged by: n₀, q, ln min(n, n₀), and the cap of (5).
#[derive(Clone, Copy)]
pub(super) struct Terms {
    pub(super) usual_segments: f32,
    pub(super) margin: f32,
    pub(super) log: f32,
    pub(super) cap: f32,
}

/// The offset of a run, α − c r for a drive of the mean r, and the variance of its error.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
struct Lasting {
    offset: f32,
    part: f32,
    variance: f32,
}

/// y, h and s² of (2): what a run says of the drive's mean r is y = h r, with this variance.
#[derive(Clone, Copy)]
struct News {
    y: f32,
    part: f32,
    variance: f32,
}

impl News {
    /// (y − h r)/s.
    fn deviations(self, reference: f32) -> f32 {
        (self.y - self.part * reference) / libm::sqrtf(self.variance)
    }
}

/// Whether a run that ends is learned, and if so, only by (9).
#[derive(Clone, Copy)]
pub(super) struct Lesson {
    pub(super) learns: bool,
    pub(super) guarded: bool,
}

impl Scores {
    pub(super) fn new(direction: &Direction, usual_segments: f32) -> Self {
        let Direction { coordinate, order, between, run, segment, skewness, correlation, .. } = *direction;
        let mut scores = Self {
            coordinate,
            order,
            between,
            run,
            segment,
            skewness,
            correlation,
            count: 0.0,
            sum: 0.0,
            precision: 1.0,
            weighted: 0.0,
            lasting: Lasting { offset: 0.0, part: 0.0, variance: run },
            sure: [1.0, 0.0],
            scores: [0.0; BETS.len()],
            since: [0; BETS.len()],
            deviations: 0.0,
            denied: 0,
            course: Course::new(between),
        };
        scores.reset(usual_segments);
        scores
    }

    pub(super) fn reset(&mut self, usual_segments: f32) {
        (self.count, self.sum, self.deviations, self.denied) = (0.0, 0.0, 0.0, 0);
        (self.precision, self.weighted) = (1.0 / self.between, 0.0);
        self.sure = [self.precision, self.weighted];
        self.lasting = Lasting { offset: 0.0, part: 0.0, variance: self.run };
        (self.scores, self.since) = ([0.0; BETS.len()], [0; BETS.len()]);
        let s = self.usual(self.run, usual_segments);
        self.course = Course::new(self.between / (s * s));
    }

    /// (1).
    pub(super) fn add(&mut self, y: &FeatureValue) {
        if !y.is_missing() {
            let weight = 1.0 / (1.0 + y.variance / self.segment);
            self.count += weight;
            self.sum += weight * y.value;
        }
    }

    /// (10): what is expected of the next run.
    fn expected(&self) -> Lasting {
        let Lasting { offset, part, variance } = self.lasting;
        let (rho, squared) = (self.correlation, self.correlation * self.correlation);
        let variance = squared * variance + (1.0 - squared) * self.run_variance();
        Lasting { offset: rho * offset, part: rho * part, variance }
    }

    /// (2); `None` if the direction had no value.
    fn news(&self) -> Option<News> {
        let Lasting { offset, part, variance } = self.expected();
        let (x, _) = self.mean()?;
        Some(News { y: x - offset, part: 1.0 - part, variance: variance + self.segment / self.count })
    }

    /// r of (3).
    fn reference(&self, margin: f32) -> f32 {
        self.weighted / self.precision + margin / libm::sqrtf(self.precision)
    }

    /// x, and its variance B + W/N where nothing is known of other runs; `None` if the direction had no value.
    fn mean(&self) -> Option<(f32, f32)> {
        (self.count > 0.0).then(|| (self.sum / self.count, self.run_variance() + self.segment / self.count))
    }

    /// B, wider after alarms that were denied.
    fn run_variance(&self) -> f32 {
        match self.denied {
            0 => self.run,
            1 => self.run * WIDER,
            2 => self.run * (WIDER * WIDER),
            _ => self.run * (WIDER * WIDER * WIDER),
        }
    }

    /// T of (6) for each bet.
    #[inline(never)]
    fn sequence(&self, terms: Terms) -> [f32; BETS.len()] {
        let Some(news) = self.news() else { return self.scores };
        let z = normal_score(news.deviations(self.reference(terms.margin)), self.skewness);
        let of_offset = news.variance - self.segment / self.count;
        let usual = self.usual(of_offset, terms.usual_segments) / libm::sqrtf(news.variance);
        let mut all = self.scores;
        for (score, bet) in pairs(&mut all, BETS) {
            let a = bet * usual;
            let gain = a * z - 0.5 * a * a;
            // Written so that NaN adds nothing.
            let gain = if gain < terms.cap {
                gain
            } else if gain >= terms.cap {
                terms.cap
            } else {
                0.0
            };
            *score = score.max(terms.log) + gain;
        }
        all
    }

    /// The largest T, and the deviations of the run as it stands.
    pub(super) fn largest(&self, terms: Terms) -> (f32, f32) {
        let top = self.sequence(terms).into_iter().fold(0.0, f32::max);
        (top, self.mean().map_or(0.0, |mean| self.deviations_of(mean)))
    }

    /// The largest S.
    pub(super) fn score(&self) -> f32 {
        self.scores.iter().copied().fold(0.0, f32::max)
    }

    /// What the direction contributes, whose index is this.
    pub(super) fn contribution(&self, direction: u8) -> Contribution {
        let score = self.score();
        let mut latest = 0;
        for (s, segment) in self.scores.iter().zip(self.since) {
            if *s >= SUPPORTS * score && segment > latest {
                latest = segment;
            }
        }
        Contribution { direction, deviations: self.deviations, score, since: latest }
    }

    /// The same in the run that is not ended, with its score.
    pub(super) fn standing(&self, direction: u8, score: f32) -> Contribution {
        let deviations = self.mean().map_or(self.deviations, |mean| self.deviations_of(mean));
        Contribution { deviations, score, ..self.contribution(direction) }
    }

    /// The growth to a size in standard deviations of usual runs, or to one that a segment shows.
    pub(super) fn growth(&self, usual_segments: f32, named: Option<f32>) -> Growth {
        let s = self.usual(self.run, usual_segments);
        let named = named.unwrap_or_else(|| self.plain() / s);
        let reference = self.weighted / self.precision / s;
        self.course.growth(reference, 1.0 / self.precision / (s * s), named)
    }

    /// The standard deviation of usual runs with this variance between runs; s₀ with B.
    fn usual(&self, between_runs: f32, usual_segments: f32) -> f32 {
        libm::sqrtf(between_runs + self.segment / usual_segments)
    }

    /// The size by which one segment of an unknown drive is four deviations from those of healthy drives.
    fn plain(&self) -> f32 {
        PLAIN * libm::sqrtf(self.between + self.run + self.segment)
    }

    /// Takes the run that ends into the course of the size, after so many usual runs.
    pub(super) fn grow(&mut self, passed: f32, usual_segments: f32) {
        let s = self.usual(self.run, usual_segments);
        self.course.pass(passed, self.weighted / self.precision / s);
        if let Some((x, variance)) = self.mean() {
            self.course.take(x / s, variance / (s * s));
        }
    }

    /// (x − û)/s.
    fn deviations_of(&self, (x, variance): (f32, f32)) -> f32 {
        (x - self.weighted / self.precision) / libm::sqrtf(variance)
    }

    /// Ends the run at this segment.
    pub(super) fn end(&mut self, terms: Terms, lesson: Lesson, now: u32) {
        let expected = self.expected();
        let (Some(mean), Some(news)) = (self.mean(), self.news()) else {
            self.lasting = expected;
            return;
        };
        let all = self.sequence(terms);
        for ((score, since), t) in pairs(pairs(&mut self.scores, &mut self.since), all) {
            *score = t.max(0.0);
            if t <= terms.log {
                *since = now;
            }
        }
        let no_evidence = all.iter().all(|t| *t <= terms.log);
        self.deviations = self.deviations_of(mean);
        self.lasting = follow(expected, news, self.reference(terms.margin));
        if lesson.learns && (!lesson.guarded || (no_evidence && self.is_sure(mean, terms))) {
            let News { y, part, variance } = news;
            self.precision += part * part / variance;
            self.weighted += part * y / variance;
        }
        if no_evidence && !lesson.guarded {
            self.sure = [self.precision, self.weighted];
        }
        (self.count, self.sum) = (0.0, 0.0);
    }

    /// (9).
    fn is_sure(&self, (x, variance): (f32, f32), terms: Terms) -> bool {
        let [precision, weighted] = self.sure;
        (x - weighted / precision).abs() <= terms.margin * libm::sqrtf(1.0 / precision + variance)
    }

    /// Whether an alarm of the direction was denied.
    pub(super) const fn is_denied(&self) -> bool {
        self.denied > 0
    }

    /// Widens the law, for at most [`MOST_DENIED`] times.
    pub(super) fn widen(&mut self) {
        if self.denied < MOST_DENIED {
            self.denied = self.denied.wrapping_add(1);
            self.lasting.variance *= WIDER;
        }
    }

    /// Forgets what the runs since the last one without evidence have taught.
    pub(super) const fn unlearn(&mut self) {
        [self.precision, self.weighted] = self.sure;
    }

    /// Starts the sums afresh at this segment.
    pub(super) const fn start(&mut self, now: u32) {
        (self.count, self.sum) = (0.0, 0.0);
        (self.scores, self.since) = ([0.0; BETS.len()], [now; BETS.len()]);
    }

    /// Whether the drive's usual mean is more than three deviations of drives from that of the fleet.
    pub(super) fn is_far(&self) -> bool {
        (self.weighted / self.precision).abs() > 3.0 * libm::sqrtf(self.between)
    }

    /// Whether it is the strength of a bearing order.
    pub(super) const fn is_order(&self) -> bool {
        self.order
    }

    /// The coordinate that a defect raises.
    pub(super) const fn coordinate(&self) -> u8 {
        self.coordinate
    }

    /// Hands out the words in their order.
    pub(super) fn save(&self, put: &mut impl FnMut(u32)) {
        let Self { count, sum, precision, weighted, lasting, sure, scores, since, deviations, course, .. } = self;
        let Lasting { offset, part, variance } = *lasting;
        let of_runs = [*count, *sum, *precision, *weighted, offset, part, variance];
        of_runs.iter().chain(sure).chain(scores).for_each(|x| put(x.to_bits()));
        since.iter().for_each(|segment| put(*segment));
        put(deviations.to_bits());
        put(self.denied.into());
        course.save(put);
    }

    /// Takes the words in their order; `None` if one is missing, or none that `segments` segments can leave.
    pub(super) fn restore(&mut self, take: &mut impl FnMut() -> Option<u32>, segments: u32) -> Option<()> {
        let mut float = || take().map(f32::from_bits);
        (self.count, self.sum) = (float()?, float()?);
        (self.precision, self.weighted) = (float()?, float()?);
        self.lasting = Lasting { offset: float()?, part: float()?, variance: float()? };
        self.sure = [float()?, float()?];
        for score in &mut self.scores {
            *score = float()?;
        }
        for since in &mut self.since {
            *since = take()?;
        }
        (self.deviations, self.denied) = (f32::from_bits(take()?), u8::try_from(take()?).ok()?);
        self.course = Course::restore(take)?;
        let Self { count, sum, precision, weighted, lasting, sure, scores, since, deviations, between, .. } = *self;
        let numbers = [sum, weighted, lasting.offset, sure[1], deviations].iter().all(|x| x.is_finite());
        let lasts = (0.0..=1.01).contains(&lasting.part) && lasting.variance >= 0.0;
        let numbers = numbers && lasts && lasting.variance <= 1.01 * self.run_variance();
        let counted = (0.0..=1.01 * segments as f32 + 1.0).contains(&count) && self.denied <= MOST_DENIED;
        let known = sure[0] >= 0.99 / between && precision >= sure[0] && precision.is_finite();
        let scored = scores.iter().all(|score| (0.0..f32::INFINITY).contains(score));
        let good = numbers && counted && known && scored && since.iter().all(|segment| *segment <= segments);
        good.then_some(())
    }
}

/// (10) after a run, for a drive of the mean r.
fn follow(expected: Lasting, news: News, reference: f32) -> Lasting {
    let gain = expected.variance / news.variance;
    let deviations = news.deviations(reference);
    // Written so that NaN changes nothing.
    let lasts = if deviations.abs() <= LASTS {
        deviations
    } else if deviations > LASTS {
        LASTS
    } else if deviations < -LASTS {
        -LASTS
    } else {
        0.0
    };
    Lasting {
        offset: expected.offset + gain * (lasts * libm::sqrtf(news.variance) + news.part * reference),
        part: expected.part + gain * news.part,
        variance: expected.variance * (1.0 - gain),
    }
}

/// z of (4).
#[inline(never)]
pub(super) fn normal_score(t: f32, skewness: f32) -> f32 {
    if skewness < SKEWED {
        return t;
    }
    let level = 1.0 + 0.5 * skewness * t;
    (6.0 / skewness) * (cube_root(level) - 1.0) + skewness / 6.0
}
