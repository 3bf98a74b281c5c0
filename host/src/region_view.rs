//! What the core gets to see of each region of a frame: its points, what surrounds them, and where its fruit end.
//!
//! A region lives in the colour image, its points on the grid of the depth image. Depth that was warped into a colour image
//! of finer pixels is interpolated: neighbouring values repeat each other. Such a grid is thinned to every `stride`-th row and
//! column, so that a point is about as much information as one of the sensor's own pixels.

use varsac_core::{Config, OutlineRay, Point3, View};

use crate::{
    backproject::{PointOptions, View as PixelView},
    error::InputError,
    image::{DepthImage, Image},
    outline::outline_rays,
    segment::Regions,
};

/// Points and outline of one region, in the order in which the core wants them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RegionView {
    /// Points of the region row by row, then those around it row by row; millimetres, camera optical frame.
    pub points: Vec<Point3>,
    /// Points of the region.
    pub in_mask: usize,
    /// Rays that touch the outline of something in the region.
    pub outline: Vec<OutlineRay>,
    /// Angle between neighbouring points, rad; 0 = not known.
    pub pitch_rad: f32,
}

impl RegionView {
    /// A cloud of which nothing else is known.
    pub fn of_cloud(points: Vec<Point3>) -> Self {
        Self { in_mask: points.len(), points, ..Self::default() }
    }

    /// As the core takes it.
    pub fn view(&self) -> View<'_> {
        View { cloud: &self.points, in_mask: self.in_mask, outline: &self.outline, pitch_rad: self.pitch_rad }
    }
}

/// How regions become views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ViewOptions {
    /// Which depth pixels become points.
    pub points: PointOptions,
    /// Where the region ends tells where its fruit ends: true for a mask drawn with care, false for a colour threshold, of
    /// whose border a point's width is not trusted.
    pub mask_is_exact: bool,
    /// What is seen around a region, this many grid points wide, is seen around its fruit: it shows where they are not.
    pub margin_px: usize,
    /// Depth that separates two surfaces at an outline, millimetres; nothing: no outline rays.
    pub outline_step_mm: Option<f32>,
    /// Most points of a region; above, its grid is thinned further.
    pub capacity: usize,
    /// Most outline rays of a region; above, they are thinned evenly.
    pub outline_capacity: usize,
}

/// Focal length, in pixels, beyond which depth is taken for interpolated: no time-of-flight camera of today has a longer one.
const NATIVE_FOCAL_PX: f64 = 650.0;

/// The depth image on its thinned grid.
struct Grid<'a> {
    pixels: PixelView<'a>,
    stride: usize,
    depth: DepthImage,
    /// Region of each grid point with depth, 0 = none.
    region: Image<u32>,
    regions: &'a Regions,
}

/// Rows and columns of a region's points on the grid, ends included.
#[derive(Clone, Copy)]
struct Bounds {
    left: i64,
    right: i64,
    top: i64,
    bottom: i64,
    count: usize,
}

/// The views of all regions, in their order. `O(depth pixels)`.
///
/// # Errors
/// When the regions are not of the size of the colour image.
pub fn region_views(
    pixels: &PixelView<'_>,
    regions: &Regions,
    options: &ViewOptions,
) -> Result<Vec<RegionView>, InputError> {
    let (width, height) = pixels.colour_size();
    if (regions.image.width, regions.image.height) != (width, height) {
        return Err(InputError::at(
            "mask",
            format!("is {}x{} pixels", regions.image.width, regions.image.height),
            format!("give one of the size of the colour image, {width}x{height}"),
        ));
    }
    let stride = stride(pixels);
    let grid = Grid::new(*pixels, regions, &options.points, stride);
    let bounds = grid.bounds(regions.list.len());
    Ok(bounds.iter().enumerate().map(|(k, bounds)| grid.view(k as u32 + 1, bounds, options)).collect())
}

/// Every so many rows and columns of the depth image are about one of the sensor's own.
pub fn stride(pixels: &PixelView<'_>) -> usize {
    (pixels.focal_px().0 / NATIVE_FOCAL_PX).ceil().max(1.0) as usize
}

/// Points whose neighbours are looked for in [`pitch_of`].
const PITCH_SAMPLES: usize = 200;

/// Angle between neighbouring points of a cloud as seen from the origin, rad: the median over some points of the angle to the
/// nearest other one. 0 where the points are not in front of a camera at the origin.
pub fn pitch_of(points: &[Point3]) -> f32 {
    if points.len() < 2 || points.iter().any(|p| p.z <= 0.0) {
        return 0.0;
    }
    let places: Vec<[f32; 2]> = points.iter().map(|p| [p.x / p.z, p.y / p.z]).collect();
    let mut nearest: Vec<f32> = crate::decimate::evenly_spaced(places.len(), PITCH_SAMPLES)
        .into_iter()
        .map(|k| {
            let squares = places.iter().enumerate().filter(|&(j, _)| j != k).map(|(_, place)| {
                let d = [place[0] - places[k][0], place[1] - places[k][1]];
                d[0] * d[0] + d[1] * d[1]
            });
            libm::sqrtf(squares.fold(f32::INFINITY, f32::min))
        })
        .collect();
    nearest.sort_by(f32::total_cmp);
    nearest[nearest.len() / 2]
}

impl ViewOptions {
    /// Points a region may have unless said otherwise: a fruit of the nearest kind fills half of it.
    pub const CAPACITY: usize = 2048;
    /// Outline rays a region may have unless said otherwise: what a co-processor takes.
    pub const OUTLINE_CAPACITY: usize = varsac_core::link::payload::OUTLINE_CAPACITY;

    /// What a search with `config` wants to see: surfaces count as separate at nine tenths of the shortest semi-axis.
    pub fn of(config: &Config) -> Self {
        Self {
            points: PointOptions::default(),
            mask_is_exact: false,
            margin_px: 2,
            outline_step_mm: Some(0.9 * config.map.prior.semi_axes_mm[2]),
            capacity: Self::CAPACITY,
            outline_capacity: Self::OUTLINE_CAPACITY,
        }
    }
}

impl<'a> Grid<'a> {
    fn new(pixels: PixelView<'a>, regions: &'a Regions, options: &PointOptions, stride: usize) -> Self {
        let full = pixels.depth();
        let (width, height) = (full.width.div_ceil(stride), full.height.div_ceil(stride));
        let mut depth = Image::filled(width, height, 0.0_f32);
        let mut region = Image::filled(width, height, 0_u32);
        for v in 0..height {
            for u in 0..width {
                let (column, row) = (u * stride, v * stride);
                let z_mm = full.pixels[row * full.width + column];
                // Written so that NaN fails it too.
                if !(z_mm > 0.0 && (options.near_mm..=options.far_mm).contains(&z_mm)) {
                    continue;
                }
                depth.pixels[v * width + u] = z_mm;
                if let Some((column, row)) = pixels.colour_px(column, row) {
                    let place = row as usize * regions.image.width + column as usize;
                    region.pixels[v * width + u] = regions.image.pixels[place];
                }
            }
        }
        let mut grid = Self { pixels, stride, depth, region, regions };
        if let Some(limit_mm) = options.flying_span_mm {
            grid.drop_flying(limit_mm);
        }
        grid
    }

    /// Takes grid points out whose neighbourhood spans more depth than this.
    fn drop_flying(&mut self, limit_mm: f32) {
        let before = self.depth.clone();
        for v in 0..before.height {
            for u in 0..before.width {
                if crate::backproject::depth_span_mm(&before, u, v) > limit_mm {
                    self.depth.pixels[v * before.width + u] = 0.0;
                }
            }
        }
    }

    fn bounds(&self, regions: usize) -> Vec<Bounds> {
        let empty = Bounds { left: i64::MAX, right: i64::MIN, top: i64::MAX, bottom: i64::MIN, count: 0 };
        let mut all = vec![empty; regions];
        for (v, row) in self.region.pixels.chunks_exact(self.region.width.max(1)).enumerate() {
            for (u, &label) in row.iter().enumerate() {
                if let Some(bounds) = (label as usize).checked_sub(1).and_then(|k| all.get_mut(k)) {
                    let (u, v) = (u as i64, v as i64);
                    bounds.left = bounds.left.min(u);
                    bounds.right = bounds.right.max(u);
                    bounds.top = bounds.top.min(v);
                    bounds.bottom = bounds.bottom.max(v);
                    bounds.count += 1;
                }
            }
        }
        all
    }

    /// One region's view. A region with more points than there is room for keeps every second, third, ... row and column.
    fn view(&self, label: u32, bounds: &Bounds, options: &ViewOptions) -> RegionView {
        let mut result = RegionView::default();
        if bounds.count == 0 {
            return result;
        }
        for step in 1.. {
            let (inside, around) = self.points(label, bounds, options, step);
            if inside.len() + around.len() <= options.capacity || step > bounds.right - bounds.left {
                result.in_mask = inside.len().min(options.capacity);
                result.points = inside;
                result.points.extend(around);
                result.points.truncate(options.capacity);
                result.pitch_rad = ((self.stride as i64 * step) as f64 / self.pixels.focal_px().0) as f32;
                break;
            }
        }
        if let Some(step_mm) = options.outline_step_mm {
            // Interpolated depth has no edges, only ramps.
            let mut rays =
                if self.stride == 1 { self.depth_edges(label, bounds, step_mm) } else { Vec::new() };
            if options.mask_is_exact || self.stride > 1 {
                let sigma_px = if options.mask_is_exact { DRAWN_SIGMA_PX } else { COLOUR_SIGMA_PX };
                rays.extend(self.mask_edges(label, bounds, step_mm, sigma_px));
            }
            let kept = crate::decimate::evenly_spaced(rays.len(), options.outline_capacity);
            result.outline = kept.iter().map(|&index| rays[index]).collect();
        }
        result
    }

    /// Every `step`-th point of the region, and of what surrounds it.
    fn points(
        &self,
        label: u32,
        bounds: &Bounds,
        options: &ViewOptions,
        step: i64,
    ) -> (Vec<Point3>, Vec<Point3>) {
        let doubtful = i64::from(!options.mask_is_exact);
        let margin = options.margin_px as i64 + doubtful;
        let (mut inside, mut around) = (Vec::new(), Vec::new());
        let reach = margin * step;
        let first = |from: i64| ((from - reach).max(0) + step - 1) / step * step;
        for v in (first(bounds.top)..=bounds.bottom + reach).step_by(step as usize) {
            for u in (first(bounds.left)..=bounds.right + reach).step_by(step as usize) {
                let Some(z_mm) = self.valid(u, v) else { continue };
                let within = |reach: i64| {
                    let own = |i, j| self.region.get(u + i * step, v + j * step) == Some(label);
                    (-reach..=reach).any(|j| (-reach..=reach).any(|i| own(i, j)))
                };
                let elsewhere = self.region.get(u, v).is_some_and(|other| other != label && other != 0);
                if within(doubtful) && !elsewhere {
                    inside.push(self.point(u, v, z_mm));
                } else if within(margin) {
                    around.push(self.point(u, v, z_mm));
                }
            }
        }
        (inside, around)
    }

    fn point(&self, u: i64, v: i64, z_mm: f32) -> Point3 {
        let point = self.ray(u as f64, v as f64).map(|x| x * f64::from(z_mm));
        Point3::new(point[0] as f32, point[1] as f32, z_mm)
    }

    /// Direction (x, y) for z = 1 of a place on the grid.
    fn ray(&self, u: f64, v: f64) -> [f64; 2] {
        let stride = self.stride as f64;
        let ray = self.pixels.ray(u * stride, v * stride);
        [ray.x, ray.y]
    }

    fn depth_edges(&self, label: u32, bounds: &Bounds, step_mm: f32) -> Vec<OutlineRay> {
        let focal_px = self.pixels.focal_px().0 / self.stride as f64;
        let own = |u, v| self.region.get(u, v) == Some(label);
        let columns = bounds.left - 1..=bounds.right + 1;
        let rows = bounds.top - 1..=bounds.bottom + 1;
        outline_rays(&self.depth, (columns, rows), own, focal_px, |u, v| self.ray(u, v), step_mm)
    }

    /// Rays between the last pixel of the region and the first one outside it, along the rows and columns of the grid; where
    /// something nearer begins there, the region ends and its fruit does not.
    fn mask_edges(&self, label: u32, bounds: &Bounds, step_mm: f32, sigma_px: f64) -> Vec<OutlineRay> {
        let depths = self.depths_of(label, bounds);
        let Some(&middle_mm) = depths.get(depths.len() / 2) else { return Vec::new() };
        let sigma_rad = (sigma_px / self.pixels.focal_px().0) as f32;
        let mut rays = Vec::new();
        for v in bounds.top - 1..=bounds.bottom + 1 {
            for u in bounds.left - 1..=bounds.right + 1 {
                if !self.in_region(label, u, v) {
                    continue;
                }
                for (du, dv) in [(1, 0), (-1, 0), (0, 1), (0, -1)] {
                    if self.in_region(label, u + du, v + dv) {
                        continue;
                    }
                    let outer = (1..=MASK_LOOK).find_map(|k| self.valid(u + k * du, v + k * dv));
                    let inner = (0..MASK_LOOK).find_map(|k| self.valid(u - k * du, v - k * dv));
                    let inner_mm = inner.unwrap_or(middle_mm);
                    if outer.is_some_and(|outer_mm| outer_mm < inner_mm - step_mm) {
                        continue;
                    }
                    let [x, y] = self.ray(u as f64 + 0.5 * du as f64, v as f64 + 0.5 * dv as f64);
                    let z = f64::from(middle_mm);
                    rays.push(OutlineRay {
                        inner: Point3::new((x * z) as f32, (y * z) as f32, middle_mm),
                        outer_mm: f32::INFINITY,
                        sigma_rad,
                    });
                }
            }
        }
        rays
    }

    /// True when the colour pixel at a grid point lies in the region, with depth or without.
    fn in_region(&self, label: u32, u: i64, v: i64) -> bool {
        let stride = self.stride as i64;
        match self.pixels {
            PixelView::Registered { .. } => self.regions.image.get(u * stride, v * stride) == Some(label),
            PixelView::Kinect { .. } => self.region.get(u, v) == Some(label),
        }
    }

    fn valid(&self, u: i64, v: i64) -> Option<f32> {
        self.depth.get(u, v).filter(|&z_mm| z_mm > 0.0)
    }

    /// Depths of a region, ascending.
    fn depths_of(&self, label: u32, bounds: &Bounds) -> Vec<f32> {
        let mut depths = Vec::with_capacity(bounds.count);
        for v in bounds.top..=bounds.bottom {
            for u in bounds.left..=bounds.right {
                if self.region.get(u, v) == Some(label) {
                    depths.extend(self.valid(u, v));
                }
            }
        }
        depths.sort_by(f32::total_cmp);
        depths
    }
}

/// Deviation of a drawn mask's border, colour pixels, and of the depth image's place in it.
const DRAWN_SIGMA_PX: f64 = 4.0;
/// The same of the border of a colour threshold.
const COLOUR_SIGMA_PX: f64 = 6.0;
/// Grid points to either side of a mask's border that are looked at.
const MASK_LOOK: i64 = 4;
