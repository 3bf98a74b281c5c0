//! The structs that cross the border. Plain data in fixed-width types; the header repeats them field by field.

use core::mem::{align_of, size_of};

use varsac_core::{Config, ConfigError, Constraint, Detection, MAX_SIZES, Point3, Scratch};

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
    pub reserved: u8,
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
    pub inliers: u32,
    pub candidates: u32,
    pub trials: u32,
    pub target: u32,
}

/// `varsac_workspace_t`: the caller's buffers.
#[repr(C)]
#[derive(Debug)]
#[allow(missing_docs, reason = "the macro VARSAC_WORKSPACE of the header fills it in")]
pub struct CWorkspace {
    pub order: *mut u16,
    pub members: *mut u16,
    pub labels: *mut u8,
    pub capacity: u32,
}

// The header asserts the same numbers.
const _: () = assert!(size_of::<CPoint>() == 12 && align_of::<CPoint>() == 4);
const _: () = assert!(size_of::<CConfig>() == 52);
const _: () = assert!(size_of::<CDetection>() == 92);

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
            reserved: 0,
        }
    }
}

impl CConfig {
    /// The core's configuration, unchecked but for what it cannot express.
    pub(crate) fn to_config(self) -> Result<Config, Status> {
        let sizes = self.sample_sizes.get(..usize::from(self.sample_size_count)).ok_or(Status::Argument)?;
        let constraint = match self.constraint {
            0 => Constraint::A11,
            1 => Constraint::Trace,
            _ => return Err(Status::Argument),
        };
        let mut config = Config { constraint, ..Config::table5() };
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
        Self {
            centre_mm: ellipsoid.centre.coords.into(),
            semi_axes_mm: ellipsoid.semi_axes,
            axes: ellipsoid.axes,
            quaternion_xyzw: ellipsoid.quaternion_xyzw(),
            inliers: detection.score.inliers,
            candidates: detection.score.candidates,
            trials: detection.report.trials,
            target: u32::from(detection.target),
        }
    }
}

impl CWorkspace {
    /// The buffers as the core takes them.
    ///
    /// # Safety
    /// Each pointer leads to `capacity` elements that nobody else touches for as long as `'a`.
    pub(crate) unsafe fn scratch<'a>(&self) -> Result<Scratch<'a>, Status> {
        if self.order.is_null() || self.members.is_null() || self.labels.is_null() || self.capacity > 65_535 {
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
        Ok(Scratch::new(order, members, labels))
    }
}
