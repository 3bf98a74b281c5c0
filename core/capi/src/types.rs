//! The structs that cross the border. Plain data in fixed-width types; the header repeats them field by field.

use core::ffi::CStr;
use core::mem::{MaybeUninit, align_of, size_of};

use varsac_core::{
    Config, ConfigError, Constraint, Detection, Finds, Gate, Inflation, MAX_SIZES, MapConfig, Method, Noise,
    OutlineRay, Point3, RefusalCode, Scratch, SizePrior, View, Viewpoint, mixture::MixtureConfig,
};

/// `varsac_point_t`: the core's own point, three floats.
pub type CPoint = Point3;

/// `varsac_config_t`, see [`Config`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::Config")]
pub struct CConfig {
    pub confidence: f32,
    pub shell: f32,
    pub radius: f32,
    pub semi_axis_min: f32,
    pub semi_axis_max: f32,
    pub min_ratio: f32,
    pub max_trials: u32,
    pub min_inliers: u16,
    pub refits: u8,
    pub max_targets: u8,
    pub max_failures: u8,
    pub constraint: u8,
    pub sample_size_count: u8,
    pub sample_sizes: [u8; MAX_SIZES],
    pub method: u8,
    pub map: CMap,
}

/// `varsac_map_t`, see [`MapConfig`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::MapConfig")]
pub struct CMap {
    pub prior: CPrior,
    pub boxiness: f32,
    pub noise: CNoise,
    pub independence: f32,
    pub outline_offset_rad: f32,
    pub inflation: CInflation,
    pub gate: CGate,
    pub hypotheses: u16,
    pub viewpoint: u8,
    pub hypothesis_steps: u8,
    pub kept: u8,
    pub refine_steps: u8,
    pub final_steps: u8,
    pub reserved: u8,
}

/// `varsac_prior_t`, see [`SizePrior`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::SizePrior")]
pub struct CPrior {
    pub semi_axes_mm: [f32; 3],
    pub spread: [f32; 3],
    pub spread_ab: f32,
    pub spread_bc: f32,
}

/// `varsac_noise_t`, see [`Noise`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::Noise")]
pub struct CNoise {
    pub axial_mm: f32,
    pub lateral_rad: f32,
}

/// `varsac_inflation_t`, see [`Inflation`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::Inflation")]
pub struct CInflation {
    pub base: f32,
    pub per_conflict: f32,
    pub per_clutter: f32,
}

/// `varsac_gate_t`, see [`Gate`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::Gate")]
pub struct CGate {
    pub size_conflict: f32,
    pub size_conflict_end_on: f32,
    pub size_unknown: f32,
    pub ambiguous: f32,
    pub outline: f32,
    pub visible: f32,
    pub colour: f32,
    pub uncertain_mm: f32,
    pub flat: f32,
    pub through: f32,
    pub shared_volume: f32,
    pub min_points: u16,
    pub reserved: u16,
}

/// `varsac_outline_ray_t`: the core's own, five floats.
pub type COutlineRay = OutlineRay;

/// `varsac_view_t`: what a search looks at, see [`View`].
#[repr(C)]
#[derive(Debug)]
#[allow(missing_docs, reason = "the header describes them")]
pub struct CView {
    pub points: *const CPoint,
    pub outline: *const COutlineRay,
    pub point_count: u32,
    pub outside_mask: u32,
    pub outline_count: u32,
    pub pitch_rad: f32,
}

/// `varsac_detection_t`, see [`Detection`].
#[repr(C)]
#[derive(Debug, Clone, Copy)]
#[allow(missing_docs, reason = "the fields are those of varsac_core::Detection")]
pub struct CDetection {
    pub centre_mm: [f32; 3],
    pub semi_axes_mm: [f32; 3],
    pub axes: [[f32; 3]; 3],
    pub quaternion_xyzw: [f32; 4],
    pub sigma_centre_mm: [f32; 3],
    pub covariance: [f32; COVARIANCE],
    pub verdict: u32,
    pub refusal_value: f32,
    pub refusal_limit: f32,
    pub inliers: u32,
    pub candidates: u32,
    pub trials: u32,
    pub target: u32,
}

/// Numbers of a symmetric 9x9 matrix.
const COVARIANCE: usize = 45;

/// `varsac_workspace_t`: the caller's buffers.
#[repr(C)]
#[derive(Debug)]
#[allow(missing_docs, reason = "the macro VARSAC_WORKSPACE of the header fills it in")]
pub struct CWorkspace {
    pub order: *mut u16,
    pub members: *mut u16,
    pub labels: *mut u8,
    pub finds: *mut CFinds,
    pub capacity: u32,
}

/// `VARSAC_FINDS_WORDS` of the header: room for what is found, and some to grow.
const FINDS_WORDS: usize = 800;

/// `varsac_finds_t`: memory that the caller owns and does not look into.
#[repr(C)]
#[derive(Debug)]
pub struct CFinds {
    words: [MaybeUninit<u64>; FINDS_WORDS],
}

const _: () = assert!(size_of::<Finds>() <= size_of::<CFinds>());
const _: () = assert!(align_of::<Finds>() <= align_of::<CFinds>());

// The header asserts the same numbers.
const _: () = assert!(size_of::<CPoint>() == 12 && align_of::<CPoint>() == 4);
const _: () = assert!(size_of::<CMap>() == 120);
const _: () = assert!(size_of::<CConfig>() == 172);
const _: () = assert!(size_of::<CDetection>() == 296);
const _: () = assert!(size_of::<COutlineRay>() == 20 && align_of::<COutlineRay>() == 4);
const _: () = assert!(size_of::<CView>() == 16 + 2 * size_of::<usize>());

/// Outcome of a call, `varsac_status_t`. Negative: an error, and nothing was done.
#[repr(i32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// Done.
    Ok = 0,
    /// There is more to do.
    Working = 1,
    /// A target was found.
    Found = 2,
    /// The search is over.
    Finished = 3,
    /// A pointer is null or a number is out of range.
    Argument = -1,
    /// A field of the configuration is out of range.
    Configuration = -2,
    /// A coordinate is not finite or too large.
    Coordinate = -3,
    /// The cloud has more points than the workspace.
    Capacity = -4,
}

impl From<&Config> for CConfig {
    fn from(config: &Config) -> Self {
        let mut sample_sizes = [0; MAX_SIZES];
        for (slot, size) in sample_sizes.iter_mut().zip(&config.sample_sizes) {
            *slot = *size;
        }
        Self {
            confidence: config.confidence,
            shell: config.shell,
            radius: config.radius,
            semi_axis_min: config.semi_axis_min,
            semi_axis_max: config.semi_axis_max,
            min_ratio: config.min_ratio,
            max_trials: config.max_trials,
            min_inliers: config.min_inliers,
            refits: config.refits,
            max_targets: config.max_targets,
            max_failures: config.max_failures,
            constraint: match config.constraint {
                Constraint::A11 => 0,
                Constraint::Trace => 1,
            },
            sample_size_count: config.sample_sizes.len() as u8,
            sample_sizes,
            method: match config.method {
                Method::Map => 0,
                Method::Varsac => 1,
                Method::Mixture => 2,
            },
            map: CMap::from(&config.map),
        }
    }
}

impl From<&MapConfig> for CMap {
    fn from(map: &MapConfig) -> Self {
        let MapConfig { prior, noise, inflation, gate, .. } = *map;
        Self {
            prior: CPrior {
                semi_axes_mm: prior.semi_axes_mm,
                spread: prior.spread,
                spread_ab: prior.spread_ab,
                spread_bc: prior.spread_bc,
            },
            boxiness: map.boxiness,
            noise: CNoise { axial_mm: noise.axial_mm, lateral_rad: noise.lateral_rad },
            independence: map.independence,
            outline_offset_rad: map.outline_offset_rad,
            inflation: CInflation {
                base: inflation.base,
                per_conflict: inflation.per_conflict,
                per_clutter: inflation.per_clutter,
            },
            gate: CGate {
                size_conflict: gate.size_conflict,
                size_conflict_end_on: gate.size_conflict_end_on,
                size_unknown: gate.size_unknown,
                ambiguous: gate.ambiguous,
                outline: gate.outline,
                visible: gate.visible,
                colour: gate.colour,
                uncertain_mm: gate.uncertain_mm,
                flat: gate.flat,
                through: gate.through,
                shared_volume: gate.shared_volume,
                min_points: gate.min_points,
                reserved: 0,
            },
            hypotheses: map.hypotheses,
            viewpoint: match map.viewpoint {
                Viewpoint::Origin => 0,
                Viewpoint::None => 1,
            },
            hypothesis_steps: map.hypothesis_steps,
            kept: map.kept,
            refine_steps: map.refine_steps,
            final_steps: map.final_steps,
            reserved: 0,
        }
    }
}

impl CMap {
    /// The core's values, unchecked; none for a viewpoint that does not exist.
    fn to_config(self) -> Option<MapConfig> {
        let Self { prior, noise, inflation, gate, .. } = self;
        Some(MapConfig {
            prior: SizePrior {
                semi_axes_mm: prior.semi_axes_mm,
                spread: prior.spread,
                spread_ab: prior.spread_ab,
                spread_bc: prior.spread_bc,
            },
            boxiness: self.boxiness,
            noise: Noise { axial_mm: noise.axial_mm, lateral_rad: noise.lateral_rad },
            viewpoint: match self.viewpoint {
                0 => Viewpoint::Origin,
                1 => Viewpoint::None,
                _ => return None,
            },
            independence: self.independence,
            outline_offset_rad: self.outline_offset_rad,
            hypotheses: self.hypotheses,
            hypothesis_steps: self.hypothesis_steps,
            kept: self.kept,
            refine_steps: self.refine_steps,
            final_steps: self.final_steps,
            inflation: Inflation {
                base: inflation.base,
                per_conflict: inflation.per_conflict,
                per_clutter: inflation.per_clutter,
            },
            gate: Gate {
                min_points: gate.min_points,
                size_conflict: gate.size_conflict,
                size_conflict_end_on: gate.size_conflict_end_on,
                size_unknown: gate.size_unknown,
                ambiguous: gate.ambiguous,
                outline: gate.outline,
                visible: gate.visible,
                colour: gate.colour,
                uncertain_mm: gate.uncertain_mm,
                flat: gate.flat,
                through: gate.through,
                shared_volume: gate.shared_volume,
            },
        })
    }
}

impl CConfig {
    /// The core's configuration, unchecked but for what it cannot express: then the name of the field.
    pub(crate) fn to_config(self) -> Result<Config, &'static CStr> {
        let sizes =
            self.sample_sizes.get(..usize::from(self.sample_size_count)).ok_or(c"sample_size_count")?;
        let constraint = match self.constraint {
            0 => Constraint::A11,
            1 => Constraint::Trace,
            _ => return Err(c"constraint"),
        };
        let method = match self.method {
            0 => Method::Map,
            1 => Method::Varsac,
            2 => Method::Mixture,
            _ => return Err(c"method"),
        };
        let map = self.map.to_config().ok_or(c"map.viewpoint")?;
        let mixture = match map.viewpoint {
            Viewpoint::Origin => MixtureConfig { noise: map.noise, ..MixtureConfig::VIEW },
            Viewpoint::None => MixtureConfig::SURFACE,
        };
        let mut config = Config { constraint, method, map, mixture, ..Config::table5() };
        config.sample_sizes.clear();
        for &size in sizes {
            // Never full: as many fit as there are.
            let _ = config.sample_sizes.push(size);
        }
        config.confidence = self.confidence;
        config.shell = self.shell;
        config.radius = self.radius;
        config.semi_axis_min = self.semi_axis_min;
        config.semi_axis_max = self.semi_axis_max;
        config.min_ratio = self.min_ratio;
        config.max_trials = self.max_trials;
        config.min_inliers = self.min_inliers;
        config.refits = self.refits;
        config.max_targets = self.max_targets;
        config.max_failures = self.max_failures;
        Ok(config)
    }
}

impl From<ConfigError> for Status {
    fn from(_: ConfigError) -> Self {
        Self::Configuration
    }
}

impl From<&Detection> for CDetection {
    fn from(detection: &Detection) -> Self {
        let ellipsoid = &detection.ellipsoid;
        let (verdict, refusal_value, refusal_limit) = match detection.status {
            varsac_core::Status::Accepted => (0, 0.0, 0.0),
            varsac_core::Status::Refused(refusal) => {
                (verdict_number(refusal.code), refusal.value, refusal.limit)
            }
        };
        // Not known: infinite, so that nobody takes it for certain.
        let mut covariance = [0.0; COVARIANCE];
        for (k, slot) in covariance.iter_mut().enumerate() {
            *slot = match &detection.covariance {
                Some(known) => known.packed().get(k).copied().unwrap_or(f32::INFINITY),
                None if DIAGONAL.contains(&k) => f32::INFINITY,
                None => 0.0,
            };
        }
        Self {
            centre_mm: ellipsoid.centre.coords.into(),
            semi_axes_mm: ellipsoid.semi_axes,
            axes: ellipsoid.axes,
            quaternion_xyzw: ellipsoid.quaternion_xyzw(),
            sigma_centre_mm: detection.covariance.map_or([f32::INFINITY; 3], |known| known.sigma_centre_mm()),
            covariance,
            verdict,
            refusal_value,
            refusal_limit,
            inliers: detection.score.inliers,
            candidates: detection.score.candidates,
            trials: detection.report.trials,
            target: u32::from(detection.target),
        }
    }
}

/// Where the variances stand among the packed numbers of a covariance.
const DIAGONAL: [usize; 9] = [0, 2, 5, 9, 14, 20, 27, 35, 44];

/// `varsac_verdict_t` of a refusal.
const fn verdict_number(code: RefusalCode) -> u32 {
    match code {
        RefusalCode::FewPoints => 1,
        RefusalCode::SizeConflict => 2,
        RefusalCode::SizeUnknown => 3,
        RefusalCode::Ambiguous => 4,
        RefusalCode::Outline => 5,
        RefusalCode::Visible => 6,
        RefusalCode::Colour => 7,
        RefusalCode::Uncertain => 8,
        RefusalCode::Flat => 9,
        RefusalCode::Through => 10,
        RefusalCode::SharedVolume => 11,
        RefusalCode::Singular => 12,
        RefusalCode::Clutter => 13,
        RefusalCode::Coverage => 14,
        RefusalCode::Shape => 15,
        RefusalCode::Vague => 16,
    }
}

impl CView {
    /// The view as the core takes it.
    ///
    /// # Safety
    /// Each pointer leads to as many elements as its count says, which stay as they are for as long as `'a`.
    pub(crate) unsafe fn view<'a>(&self) -> Result<View<'a>, Status> {
        if self.point_count > MAX_ITEMS
            || self.outline_count > MAX_ITEMS
            || self.outside_mask > self.point_count
        {
            return Err(Status::Argument);
        }
        // SAFETY: the caller answers for it.
        let (cloud, outline) =
            unsafe { (slice(self.points, self.point_count)?, slice(self.outline, self.outline_count)?) };
        Ok(View {
            cloud,
            in_mask: (self.point_count - self.outside_mask) as usize,
            outline,
            pitch_rad: self.pitch_rad,
        })
    }
}

/// Indices are 16 bits wide.
const MAX_ITEMS: u32 = 65_535;

/// # Safety
/// `items` is null or leads to `count` items, which stay as they are for as long as `'a`.
unsafe fn slice<'a, T>(items: *const T, count: u32) -> Result<&'a [T], Status> {
    match (items.is_null(), count) {
        (_, 0) => Ok(&[]),
        (true, _) => Err(Status::Argument),
        // SAFETY: not null, and the caller answers for the rest.
        (false, _) => Ok(unsafe { core::slice::from_raw_parts(items, count as usize) }),
    }
}

impl CWorkspace {
    /// The buffers as the core takes them.
    ///
    /// # Safety
    /// The pointers to lists lead to `capacity` elements, the other to what it says, and nobody else touches them for as
    /// long as `'a`.
    pub(crate) unsafe fn scratch<'a>(&self) -> Result<Scratch<'a>, Status> {
        let missing =
            self.order.is_null() || self.members.is_null() || self.labels.is_null() || self.finds.is_null();
        if missing || self.capacity > MAX_ITEMS {
            return Err(Status::Argument);
        }
        let capacity = self.capacity as usize;
        // SAFETY: not null, and the caller answers for the rest.
        let (order, members, labels) = unsafe {
            (
                core::slice::from_raw_parts_mut(self.order, capacity),
                core::slice::from_raw_parts_mut(self.members, capacity),
                core::slice::from_raw_parts_mut(self.labels, capacity),
            )
        };
        let finds = self.finds.cast::<Finds>();
        // SAFETY: size and alignment are asserted above; not null, and the caller answers for the rest.
        let finds = unsafe {
            finds.write(Finds::new());
            &mut *finds
        };
        Ok(Scratch::new(order, members, labels, finds))
    }
}
