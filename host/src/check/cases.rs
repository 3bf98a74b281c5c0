//! Seeded inputs of the check: clouds of every family with the configurations to search them.
//!
//! A case is a function of the seed of the check and of its number, and of nothing else. Only `+ - * /` and `libm`
//! make it, so that it is the same case on every machine.

use super::{bodies, scenes, views};
use crate::region_view::RegionView;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use varsac_core::mixture::MixtureConfig;
use varsac_core::{Config, Constraint, Method};

/// What kind of input a case is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// A whole surface at unit scale with outliers: the paper's simulation.
    Surface,
    /// One side of a jujube at 500 to 1300 mm with noise and outliers.
    View,
    /// Two fruit that touch, seen from one side.
    Touching,
    /// Points of a grid, so that distances and shells have many ties.
    Grid,
    /// What determines no ellipsoid: planes, lines, equal points, hardly any points; and clouds to be refused.
    Degenerate,
    /// Any of the others at a scale where rounding, overflow or subnormals matter.
    Scale,
    /// A surface without noise, whose points are exactly as many as a target needs.
    Exact,
    /// Single stages on inputs made for their ties and edges.
    Parts,
    /// One fruit from one side with its surroundings and outline, for the default search.
    OneSided,
    /// Two to four fruit that touch, for the default search.
    Cluster,
    /// Whole surfaces without a viewpoint, for the default search.
    AllAround,
    /// Views that make no sense to the default search.
    Hostile,
    /// Whole surfaces in any unit, for the search without a size prior.
    Whole,
    /// One view of bodies of unknown size, for the search without a size prior.
    Unknown,
    /// Views that make no sense to the search without a size prior.
    Odd,
    /// Points for single fits.
    Single,
    /// A recorded view.
    Recorded,
}

/// The synthetic families in the order in which case numbers go through them.
const TURNS: [Family; 20] = [
    Family::Surface,
    Family::OneSided,
    Family::View,
    Family::Parts,
    Family::Whole,
    Family::Single,
    Family::Cluster,
    Family::Grid,
    Family::Touching,
    Family::Hostile,
    Family::Degenerate,
    Family::OneSided,
    Family::Unknown,
    Family::Odd,
    Family::Surface,
    Family::Scale,
    Family::Cluster,
    Family::View,
    Family::AllAround,
    Family::Exact,
];

/// A view from a file, to be searched besides the synthetic ones.
#[derive(Clone, Debug)]
pub struct RecordedView {
    /// The argument that names it on the command line.
    pub name: String,
    /// What the core gets to see.
    pub view: RegionView,
}

/// One input of both sides.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub(crate) family: Family,
    pub(crate) view: RegionView,
    pub(crate) config: Config,
    pub(crate) seed: u64,
}

impl Case {
    /// Case `number` of the check with this seed. With recorded views, every second case is one of them.
    pub(crate) fn generate(seed: u64, number: u64, recorded: &[RecordedView]) -> Self {
        let mut dice = Dice::new(seed, number);
        if !recorded.is_empty() && number % 2 == 1 {
            let chosen = &recorded[(number / 2) as usize % recorded.len()];
            let method = [Method::Map, Method::Varsac, Method::Mixture][(number / 2 % 3) as usize];
            return Self::recorded(chosen, method, &mut dice);
        }
        let turn = if recorded.is_empty() { number } else { number / 2 };
        let family = TURNS[(turn % TURNS.len() as u64) as usize];
        let mut config = any_config(&mut dice);
        let cloud = match family {
            Family::OneSided | Family::Cluster | Family::AllAround | Family::Hostile => {
                return Self::for_the_default_search(family, dice);
            }
            Family::Whole | Family::Unknown | Family::Odd => {
                return Self::without_a_prior(family, dice);
            }
            Family::Single => bodies::single(&mut dice),
            Family::Surface => scenes::surface(&mut dice, &mut config),
            Family::View => scenes::view(&mut dice, &mut config, 1),
            Family::Touching => scenes::view(&mut dice, &mut config, 2),
            Family::Grid => scenes::grid(&mut dice, &mut config),
            Family::Degenerate => scenes::degenerate(&mut dice, &mut config),
            Family::Scale => scenes::scaled(&mut dice, &mut config),
            Family::Exact => scenes::exact(&mut dice, &mut config),
            Family::Parts | Family::Recorded => Vec::new(),
        };
        Self { family, view: RegionView::of_cloud(cloud), config, seed: dice.word64() }
    }

    fn for_the_default_search(family: Family, mut dice: Dice) -> Self {
        let mut config = views::any_config(&mut dice);
        let view = match family {
            Family::Cluster => views::cluster(&mut dice, &mut config),
            Family::AllAround => views::all_around(&mut dice, &mut config),
            Family::Hostile => views::hostile(&mut dice, &mut config),
            _ => views::one_sided(&mut dice),
        };
        Self { family, view, config, seed: dice.word64() }
    }

    fn without_a_prior(family: Family, mut dice: Dice) -> Self {
        let whole = family == Family::Whole;
        let preset = if whole { MixtureConfig::SURFACE } else { MixtureConfig::VIEW };
        let mut config = bodies::any_config(&mut dice, preset);
        let view = match family {
            Family::Whole => bodies::whole(&mut dice),
            Family::Odd => bodies::odd(&mut dice, &mut config),
            _ => bodies::unknown(&mut dice),
        };
        Self { family, view, config, seed: dice.word64() }
    }

    fn recorded(chosen: &RecordedView, method: Method, dice: &mut Dice) -> Self {
        let mut config = Config { method, ..Config::jujube() };
        match method {
            Method::Map => views::vary(&mut config, dice),
            Method::Mixture => bodies::vary(&mut config, dice),
            Method::Varsac => vary(&mut config, dice),
        }
        config.max_trials = 1 + dice.below(40);
        Self { family: Family::Recorded, view: chosen.view.clone(), config, seed: dice.word64() }
    }
}

/// A configuration with every field at random within what finds something now and then.
fn any_config(dice: &mut Dice) -> Config {
    let mut config = Config::table5();
    vary(&mut config, dice);
    config.confidence = dice.pick(&[0.95, 0.98, 0.5, 0.999]);
    config.shell = dice.pick(&[0.1, 0.05, 0.25, 0.2]);
    config.max_trials = dice.pick(&[1, 20, 60, 150]);
    config
}

/// What may vary without spoiling a search of a recorded cloud.
fn vary(config: &mut Config, dice: &mut Dice) {
    config.sample_sizes.clear();
    let (first, count) = dice.pick(&[(9, 4), (9, 1), (12, 1), (9, 16), (20, 3), (32, 1)]);
    for size in first..first + count {
        // At most sixteen of sixteen.
        let _ = config.sample_sizes.push(size);
    }
    config.refits = dice.pick(&[0, 1, 5, 10]);
    config.min_inliers = dice.pick(&[1, 12, 20, 30]);
    config.min_ratio = dice.pick(&[0.0, 0.0, 0.3, 0.6]);
    config.max_targets = dice.pick(&[1, 2, 4, 16]);
    config.max_failures = dice.pick(&[1, 1, 2, 3]);
    config.constraint = dice.pick(&[Constraint::A11, Constraint::Trace]);
}

/// The random numbers a case is made from.
pub(crate) struct Dice(Xoshiro256PlusPlus);

impl Dice {
    /// The dice of case `number`.
    pub(crate) fn new(seed: u64, number: u64) -> Self {
        // Odd multiples of a 64-bit constant: no two cases of a check, and few of two checks, share their dice.
        Self(Xoshiro256PlusPlus::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    pub(crate) fn word(&mut self) -> u32 {
        self.0.next_u32()
    }

    pub(crate) fn word64(&mut self) -> u64 {
        self.0.next_u64()
    }

    /// Uniform in `0..bound`, up to the rounding of a remainder.
    pub(crate) fn below(&mut self, bound: u32) -> u32 {
        self.word() % bound
    }

    /// One of the choices.
    pub(crate) fn pick<T: Copy>(&mut self, choices: &[T]) -> T {
        choices[self.below(choices.len() as u32) as usize]
    }

    /// Uniform in `low..high`.
    pub(crate) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.word() >> 8) as f32 / 16_777_216.0)
    }

    /// Normal with mean 0 and deviation 1 (Box and Muller 1958).
    pub(crate) fn normal(&mut self) -> f32 {
        let u = ((self.word() >> 8) as f32 + 1.0) / 16_777_216.0;
        let turn = self.between(0.0, core::f32::consts::TAU);
        libm::sqrtf(-2.0 * libm::logf(u)) * libm::cosf(turn)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_case_is_a_function_of_seed_and_number_and_its_configuration_is_valid() {
        for number in 0..500 {
            let case = Case::generate(3, number, &[]);
            assert_eq!(case.config.check(), Ok(()), "case {number}, {:?}", case.family);
            let again = Case::generate(3, number, &[]);
            assert_eq!((&case.config, case.seed), (&again.config, again.seed));
            let bits = |case: &Case| -> Vec<u32> {
                case.view.points.iter().flat_map(|p| [p.x, p.y, p.z]).map(f32::to_bits).collect()
            };
            assert_eq!(bits(&case), bits(&again));
        }
    }

    #[test]
    fn recorded_views_take_every_second_case_and_all_searches() {
        let view = RegionView { pitch_rad: 0.5, ..RegionView::default() };
        let recorded = [RecordedView { name: "one".to_owned(), view }];
        assert_ne!(Case::generate(1, 0, &recorded).family, Family::Recorded);
        let case = |number| Case::generate(1, number, &recorded);
        assert_eq!((case(1).family, case(1).view.pitch_rad), (Family::Recorded, 0.5));
        let methods = [1, 3, 5].map(|number| case(number).config.method);
        assert_eq!(methods, [Method::Map, Method::Varsac, Method::Mixture]);
    }
}
