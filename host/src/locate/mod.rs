//! The main job: from a frame or a cloud to a list of located fruit.
//!
//! A frame is segmented by colour (or by a given mask) into regions of the colour image; the depth pixels of each
//! region become points; each region is a cloud of its own and is searched on its own, regions side by side. A cloud
//! given as such is one region. Results are in the order of the regions, and within a region in the order found.

mod learn;
mod region;
mod whole;

use std::time::{Duration, Instant};

use serde::Serialize;
use varsac_core::{Config, Covariance, Ellipsoid, MapConfig, Point3, Score, Viewpoint};

use crate::{
    backproject::{Pinhole, View},
    cloud::Cloud,
    decimate::decimate,
    error::InputError,
    frame::{Frame, Geometry},
    image::LabelImage,
    kinect::Registration,
    region_view::{RegionView, ViewOptions, pitch_of, region_views},
    segment::{self, Regions, SegmentOptions},
};

pub use learn::LearntSize;
pub use region::{Found, Here, Searcher, detector, seen};
pub use whole::fit_all;

/// Points a cloud may have: what 16-bit indices can name.
pub const MAX_CAPACITY: usize = varsac_core::point::MAX_POINTS;
/// How an ellipsoid is searched for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Method {
    /// The default: the most probable body of known size, with its uncertainty, accepted or refused.
    Map,
    /// The most probable ellipsoid of any size: what the default is with `--fruit none`.
    Mixture,
    /// The paper's: variable sample consensus, counting between two ellipsoids, least squares.
    Varsac,
    /// The paper's baseline: nine points, distance and normal.
    Ransac,
    /// The paper's baseline: least squares on all points of a region.
    Direct,
    /// One ellipsoid through all points, every one good: least squares of a frame-independent quadric, with uncertainty.
    Algebraic,
    /// The same with the least sum of squared distances from the surface.
    Geometric,
}

impl Method {
    /// The name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Map => "map",
            Self::Mixture => "mixture",
            Self::Varsac => "varsac",
            Self::Ransac => "ransac",
            Self::Direct => "direct",
            Self::Algebraic => "algebraic",
            Self::Geometric => "geometric",
        }
    }
}

/// Where the regions of a frame come from.
#[derive(Debug, Clone)]
pub enum RegionSource {
    /// The colour of the fruit.
    Colour(SegmentOptions),
    /// The frame's own `mask.png`: connected regions.
    Mask,
    /// The frame's own `instances.png`: a region a value.
    Instances,
    /// A mask from elsewhere; more than one non-zero value makes it an instance image.
    Given(LabelImage),
}

/// What to do with each input.
#[derive(Debug, Clone)]
pub struct Options {
    /// Search method.
    pub method: Method,
    /// Configuration of the search; the baselines take their limits, radius, trials and constraint from it too.
    pub config: Config,
    /// Where the regions of a frame come from.
    pub regions: RegionSource,
    /// What the search gets to see of each region of a frame.
    pub views: ViewOptions,
    /// Seed of every region's search.
    pub seed: u64,
    /// Points a cloud may have; larger ones are thinned.
    pub cloud_capacity: usize,
    /// What is known of the camera's noise.
    pub noise: CameraNoise,
    /// What the size prior's mean was learnt from, if it was ([`Self::with_learnt_size`]).
    pub learnt_size: Option<LearntSize>,
}

/// What a user knows of the camera's noise; what is not given follows from the kind of depth image.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct CameraNoise {
    /// Standard deviation along the viewing rays, mm.
    pub axial_mm: Option<f32>,
    /// Standard deviation of where a depth pixel looks, depth pixels.
    pub lateral_px: Option<f32>,
    /// How much a pixel tells beside one with noise of its own, above 0 to 1.
    pub independence: Option<f32>,
}

impl CameraNoise {
    /// Depth that was warped into a finer colour image, as measured on two orchard frames of a time-of-flight camera in the
    /// sun: it follows a fruit's roundness poorly, lies some pixels beside its colour, and repeats itself.
    const INTERPOLATED: (f32, f32, f32) = (3.0, 2.0, 0.02);

    fn apply(&self, map: &mut MapConfig, pitch_rad: f32, interpolated: bool) {
        let (mut axial_mm, mut lateral_rad) = (map.noise.axial_mm, map.noise.lateral_rad);
        if interpolated {
            let (axial, lateral_px, independence) = Self::INTERPOLATED;
            (axial_mm, lateral_rad, map.independence) = (axial, lateral_px * pitch_rad, independence);
        }
        map.noise.axial_mm = self.axial_mm.unwrap_or(axial_mm);
        map.noise.lateral_rad = self.lateral_px.map_or(lateral_rad, |pixels| pixels * pitch_rad);
        map.independence = self.independence.unwrap_or(map.independence);
    }
}

impl Options {
    /// Looks for what `config` says, with the search it names.
    pub fn new(config: Config, regions: RegionSource, seed: u64) -> Self {
        let method = match config.method {
            varsac_core::Method::Map => Method::Map,
            varsac_core::Method::Mixture => Method::Mixture,
            varsac_core::Method::Varsac => Method::Varsac,
        };
        let mask_is_exact = !matches!(regions, RegionSource::Colour(_));
        let views = ViewOptions { mask_is_exact, ..ViewOptions::of(&config) };
        Self {
            method,
            config,
            regions,
            views,
            seed,
            cloud_capacity: MAX_CAPACITY,
            noise: CameraNoise::default(),
            learnt_size: None,
        }
    }
}

/// Why a target is not to be trusted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Refusal {
    /// What was tested ([`varsac_core::RefusalCode::name`]).
    pub code: &'static str,
    /// The value found.
    pub value: f32,
    /// The limit it broke.
    pub limit: f32,
}

impl std::fmt::Display for Refusal {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "refused: {}", self.brief())?;
        if self.has_value() {
            write!(f, " (limit {})", figures(self.limit))?;
        }
        Ok(())
    }
}

impl Refusal {
    /// What failed and by what value, in short.
    pub fn brief(&self) -> String {
        if self.has_value() { format!("{} {}", self.code, figures(self.value)) } else { self.code.to_owned() }
    }

    fn has_value(&self) -> bool {
        self.value != self.limit
    }
}

/// As many decimals as three significant digits need: limits are anything from 0.025 to 20.
fn figures(value: f32) -> String {
    match value.abs() {
        _ if value.fract() == 0.0 => format!("{value:.0}"),
        small if small < 0.1 => format!("{value:.3}"),
        medium if medium < 10.0 => format!("{value:.2}"),
        _ => format!("{value:.1}"),
    }
}

/// A located fruit.
#[derive(Debug, Clone)]
pub struct Target {
    /// Region it was found in, 1 for the first.
    pub region: u32,
    /// Nothing when accepted.
    pub refusal: Option<Refusal>,
    /// Centre, semi-axes, axes; camera frame, millimetres.
    pub ellipsoid: Ellipsoid,
    /// Inliers among the points that were still unclaimed.
    pub score: Score,
    /// Trials of its search.
    pub trials: u32,
    /// How sure, where the method knows.
    pub covariance: Option<Covariance>,
}

impl Target {
    /// To be trusted.
    pub fn is_accepted(&self) -> bool {
        self.refusal.is_none()
    }
}

/// What was found in one input.
#[derive(Debug, Clone)]
pub struct Located {
    /// The input as named by the user.
    pub input: String,
    /// Name of the frame or cloud.
    pub name: String,
    /// Method used.
    pub method: Method,
    /// Seed used.
    pub seed: u64,
    /// All points searched, region after region.
    pub points: Vec<Point3>,
    /// For each point 0, or the number of the target (from 1, in the order of `targets`) that claimed it.
    pub labels: Vec<u32>,
    /// What was found.
    pub targets: Vec<Target>,
    /// What the size prior's mean was learnt from, if it was.
    pub learnt_size: Option<LearntSize>,
    /// What a user should know: points thinned, points without measurement.
    pub notes: Vec<String>,
    /// Segmentation, back-projection and search; not reading.
    pub elapsed: Duration,
}

impl Located {
    /// Targets that are to be trusted.
    pub fn accepted(&self) -> impl Iterator<Item = &Target> {
        self.targets.iter().filter(|target| target.is_accepted())
    }
}

/// The camera of a frame, with what has to be kept alive for a [`View`] of it.
#[derive(Debug)]
pub enum Camera {
    /// Colour and depth share one pinhole camera.
    Shared(Pinhole),
    /// A Kinect v2 pair with its registered depth.
    Kinect(Box<(Registration, crate::kinect::RegisteredDepth)>),
}

impl Camera {
    /// The camera of `frame`; registers the depth of a Kinect pair.
    ///
    /// # Errors
    /// Intrinsics that describe no camera, or depth of another size than the device's.
    pub fn of(frame: &Frame) -> Result<Self, InputError> {
        match &frame.geometry {
            Geometry::Registered(i) => Ok(Self::Shared(Pinhole::new(i.fx, i.fy, i.cx, i.cy)?)),
            Geometry::Factory(calibration) => {
                let registration = Registration::new(calibration);
                let registered = registration.register(&frame.depth_mm)?;
                Ok(Self::Kinect(Box::new((registration, registered))))
            }
        }
    }

    /// [`Self::of`] for one frame after another: tables and images of the frame before are used again where the device
    /// is the same, which halves the work.
    ///
    /// # Errors
    /// As [`Self::of`].
    pub fn turn_to<'a>(camera: &'a mut Option<Self>, frame: &Frame) -> Result<&'a Self, InputError> {
        let kept = match (camera.take(), &frame.geometry) {
            (Some(Self::Kinect(mut pair)), Geometry::Factory(calibration)) if pair.0.is_of(calibration) => {
                let (registration, registered) = &mut *pair;
                registration.register_again(&frame.depth_mm, registered)?;
                Self::Kinect(pair)
            }
            _ => Self::of(frame)?,
        };
        Ok(camera.insert(kept))
    }

    /// Where the colour image was seen from, millimetres, in the frame of the points.
    pub fn colour_centre_mm(&self) -> [f64; 3] {
        match self {
            Self::Shared(_) => [0.0; 3],
            Self::Kinect(pair) => pair.0.colour_camera().centre_mm(),
        }
    }

    /// How `frame`'s pixels and points relate.
    pub fn view<'a>(&'a self, frame: &'a Frame) -> View<'a> {
        match self {
            Self::Shared(camera) => View::Registered { depth: &frame.depth_mm, camera: *camera },
            Self::Kinect(pair) => View::Kinect { registration: &pair.0, depth: &pair.1 },
        }
    }
}

/// Locates fruit in a frame.
///
/// # Errors
/// A mask that is asked for and missing or of the wrong size, intrinsics that describe no camera, a configuration out of range.
pub fn locate_frame(input: &str, frame: &Frame, options: &Options) -> Result<Located, InputError> {
    locate_frame_with(&mut Here, &mut None, input, frame, options)
}

/// [`locate_frame`], searched by somebody else, with the camera of the frame before, which becomes that of this one.
///
/// # Errors
/// As [`locate_frame`], and the searcher's.
pub fn locate_frame_with(
    searcher: &mut dyn Searcher,
    camera: &mut Option<Camera>,
    input: &str,
    frame: &Frame,
    options: &Options,
) -> Result<Located, InputError> {
    let started = Instant::now();
    let camera = Camera::turn_to(camera, frame)?;
    let view = camera.view(frame);
    let views = region_views(&view, &regions_of(input, frame, &options.regions)?, &options.views)?;
    let stride = crate::region_view::stride(&view);
    let pitch_rad = (stride as f64 / view.focal_px().0) as f32;
    let work = Work { input, name: &frame.name, started };
    search(&work, searcher, views, (pitch_rad, stride > 1), Vec::new(), options)
}

/// What the core gets to see of each region of a frame, in the order of the regions.
///
/// # Errors
/// As [`locate_frame`].
pub fn views_of(
    camera: &Camera,
    input: &str,
    frame: &Frame,
    source: &RegionSource,
    options: &ViewOptions,
) -> Result<Vec<RegionView>, InputError> {
    region_views(&camera.view(frame), &regions_of(input, frame, source)?, options)
}

/// Locates fruit in a cloud.
///
/// # Errors
/// A configuration out of range.
pub fn locate_cloud(input: &str, cloud: &Cloud, options: &Options) -> Result<Located, InputError> {
    locate_cloud_with(&mut Here, input, cloud, options)
}

/// [`locate_cloud`], searched by somebody else.
///
/// # Errors
/// As [`locate_cloud`], and the searcher's.
pub fn locate_cloud_with(
    searcher: &mut dyn Searcher,
    input: &str,
    cloud: &Cloud,
    options: &Options,
) -> Result<Located, InputError> {
    let started = Instant::now();
    let notes = match cloud.dropped {
        0 => Vec::new(),
        n => vec![format!("{n} points of the file carry no measurement")],
    };
    let kept = decimate(&cloud.points_mm, options.cloud_capacity.min(MAX_CAPACITY));
    let mut notes = notes;
    notes.extend(kept.is_thinned().then(|| kept.to_string()));
    let mut view = RegionView::of_cloud(kept.points);
    let mut pitch_rad = view.pitch_rad;
    if options.config.map.viewpoint == Viewpoint::Origin {
        pitch_rad = pitch_of(&cloud.points_mm);
        // Of the pixels of a thinned cloud each stands for several.
        let stands_for = cloud.points_mm.len() as f32 / view.points.len().max(1) as f32;
        view.pitch_rad = pitch_rad * stands_for.sqrt();
    }
    let work = Work { input, name: &cloud.name, started };
    search(&work, searcher, vec![view], (pitch_rad, false), notes, options)
}

fn regions_of(input: &str, frame: &Frame, source: &RegionSource) -> Result<Regions, InputError> {
    let all = segment::AreaLimits::ALL;
    let missing = |file: &str| {
        InputError::at(
            input,
            format!("has no {file}"),
            "leave out --regions to segment by colour, or give --mask FILE",
        )
    };
    match source {
        RegionSource::Colour(options) => segment::segment(&frame.colour, options),
        RegionSource::Mask => {
            let mask = frame.mask.as_ref().ok_or_else(|| missing("mask.png"))?;
            Ok(segment::regions::connected_regions(mask, all))
        }
        RegionSource::Instances => {
            let instances = frame.instances.as_ref().ok_or_else(|| missing("instances.png"))?;
            Ok(segment::regions::instance_regions(instances, all))
        }
        RegionSource::Given(mask) => {
            let mut values = mask.pixels.iter().filter(|&&value| value != 0);
            let first = values.next();
            Ok(match first {
                Some(first) if values.any(|value| value != first) => {
                    segment::regions::instance_regions(mask, all)
                }
                _ => segment::regions::connected_regions(mask, all),
            })
        }
    }
}

/// What is searched, for the results and the clock.
struct Work<'a> {
    input: &'a str,
    name: &'a str,
    started: Instant,
}

/// Searches each view and puts the results together. `pitch_rad` is that of the camera's own pixels, 0 where it is not known.
fn search(
    work: &Work<'_>,
    searcher: &mut dyn Searcher,
    views: Vec<RegionView>,
    (pitch_rad, interpolated): (f32, bool),
    mut notes: Vec<String>,
    options: &Options,
) -> Result<Located, InputError> {
    let mut options = options.clone();
    if pitch_rad > 0.0 {
        options.config.map = options.config.map.with_pitch(pitch_rad);
        options.noise.apply(&mut options.config.map, pitch_rad, interpolated);
    }
    let found = searcher.search(&views, &options)?;

    notes.extend(options.learnt_size.map(|learnt| learnt.to_string()));

    let mut located = Located {
        input: work.input.to_owned(),
        name: work.name.to_owned(),
        method: options.method,
        seed: options.seed,
        points: Vec::new(),
        labels: Vec::new(),
        targets: Vec::new(),
        learnt_size: options.learnt_size,
        notes,
        elapsed: Duration::ZERO,
    };
    for (k, (view, (targets, labels))) in views.into_iter().zip(found).enumerate() {
        let before = located.targets.len() as u32;
        located.points.extend(view.points);
        located.labels.extend(labels.iter().map(|&label| if label == 0 { 0 } else { before + label }));
        located.targets.extend(targets.into_iter().map(|target| Target { region: k as u32 + 1, ..target }));
    }
    located.elapsed = work.started.elapsed();
    Ok(located)
}
