//! RANSAC with distance-and-normal score: the method the paper compares itself with (sections I and III).
//!
//! A random seed point and its neighbourhood, nine points of it, the quadric through them, the size check, then the
//! score: a point is an inlier when it lies within 1.5 mm of the closest point on the ellipsoid and its local normal
//! is within acos(0.8) = 37 degrees of the ellipsoid's there. Trials by Eq. (15), one final least squares on the inliers,
//! several targets by taking the inliers out (Step 5). What the paper leaves open is read as in its own method:
//! seed drawn anew for each hypothesis, sampling without replacement, w over the neighbourhood.

use super::fit::{UNKNOWNS, fit};
use super::neighbours::NeighbourTree;
use super::normals::normals;
use super::score::Score;
use crate::eval::EllipsoidF64;
use varsac_core::Config;
use varsac_core::rng::Stream;

/// What the search is told. The defaults are the paper's Table 5 where it gives a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RansacOptions {
    /// r_s: points farther than this from the seed point are not sampled, millimetres. `None` samples the whole cloud.
    pub radius_mm: Option<f64>,
    /// Semi-axes of a valid ellipsoid are longer than the first and shorter than the second, millimetres.
    pub semi_axis_limits_mm: [f64; 2],
    /// An inlier's distance from the ellipsoid is below this, millimetres.
    pub distance_mm: f64,
    /// An inlier's normal and the ellipsoid's have a cosine above this, in magnitude.
    pub normal_cosine: f64,
    /// Nearest neighbours that a local normal is estimated from.
    pub normal_neighbours: usize,
    /// p of Eq. (15), between 0 and 1.
    pub confidence: f64,
    /// k_max: hypotheses for one target.
    pub max_trials: u32,
    /// Least squares on the inliers of the best hypothesis, one after the other. The paper does one.
    pub refits: u32,
    /// A hypothesis with fewer inliers in its neighbourhood does not count, nor does a target.
    pub min_inliers: usize,
    /// A hypothesis that explains less of its neighbourhood than this does not count.
    pub min_ratio: f64,
    /// Targets to look for.
    pub max_targets: usize,
}

impl Default for RansacOptions {
    fn default() -> Self {
        Self {
            radius_mm: Some(30.0),
            semi_axis_limits_mm: [9.5, 24.5],
            distance_mm: 1.5,
            normal_cosine: 0.8,
            normal_neighbours: 12,
            confidence: 0.95,
            max_trials: 3000,
            refits: 1,
            min_inliers: 20,
            min_ratio: 0.0,
            max_targets: 16,
        }
    }
}

impl From<&Config> for RansacOptions {
    /// Everything the two methods share, so that they differ in sample size, score and precision only. Distance, cosine
    /// and neighbours keep their defaults: scale the distance for clouds that are not in millimetres.
    fn from(config: &Config) -> Self {
        let radius = f64::from(config.radius);
        Self {
            radius_mm: radius.is_finite().then_some(radius),
            semi_axis_limits_mm: [f64::from(config.semi_axis_min), f64::from(config.semi_axis_max)],
            confidence: f64::from(config.confidence),
            max_trials: config.max_trials,
            refits: u32::from(config.refits),
            min_inliers: usize::from(config.min_inliers),
            min_ratio: f64::from(config.min_ratio),
            max_targets: usize::from(config.max_targets),
            ..Self::default()
        }
    }
}

/// One ellipsoid that a baseline found.
#[derive(Debug, Clone, PartialEq)]
pub struct BaselineTarget {
    /// The ellipsoid, after the final least squares.
    pub ellipsoid: EllipsoidF64,
    /// Indices of its points in the cloud, ascending: all points of the cloud that were left count.
    pub inliers: Vec<u32>,
    /// Points that were left when this target was sought: the denominator of the paper's model score.
    pub candidates: usize,
    /// Inliers of the best hypothesis within the neighbourhood it was drawn from.
    pub neighbourhood_inliers: usize,
    /// Points of that neighbourhood. The ratio of the two is w of Eq. (15).
    pub neighbourhood: usize,
    /// Hypotheses drawn.
    pub trials: u32,
    /// Hypotheses that were ellipsoids of valid size and were scored.
    pub scored: u32,
}

/// Finds ellipsoids in a cloud, best first, until the paper's Step 5, `max_targets` or a search without success ends it.
///
/// Points that are not finite are left out. The same cloud, options and seed give the same targets. Cost: a score is
/// `O(n)` closest points, about 0.15 us each; at most `max_trials` scores a target.
pub fn ransac(points: &[[f32; 3]], options: &RansacOptions, seed: u64) -> Vec<BaselineTarget> {
    let mut left: Vec<u32> =
        (0..points.len() as u32).filter(|&i| points[i as usize].iter().all(|v| v.is_finite())).collect();
    let coordinates = |index: &u32| points[*index as usize].map(f64::from);
    let mut left_normals =
        normals(&NeighbourTree::new(left.iter().map(coordinates).collect()), options.normal_neighbours);
    let mut stream = Stream::new(seed);
    let mut targets: Vec<BaselineTarget> = Vec::new();
    while targets.len() < options.max_targets {
        let enough = targets.last().map_or(UNKNOWNS, |last| last.inliers.len().max(UNKNOWNS));
        if left.len() < enough {
            break;
        }
        let search = Search {
            tree: NeighbourTree::new(left.iter().map(coordinates).collect()),
            normals: &left_normals,
            options,
        };
        let Some(best) = search.run(&mut stream) else { break };
        let (ellipsoid, members) = search.refitted(best.ellipsoid);
        if members.len() < options.min_inliers.max(1) {
            break;
        }
        targets.push(BaselineTarget {
            ellipsoid,
            inliers: members.iter().map(|&m| left[m as usize]).collect(),
            candidates: left.len(),
            ..best
        });
        let mut is_member = vec![false; left.len()];
        for &m in &members {
            is_member[m as usize] = true;
        }
        left = unmarked(&left, &is_member);
        left_normals = unmarked(&left_normals, &is_member);
    }
    targets
}

fn unmarked<T: Copy>(values: &[T], marked: &[bool]) -> Vec<T> {
    values.iter().zip(marked).filter(|(_, marked)| !**marked).map(|(value, _)| *value).collect()
}

/// Number of trials by Eq. (15), at least 1 and at most `max_trials`, rounded up: `inlier_ratio` is w, the sample nine.
///
/// A ratio of 0 (or NaN) gives `max_trials`.
pub fn trials(confidence: f64, inlier_ratio: f64, max_trials: u32) -> u32 {
    let all_good = inlier_ratio.powi(UNKNOWNS as i32);
    if all_good > 0.0 {
        let count = libm::log1p(-confidence) / libm::log1p(-all_good.min(1.0));
        // The cast saturates, and turns NaN (confidence 1 and ratio 1) into 0.
        (count.ceil() as u32).clamp(1, max_trials.max(1))
    } else {
        max_trials
    }
}

/// The search for one target in what is left of the cloud.
struct Search<'a> {
    tree: NeighbourTree,
    normals: &'a [[f64; 3]],
    options: &'a RansacOptions,
}

impl Search<'_> {
    /// The hypothesis with the most inliers; of equal ones the first.
    fn run(&self, stream: &mut Stream) -> Option<BaselineTarget> {
        let points = self.tree.points();
        let mut neighbourhood: Vec<u32> = (0..points.len() as u32).collect();
        let mut best: Option<BaselineTarget> = None;
        let (mut trial, mut scored, mut needed) = (0, 0, self.options.max_trials);
        while trial < needed {
            trial += 1;
            if let Some(radius) = self.options.radius_mm {
                let seed_point = points[stream.below(points.len() as u32) as usize];
                self.tree.within(seed_point, radius, &mut neighbourhood);
            }
            let Some(sample) = draw_nine(stream, &neighbourhood) else { continue };
            let Some(ellipsoid) = fit(sample.iter().map(|&i| points[i as usize])) else { continue };
            if !self.has_valid_size(&ellipsoid) {
                continue;
            }
            scored += 1;
            let least = self.options.min_inliers.max(1);
            let to_beat = best.as_ref().map_or(least - 1, |b| b.neighbourhood_inliers);
            let Some(inliers) = self.count_above(to_beat, &ellipsoid, &neighbourhood) else { continue };
            let inlier_ratio = inliers as f64 / neighbourhood.len() as f64;
            if inlier_ratio < self.options.min_ratio {
                continue;
            }
            needed = trials(self.options.confidence, inlier_ratio, self.options.max_trials);
            best = Some(BaselineTarget {
                ellipsoid,
                inliers: Vec::new(),
                candidates: points.len(),
                neighbourhood_inliers: inliers,
                neighbourhood: neighbourhood.len(),
                trials: 0,
                scored: 0,
            });
        }
        best.map(|best| BaselineTarget { trials: trial, scored, ..best })
    }

    /// The final least squares on all inliers, and the inliers of its result. A result that is no valid ellipsoid is
    /// dropped and ends the refits.
    fn refitted(&self, model: EllipsoidF64) -> (EllipsoidF64, Vec<u32>) {
        let points = self.tree.points();
        let (mut model, mut members) = (model, self.inliers(&model));
        for _ in 0..self.options.refits {
            let better = fit(members.iter().map(|&i| points[i as usize])).filter(|e| self.has_valid_size(e));
            match better {
                Some(better) if better != model => {
                    model = better;
                    members = self.inliers(&model);
                }
                _ => break,
            }
        }
        (model, members)
    }

    fn has_valid_size(&self, ellipsoid: &EllipsoidF64) -> bool {
        let [least, greatest] = self.options.semi_axis_limits_mm;
        ellipsoid.semi_axes_mm.iter().all(|&semi_axis| semi_axis > least && semi_axis < greatest)
    }

    /// Number of inliers if it is above `to_beat`. Counting stops when that cannot be reached any more.
    fn count_above(&self, to_beat: usize, ellipsoid: &EllipsoidF64, among: &[u32]) -> Option<usize> {
        let score = Score::new(ellipsoid, self.options.distance_mm, self.options.normal_cosine);
        let (mut count, mut outliers_allowed) = (0, among.len().checked_sub(to_beat + 1)?);
        for &index in among {
            if score.is_inlier(self.tree.points()[index as usize], self.normals[index as usize]) {
                count += 1;
            } else {
                outliers_allowed = outliers_allowed.checked_sub(1)?;
            }
        }
        Some(count)
    }

    fn inliers(&self, ellipsoid: &EllipsoidF64) -> Vec<u32> {
        let score = Score::new(ellipsoid, self.options.distance_mm, self.options.normal_cosine);
        let both = self.tree.points().iter().zip(self.normals).enumerate();
        both.filter(|(_, (point, normal))| score.is_inlier(**point, **normal))
            .map(|(i, _)| i as u32)
            .collect()
    }
}

/// Nine different members of the neighbourhood (Floyd's method), or nothing where it has fewer.
fn draw_nine(stream: &mut Stream, neighbourhood: &[u32]) -> Option<[u32; UNKNOWNS]> {
    let first = neighbourhood.len().checked_sub(UNKNOWNS)?;
    let mut places = [usize::MAX; UNKNOWNS];
    for k in 0..UNKNOWNS {
        let draw = stream.below((first + k + 1) as u32) as usize;
        places[k] = if places.contains(&draw) { first + k } else { draw };
    }
    Some(places.map(|place| neighbourhood[place]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::baseline::closest::ClosestPoint;
    use crate::eval::attitude::{EQUAL_AXES_RATIO, axes_of_angles, axis_error_deg};
    use crate::eval::{dot, norm, subtract};

    /// Surface points with uniform noise of +-`noise_mm`, then as many clutter points in a box around them.
    fn scene(fruit: &[EllipsoidF64], on_each: u32, clutter: u32, noise_mm: f64) -> Vec<[f32; 3]> {
        let mut stream = Stream::new(42);
        let mut uniform = move || f64::from(stream.below(2_000_001)) / 1e6 - 1.0;
        let mut points = Vec::new();
        for e in fruit {
            for i in 0..on_each {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(on_each);
                let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
                let ring = (1.0 - z * z).sqrt();
                let [a, b, c] = e.semi_axes_mm;
                let p = e.from_body([a * z, b * ring * cos, c * ring * sin]);
                points.push(p.map(|v| (v + noise_mm * uniform()) as f32));
            }
        }
        for _ in 0..clutter {
            let centre = fruit[0].centre_mm;
            points.push(centre.map(|v| (v + 40.0 * uniform()) as f32));
        }
        points
    }

    fn jujube(x: f64, angle: f64) -> EllipsoidF64 {
        EllipsoidF64::sorted([x, -20.0, 700.0], [21.7, 11.2, 10.6], axes_of_angles([0.2, angle, 1.0]))
    }

    #[test]
    fn trials_of_eq_15() {
        // Computed by hand: ln 0.05 / ln(1 - 0.8^9) = 20.79, ln 0.05 / ln(1 - 0.612^9) = 247.2.
        assert_eq!(trials(0.95, 0.8, 3000), 21);
        assert_eq!(trials(0.95, 0.612, 3000), 248);
        assert_eq!(trials(0.95, 1.0, 3000), 1);
        assert_eq!(trials(0.95, 0.1, 3000), 3000);
        assert_eq!(trials(0.95, 0.0, 3000), 3000);
        assert_eq!(trials(1.0, 0.5, 3000), 3000);
        assert_eq!(trials(0.0, 0.5, 3000), 1);
    }

    #[test]
    fn one_fruit_in_clutter_is_found() {
        let truth = jujube(0.0, 0.4);
        let points = scene(&[truth], 400, 170, 0.1);
        let options = RansacOptions { max_targets: 1, ..RansacOptions::default() };
        let targets = ransac(&points, &options, 1);
        let found = &targets[0];
        assert!(norm(subtract(found.ellipsoid.centre_mm, truth.centre_mm)) < 0.5, "{found:?}");
        for k in 0..3 {
            assert!((found.ellipsoid.semi_axes_mm[k] - truth.semi_axes_mm[k]).abs() < 0.6, "{found:?}");
        }
        assert!(axis_error_deg(&truth, &found.ellipsoid, EQUAL_AXES_RATIO).unwrap() < 3.0);
        assert_eq!(found.candidates, 570);
        let own = found.inliers.iter().filter(|&&i| i < 400).count();
        assert!(own > 360, "{own} of the fruit's points");
        assert!(found.trials >= found.scored && found.trials <= 3000);
    }

    #[test]
    fn two_fruit_are_taken_out_one_after_the_other() {
        let truths = [jujube(0.0, 0.4), jujube(60.0, -0.5)];
        let targets = ransac(&scene(&truths, 350, 60, 0.05), &RansacOptions::default(), 3);
        assert!(targets.len() >= 2, "{targets:?}");
        for truth in truths {
            let nearest = targets[..2]
                .iter()
                .map(|t| norm(subtract(t.ellipsoid.centre_mm, truth.centre_mm)))
                .fold(f64::MAX, f64::min);
            assert!(nearest < 0.5, "{nearest}");
        }
        let mut all: Vec<u32> = targets.iter().flat_map(|t| t.inliers.iter().copied()).collect();
        let count = all.len();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), count, "a point belongs to one target");
    }

    #[test]
    fn the_same_seed_gives_the_same_answer() {
        let points = scene(&[jujube(0.0, 0.4)], 300, 150, 0.1);
        let options = RansacOptions::default();
        assert_eq!(ransac(&points, &options, 5), ransac(&points, &options, 5));
    }

    #[test]
    fn the_shortcuts_change_no_inlier() {
        let truth = jujube(0.0, 0.4);
        let points = scene(&[truth], 300, 600, 1.5);
        let tree = NeighbourTree::new(points.iter().map(|p| p.map(f64::from)).collect());
        let point_normals = normals(&tree, 12);
        let options = RansacOptions::default();
        let search = Search { tree, normals: &point_normals, options: &options };
        let by_definition: Vec<u32> = (0..points.len())
            .filter(|&i| {
                let body = truth.to_body(points[i].map(f64::from));
                let q = ClosestPoint::new(truth.semi_axes_mm).of(body);
                let gradient: [f64; 3] = std::array::from_fn(|k| q[k] / truth.semi_axes_mm[k].powi(2));
                let cosine =
                    dot(gradient, truth.axes.map(|axis| dot(axis, point_normals[i]))) / norm(gradient);
                norm(subtract(body, q)) < 1.5 && cosine.abs() > 0.8
            })
            .map(|i| i as u32)
            .collect();
        assert_eq!(search.inliers(&truth), by_definition);
        assert!(by_definition.len() > 100 && by_definition.len() < points.len() - 100);
        let among: Vec<u32> = (0..points.len() as u32).collect();
        let count = by_definition.len();
        assert_eq!(search.count_above(0, &truth, &among), Some(count));
        assert_eq!(search.count_above(count - 1, &truth, &among), Some(count));
        assert_eq!(search.count_above(count, &truth, &among), None);
    }

    #[test]
    fn hopeless_clouds_end() {
        let options = RansacOptions { max_trials: 50, ..RansacOptions::default() };
        let flat: Vec<[f32; 3]> =
            (0..400_u16).map(|i| [f32::from(i % 20), f32::from(i / 20), 700.0]).collect();
        for cloud in
            [Vec::new(), vec![[1.0; 3]; 8], vec![[1.0; 3]; 100], vec![[f32::NAN, 1.0, 2.0]; 100], flat]
        {
            assert_eq!(ransac(&cloud, &options, 0), Vec::new());
            assert_eq!(ransac(&cloud, &RansacOptions { radius_mm: None, ..options }, u64::MAX), Vec::new());
        }
    }
}
