//! The kinds of fruit a user can name, and what each name sets: size, its spread, and the limits of the paper's search.
//!
//! Colour presets of the same names are in [`crate::segment`].

use clap::ValueEnum;
use varsac_core::{Config, MapConfig, SizePrior};

/// `--fruit`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Fruit {
    /// Lingwu long jujube, about 44 x 22 x 22 mm.
    Jujube,
    /// Apple, 54 to 100 mm.
    Apple,
    /// Tomato, 44 to 100 mm.
    Tomato,
    /// Lemon, about 65 x 52 x 52 mm.
    Lemon,
    /// Kiwi fruit, about 68 x 52 x 46 mm.
    Kiwi,
    /// Hen's egg, about 57 x 44 x 44 mm.
    Egg,
    /// Cherry tomato, 20 to 40 mm.
    CherryTomato,
    /// Any fruit of 10 to 120 mm: limits for the paper's methods; to the others its size is unknown.
    Generic,
    /// Any ellipsoid of any size: no limits.
    None,
}

impl Fruit {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jujube => "jujube",
            Self::Apple => "apple",
            Self::Tomato => "tomato",
            Self::Lemon => "lemon",
            Self::Kiwi => "kiwi",
            Self::Egg => "egg",
            Self::CherryTomato => "cherry-tomato",
            Self::Generic => "generic",
            Self::None => "none",
        }
    }

    /// The configuration for this fruit: the default search with the fruit's size. Limits of the paper's search are about
    /// 0.8 times the shortest and 1.25 times the longest semi-axis of the sizes named above; its radius spans the fruit from
    /// a point in the middle of its visible side.
    pub fn config(self) -> Config {
        let sized = |prior, min, max, radius| Config {
            semi_axis_min: min,
            semi_axis_max: max,
            radius,
            map: MapConfig::of(prior),
            ..Config::jujube()
        };
        match self {
            Self::Jujube => Config::jujube(),
            Self::Apple => Config::apple(),
            Self::Tomato => sized(SizePrior::TOMATO, 20.0, 52.0, 50.0),
            Self::Lemon => sized(SizePrior::LEMON, 20.0, 42.0, 45.0),
            Self::Kiwi => sized(SizePrior::KIWI, 18.0, 42.0, 45.0),
            Self::Egg => sized(SizePrior::EGG, 17.0, 36.0, 40.0),
            Self::CherryTomato => sized(SizePrior::CHERRY_TOMATO, 8.0, 25.0, 30.0),
            Self::Generic => Config::generic(),
            // Six decades either side of one: unit-scale simulations and surveys in millimetres alike.
            Self::None => {
                Config { min_ratio: 0.0, ..sized(SizePrior::APPLE, 1e-6, 1e6, f32::INFINITY) }.paper()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fruit_has_a_valid_configuration_and_its_own_name() {
        for fruit in Fruit::value_variants() {
            assert_eq!(fruit.config().check(), Ok(()));
            assert_eq!(fruit.to_possible_value().unwrap().get_name(), fruit.name());
        }
    }
}
