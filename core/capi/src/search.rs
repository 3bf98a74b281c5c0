//! Detection in one call and step by step.

use core::mem::{MaybeUninit, align_of, size_of};

use varsac_core::{CloudError, Config, Detections, Detector, Scratch, Step, View};

use crate::types::{CConfig, CDetection, CView, CWorkspace, Status};

/// `VARSAC_SEARCH_WORDS` of the header: room for a search on 32- and 64-bit machines, and some to grow.
const SEARCH_WORDS: usize = 320;

/// `varsac_search_t`: memory that the caller owns and does not look into.
#[repr(C)]
#[derive(Debug)]
pub struct CSearch {
    words: [MaybeUninit<u64>; SEARCH_WORDS],
}

/// What lies in a [`CSearch`]. The run borrows the detector beside it, hence: a search must not be moved.
struct Search {
    detector: Detector,
    run: Option<Detections<'static>>,
}

const _: () = assert!(size_of::<Search>() <= size_of::<CSearch>());
const _: () = assert!(align_of::<Search>() <= align_of::<CSearch>());

/// Fills in a preset of the configuration.
///
/// # Safety
/// `config` is null or leads to a `varsac_config_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn varsac_config_preset(preset: u32, config: *mut CConfig) -> Status {
    let values = match preset {
        0 => Config::jujube(),
        1 => Config::apple(),
        2 => Config::generic(),
        3 => Config::table5(),
        4 => Config::table2(),
        5 => Config::surface(),
        6 => Config::unknown(),
        _ => return Status::Argument,
    };
    if config.is_null() {
        return Status::Argument;
    }
    // SAFETY: not null, and the caller answers for the rest.
    unsafe { config.write(CConfig::from(&values)) };
    Status::Ok
}

/// Begins a search that is carried on by `varsac_step`.
///
/// # Safety
/// `search`, `config`, `view` and `workspace` are null or lead to one of their kind, the pointers of the view to as many
/// elements as it says. Search, points, outline rays and workspace stay where they are and untouched until the search is
/// over or given up.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn varsac_begin(
    search: *mut CSearch,
    config: *const CConfig,
    view: *const CView,
    workspace: *const CWorkspace,
    seed: u64,
) -> Status {
    // SAFETY: handed on as it came.
    match unsafe { begin(search, config, view, workspace, seed) } {
        Ok(_) => Status::Ok,
        Err(status) => status,
    }
}

/// Does one bounded piece of work.
///
/// # Safety
/// `search` is null or was begun successfully; `detection` is null or leads to a `varsac_detection_t`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn varsac_step(search: *mut CSearch, detection: *mut CDetection) -> Status {
    // SAFETY: `varsac_begin` wrote a `Search` there, and the alignment is that of `CSearch`.
    let Some(search) = (unsafe { search.cast::<Search>().as_mut() }) else { return Status::Argument };
    let Some(run) = &mut search.run else { return Status::Argument };
    step(run, detection)
}

/// Searches to the end.
///
/// # Safety
/// As for `varsac_begin`, for the length of the call; `detections` leads to `capacity` of them, `found` to a number.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn varsac_detect(
    config: *const CConfig,
    view: *const CView,
    workspace: *const CWorkspace,
    seed: u64,
    detections: *mut CDetection,
    capacity: u32,
    found: *mut u32,
) -> Status {
    if found.is_null() || (detections.is_null() && capacity > 0) {
        return Status::Argument;
    }
    let mut storage = CSearch { words: [MaybeUninit::uninit(); SEARCH_WORDS] };
    // SAFETY: the storage is on this stack and stays there; the rest is handed on as it came.
    let run = match unsafe { begin(&raw mut storage, config, view, workspace, seed) } {
        Ok(run) => run,
        Err(status) => return status,
    };
    let mut number = 0;
    while number < capacity {
        // SAFETY: `number` is below `capacity`.
        match step(run, unsafe { detections.add(number as usize) }) {
            Status::Found => number += 1,
            Status::Working => {}
            _ => break,
        }
    }
    // SAFETY: checked above.
    unsafe { found.write(number) };
    Status::Ok
}

/// Checks what can be checked and lays a [`Search`] into the caller's memory.
///
/// # Safety
/// As for `varsac_begin`.
unsafe fn begin<'a>(
    storage: *mut CSearch,
    config: *const CConfig,
    view: *const CView,
    workspace: *const CWorkspace,
    seed: u64,
) -> Result<&'a mut Detections<'static>, Status> {
    // SAFETY: null is refused; the caller answers for the rest.
    let (config, view, workspace) = unsafe { (config.as_ref(), view.as_ref(), workspace.as_ref()) };
    let (Some(config), Some(view), Some(workspace)) = (config, view, workspace) else {
        return Err(Status::Argument);
    };
    if storage.is_null() {
        return Err(Status::Argument);
    }
    // SAFETY: the caller keeps points and rays in place until the search is over, which is all `'static` is for.
    let view: View<'static> = unsafe { view.view() }?;
    // SAFETY: as above.
    let scratch: Scratch<'static> = unsafe { workspace.scratch() }?;
    let detector = Detector::new(config.to_config().map_err(|_| Status::Configuration)?)?;
    let search = storage.cast::<Search>();
    // SAFETY: size and alignment are asserted above. The reference lives as long as the caller's memory, see above.
    let search: &'static mut Search = unsafe {
        search.write(Search { detector, run: None });
        &mut *search
    };
    let detector = &search.detector;
    let run = detector.detect_view(&view, scratch, seed).map_err(|error| match error {
        CloudError::Coordinate { .. } => Status::Coordinate,
        CloudError::TooManyPoints { .. } | CloudError::TooManyRays { .. } => Status::Capacity,
    })?;
    Ok(search.run.insert(run))
}

fn step(run: &mut Detections<'_>, detection: *mut CDetection) -> Status {
    match run.step() {
        Step::Working | Step::Missed(_) => Status::Working,
        Step::Found(found) => {
            if !detection.is_null() {
                // SAFETY: not null, and the caller answers for the rest.
                unsafe { detection.write(CDetection::from(&found)) };
            }
            Status::Found
        }
        Step::Finished(_) => Status::Finished,
    }
}
