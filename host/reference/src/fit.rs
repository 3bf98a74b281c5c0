//! Least squares of a quadric in a local frame: contract, chapter 5, steps 1 to 6; Eq. (3) to (5).

use crate::fault::{self, Fault};
use crate::quadric::{central, invariants, quadric};
use crate::{Central, Constraint, Event, Point, Rejection, Symmetric};

/// Chapter 5: the real ellipsoid through the points `list` of the cloud, in that order.
///
/// # Errors
/// The first rejection of chapter 5.
pub fn fit(cloud: &[Point], list: &[u16], constraint: Constraint) -> Result<Central, Rejection> {
    fit_observed(cloud, list, constraint, &mut |_| {})
}

/// [`fit`], with each intermediate result as an event.
///
/// # Errors
/// The first rejection of chapter 5.
pub fn fit_observed(
    cloud: &[Point],
    list: &[u16],
    constraint: Constraint,
    observe: &mut dyn FnMut(Event),
) -> Result<Central, Rejection> {
    if list.len() < 9 {
        return Err(Rejection::TooFewPoints);
    }
    let frame = local_frame(cloud, list)?;
    let mut rows = Vec::new();
    for &index in list {
        rows.push(design_row(frame.local(cloud[index as usize]), constraint));
    }
    let (matrix, rhs) = normal_equations(&rows);
    observe(Event::Normal { matrix: lower_triangle(&matrix), rhs });
    let factors = factor(&matrix)?;
    let x = solution(&factors, &rhs, &rows);
    observe(Event::Solution(x));
    let q = quadric(&x, constraint);
    observe(Event::Quadric([q.a11, q.a22, q.a33, q.a12, q.a13, q.a23, q.a14, q.a24, q.a34, q.a44]));
    let i = invariants(&q);
    observe(Event::Invariants([i.i1, i.i2, i.i3, i.i4]));
    let surface = frame.back_to_the_cloud(central(&i)?);
    observe(Event::Hypothesis(surface));
    Ok(surface)
}

/// Chapter 5.1: a frame that is shifted and scaled by a power of two.
pub(crate) struct Frame {
    pub(crate) origin: Point,
    pub(crate) scale: f32,
}

/// Chapter 5.1: origin in the mean of the points, largest coordinate between 1 and 2.
pub(crate) fn local_frame(cloud: &[Point], list: &[u16]) -> Result<Frame, Rejection> {
    let mut sum = [0.0_f32; 3];
    for &index in list {
        for axis in 0..3 {
            sum[axis] += cloud[index as usize][axis];
        }
    }
    let count = list.len() as f32;
    let origin = [sum[0] / count, sum[1] / count, sum[2] / count];
    let mut largest = 0.0_f32;
    for &index in list {
        for axis in 0..3 {
            let v = libm::fabsf(cloud[index as usize][axis] - origin[axis]);
            if v > largest {
                largest = v;
            }
        }
    }
    let e = (largest.to_bits() >> 23) & 0xff;
    if e == 0 || e >= 254 {
        return Err(Rejection::Degenerate);
    }
    Ok(Frame { origin, scale: f32::from_bits((254 - e) << 23) })
}

impl Frame {
    /// Chapter 5.1, last sentence.
    pub(crate) fn local(&self, p: Point) -> Point {
        let mut local = [0.0; 3];
        for axis in 0..3 {
            local[axis] = (p[axis] - self.origin[axis]) * self.scale;
        }
        local
    }

    /// Chapter 5.10.
    fn back_to_the_cloud(&self, local: Central) -> Central {
        let back = 1.0 / self.scale;
        let square = self.scale * self.scale;
        let mut centre = [0.0; 3];
        for axis in 0..3 {
            centre[axis] = self.origin[axis] + local.centre[axis] * back;
        }
        let s = local.shape;
        let shape = Symmetric {
            xx: s.xx * square,
            yy: s.yy * square,
            zz: s.zz * square,
            xy: s.xy * square,
            xz: s.xz * square,
            yz: s.yz * square,
        };
        Central { centre, shape }
    }
}

/// One equation of the overdetermined system.
struct Row {
    row: [f32; 9],
    target: f32,
}

/// Chapter 5.2.
fn design_row([x, y, z]: Point, constraint: Constraint) -> Row {
    let xx = x * x;
    let yy = y * y;
    let zz = z * z;
    match constraint {
        Constraint::A11 => Row { row: [yy, zz, x, y, z, 1.0, x * y, x * z, y * z], target: -xx },
        Constraint::Trace => {
            Row { row: [yy - xx, zz - xx, x, y, z, 1.0, x * y, x * z, y * z], target: -(xx + yy + zz) }
        }
    }
}

/// Chapter 5.3: the lower triangle of `M` and `g`.
fn normal_equations(rows: &[Row]) -> ([[f32; 9]; 9], [f32; 9]) {
    let mut m = [[0.0_f32; 9]; 9];
    let mut g = [0.0_f32; 9];
    for n in 0..rows.len() {
        let Row { row, target } = &rows[if fault::is(Fault::NormalMatrix) { rows.len() - 1 - n } else { n }];
        for i in 0..9 {
            for j in 0..=i {
                m[i][j] += (1.0 * row[i]) * row[j];
            }
            g[i] += row[i] * target;
        }
    }
    (m, g)
}

/// The lower triangle by rows, as events carry it.
fn lower_triangle(m: &[[f32; 9]; 9]) -> [f32; 45] {
    let mut numbers = [0.0; 45];
    let mut next = 0;
    for i in 0..9 {
        for j in 0..=i {
            numbers[next] = m[i][j];
            next += 1;
        }
    }
    numbers
}

/// `L` (its unit diagonal left out) and `D` of chapter 5.4.
pub(crate) struct Factors {
    l: [[f32; 9]; 9],
    d: [f32; 9],
}

/// Chapter 5.4: `M = L D L^T`.
pub(crate) fn factor(m: &[[f32; 9]; 9]) -> Result<Factors, Rejection> {
    let mut l = [[0.0_f32; 9]; 9];
    let mut d = [0.0_f32; 9];
    let mut ld = [[0.0_f32; 9]; 9];
    for i in 0..9 {
        for j in 0..i {
            let mut s = m[i][j];
            for k in 0..j {
                s -= ld[i][k] * l[j][k];
            }
            ld[i][j] = s;
        }
        let mut pivot = m[i][i];
        for j in 0..i {
            l[i][j] = ld[i][j] / d[j];
            pivot -= ld[i][j] * l[i][j];
        }
        let two_to_minus_22 = 1.0 / 4_194_304.0;
        let regular = pivot > two_to_minus_22 * m[i][i] && pivot <= f32::MAX;
        if !regular {
            return Err(Rejection::Degenerate);
        }
        d[i] = pivot;
    }
    Ok(Factors { l, d })
}

/// Chapter 5.5: the solution for one right-hand side.
pub(crate) fn solve(factors: &Factors, b: &[f32; 9]) -> [f32; 9] {
    let Factors { l, d } = factors;
    let mut y = [0.0_f32; 9];
    for i in 0..9 {
        let mut s = b[i];
        for k in 0..i {
            s -= l[i][k] * y[k];
        }
        y[i] = s;
    }
    for i in 0..9 {
        y[i] /= d[i];
    }
    let mut x = [0.0_f32; 9];
    for i in (0..9).rev() {
        let mut s = y[i];
        for k in (i + 1..9).rev() {
            s -= l[k][i] * x[k];
        }
        x[i] = s;
    }
    x
}

/// Chapter 5.6: the solution for `g`, refined once with the residuals of the rows.
fn solution(factors: &Factors, g: &[f32; 9], rows: &[Row]) -> [f32; 9] {
    let mut x = solve(factors, g);
    if fault::is(Fault::Solution) {
        return x;
    }
    let mut h = [0.0_f32; 9];
    for Row { row, target } in rows {
        let mut r = *target;
        for k in 0..9 {
            r -= row[k] * x[k];
        }
        for i in 0..9 {
            h[i] += row[i] * r;
        }
    }
    let correction = solve(factors, &h);
    for k in 0..9 {
        x[k] += correction[k];
    }
    x
}

#[cfg(test)]
#[path = "fit_tests.rs"]
mod tests;
