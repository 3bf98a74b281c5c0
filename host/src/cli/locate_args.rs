//! The options of `varsac locate` and the configuration they make.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use varsac_core::{Config, Constraint, Gate, SizePrior, Viewpoint, mixture::MixtureConfig};

use crate::{
    backproject::PointOptions,
    cloud::Unit,
    error::InputError,
    frame::png_file,
    fruit::Fruit,
    locate::{CameraNoise, Located, MAX_CAPACITY, Method, Options, RegionSource},
    segment::{AreaLimits, HueRange, SegmentOptions, preset},
};

/// Headings of the help.
const FRAMES: &str = "Options for frames";
const CAMERA: &str = "Options for the camera (map)";
const OUTPUT: &str = "Options for the output";
const PAPER: &str = "Options for the paper's methods (varsac, ransac, direct)";

/// Options of `varsac locate`.
#[derive(Debug, Args)]
#[command(after_help = "\
A frame folder holds color.png (8 bit), depth.png (16 bit) and intrinsics.json; or color.png 1920x1080, depth.png 512x424
and calibration.json for an unregistered Kinect v2 pair; optionally mask.png and instances.png. Results are in
millimetres in the camera's optical frame: x right, y down, z forward.

A target is accepted or refused with the test it failed, the value and the limit; refused ones are listed and drawn
too, but are not found. Exit code: 0 at least one target accepted, 1 none, 2 usage or unreadable input.

Examples:
  varsac locate frames/tree-1 --draw found.png
  varsac locate frames/* --fruit apple --json > found.jsonl
  varsac locate frames/* --learn-size                           an orchard whose fruit may be larger than usual
  varsac locate view.csv --prior 34,0.1,27,0.1                  fruit of your own size, 34 x 27 x 27 mm within 10 %
  varsac locate view.csv --fruit none                           one view of fruit of unknown size
  varsac locate scan.ply --fruit none --viewpoint none          complete surfaces of any size
  varsac locate log.csv --fruit none --method geometric         one ellipsoid through every point: a magnetometer
  varsac locate view.csv --method varsac --radius 30            the paper's search")]
pub(super) struct LocateArgs {
    /// Frame folders, clouds (.ply .pcd .csv .xyz), or - for csv on standard input.
    #[arg(required = true, value_name = "INPUT")]
    pub(super) inputs: Vec<PathBuf>,

    /// What to look for: its colour and its size.
    #[arg(long, value_enum, default_value = "jujube")]
    pub(super) fruit: Fruit,
    /// Size of the fruit instead of the kind's: mean semi-axes, longest first, each with its relative standard deviation, e.g.
    /// 21.75,0.035,10.9,0.06 for a fruit with two equal short semi-axes, or six numbers (millimetres). Wide (0.15) where
    /// sizes vary or are not known well.
    #[arg(long, value_name = "A,SD,B,SD[,C,SD]", value_delimiter = ',')]
    prior: Option<Vec<f32>>,
    /// Search everything twice: first with the size loosened by 15 %, then with the mean size learnt from what was accepted.
    /// For an orchard whose fruit may be larger or smaller than the kind's usual size, by 20 % at most; needs 12 accepted fits.
    #[arg(long)]
    pub(super) learn_size: bool,
    /// How to search [default: map; mixture where the size is not known; varsac with --preset].
    #[arg(long, value_enum)]
    method: Option<Method>,
    /// From where the points were seen: from the camera at the origin, or from all around (a scanner's complete surface).
    /// For map and mixture.
    #[arg(long, value_enum, default_value = "origin")]
    viewpoint: ViewpointArg,
    /// How careful map is before it accepts a target.
    #[arg(long, value_enum, default_value = "balanced")]
    gate: GateArg,
    /// Targets per region at most.
    #[arg(long, value_name = "N")]
    max_targets: Option<u8>,
    /// Seed of the random stream; the same input and seed give the same bits.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Unit of a cloud's coordinates [default: m for .pcd, mm otherwise].
    #[arg(long, value_enum)]
    pub(super) unit: Option<Unit>,
    /// Points a region or cloud may have; larger ones are thinned evenly [default: 2048 for a region of a frame,
    /// 65535 for a cloud].
    #[arg(long, value_name = "N")]
    capacity: Option<usize>,

    /// Where the regions of a frame come from: its colour, its mask.png, or its instances.png.
    #[arg(long, help_heading = FRAMES, value_enum, default_value = "colour", conflicts_with = "mask")]
    regions: RegionsArg,
    /// A mask image for all frames: one value is split into connected regions, several values are instances.
    #[arg(long, help_heading = FRAMES, value_name = "FILE.png")]
    mask: Option<PathBuf>,
    /// Hue range in degrees instead of the fruit's; 252..36 passes through 360.
    #[arg(long, help_heading = FRAMES, value_name = "FROM..TO", value_parser = parse_hue)]
    hue: Option<HueRange>,
    /// Regions smaller than this many colour pixels are removed.
    #[arg(long, help_heading = FRAMES, value_name = "PIXELS")]
    min_area: Option<u32>,
    /// Drop depth pixels whose 3x3 neighbourhood spans more than this (flying pixels), millimetres.
    #[arg(long, help_heading = FRAMES, value_name = "MM")]
    flying_span: Option<f32>,
    /// Standard deviation of the depth camera along its rays, millimetres [default: 1; 3 where depth was enlarged to a finer
    /// colour image].
    #[arg(long, help_heading = CAMERA, value_name = "MM")]
    axial_noise: Option<f32>,
    /// Standard deviation of where a depth pixel looks, depth pixels [default: 0.365; 2 where depth was enlarged].
    #[arg(long, help_heading = CAMERA, value_name = "PIXELS")]
    lateral_noise: Option<f32>,
    /// How much a depth pixel tells beside one with noise of its own, above 0 to 1 [default: 1; 0.02 where depth was
    /// enlarged].
    #[arg(long, help_heading = CAMERA, value_name = "SHARE")]
    independence: Option<f32>,
    /// Do not use the outline of the fruit in the depth image.
    #[arg(long, help_heading = CAMERA)]
    no_outline: bool,

    /// Draw the result; with several inputs the name of each is put before the extension.
    #[arg(long, help_heading = OUTPUT, value_name = "FILE.png")]
    pub(super) draw: Option<PathBuf>,
    /// Write the searched points coloured by target; several inputs as with --draw.
    #[arg(long, help_heading = OUTPUT, value_name = "FILE.ply")]
    pub(super) cloud_out: Option<PathBuf>,
    /// One JSON object per input line instead of tables.
    #[arg(long, help_heading = OUTPUT)]
    pub(super) json: bool,

    /// Limits of the semi-axes instead of the fruit's, e.g. 9.5..24.5 (millimetres). For varsac and ransac.
    #[arg(long, help_heading = PAPER, value_name = "MIN..MAX", value_parser = parse_range)]
    semi_axes: Option<(f32, f32)>,
    /// A table of the paper as configuration, instead of the fruit's.
    #[arg(long, help_heading = PAPER, value_enum)]
    preset: Option<Preset>,
    /// How least squares fix the scale of the quadric. For varsac and direct.
    #[arg(long, help_heading = PAPER, value_enum, default_value = "a11")]
    constraint: ConstraintArg,
    /// Sampling radius r_s around the seed point in millimetres, or all.
    #[arg(long, help_heading = PAPER, value_name = "R|all", value_parser = parse_radius)]
    radius: Option<f32>,
    /// Half-thickness d of the counting shell, part of each semi-axis.
    #[arg(long, help_heading = PAPER, value_name = "D")]
    shell: Option<f32>,
    /// Probability of having drawn a good sample when the search stops.
    #[arg(long, help_heading = PAPER, value_name = "P")]
    confidence: Option<f32>,
    /// Sample sizes, tried in turn.
    #[arg(long, help_heading = PAPER, value_name = "N,N,...", value_delimiter = ',')]
    sizes: Option<Vec<u8>>,
    /// Trials per target at most.
    #[arg(long, help_heading = PAPER, value_name = "N")]
    max_trials: Option<u32>,
    /// Least-squares refits of the best hypothesis.
    #[arg(long, help_heading = PAPER, value_name = "N")]
    refits: Option<u8>,
    /// Points a target must have. (What map and mixture demand follows from --gate and the size.)
    #[arg(long, help_heading = PAPER, value_name = "N")]
    min_inliers: Option<u16>,
    /// Part of its neighbourhood that a hypothesis must explain, 0 to 1.
    #[arg(long, help_heading = PAPER, value_name = "W")]
    min_ratio: Option<f32>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Preset {
    /// Table 2: the simulation, r_s = 1.
    Table2,
    /// Table 2 with r_s = 6.5 and five refits.
    Table2Wide,
    /// Table 5: jujubes as printed.
    Table5,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ViewpointArg {
    /// A depth camera: fruit show their near side.
    Origin,
    /// Complete surfaces.
    None,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GateArg {
    /// Few, and those are right.
    Strict,
    /// The default.
    Balanced,
    /// Many, and more of them wrong.
    Eager,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum ConstraintArg {
    /// a11 = 1, as in the paper.
    A11,
    /// Constant trace: the same answer in every frame.
    Trace,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum RegionsArg {
    /// Hue threshold, mean filter, connected regions.
    Colour,
    /// The frame's mask.png.
    Mask,
    /// The frame's instances.png.
    Instances,
}

fn bounds(text: &str) -> Option<(f32, f32)> {
    let (from, to) = text.split_once("..")?;
    Some((from.trim().parse().ok()?, to.trim().parse().ok()?))
}

fn parse_range(text: &str) -> Result<(f32, f32), String> {
    bounds(text).ok_or_else(|| "write two numbers as MIN..MAX, e.g. 9.5..24.5".to_owned())
}

fn parse_hue(text: &str) -> Result<HueRange, String> {
    let (from, to) = bounds(text).ok_or("write degrees as FROM..TO, e.g. 252..36")?;
    let whole = |value: f32| {
        let inside = (0.0..=360.0).contains(&value) && value.fract() == 0.0;
        inside
            .then_some(value as u16)
            .ok_or_else(|| format!("{value} is not a whole number of degrees from 0 to 360"))
    };
    Ok(HueRange { from_deg: whole(from)?, to_deg: whole(to)? })
}

fn parse_radius(text: &str) -> Result<f32, String> {
    if text == "all" {
        return Ok(f32::INFINITY);
    }
    text.parse().map_err(|_| "write millimetres, or all".to_owned())
}

impl LocateArgs {
    /// The search method asked for; where the size is not known, the default is the search without it.
    pub(super) fn method(&self) -> Method {
        let of_options = if self.preset.is_some() {
            Method::Varsac
        } else if self.is_sized() {
            Method::Map
        } else {
            Method::Mixture
        };
        self.method.unwrap_or(of_options)
    }

    /// True when the options tell how large the fruit are.
    fn is_sized(&self) -> bool {
        self.prior.is_some() || !matches!(self.fruit, Fruit::None | Fruit::Generic)
    }

    /// Says on standard error which of the given options play no part in the method: a user who turns one of them shall not
    /// wonder why nothing changes.
    pub(super) fn note_idle_options(&self) {
        let method = self.method();
        let paper = [
            ("--semi-axes", self.semi_axes.is_some() && self.prior.is_none()),
            ("--preset", self.preset.is_some()),
            ("--radius", self.radius.is_some()),
            ("--confidence", self.confidence.is_some()),
            ("--sizes", self.sizes.is_some()),
            ("--max-trials", self.max_trials.is_some()),
            ("--refits", self.refits.is_some()),
            ("--min-inliers", self.min_inliers.is_some()),
            ("--min-ratio", self.min_ratio.is_some()),
        ];
        let sized = [
            ("--prior", self.prior.is_some()),
            ("--axial-noise", self.axial_noise.is_some()),
            ("--lateral-noise", self.lateral_noise.is_some()),
            ("--independence", self.independence.is_some()),
        ];
        let idle = match method {
            Method::Varsac | Method::Ransac => &sized[..],
            Method::Map => &paper[..],
            _ => &[paper.as_slice(), &sized].concat(),
        };
        let names: Vec<&str> = idle.iter().filter(|(_, given)| *given).map(|(name, _)| *name).collect();
        if !names.is_empty() {
            eprintln!("varsac: note: {} has no say in --method {}", names.join(", "), method.name());
        }
    }

    fn config(&self) -> Config {
        let mut config = match self.preset {
            None => self.fruit.config(),
            Some(Preset::Table2) => Config::table2(),
            Some(Preset::Table2Wide) => Config::table2_wide(),
            Some(Preset::Table5) => Config::table5(),
        };
        config.constraint = match self.constraint {
            ConstraintArg::A11 => Constraint::A11,
            ConstraintArg::Trace => Constraint::Trace,
        };
        if let Some((min, max)) = self.semi_axes {
            (config.semi_axis_min, config.semi_axis_max) = (min, max);
        }
        if let Some(sizes) = &self.sizes {
            config.sample_sizes = sizes.iter().copied().take(config.sample_sizes.capacity()).collect();
        }
        config.radius = self.radius.unwrap_or(config.radius);
        config.shell = self.shell.unwrap_or(config.shell);
        config.confidence = self.confidence.unwrap_or(config.confidence);
        config.max_trials = self.max_trials.unwrap_or(config.max_trials);
        config.refits = self.refits.unwrap_or(config.refits);
        config.min_inliers = self.min_inliers.unwrap_or(config.min_inliers);
        config.min_ratio = self.min_ratio.unwrap_or(config.min_ratio);
        config.max_targets = self.max_targets.unwrap_or(config.max_targets);
        config.method = match self.method() {
            Method::Map => varsac_core::Method::Map,
            Method::Mixture => varsac_core::Method::Mixture,
            _ => varsac_core::Method::Varsac,
        };
        let map = &mut config.map;
        if let Some(prior) = &self.prior {
            map.prior = size_prior(prior);
        }
        let limits = match self.gate {
            GateArg::Strict => Some(Gate::STRICT),
            GateArg::Balanced => None,
            GateArg::Eager => Some(Gate::EAGER),
        };
        if let Some(gate) = limits {
            map.gate = gate.scaled(map.prior.semi_axes_mm[2]);
        } else if self.prior.is_some() {
            map.gate = Gate::BALANCED.scaled(map.prior.semi_axes_mm[2]);
        }
        (map.viewpoint, config.mixture) = match self.viewpoint {
            ViewpointArg::Origin => (Viewpoint::Origin, MixtureConfig::VIEW),
            ViewpointArg::None => (Viewpoint::None, MixtureConfig::SURFACE),
        };
        config
    }

    fn segmentation(&self) -> SegmentOptions {
        let mut options = preset(self.fruit.name());
        if let Some(hue) = self.hue {
            options.gate.hue = hue;
        }
        if let Some(min_px) = self.min_area {
            options.area = AreaLimits { min_px, ..options.area };
        }
        options
    }

    pub(super) fn options(&self) -> Result<Options, InputError> {
        if let Some(capacity) = self.capacity
            && !(1..=MAX_CAPACITY).contains(&capacity)
        {
            return Err(InputError::at(
                "--capacity",
                format!("is {capacity}"),
                format!("give 1 to {MAX_CAPACITY}: the core's indices have 16 bits"),
            ));
        }
        if self.sizes.as_ref().is_some_and(|sizes| sizes.len() > varsac_core::MAX_SIZES) {
            return Err(InputError::at(
                "--sizes",
                "lists too many sample sizes",
                format!("give at most {}", varsac_core::MAX_SIZES),
            ));
        }
        if self.prior.as_ref().is_some_and(|prior| prior.len() != 4 && prior.len() != 6) {
            return Err(InputError::at(
                "--prior",
                "needs four or six numbers",
                "give A,SD,B,SD (two equal short semi-axes) or A,SD,B,SD,C,SD in millimetres, e.g. 21.75,0.035,10.9,0.06",
            ));
        }
        if self.method() == Method::Map && !self.is_sized() {
            return Err(InputError::at(
                "--method",
                "map needs to know the size",
                "name a fruit or give --prior, or leave it out to search without a size (mixture)",
            ));
        }
        if self.learn_size && self.method() != Method::Map {
            return Err(InputError::at(
                "--learn-size",
                format!("has no size to learn with --method {}", self.method().name()),
                "name a fruit or give --prior, with --method map",
            ));
        }
        if self.learn_size && self.inputs.iter().any(|path| path.as_os_str() == "-") {
            return Err(InputError::at(
                "--learn-size",
                "reads every input twice, standard input can be read once",
                "save it as a file",
            ));
        }
        let config = self.config();
        config.check().map_err(|error| {
            InputError::at(format!("--{}", option_of(error.field)), error.to_string(), "change that option")
        })?;
        let regions = match (&self.mask, self.regions) {
            (Some(path), _) => RegionSource::Given(png_file::read(path, png_file::decode_instances)?),
            (None, RegionsArg::Colour) => RegionSource::Colour(self.segmentation()),
            (None, RegionsArg::Mask) => RegionSource::Mask,
            (None, RegionsArg::Instances) => RegionSource::Instances,
        };
        let mut options = Options::new(config, regions, self.seed);
        options.method = self.method();
        options.views.points = PointOptions { flying_span_mm: self.flying_span, ..PointOptions::default() };
        options.views.capacity = self.capacity.unwrap_or(options.views.capacity);
        options.cloud_capacity = self.capacity.unwrap_or(options.cloud_capacity);
        options.noise = CameraNoise {
            axial_mm: self.axial_noise,
            lateral_px: self.lateral_noise,
            independence: self.independence,
        };
        if self.no_outline {
            options.views.outline_step_mm = None;
        }
        Ok(options)
    }

    /// The file of this input: the one named, or with several inputs one with the input's name in it.
    pub(super) fn output(&self, named: &Path, located: &Located) -> PathBuf {
        if self.inputs.len() == 1 {
            return named.to_owned();
        }
        let stem = named.file_stem().unwrap_or_default().to_string_lossy();
        let extension = named.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
        named.with_file_name(format!("{stem}-{}{extension}", located.name))
    }
}

/// The prior of `--prior`: as many numbers as [`LocateArgs::options`] lets through.
fn size_prior(numbers: &[f32]) -> SizePrior {
    let at = |k: usize| numbers.get(k).copied().unwrap_or(f32::NAN);
    let (a, b) = ([at(0), at(1)], [at(2), at(3)]);
    let c = if numbers.len() == 6 { [at(4), at(5)] } else { b };
    SizePrior { semi_axes_mm: [a[0], b[0], c[0]], spread: [a[1], b[1], c[1]], ..SizePrior::JUJUBE }
}

/// The command-line option that sets a field of the configuration.
fn option_of(field: &str) -> String {
    match field {
        "sample_sizes" => "sizes".to_owned(),
        "semi_axis_min" | "semi_axis_max" => "semi-axes".to_owned(),
        "map.noise.axial_mm" => "axial-noise".to_owned(),
        other if other.starts_with("map.prior") => "prior".to_owned(),
        other => other.replace('_', "-"),
    }
}
