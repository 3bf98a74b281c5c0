//! Which detection is which fruit: greedy, one to one, by the distance of the centres, within a gate.
//!
//! Greedy means the closest pair of all first. It differs from the assignment of least total distance only where
//! detections are as far from their fruit as the fruit are from each other, and there neither is right.

use super::{norm, subtract};

/// One detection assigned to one true fruit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Match {
    /// Index of the true fruit.
    pub truth: usize,
    /// Index of the detection.
    pub detection: usize,
    /// Distance of the two centres, millimetres.
    pub distance_mm: f64,
}

/// The result of [`match_centres`]. Every index occurs exactly once.
#[derive(Debug, Clone, PartialEq)]
pub struct Matching {
    /// Pairs, closest first.
    pub matches: Vec<Match>,
    /// True fruit without a detection, ascending.
    pub missed: Vec<usize>,
    /// Detections without a true fruit, ascending.
    pub false_detections: Vec<usize>,
}

impl Matching {
    /// Share of the true fruit that were found, `[0, 1]`; nothing when there were none to find.
    pub fn recall(&self) -> Option<f64> {
        share(self.matches.len(), self.missed.len())
    }

    /// Share of the detections that are true, `[0, 1]`; nothing when there were no detections.
    pub fn precision(&self) -> Option<f64> {
        share(self.matches.len(), self.false_detections.len())
    }
}

fn share(part: usize, rest: usize) -> Option<f64> {
    let whole = part + rest;
    (whole > 0).then(|| part as f64 / whole as f64)
}

/// Assigns detections to true fruit whose centres are at most `gate_mm` away.
///
/// Equal distances: lower index of the truth first, then of the detection. A centre that is not finite matches
/// nothing. `O(n m log(n m))`.
pub fn match_centres(truths_mm: &[[f64; 3]], detections_mm: &[[f64; 3]], gate_mm: f64) -> Matching {
    let mut candidates = Vec::new();
    for (truth, &centre) in truths_mm.iter().enumerate() {
        for (detection, &found) in detections_mm.iter().enumerate() {
            let distance_mm = norm(subtract(found, centre));
            if distance_mm <= gate_mm {
                candidates.push(Match { truth, detection, distance_mm });
            }
        }
    }
    // The sort is stable and the pairs were made in the order of their indices.
    candidates.sort_by(|p, q| p.distance_mm.total_cmp(&q.distance_mm));
    let mut truth_free = vec![true; truths_mm.len()];
    let mut detection_free = vec![true; detections_mm.len()];
    candidates.retain(|pair| {
        let free = truth_free[pair.truth] && detection_free[pair.detection];
        if free {
            truth_free[pair.truth] = false;
            detection_free[pair.detection] = false;
        }
        free
    });
    let still_free = |free: Vec<bool>| (0..free.len()).filter(|&k| free[k]).collect();
    Matching {
        matches: candidates,
        missed: still_free(truth_free),
        false_detections: still_free(detection_free),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on_a_line(positions: &[f64]) -> Vec<[f64; 3]> {
        positions.iter().map(|&x| [x, 0.0, 700.0]).collect()
    }

    #[test]
    fn the_closest_pair_of_all_goes_first() {
        // Fruit 0 is nearest to detection 0 (4 mm), but that belongs to fruit 1 (1 mm).
        let matching = match_centres(&on_a_line(&[0.0, 5.0]), &on_a_line(&[4.0, -9.0, 60.0]), 10.0);
        let pairs: Vec<_> = matching.matches.iter().map(|m| (m.truth, m.detection, m.distance_mm)).collect();
        assert_eq!(pairs, [(1, 0, 1.0), (0, 1, 9.0)]);
        assert_eq!(matching.missed, Vec::<usize>::new());
        assert_eq!(matching.false_detections, [2]);
        assert_eq!(matching.recall(), Some(1.0));
        assert_eq!(matching.precision(), Some(2.0 / 3.0));
    }

    #[test]
    fn the_gate_is_inclusive_and_ties_go_to_the_lower_index() {
        let matching = match_centres(&on_a_line(&[0.0, 10.0]), &on_a_line(&[5.0]), 5.0);
        assert_eq!(matching.matches, [Match { truth: 0, detection: 0, distance_mm: 5.0 }]);
        assert_eq!(matching.missed, [1]);
        assert!(match_centres(&on_a_line(&[0.0]), &on_a_line(&[5.0]), 4.999).matches.is_empty());
    }

    #[test]
    fn nothing_and_nonsense() {
        let empty = match_centres(&[], &[], 5.0);
        assert_eq!((empty.recall(), empty.precision()), (None, None));
        let nonsense = match_centres(&on_a_line(&[0.0]), &on_a_line(&[f64::NAN]), f64::INFINITY);
        assert_eq!((nonsense.missed, nonsense.false_detections), (vec![0], vec![0]));
    }
}
