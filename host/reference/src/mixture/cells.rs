//! Where on a surface the residuals lie: contract, chapter X10, cells and misfit.

use crate::map::algebra::Vector;

/// What the points of one cell add up to.
#[derive(Clone, Copy, Default)]
pub(crate) struct Cell {
    pub(crate) count: f32,
    pub(crate) mean: f32,
}

/// Nine cells on each of the six faces of a cube.
pub(crate) type Cells = [Cell; 54];

/// X10: the cell of `u`.
pub(crate) fn cell(u: Vector) -> usize {
    let [x, y, z] = u.map(libm::fabsf);
    let (face, main, p, q) = if x >= y && x >= z {
        (0, u[0], u[1], u[2])
    } else if y >= z {
        (1, u[1], u[2], u[0])
    } else {
        (2, u[2], u[0], u[1])
    };
    let third = |v: f32| {
        if 3.0 * libm::fabsf(v) < libm::fabsf(main) {
            1
        } else if v < 0.0 {
            0
        } else {
            2
        }
    };
    ((2 * face + usize::from(main < 0.0)) * 3 + third(p)) * 3 + third(q)
}

/// X10: the variance between the cells that chance does not explain, for each member; `q` is the sum of squared
/// distances, `sigma` the scale.
pub(crate) fn variance_between(cells: &Cells, q: f32, sigma: f32, members: f32) -> f32 {
    let s = q / (sigma * sigma);
    let (mut between, mut occupied) = (0.0, 0.0);
    for cell in cells {
        if cell.count > 1.0 {
            between += (cell.mean * cell.mean) / cell.count;
            occupied += 1.0;
        }
    }
    let free = if occupied > 9.0 { occupied - 9.0 } else { 0.0 };
    let chance = (free + 3.0 * libm::sqrtf(2.0 * free)) * (s / members);
    (between - chance) / members
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_cell_is_met() {
        let mut met = [false; 54];
        for face in 0..3 {
            for sign in [1.0, -1.0] {
                for p in [-0.7, 0.1, 0.7] {
                    for q in [-0.7, 0.1, 0.7] {
                        let mut u = [0.0; 3];
                        u[face] = sign;
                        u[(face + 1) % 3] = p;
                        u[(face + 2) % 3] = q;
                        met[cell(u)] = true;
                    }
                }
            }
        }
        assert_eq!(met, [true; 54]);
    }
}
