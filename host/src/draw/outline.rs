//! What of an ellipsoid shows in a picture: its outline, its semi-axes, the uncertainty of its centre.
//!
//! The outline is the image of the contour generator, the curve where lines of sight touch the surface. In body
//! coordinates divided by the semi-axes the ellipsoid is the unit sphere; seen from w (outside: |w| > 1) the contour
//! is the circle `u . w = 1`, so in space it is a plane ellipse. It is sampled there and projected point by point,
//! because the mapping from space to picture need not be a pinhole's (the Kinect's is a polynomial).

use super::canvas::Position;
use crate::eval::{EllipsoidF64, cross, dot, norm};

/// Points of a closed outline.
pub const OUTLINE_POINTS: usize = 96;

/// Where the scene is seen from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Viewpoint {
    /// From a centre of projection, millimetres.
    Point([f64; 3]),
    /// From infinitely far away, looking along this direction.
    Direction([f64; 3]),
}

/// A view: where from, and where in the picture (pixels) a point in space (millimetres) appears, if anywhere.
#[derive(Clone, Copy)]
pub struct View<'a> {
    /// Where the scene is seen from.
    pub viewpoint: Viewpoint,
    /// Space to picture.
    pub project: &'a dyn Fn([f64; 3]) -> Option<Position>,
}

/// The contour generator in space, millimetres, closed: the last point is the first. Empty when the viewpoint is
/// inside the ellipsoid or a number is not finite.
pub fn contour_generator(ellipsoid: &EllipsoidF64, viewpoint: &Viewpoint) -> Vec<[f64; 3]> {
    let semi_axes = ellipsoid.semi_axes_mm;
    let on_sphere = |body: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| body[k] / semi_axes[k]) };
    // Unit vector towards the viewer, distance of the contour's plane from the centre, radius of its circle.
    let (towards, height) = match *viewpoint {
        Viewpoint::Point(point) => {
            let w = on_sphere(ellipsoid.to_body(point));
            (w, 1.0 / norm(w))
        }
        Viewpoint::Direction(direction) => (on_sphere(ellipsoid.axes.map(|axis| -dot(axis, direction))), 0.0),
    };
    let length = norm(towards);
    let radius = (1.0 - height * height).sqrt();
    let is_visible = length > 0.0 && length.is_finite() && radius > 0.0;
    if !is_visible {
        return Vec::new();
    }
    let towards = towards.map(|v| v / length);
    let (p, q) = across(towards);
    let point = |k: usize| {
        let angle = std::f64::consts::TAU * (k % OUTLINE_POINTS) as f64 / OUTLINE_POINTS as f64;
        let (sin, cos) = libm::sincos(angle);
        let body = |i: usize| semi_axes[i] * (height * towards[i] + radius * (cos * p[i] + sin * q[i]));
        ellipsoid.from_body([body(0), body(1), body(2)])
    };
    (0..=OUTLINE_POINTS).map(point).collect()
}

/// Two unit vectors across a unit vector and each other.
fn across(direction: [f64; 3]) -> ([f64; 3], [f64; 3]) {
    // The unit vector least aligned with the direction is a safe start.
    let least =
        (0..3).fold(0, |least, k| if direction[k].abs() < direction[least].abs() { k } else { least });
    let start: [f64; 3] = std::array::from_fn(|k| if k == least { 1.0 } else { 0.0 });
    let p = cross(direction, start);
    let p = p.map(|v| v / norm(p));
    (p, cross(direction, p))
}

/// The outline in the picture, closed. Points that appear nowhere are NaN: they interrupt the line. Empty when nothing
/// of it appears.
pub fn outline(ellipsoid: &EllipsoidF64, view: &View) -> Vec<Position> {
    projected(&contour_generator(ellipsoid, &view.viewpoint), view)
}

fn projected(points: &[[f64; 3]], view: &View) -> Vec<Position> {
    let line: Vec<Position> =
        points.iter().map(|&p| (view.project)(p).unwrap_or((f64::NAN, f64::NAN))).collect();
    if line.iter().any(|p| p.0.is_finite() && p.1.is_finite()) { line } else { Vec::new() }
}

/// The three semi-axes in the picture, long one first: the long axis whole, the others from the centre to the end that
/// faces the viewer.
pub fn semi_axes(ellipsoid: &EllipsoidF64, view: &View) -> [Vec<Position>; 3] {
    let towards = match view.viewpoint {
        Viewpoint::Point(point) => ellipsoid.to_body(point),
        Viewpoint::Direction(direction) => ellipsoid.axes.map(|axis| -dot(axis, direction)),
    };
    std::array::from_fn(|k| {
        let end =
            |length: f64| ellipsoid.from_body(std::array::from_fn(|i| if i == k { length } else { 0.0 }));
        let tip = ellipsoid.semi_axes_mm[k].copysign(towards[k]);
        let start = if k == 0 { -tip } else { 0.0 };
        projected(&[end(start), end(tip)], view)
    })
}

/// Squared radius, in standard deviations, of the ellipse that holds a two-dimensional normal variable with probability
/// 0.95: `-2 ln 0.05`.
const CHI_SQUARED_95: f64 = 5.991_464_547_107_979;

/// The region of the picture that holds the centre with 95 % probability, closed; from its covariance in square
/// millimetres, carried through the projection to first order. Empty when the centre appears nowhere or the covariance
/// is none.
pub fn centre_uncertainty(centre_mm: [f64; 3], covariance_mm2: &[[f64; 3]; 3], view: &View) -> Vec<Position> {
    /// Half the step of the central differences: far below a pixel, far above rounding.
    const STEP_MM: f64 = 0.05;
    let Some((x, y)) = (view.project)(centre_mm) else { return Vec::new() };
    let mut jacobian = [[0.0; 3]; 2];
    for k in 0..3 {
        let moved = |step: f64| {
            (view.project)(std::array::from_fn(|i| centre_mm[i] + if i == k { step } else { 0.0 }))
        };
        let (Some(ahead), Some(behind)) = (moved(STEP_MM), moved(-STEP_MM)) else { return Vec::new() };
        jacobian[0][k] = (ahead.0 - behind.0) / (2.0 * STEP_MM);
        jacobian[1][k] = (ahead.1 - behind.1) / (2.0 * STEP_MM);
    }
    let covariance = |i: usize, j: usize| dot(jacobian[i], covariance_mm2.map(|row| dot(row, jacobian[j])));
    let (xx, xy, yy) = (covariance(0, 0), covariance(0, 1), covariance(1, 1));
    // Cholesky factor of the 2x2 covariance: it maps the unit circle onto the ellipse.
    let l11 = xx.sqrt();
    let l21 = xy / l11;
    let l22 = (yy - l21 * l21).max(0.0).sqrt();
    if !(l11.is_finite() && l21.is_finite() && l22.is_finite()) {
        return Vec::new();
    }
    let radius = CHI_SQUARED_95.sqrt();
    (0..=OUTLINE_POINTS)
        .map(|k| {
            let angle = std::f64::consts::TAU * (k % OUTLINE_POINTS) as f64 / OUTLINE_POINTS as f64;
            let (sin, cos) = libm::sincos(angle);
            (x + radius * l11 * cos, y + radius * (l21 * cos + l22 * sin))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::eval::attitude::axes_of_angles;
    use crate::eval::subtract;

    fn body() -> EllipsoidF64 {
        EllipsoidF64::sorted([40.0, -25.0, 600.0], [22.0, 12.0, 10.0], axes_of_angles([0.4, -0.9, 1.3]))
    }

    fn pinhole(p: [f64; 3]) -> Option<Position> {
        (p[2] > 0.0).then(|| (1000.0 * p[0] / p[2] + 960.0, 1000.0 * p[1] / p[2] + 540.0))
    }

    const CAMERA: View<'_> = View { viewpoint: Viewpoint::Point([0.0; 3]), project: &pinhole };

    #[test]
    fn lines_of_sight_touch_the_contour() {
        let e = body();
        for viewpoint in [Viewpoint::Point([0.0; 3]), Viewpoint::Direction([0.1, 0.2, 1.0])] {
            let contour = contour_generator(&e, &viewpoint);
            assert_eq!(contour.len(), OUTLINE_POINTS + 1);
            for point in contour {
                let body = e.to_body(point);
                let gradient: [f64; 3] = std::array::from_fn(|k| body[k] / e.semi_axes_mm[k].powi(2));
                assert!((dot(body, gradient) - 1.0).abs() < 1e-9, "on the surface");
                let sight = match viewpoint {
                    Viewpoint::Point(from) => subtract(point, from),
                    Viewpoint::Direction(along) => along,
                };
                assert!(
                    dot(gradient, e.axes.map(|axis| dot(axis, sight))).abs() < 1e-9 * norm(sight),
                    "tangent"
                );
            }
        }
    }

    #[test]
    fn every_surface_point_projects_inside_the_outline() {
        let e = body();
        let line = outline(&e, &CAMERA);
        for k in 0..2000 {
            let z = 1.0 - (2.0 * f64::from(k) + 1.0) / 2000.0;
            let (sin, cos) = libm::sincos(f64::from(k) * 2.399_963_229_728_653);
            let ring = (1.0 - z * z).sqrt();
            let [a, b, c] = e.semi_axes_mm;
            let (x, y) = pinhole(e.from_body([a * z, b * ring * cos, c * ring * sin])).unwrap();
            // Left of every edge of the convex polygon, within the sagitta of 1/96 of a turn (0.02 px here).
            let turn = |p: Position, q: Position| (q.0 - p.0) * (y - p.1) - (q.1 - p.1) * (x - p.0);
            let signs: Vec<f64> = line
                .windows(2)
                .map(|w| turn(w[0], w[1]) / (w[1].0 - w[0].0).hypot(w[1].1 - w[0].1))
                .collect();
            let (least, most) = signs.iter().fold((f64::MAX, f64::MIN), |(a, b), &s| (a.min(s), b.max(s)));
            assert!(least > -0.05 || most < 0.05, "{x} {y}");
        }
    }

    #[test]
    fn a_ball_on_the_optical_axis_is_a_circle_of_known_radius() {
        let ball = EllipsoidF64::sorted([0.0, 0.0, 500.0], [30.0; 3], axes_of_angles([0.0; 3]));
        let expected = 1000.0 * 30.0 / (500.0_f64.powi(2) - 30.0_f64.powi(2)).sqrt();
        for (x, y) in outline(&ball, &CAMERA) {
            assert!(((x - 960.0).hypot(y - 540.0) - expected).abs() < 1e-9);
        }
    }

    #[test]
    fn from_inside_and_from_behind_nothing_shows() {
        let mut e = body();
        assert!(contour_generator(&e, &Viewpoint::Point(e.centre_mm)).is_empty());
        assert!(contour_generator(&e, &Viewpoint::Point([f64::NAN; 3])).is_empty());
        e.centre_mm[2] = -600.0;
        assert!(outline(&e, &CAMERA).is_empty());
        assert!(semi_axes(&e, &CAMERA).iter().all(Vec::is_empty));
    }

    #[test]
    fn semi_axes_end_on_the_surface_facing_the_viewer() {
        let e = EllipsoidF64::sorted([0.0, 0.0, 1000.0], [20.0, 10.0, 5.0], axes_of_angles([0.0; 3]));
        let [long, second, third] = semi_axes(&e, &CAMERA);
        assert_eq!(long.len(), 2);
        assert!(((long[1].0 - long[0].0).abs() - 40.0).abs() < 1e-9);
        assert!((second[0].0 - 960.0).abs() < 1e-9 && ((second[1].1 - 540.0).abs() - 10.0).abs() < 1e-9);
        // Straight towards the camera: a point.
        assert!((third[1].0 - 960.0).abs() < 1e-9 && (third[1].1 - 540.0).abs() < 1e-9);
    }

    #[test]
    fn an_uncertain_centre_becomes_an_ellipse_of_the_right_size() {
        // At 1000 mm and 1000 px a millimetre across is a pixel; along the line of sight it is none.
        let covariance = [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 100.0]];
        let line = centre_uncertainty([0.0, 0.0, 1000.0], &covariance, &CAMERA);
        let reach = |of: fn(&Position) -> f64| line.iter().map(of).fold(f64::MIN, f64::max);
        assert!((reach(|p| p.0 - 960.0) - 2.0 * 2.4477).abs() < 1e-3);
        assert!((reach(|p| p.1 - 540.0) - 2.4477).abs() < 1e-2);
        assert!(centre_uncertainty([0.0, 0.0, -5.0], &covariance, &CAMERA).is_empty());
        assert!(centre_uncertainty([0.0, 0.0, 1000.0], &[[f64::NAN; 3]; 3], &CAMERA).is_empty());
        assert!(centre_uncertainty([0.0, 0.0, 1000.0], &[[0.0; 3]; 3], &CAMERA).is_empty());
    }
}
