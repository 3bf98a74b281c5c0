//! Views made from a number, the same on every machine: what a depth camera sees of jujubes, pixel by pixel, with the mask
//! and the outline rays that the default search uses. For proofs on boards without a link, as [`crate::scene`].
//!
//! A view is a small raster about the optical axis: one or two fruit, half of them partly covered by a leaf, before a
//! background. Points of the mask come first, then the pixels beside it. A ray stands between a fruit's pixel and a
//! neighbour that lies clearly behind.

use varsac_core::rng::Stream;
use varsac_core::{Config, Detector, MapConfig, OutlineRay, Point3, View, Workspace};

use crate::scene::{Digested, Fruit, uniform};

/// Points of a view at most.
pub const VIEW_POINTS: usize = 700;
/// Outline rays of a view at most.
pub const VIEW_RAYS: usize = 128;
/// Pixels along a side of the raster.
const SIDE: usize = 56;
/// Angle of a pixel: the Kinect v2's.
const PIXEL_RAD: f32 = 1.0 / 365.456;
/// Depth of the background and of the leaf, mm.
const BACKGROUND_MM: f32 = 780.0;
const LEAF_MM: f32 = 620.0;
/// What separates two surfaces, mm.
const STEP_MM: f32 = 10.0;
/// Standard deviation of a ray, pixels: half a pixel's uniform error, and the noise of the edge.
const RAY_PX: f32 = 0.38;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Shows {
    Background,
    Leaf,
    Fruit,
}

/// Room for one view and for the raster it is made on.
#[derive(Debug)]
pub struct Canvas {
    shows: [Shows; SIDE * SIDE],
    depth_mm: [f32; SIDE * SIDE],
    cloud: [Point3; VIEW_POINTS],
    outline: [OutlineRay; VIEW_RAYS],
}

const ORIGIN: Point3 = Point3::new(0.0, 0.0, 0.0);

impl Canvas {
    /// Nothing to be seen. Place it in a `static` on a board.
    pub const fn new() -> Self {
        Self {
            shows: [Shows::Background; SIDE * SIDE],
            depth_mm: [0.0; SIDE * SIDE],
            cloud: [ORIGIN; VIEW_POINTS],
            outline: [OutlineRay { inner: ORIGIN, outer_mm: 0.0, sigma_rad: 0.0 }; VIEW_RAYS],
        }
    }

    /// View `number`: one fruit or two that touch or nearly do.
    pub fn scene(&mut self, number: u64) -> View<'_> {
        let mut stream = Stream::new(number);
        let mut first = Fruit::random(&mut stream);
        let mut second = Fruit::random(&mut stream);
        let pair = number & 1 != 0;
        let aside = if pair { 13.0 + 6.0 * uniform(&mut stream) } else { 0.0 };
        let depth = 660.0 + 80.0 * uniform(&mut stream);
        first.centre = [-aside, 4.0 * uniform(&mut stream) - 2.0, depth];
        second.centre = [aside, 4.0 * uniform(&mut stream) - 2.0, depth + 6.0 * uniform(&mut stream)];
        // From this column on a leaf is in front.
        let leaf = if number & 2 != 0 { SIDE / 2 + stream.below(8) as usize } else { SIDE };
        let fruit = [first, second];
        self.render(if pair { &fruit } else { &fruit[..1] }, leaf, &mut stream)
    }

    /// One whole fruit, 680 mm away: about 250 points.
    pub fn one_fruit(&mut self) -> View<'_> {
        let fruit =
            Fruit { centre: [0.0, 0.0, 680.0], axes: [[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]] };
        self.render(&[fruit], SIDE, &mut Stream::new(7))
    }

    fn render(&mut self, fruit: &[Fruit], leaf: usize, stream: &mut Stream) -> View<'_> {
        for (k, (shows, depth_mm)) in self.shows.iter_mut().zip(&mut self.depth_mm).enumerate() {
            let (u, v) = (k % SIDE, k / SIDE);
            let mut seen =
                if u >= leaf { (Shows::Leaf, LEAF_MM) } else { (Shows::Background, BACKGROUND_MM) };
            for one in fruit {
                if let Some(z) = one.depth_mm([tangent(u, 0.0), tangent(v, 0.0)])
                    && z < seen.1
                {
                    seen = (Shows::Fruit, z);
                }
            }
            // Sum of four: close to a normal distribution of 0.7 mm.
            let sum = uniform(stream) + uniform(stream) + uniform(stream) + uniform(stream);
            (*shows, *depth_mm) = (seen.0, seen.1 + 1.21 * (sum - 2.0));
        }
        let in_mask = self.list(0, |shows, _| shows == Shows::Fruit);
        let points = self.list(in_mask, |shows, beside| shows != Shows::Fruit && beside);
        let rays = self.edges();
        View {
            cloud: self.cloud.get(..points).unwrap_or(&[]),
            in_mask,
            outline: self.outline.get(..rays).unwrap_or(&[]),
            pitch_rad: PIXEL_RAD,
        }
    }

    fn pixel(&self, at: usize) -> Option<(Shows, f32)> {
        self.shows.get(at).copied().zip(self.depth_mm.get(at).copied())
    }

    /// Appends the points of the wanted pixels (what it shows; whether a fruit's pixel is beside it); how many there are then.
    fn list(&mut self, mut count: usize, wanted: impl Fn(Shows, bool) -> bool) -> usize {
        for v in 0..SIDE {
            for u in 0..SIDE {
                let Some((shows, z)) = self.pixel(v * SIDE + u) else { continue };
                let beside = neighbours(u, v).any(|(at, _)| self.shows.get(at) == Some(&Shows::Fruit));
                if wanted(shows, beside)
                    && let Some(slot) = self.cloud.get_mut(count)
                {
                    *slot = Point3::new(z * tangent(u, 0.0), z * tangent(v, 0.0), z);
                    count += 1;
                }
            }
        }
        count
    }

    /// Lists the rays between the fruit's pixels and what is behind them; how many.
    fn edges(&mut self) -> usize {
        let mut count = 0;
        for v in 0..SIDE {
            for u in 0..SIDE {
                let Some((Shows::Fruit, z)) = self.pixel(v * SIDE + u) else { continue };
                for (at, [du, dv]) in neighbours(u, v) {
                    let Some((_, outer_mm)) = self.pixel(at) else { continue };
                    if outer_mm < z + STEP_MM {
                        continue;
                    }
                    if let Some(slot) = self.outline.get_mut(count) {
                        let inner = Point3::new(z * tangent(u, 0.5 * du), z * tangent(v, 0.5 * dv), z);
                        *slot = OutlineRay { inner, outer_mm, sigma_rad: RAY_PX * PIXEL_RAD };
                        count += 1;
                    }
                }
            }
        }
        count
    }
}

impl Default for Canvas {
    fn default() -> Self {
        Self::new()
    }
}

/// Tangent of the angle from the optical axis of column or row `k`, displaced by `offset` pixels.
fn tangent(k: usize, offset: f32) -> f32 {
    (k as f32 + offset - (SIDE as f32 - 1.0) / 2.0) * PIXEL_RAD
}

/// The up to four neighbours inside the raster: index and direction.
fn neighbours(u: usize, v: usize) -> impl Iterator<Item = (usize, [f32; 2])> {
    [
        (u + 1 < SIDE).then(|| (v * SIDE + u + 1, [1.0, 0.0])),
        (u > 0).then(|| (v * SIDE + u - 1, [-1.0, 0.0])),
        (v + 1 < SIDE).then(|| ((v + 1) * SIDE + u, [0.0, 1.0])),
        (v > 0).then(|| ((v - 1) * SIDE + u, [0.0, -1.0])),
    ]
    .into_iter()
    .flatten()
}

/// How view `number` is searched: the preset for jujubes, in two variations.
pub fn config(number: u64) -> Config {
    let preset = Config::jujube();
    let map = match number & 4 {
        0 => preset.map,
        _ => MapConfig { boxiness: 0.0, hypotheses: 16, kept: 3, ..preset.map },
    };
    Config { map, ..preset }
}

/// Makes view `number`, searches it to the end by the default search, and digests all that was found.
pub fn search_digest(number: u64, canvas: &mut Canvas, workspace: &mut Workspace<VIEW_POINTS>) -> Digested {
    let view = canvas.scene(number);
    let Ok(detector) = Detector::new(config(number)) else { return Digested::default() };
    let Ok(run) = detector.detect_view(&view, workspace.scratch(), number) else {
        return Digested::default();
    };
    run.fold(Digested::default(), |before, detection| before.and(&detection))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_fruit_has_about_250_points_and_an_outline() {
        let mut canvas = Canvas::new();
        let View { cloud, in_mask, outline, .. } = canvas.one_fruit();
        assert!((200..300).contains(&cloud.len()), "{}", cloud.len());
        assert!((150..cloud.len()).contains(&in_mask), "{in_mask}");
        assert!((40..120).contains(&outline.len()), "{}", outline.len());
        assert!(cloud[..in_mask].iter().all(|point| point.z < 685.0));
        assert!(cloud[in_mask..].iter().all(|point| point.z > 770.0));
        assert!(outline.iter().all(|ray| ray.inner.z < 685.0 && ray.outer_mm > 770.0));
    }

    #[test]
    fn scenes_fit_and_are_found() {
        let mut canvas = Canvas::new();
        let mut workspace = Workspace::new();
        let (mut targets, mut accepted) = (0, 0);
        for number in 0..40 {
            let view = canvas.scene(number);
            // Two fruit can have more rays than there is room for: the device holds no more either.
            let sizes = (view.cloud.len(), view.outline.len());
            assert!(sizes.0 < VIEW_POINTS && sizes.1 > 0, "{number}: {sizes:?}");
            let found = search_digest(number, &mut canvas, &mut workspace);
            targets += found.targets;
            accepted += found.accepted;
        }
        assert!(accepted >= 35 && targets > accepted, "{accepted} of {targets} accepted");
    }
}
