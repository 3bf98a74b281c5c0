//! Inputs of the core under the names of the contract, for the reference.

use varsac_core::{CentralQuadric, Config, Constraint, Noise, Point3, Viewpoint};
use varsac_reference as reference;

use crate::region_view::RegionView;

/// The cloud as the reference has it.
pub(crate) fn points(cloud: &[Point3]) -> Vec<reference::Point> {
    cloud.iter().map(|p| [p.x, p.y, p.z]).collect()
}

/// The view as the reference has it.
pub fn reference_view(view: &RegionView) -> reference::View {
    let rays = view.outline.iter().map(|ray| reference::OutlineRay {
        inner: [ray.inner.x, ray.inner.y, ray.inner.z],
        outer: ray.outer_mm,
        sigma: ray.sigma_rad,
    });
    reference::View {
        points: points(&view.points),
        in_mask: view.in_mask,
        outline: rays.collect(),
        pitch: view.pitch_rad,
    }
}

/// The surface as the reference has it.
pub(crate) fn central(surface: &CentralQuadric) -> reference::Central {
    let (c, s) = (&surface.centre, &surface.shape);
    reference::Central {
        centre: [c.x, c.y, c.z],
        shape: reference::Symmetric { xx: s.xx, yy: s.yy, zz: s.zz, xy: s.xy, xz: s.xz, yz: s.yz },
    }
}

/// The constraint of the same name.
pub(crate) fn constraint(constraint: Constraint) -> reference::Constraint {
    match constraint {
        Constraint::A11 => reference::Constraint::A11,
        Constraint::Trace => reference::Constraint::Trace,
    }
}

/// What a configuration tells the paper's search.
pub fn reference_config(config: &Config) -> reference::Config {
    reference::Config {
        confidence: config.confidence,
        sizes: config.sample_sizes.to_vec(),
        shell: config.shell,
        radius: config.radius,
        semi_axis_min: config.semi_axis_min,
        semi_axis_max: config.semi_axis_max,
        max_trials: config.max_trials,
        refits: u32::from(config.refits),
        min_inliers: u32::from(config.min_inliers),
        min_ratio: config.min_ratio,
        max_targets: config.max_targets,
        max_failures: u32::from(config.max_failures),
        constraint: constraint(config.constraint),
    }
}

/// What a configuration tells the default search.
pub fn reference_map_config(config: &Config) -> reference::MapConfig {
    let map = &config.map;
    reference::MapConfig {
        max_targets: config.max_targets,
        max_failures: u32::from(config.max_failures),
        semi_axes: map.prior.semi_axes_mm,
        spread: map.prior.spread,
        spread_ab: map.prior.spread_ab,
        spread_bc: map.prior.spread_bc,
        boxiness: map.boxiness,
        noise: noise(map.noise),
        independence: map.independence,
        viewpoint: viewpoint(map.viewpoint),
        outline_offset: map.outline_offset_rad,
        hypotheses: u32::from(map.hypotheses),
        hypothesis_steps: u32::from(map.hypothesis_steps),
        kept: usize::from(map.kept),
        refine_steps: u32::from(map.refine_steps),
        final_steps: u32::from(map.final_steps),
        inflation: reference::Inflation {
            base: map.inflation.base,
            per_conflict: map.inflation.per_conflict,
            per_clutter: map.inflation.per_clutter,
        },
        gate: reference::Gate {
            min_points: map.gate.min_points,
            size_conflict: map.gate.size_conflict,
            size_conflict_end_on: map.gate.size_conflict_end_on,
            size_unknown: map.gate.size_unknown,
            ambiguous: map.gate.ambiguous,
            outline: map.gate.outline,
            visible: map.gate.visible,
            colour: map.gate.colour,
            uncertain: map.gate.uncertain_mm,
            flat: map.gate.flat,
            through: map.gate.through,
            shared_volume: map.gate.shared_volume,
        },
    }
}

/// What a configuration tells the search without a size prior.
pub fn reference_mixture_config(config: &Config) -> reference::MixtureConfig {
    let mixture = &config.mixture;
    reference::MixtureConfig {
        max_targets: config.max_targets,
        max_failures: u32::from(config.max_failures),
        viewpoint: viewpoint(mixture.viewpoint),
        noise: noise(mixture.noise),
        sample: mixture.sample,
        starts: mixture.starts,
        area_weight: mixture.area_weight,
        shape_spread: mixture.shape_spread,
        outline_offset: mixture.outline_offset_rad,
        inflation: mixture.inflation,
        inflation_thin: mixture.inflation_thin,
        inflation_outliers: mixture.inflation_outliers,
        gate: reference::MixtureGate {
            min_points: mixture.gate.min_points,
            gain: mixture.gate.gain,
            flat: mixture.gate.flat,
            coverage: mixture.gate.coverage,
            misfit: mixture.gate.misfit,
            uncertain: mixture.gate.uncertain,
        },
    }
}

fn noise(noise: Noise) -> reference::Noise {
    reference::Noise { axial: noise.axial_mm, lateral: noise.lateral_rad }
}

fn viewpoint(viewpoint: Viewpoint) -> reference::Viewpoint {
    match viewpoint {
        Viewpoint::Origin => reference::Viewpoint::Origin,
        Viewpoint::None => reference::Viewpoint::None,
    }
}
