//! Local surface normals: the direction in which a point's nearest neighbours spread least.
//!
//! Principal component analysis of the point and its k nearest neighbours (H. Hoppe et al., Surface reconstruction
//! from unorganized points, 1992, section 3.2). The sign is not oriented: the score takes the magnitude of a cosine.

use super::neighbours::NeighbourTree;
use nalgebra::{Matrix3, SymmetricEigen};

/// Neighbours whose second spread (variance) is below this share of the first lie on a line: no plane, no normal.
const LINE_RATIO: f64 = 1e-12;

/// A unit normal for each point of the tree from its `neighbours` nearest others, any unit.
///
/// `[0, 0, 0]` where the neighbourhood spans no plane (fewer than three points, a line, one place).
/// `O(n k log n)`.
pub fn normals(tree: &NeighbourTree, neighbours: usize) -> Vec<[f64; 3]> {
    let mut nearest = Vec::new();
    let mut normal = |&point: &[f64; 3]| {
        tree.nearest(point, neighbours.saturating_add(1).min(tree.points().len()), &mut nearest);
        normal_of(nearest.iter().map(|&index| tree.points()[index as usize]))
    };
    tree.points().iter().map(&mut normal).collect()
}

fn normal_of(points: impl ExactSizeIterator<Item = [f64; 3]> + Clone) -> [f64; 3] {
    let count = points.len() as f64;
    let mut mean = [0.0; 3];
    for point in points.clone() {
        for k in 0..3 {
            mean[k] += point[k] / count;
        }
    }
    let mut spread = Matrix3::<f64>::zeros();
    for point in points {
        let offset: [f64; 3] = std::array::from_fn(|k| point[k] - mean[k]);
        for i in 0..3 {
            for j in 0..3 {
                spread[(i, j)] += offset[i] * offset[j];
            }
        }
    }
    let eigen = SymmetricEigen::new(spread);
    let mut order = [0, 1, 2];
    order.sort_by(|&i: &usize, &j: &usize| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let [least, second, most] = order;
    // False for NaN too.
    let spans_a_plane = eigen.eigenvalues[second] > LINE_RATIO * eigen.eigenvalues[most];
    if !spans_a_plane {
        return [0.0; 3];
    }
    let axis = eigen.eigenvectors.column(least);
    [axis[0], axis[1], axis[2]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_of_a_plane() {
        let points: Vec<[f64; 3]> = (0..400)
            .map(|i| {
                let (x, y) = (f64::from(i % 20), f64::from(i / 20));
                [x, y, 700.0 + 0.5 * x]
            })
            .collect();
        let expected = [-0.5 / 1.25_f64.sqrt(), 0.0, 1.0 / 1.25_f64.sqrt()];
        for normal in normals(&NeighbourTree::new(points), 12) {
            assert!((crate::eval::dot(normal, expected).abs() - 1.0).abs() < 1e-12, "{normal:?}");
        }
    }

    #[test]
    fn normals_of_a_ball_point_along_its_radii() {
        // A Fibonacci spiral: nearly even cover, 2000 points, radius 20.
        let points: Vec<[f64; 3]> = (0..2000)
            .map(|i| {
                let z = 1.0 - (2.0 * f64::from(i) + 1.0) / 2000.0;
                let (sin, cos) = libm::sincos(f64::from(i) * 2.399_963_229_728_653);
                let ring = 20.0 * (1.0 - z * z).sqrt();
                [ring * cos, ring * sin, 20.0 * z]
            })
            .collect();
        for (normal, point) in normals(&NeighbourTree::new(points.clone()), 12).iter().zip(points) {
            assert!(crate::eval::dot(*normal, point).abs() / 20.0 > 0.999, "{normal:?} {point:?}");
        }
    }

    #[test]
    fn a_line_one_place_and_two_points_have_no_normal() {
        let line = (0..30).map(|i| [f64::from(i), 2.0 * f64::from(i), 5.0]).collect();
        let place = vec![[1.0, 2.0, 3.0]; 30];
        let two = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        for cloud in [line, place, two, Vec::new()] {
            let tree = NeighbourTree::new(cloud);
            assert!(normals(&tree, 12).iter().all(|&n| n == [0.0; 3]));
            assert!(normals(&tree, usize::MAX).iter().all(|&n| n == [0.0; 3]));
        }
    }
}
