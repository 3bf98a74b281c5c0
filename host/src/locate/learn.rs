//! The size of the fruit of one orchard, learnt from its own pictures.
//!
//! A size prior whose mean is wrong by a tenth pulls every centre aside by about as much of a semi-axis, and says nothing of it in
//! the covariance. The cure: search everything once with the size loosened as a whole, take what is accepted for a sample of
//! the orchard, and search again with the sample's size and the kind's own spread.
//!
//! One number is learnt, the factor of the whole size: `exp(median_i (1/3) sum_k (ln x_ik - m_k))` over the accepted fits `i` and
//! their semi-axes `k`, with `m` the logarithms of the preset's. One view tells proportions badly, and sorting the two short
//! semi-axes by length alone would pull them apart. The median forgives every other fit.

use serde::Serialize;
use varsac_core::{Gate, SizePrior};

use super::{Options, Target};

/// Spread of the whole size in the first search. Two of it cover the factors that are believed, [`MAX_FACTOR`].
const LOOSE_SPREAD: f32 = 0.15;
/// Accepted fits that make a sample. A loose fit tells the size to about 7 %, the median of so many to
/// `1.25 * 7 % / sqrt(12)` = 2.5 %: less than the spread of any preset.
const ENOUGH: usize = 12;
/// An orchard whose mean is further from the preset than this factor grows another kind of fruit, or what was found is none.
const MAX_FACTOR: f32 = 1.2;

/// A size prior's mean and where it comes from.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LearntSize {
    /// Mean semi-axes that are used, longest first.
    pub semi_axes_mm: [f32; 3],
    /// Accepted fits they were learnt from.
    pub from: usize,
    /// True when the fits wanted a change of more than 20 % and got 20 %.
    pub bounded: bool,
    /// True when there were too few fits to learn from: the semi-axes are the preset's.
    pub too_few: bool,
}

impl LearntSize {
    /// From the targets of a search with [`Options::with_loose_size`], `preset` being the prior without it.
    pub fn of<'a>(preset: &SizePrior, targets: impl IntoIterator<Item = &'a Target>) -> Self {
        let factor = |target: &Target| {
            let ratios = target.ellipsoid.semi_axes.iter().zip(preset.semi_axes_mm);
            ratios.map(|(&axis, mean)| (axis / mean).ln()).sum::<f32>() / 3.0
        };
        let accepted = targets.into_iter().filter(|target| target.is_accepted());
        let mut logarithms: Vec<f32> = accepted.map(factor).collect();
        logarithms.sort_by(f32::total_cmp);
        let from = logarithms.len();
        let too_few = from < ENOUGH;
        let wanted = if too_few { 0.0 } else { 0.5 * (logarithms[(from - 1) / 2] + logarithms[from / 2]) };
        let limit = MAX_FACTOR.ln();
        let factor = wanted.clamp(-limit, limit).exp();
        Self {
            semi_axes_mm: preset.semi_axes_mm.map(|axis| axis * factor),
            from,
            bounded: wanted.abs() > limit,
            too_few,
        }
    }
}

impl std::fmt::Display for LearntSize {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [a, b, c] = self.semi_axes_mm;
        if self.too_few {
            let from = self.from;
            return write!(
                f,
                "size not learnt: {from} accepted loose fits, {ENOUGH} are needed; {a:.1} x {b:.1} x {c:.1} mm kept"
            );
        }
        write!(f, "mean size {a:.1} x {b:.1} x {c:.1} mm, learnt from {} accepted loose fits", self.from)?;
        if self.bounded {
            write!(f, "; they want a change of more than {:.0} %", 100.0 * (MAX_FACTOR - 1.0))?;
        }
        Ok(())
    }
}

impl Options {
    /// The same for a first search of fruit whose whole size is hardly known; their proportions are known as well as before.
    #[must_use]
    pub fn with_loose_size(mut self) -> Self {
        let prior = &mut self.config.map.prior;
        let SizePrior { semi_axes_mm, spread: [a, b, c], spread_ab, spread_bc } = *prior;
        // Where no term of its own holds a proportion, the spreads of its two semi-axes did.
        let held = |own: f32, by: f32| if own.is_finite() { own } else { by };
        let loose = SizePrior::of(
            semi_axes_mm,
            LOOSE_SPREAD,
            held(spread_ab, a.hypot(b)),
            held(spread_bc, b.hypot(c)),
        );
        if loose.spread[0] > a {
            *prior = loose;
        }
        self
    }

    /// The same for fruit of the learnt mean size with the kind's own spread. What the gate allows in millimetres grows along.
    #[must_use]
    pub fn with_learnt_size(mut self, learnt: LearntSize) -> Self {
        let map = &mut self.config.map;
        let factor = learnt.semi_axes_mm[0] / map.prior.semi_axes_mm[0];
        map.prior.semi_axes_mm = learnt.semi_axes_mm;
        map.gate = Gate { uncertain_mm: factor * map.gate.uncertain_mm, ..map.gate };
        self.learnt_size = Some(learnt);
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        eval::{EllipsoidF64, norm, subtract},
        fruit::Fruit,
        locate::{Here, RegionSource, Searcher},
        region_view::RegionView,
        synth::onesided::{Family, MaskBias, Scene, families::HARD, scaled_jujube},
    };

    /// As many scenes as make a run.
    const SCENES: u64 = 300;
    /// An accepted centre this far from every fruit is wrong, mm.
    const WRONG_MM: f64 = 5.0;

    fn orchard(factor: f64) -> Vec<(Scene, RegionView)> {
        let family: Family = HARD.of("orchard", scaled_jujube(factor));
        let one = |seed| {
            let scene = Scene::new(&family, seed);
            let seen = scene.sighting(MaskBias::default());
            let view = RegionView {
                points: seen.cloud,
                in_mask: seen.in_mask,
                outline: seen.outline,
                pitch_rad: seen.pitch_rad,
            };
            (scene, view)
        };
        (0..SCENES).map(one).collect()
    }

    fn jujubes() -> Options {
        let mut config = Fruit::Jujube.config();
        config.max_targets = 2;
        Options::new(config, RegionSource::Mask, 1)
    }

    fn search(orchard: &[(Scene, RegionView)], options: &Options) -> Vec<Vec<Target>> {
        let views: Vec<RegionView> = orchard.iter().map(|(_, view)| view.clone()).collect();
        Here.search(&views, options).unwrap().into_iter().map(|(targets, _)| targets).collect()
    }

    /// Of the accepted targets: how many, their median distance from the nearest fruit, mm, and how many are wrong.
    fn judged(orchard: &[(Scene, RegionView)], found: &[Vec<Target>]) -> (usize, f64, usize) {
        let mut errors = Vec::new();
        for ((scene, _), targets) in orchard.iter().zip(found) {
            for target in targets.iter().filter(|target| target.is_accepted()) {
                let centre = EllipsoidF64::from(&target.ellipsoid).centre_mm;
                let off = scene.fruit.iter().map(|truth| norm(subtract(centre, truth.ellipsoid.centre_mm)));
                errors.push(off.fold(f64::INFINITY, f64::min));
            }
        }
        errors.sort_by(f64::total_cmp);
        let wrong = errors.iter().filter(|&&error| error > WRONG_MM).count();
        (errors.len(), errors[errors.len() / 2], wrong)
    }

    #[test]
    fn an_orchard_of_larger_fruit_is_learnt_and_located_better() {
        let orchard = orchard(1.1);
        let options = jujubes();
        let loose = search(&orchard, &options.clone().with_loose_size());
        let learnt = LearntSize::of(&SizePrior::JUJUBE, loose.iter().flatten());
        println!("{learnt}");
        let (preset, after) =
            (search(&orchard, &options), search(&orchard, &options.clone().with_learnt_size(learnt)));
        let (before, after) = (judged(&orchard, &preset), judged(&orchard, &after));
        println!("accepted, median error in mm, wrong: {before:?} with the preset, {after:?} learnt");
        let factor = learnt.semi_axes_mm[0] / SizePrior::JUJUBE.semi_axes_mm[0];
        assert!((factor - 1.1).abs() < 0.03 && !learnt.bounded && !learnt.too_few, "{factor}");
        assert!(after.1 < before.1 && after.0 > before.0);
        assert!((after.2 * before.0) <= (before.2 * after.0), "share of wrong ones");
    }

    #[test]
    fn an_orchard_as_the_preset_says_changes_little() {
        let loose = search(&orchard(1.0), &jujubes().with_loose_size());
        let learnt = LearntSize::of(&SizePrior::JUJUBE, loose.iter().flatten());
        println!("{learnt}");
        assert!((learnt.semi_axes_mm[0] / SizePrior::JUJUBE.semi_axes_mm[0] - 1.0).abs() < 0.03);
    }
}
