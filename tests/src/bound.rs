//! How many steps a run may take, from its configuration alone.

use varsac_core::Config;

/// Upper bound on the calls of `Detections::step` up to and including the first that says `Finished`, whatever the cloud.
///
/// A search is prepared once, has at most `max_trials` trials, at most `refits` refits and one more that finds them
/// used up, and one claim. Searches that find something number at most `max_targets`, those that find nothing at most
/// `max_failures`, and the last of either kind ends the run: one of the two limits is never reached. Then one step
/// decides that it is over and one says so.
pub fn steps(config: &Config) -> u64 {
    let searches = u64::from(config.max_targets) + u64::from(config.max_failures) - 1;
    let search = 1 + u64::from(config.max_trials) + u64::from(config.refits) + 1 + 1;
    searches * search + 2
}
