//! `varsac locate`: options to a configuration, inputs to results, results to text, JSON, pictures and clouds.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use indicatif::{ProgressBar, ProgressStyle};
use varsac_core::{Config, Constraint, Gate, SizePrior, Viewpoint, mixture::MixtureConfig};

use super::{Outcome, print};
use crate::{
    backproject::PointOptions,
    cloud::{Cloud, Unit},
    error::InputError,
    frame::{Frame, png_file},
    fruit::Fruit,
    locate::{
        Camera, CameraNoise, Here, Located, MAX_CAPACITY, Method, Options, RegionSource, Searcher,
        locate_cloud_with, locate_frame_with,
    },
    picture, ply_out,
    report::{InputReport, table},
    segment::{AreaLimits, HueRange, SegmentOptions, preset},
};

/// Options of `varsac locate`.
#[derive(Debug, Args)]
#[command(after_help = "\
A frame folder holds color.png (8 bit), depth.png (16 bit) and intrinsics.json; or color.png 1920x1080, depth.png 512x424
and calibration.json for an unregistered Kinect v2 pair; optionally mask.png and instances.png. Results are in
millimetres in the camera's optical frame: x right, y down, z forward.

Examples:
  varsac locate frames/tree-1 --draw found.png
  varsac locate frames/* --fruit apple --json > found.jsonl
  varsac locate scan.ply --fruit lemon --radius all --constraint trace
  varsac locate log.csv --fruit none --method direct --constraint trace")]
pub(super) struct LocateArgs {
    /// Frame folders, clouds (.ply .pcd .csv .xyz), or - for csv on standard input.
    #[arg(required = true, value_name = "INPUT")]
    inputs: Vec<PathBuf>,

    /// What to look for: colour, size limits and sampling.
    #[arg(long, value_enum, default_value = "jujube")]
    fruit: Fruit,
    /// Limits of the semi-axes instead of the fruit's, e.g. 9.5..24.5 (millimetres).
    #[arg(long, value_name = "MIN..MAX", value_parser = parse_range)]
    semi_axes: Option<(f32, f32)>,
    /// Size of the fruit instead of the kind's: mean semi-axes, longest first, each with its relative standard deviation, e.g.
    /// 21.75,0.035,10.9,0.06 for a fruit with two equal short semi-axes, or six numbers (millimetres). Wide (0.15) where
    /// sizes vary or are not known well.
    #[arg(long, value_name = "A,SD,B,SD[,C,SD]", value_delimiter = ',')]
    prior: Option<Vec<f32>>,
    /// Search method.
    #[arg(long, value_enum, default_value = "map")]
    method: Method,
    /// From where the points were seen: the camera at the origin, or all around (a scanner's complete surface).
    #[arg(long, value_enum, default_value = "origin")]
    viewpoint: ViewpointArg,
    /// How careful to be before a target is accepted.
    #[arg(long, value_enum, default_value = "balanced")]
    gate: GateArg,
    /// Standard deviation of the depth camera along its rays, millimetres [default: 1].
    #[arg(long, value_name = "MM")]
    axial_noise: Option<f32>,
    /// Standard deviation of where a depth pixel looks, depth pixels [default: 0.365; 2 where depth was enlarged].
    #[arg(long, value_name = "PIXELS")]
    lateral_noise: Option<f32>,
    /// How much a depth pixel tells beside one with noise of its own, above 0 to 1 [default: 1; 0.1 where depth was enlarged to
    /// a finer colour image].
    #[arg(long, value_name = "SHARE")]
    independence: Option<f32>,
    /// Do not use the outline of the fruit in the depth image.
    #[arg(long)]
    no_outline: bool,
    /// A table of the paper as configuration, instead of the fruit's.
    #[arg(long, value_enum)]
    preset: Option<Preset>,
    /// How least squares fix the scale of the quadric.
    #[arg(long, value_enum, default_value = "a11")]
    constraint: ConstraintArg,
    /// Sampling radius r_s around the seed point in millimetres, or all.
    #[arg(long, value_name = "R|all", value_parser = parse_radius)]
    radius: Option<f32>,
    /// Half-thickness d of the counting shell, part of each semi-axis.
    #[arg(long, value_name = "D")]
    shell: Option<f32>,
    /// Probability of having drawn a good sample when the search stops.
    #[arg(long, value_name = "P")]
    confidence: Option<f32>,
    /// Sample sizes, tried in turn.
    #[arg(long, value_name = "N,N,...", value_delimiter = ',')]
    sizes: Option<Vec<u8>>,
    /// Trials per target at most.
    #[arg(long, value_name = "N")]
    max_trials: Option<u32>,
    /// Least-squares refits of the best hypothesis.
    #[arg(long, value_name = "N")]
    refits: Option<u8>,
    /// Points a target must have.
    #[arg(long, value_name = "N")]
    min_inliers: Option<u16>,
    /// Part of its neighbourhood that a hypothesis must explain, 0 to 1.
    #[arg(long, value_name = "W")]
    min_ratio: Option<f32>,
    /// Targets per region at most.
    #[arg(long, value_name = "N")]
    max_targets: Option<u8>,
    /// Seed of the random stream; the same input and seed give the same bits.
    #[arg(long, default_value_t = 1)]
    seed: u64,

    /// Where the regions of a frame come from: its colour, its mask.png, or its instances.png.
    #[arg(long, value_enum, default_value = "colour", conflicts_with = "mask")]
    regions: RegionsArg,
    /// A mask image for all frames: one value is split into connected regions, several values are instances.
    #[arg(long, value_name = "FILE.png")]
    mask: Option<PathBuf>,
    /// Hue range in degrees instead of the fruit's; 252..36 passes through 360.
    #[arg(long, value_name = "FROM..TO", value_parser = parse_hue)]
    hue: Option<HueRange>,
    /// Regions smaller than this many colour pixels are removed.
    #[arg(long, value_name = "PIXELS")]
    min_area: Option<u32>,
    /// Drop depth pixels whose 3x3 neighbourhood spans more than this (flying pixels), millimetres.
    #[arg(long, value_name = "MM")]
    flying_span: Option<f32>,
    /// Unit of a cloud's coordinates [default: m for .pcd, mm otherwise].
    #[arg(long, value_enum)]
    unit: Option<Unit>,
    /// Points a region or cloud may have; larger ones are thinned evenly [default: 1024 for a region of a frame,
    /// 65535 for a cloud].
    #[arg(long, value_name = "N")]
    capacity: Option<usize>,

    /// Draw the result; with several inputs the name of each is put before the extension.
    #[arg(long, value_name = "FILE.png")]
    draw: Option<PathBuf>,
    /// Write the searched points coloured by target; several inputs as with --draw.
    #[arg(long, value_name = "FILE.ply")]
    cloud_out: Option<PathBuf>,
    /// One JSON object per input line instead of tables.
    #[arg(long)]
    json: bool,
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
    /// The search method asked for.
    pub(super) fn method(&self) -> Method {
        match self.method {
            Method::Map if self.fruit == Fruit::None && self.prior.is_none() => Method::Mixture,
            method => method,
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

    fn options(&self) -> Result<Options, InputError> {
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
    fn output(&self, named: &Path, located: &Located) -> PathBuf {
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

/// Runs the command. Inputs are worked on one after the other and reported in their order; an input that cannot be
/// read does not keep the others from being worked on, but the exit code says so.
pub(super) fn run(args: &LocateArgs) -> Result<Outcome, InputError> {
    run_with(args, &mut Here)
}

/// [`run`], the regions searched by somebody else.
pub(super) fn run_with(args: &LocateArgs, searcher: &mut dyn Searcher) -> Result<Outcome, InputError> {
    let options = args.options()?;
    let progress = progress(args.inputs.len());
    let mut outcome = Outcome::NothingFound;
    let mut failed = None;
    let mut camera = None;
    for path in &args.inputs {
        match one(args, path, &options, searcher, &mut camera) {
            Ok((text, found)) => {
                progress.suspend(|| print(&text))?;
                if found {
                    outcome = Outcome::Found;
                }
            }
            Err(error) if args.inputs.len() == 1 => return Err(error),
            Err(error) => {
                progress.suspend(|| eprintln!("varsac: {error}"));
                failed = Some(error);
            }
        }
        progress.inc(1);
    }
    progress.finish_and_clear();
    match failed {
        None => Ok(outcome),
        Some(error) => {
            Err(InputError::at("locate", "not every input could be read", format!("the last was: {error}")))
        }
    }
}

/// Progress on a terminal when there is more than a moment's work.
fn progress(inputs: usize) -> ProgressBar {
    if inputs < 3 {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:30} {pos}/{len} {elapsed} (about {eta} left)");
    ProgressBar::new(inputs as u64).with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
}

/// Works on one input; returns what to print and whether anything was accepted.
fn one(
    args: &LocateArgs,
    path: &Path,
    options: &Options,
    searcher: &mut dyn Searcher,
    camera: &mut Option<Camera>,
) -> Result<(String, bool), InputError> {
    let input = path.display().to_string();
    let located = if path.is_dir() {
        let frame = Frame::read(path)?;
        let located = locate_frame_with(searcher, camera, &input, &frame, options)?;
        if let (Some(named), Some(camera)) = (&args.draw, camera) {
            picture::of_frame(&frame, camera, &located, &args.output(named, &located))?;
        }
        located
    } else {
        let located = locate_cloud_with(searcher, &input, &Cloud::read(path, args.unit)?, options)?;
        if let Some(named) = &args.draw {
            picture::of_cloud(&located, &args.output(named, &located))?;
        }
        located
    };
    if let Some(named) = &args.cloud_out {
        let points: Vec<[f32; 3]> = located.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        ply_out::write_ply(&args.output(named, &located), &points, &located.labels)?;
    }
    let found = located.targets.iter().any(|target| target.refusal.is_none());
    let text = if args.json {
        let report = InputReport::new(&located);
        format!(
            "{}\n",
            serde_json::to_string(&report).expect("a report of numbers and strings has a JSON form")
        )
    } else {
        table(&located)
    };
    Ok((text, found))
}
