//! The kinds of fruit that scenes are made of: size, how they hang, and what their skin looks like.
//!
//! Sizes are typical of the fruit, not measured; a jujube's are the paper's. Spreads are of one harvest.

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::noise::Noise;

/// A kind of fruit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum FruitKind {
    /// Lingwu long jujube.
    Jujube,
    /// Red apple.
    Apple,
    /// Ripe tomato.
    Tomato,
    /// Ripe lemon.
    Lemon,
    /// Kiwi fruit.
    Kiwi,
    /// Brown hen's egg.
    Egg,
    /// Ripe cherry tomato.
    CherryTomato,
}

/// Which semi-axis points to the stalk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Pole {
    /// Long fruit: jujube, lemon.
    Longest,
    /// Flat fruit: apple, tomato.
    Shortest,
}

/// Size and look of a kind of fruit. Colours are display values, 0..1.
#[derive(Debug, Clone, Copy)]
pub(super) struct FruitModel {
    /// Mean semi-axes a >= b >= c, millimetres.
    pub(super) semi_axes_mm: [f64; 3],
    /// Relative standard deviation of the size of the whole fruit.
    pub(super) size_spread: f64,
    /// Relative standard deviation of each semi-axis beside it.
    pub(super) shape_spread: f64,
    pub(super) pole: Pole,
    pub(super) skin: Skin,
}

/// What the skin looks like.
#[derive(Debug, Clone, Copy)]
pub(super) struct Skin {
    /// The two colours that most of it varies between.
    pub(super) colours: [[f32; 3]; 2],
    /// Colour of the patches that have ripened less, and how much of the skin they take, 0..1.
    pub(super) patch: [f32; 3],
    pub(super) patch_share: f32,
    /// Strength of the highlight, 0 matt to 1 polished.
    pub(super) gloss: f32,
}

impl FruitKind {
    /// All kinds.
    pub const ALL: [Self; 7] =
        [Self::Jujube, Self::Apple, Self::Tomato, Self::Lemon, Self::Kiwi, Self::Egg, Self::CherryTomato];

    /// Its name, as the command line writes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Jujube => "jujube",
            Self::Apple => "apple",
            Self::Tomato => "tomato",
            Self::Lemon => "lemon",
            Self::Kiwi => "kiwi",
            Self::Egg => "egg",
            Self::CherryTomato => "cherry-tomato",
        }
    }

    pub(super) fn model(self) -> FruitModel {
        let model = |semi_axes_mm, pole, colours, (patch, patch_share), gloss| FruitModel {
            semi_axes_mm,
            size_spread: 0.04,
            shape_spread: 0.02,
            pole,
            skin: Skin { colours, patch, patch_share, gloss },
        };
        match self {
            Self::Jujube => FruitModel {
                size_spread: 0.03,
                ..model(
                    [21.75, 11.1, 10.7],
                    Pole::Longest,
                    [[0.60, 0.20, 0.13], [0.40, 0.125, 0.09]],
                    ([0.72, 0.40, 0.20], 0.22),
                    0.55,
                )
            },
            Self::Apple => model(
                [38.0, 37.5, 34.5],
                Pole::Shortest,
                [[0.78, 0.13, 0.16], [0.62, 0.08, 0.14]],
                ([0.85, 0.55, 0.30], 0.18),
                0.45,
            ),
            Self::Tomato => model(
                [34.0, 33.5, 28.0],
                Pole::Shortest,
                [[0.85, 0.18, 0.10], [0.75, 0.12, 0.07]],
                ([0.88, 0.40, 0.14], 0.15),
                0.75,
            ),
            Self::Lemon => model(
                [32.0, 25.5, 25.0],
                Pole::Longest,
                [[0.95, 0.82, 0.18], [0.90, 0.74, 0.12]],
                ([0.80, 0.82, 0.22], 0.15),
                0.30,
            ),
            Self::Kiwi => model(
                [34.0, 26.0, 24.5],
                Pole::Longest,
                [[0.50, 0.38, 0.20], [0.42, 0.31, 0.16]],
                ([0.56, 0.44, 0.24], 0.20),
                0.05,
            ),
            Self::Egg => model(
                [29.0, 22.0, 22.0],
                Pole::Longest,
                [[0.80, 0.58, 0.44], [0.74, 0.51, 0.37]],
                ([0.83, 0.63, 0.50], 0.20),
                0.15,
            ),
            Self::CherryTomato => model(
                [14.5, 13.0, 12.8],
                Pole::Longest,
                [[0.86, 0.16, 0.09], [0.76, 0.11, 0.07]],
                ([0.90, 0.42, 0.12], 0.12),
                0.80,
            ),
        }
    }
}

impl FruitModel {
    /// Semi-axes of one fruit, a >= b >= c, millimetres: the mean times log-normal factors, all within 2.5 sigma so
    /// that no scene holds a freak.
    pub(super) fn draw_semi_axes(&self, noise: &mut Noise) -> Vector3<f64> {
        let mut factor = |spread: f64| libm::exp(spread * noise.normal().clamp(-2.5, 2.5));
        let size = factor(self.size_spread);
        let mut semi_axes = self.semi_axes_mm.map(|mean| mean * size * factor(self.shape_spread));
        semi_axes.sort_by(|a, b| b.total_cmp(a));
        Vector3::from(semi_axes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jujubes_fit_the_papers_size_limits() {
        let mut noise = Noise::new(1);
        let model = FruitKind::Jujube.model();
        for _ in 0..1000 {
            let semi_axes = model.draw_semi_axes(&mut noise);
            assert!(semi_axes[0] < 25.2 && semi_axes[2] > 9.4, "{semi_axes}");
            assert!(semi_axes[0] >= semi_axes[1] && semi_axes[1] >= semi_axes[2]);
        }
    }
}
