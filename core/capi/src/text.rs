//! Words for codes. The linker leaves them out of a program that does not ask.

use core::ffi::{CStr, c_char};

use crate::types::CConfig;

/// A sentence for a status, never null.
#[unsafe(no_mangle)]
pub extern "C" fn varsac_status_text(status: i32) -> *const c_char {
    let text: &CStr = match status {
        0 => c"done",
        1 => c"there is more to do",
        2 => c"a target was found",
        3 => c"the search is over",
        -1 => c"a pointer is null or a number is out of range",
        -2 => c"a field of the configuration is out of range; varsac_config_problem names it",
        -3 => c"a coordinate of the cloud is not finite or too large",
        -4 => c"the cloud has more points than the workspace, or more outline rays than a view may have",
        _ => c"not a status of this version",
    };
    text.as_ptr()
}

/// A word or two for a verdict, never null.
#[unsafe(no_mangle)]
pub extern "C" fn varsac_verdict_text(verdict: u32) -> *const c_char {
    let text: &CStr = match verdict {
        0 => c"accepted",
        1 => c"refused: few points",
        2 => c"refused: size conflict",
        3 => c"refused: size unknown",
        4 => c"refused: ambiguous",
        5 => c"refused: outline",
        6 => c"refused: visible",
        7 => c"refused: colour",
        8 => c"refused: uncertain",
        9 => c"refused: flat",
        10 => c"refused: seen through",
        11 => c"refused: shared volume",
        12 => c"refused: singular",
        13 => c"refused: clutter",
        14 => c"refused: coverage",
        15 => c"refused: shape",
        16 => c"refused: vague",
        _ => c"not a verdict of this version",
    };
    text.as_ptr()
}

/// Name of the first field of a configuration that is out of range, or null.
///
/// # Safety
/// `config` is null or leads to a `varsac_config_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn varsac_config_problem(config: *const CConfig) -> *const c_char {
    // SAFETY: null is refused; the caller answers for the rest.
    let Some(config) = (unsafe { config.as_ref() }) else { return c"config".as_ptr() };
    let field = match config.to_config() {
        Err(field) => return field.as_ptr(),
        Ok(config) => match config.check() {
            Ok(()) => return core::ptr::null(),
            Err(error) => error.field,
        },
    };
    let found = FIELDS.iter().find(|name| name.to_bytes() == field.as_bytes());
    found.map_or(c"config".as_ptr(), |name| name.as_ptr())
}

/// The core's names of the fields it checks, which do not end in 0, with their 0. As expressions behind `config->` or
/// `config.` they are C.
const FIELDS: &[&CStr] = &[
    c"confidence",
    c"sample_sizes",
    c"shell",
    c"radius",
    c"semi_axis_min",
    c"semi_axis_max",
    c"max_trials",
    c"refits",
    c"min_inliers",
    c"min_ratio",
    c"max_targets",
    c"max_failures",
    c"map.prior.semi_axes_mm",
    c"map.prior.spread",
    c"map.prior.spread_ab",
    c"map.prior.spread_bc",
    c"map.boxiness",
    c"map.noise.axial_mm",
    c"map.noise.lateral_rad",
    c"map.independence",
    c"map.outline_offset_rad",
    c"map.hypotheses",
    c"map.hypothesis_steps",
    c"map.kept",
    c"map.refine_steps",
    c"map.final_steps",
    c"map.inflation.base",
    c"map.inflation.per_conflict",
    c"map.inflation.per_clutter",
    c"map.gate.size_conflict",
    c"map.gate.size_conflict_end_on",
    c"map.gate.size_unknown",
    c"map.gate.ambiguous",
    c"map.gate.outline",
    c"map.gate.visible",
    c"map.gate.colour",
    c"map.gate.uncertain_mm",
    c"map.gate.flat",
    c"map.gate.through",
    c"map.gate.shared_volume",
];
