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
        -4 => c"the cloud has more points than the workspace",
        _ => c"not a status of this version",
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
        Err(_) if usize::from(config.sample_size_count) > config.sample_sizes.len() => "sample_size_count",
        Err(_) => "constraint",
        Ok(config) => match config.check() {
            Ok(()) => return core::ptr::null(),
            Err(error) => error.field,
        },
    };
    // The core's names do not end in 0: find the one that does.
    let fields: [&CStr; 14] = [
        c"confidence",
        c"sample_sizes",
        c"sample_size_count",
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
        c"constraint",
    ];
    let found = fields.iter().find(|name| name.to_bytes() == field.as_bytes());
    found.map_or(c"config".as_ptr(), |name| name.as_ptr())
}
