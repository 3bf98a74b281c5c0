//! First and second moments of vectors: contract, chapter X1.

use crate::Symmetric;
use crate::jacobi::{ascending, eigen};
use crate::map::algebra::Vector;

/// X1: the sums `S` and `Q`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Moments {
    pub(crate) s: Vector,
    pub(crate) q: Symmetric,
}

impl Moments {
    /// X1: "the sums gain `v` with weight `q`".
    pub(crate) fn gain(&mut self, [x, y, z]: Vector, weight: f32) {
        let (qx, qy, qz) = (weight * x, weight * y, weight * z);
        self.s = [self.s[0] + qx, self.s[1] + qy, self.s[2] + qz];
        self.q.xx += qx * x;
        self.q.yy += qy * y;
        self.q.zz += qz * z;
        self.q.xy += qx * y;
        self.q.xz += qx * z;
        self.q.yz += qy * z;
    }

    /// X1: `S / n`.
    pub(crate) fn mean(&self, n: f32) -> Vector {
        [self.s[0] / n, self.s[1] / n, self.s[2] / n]
    }

    /// X1: `scatter(n, S, Q)`.
    pub(crate) fn scatter(&self, n: f32) -> Symmetric {
        let [mx, my, mz] = self.mean(n);
        Symmetric {
            xx: self.q.xx / n - mx * mx,
            yy: self.q.yy / n - my * my,
            zz: self.q.zz / n - mz * mz,
            xy: self.q.xy / n - mx * my,
            xz: self.q.xz / n - mx * mz,
            yz: self.q.yz / n - my * mz,
        }
    }
}

/// Chapters 11.1 and 11.2: the smallest eigenvalue.
pub(crate) fn smallest_eigenvalue(matrix: &Symmetric) -> f32 {
    ascending(&eigen(matrix)).values[0]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scatter_of_two_points_is_that_of_their_distance() {
        let mut moments = Moments::default();
        moments.gain([1.0, 2.0, 4.0], 2.0);
        moments.gain([3.0, 2.0, 0.0], 2.0);
        assert_eq!(moments.mean(4.0), [2.0, 2.0, 2.0]);
        assert_eq!(moments.scatter(4.0), Symmetric { xx: 1.0, zz: 4.0, xz: -2.0, ..Symmetric::default() });
        assert!(smallest_eigenvalue(&moments.scatter(4.0)).abs() < 1e-6);
    }
}
