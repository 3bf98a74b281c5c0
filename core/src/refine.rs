//! One Gauss-Newton step of the nine parameters, and the state it moves.
//!
//! Parameters, in this order: centre along the body's axes (mm), rotation about the body's axes (rad), logarithms of
//! the semi-axes. The cost is `1/2 sum w F^2 / var + 1/2 (x - m)^T P (x - m)` ([`crate::residual`], [`crate::prior`]);
//! its normal equations are `H d = -g`, `H = sum (w / var) J J^T + P`, `g = sum (w F / var) J + P (x - m)`.

use crate::{
    Ellipsoid, Point3,
    field::Field,
    linalg::{N, Symmetric9},
    moments::Moments,
    nuisance::{Follower, Nuisances, fullness},
    outline::{OutlineRay, Touch},
    point::at,
    prior::SizeTerm,
    residual::{Noise, RayModel, Viewpoint},
};

/// A model on its way: centre, axes (rows, orthonormal, in the order of the prior) and logarithms of the semi-axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Centre, mm, frame of the cloud.
    pub centre: [f32; 3],
    /// Row k is the unit vector of the k-th semi-axis.
    pub axes: [[f32; 3]; 3],
    /// `ln a, ln b, ln c`.
    pub ln_axes: [f32; 3],
    /// How much fuller than an ellipsoid it is between its axes, see [`MapConfig::boxiness`](crate::MapConfig::boxiness).
    pub boxiness: f32,
}

/// Normal equations under construction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Normal {
    /// `H`.
    pub matrix: Symmetric9,
    /// `g`.
    pub gradient: [f32; N],
    /// What the boxiness does when the nine parameters move.
    pub(crate) boxiness: Follower,
}

/// Added to the diagonal of the rotations, rad^-2: turning a spheroid about its long axis changes nothing it can be
/// measured by, and the step must not run away along it. `12 / pi^2`: the variance of an angle that is uniform over half
/// a turn, so that in the covariance an undetermined twist is as uncertain as it can be.
pub(crate) const ROTATION_INFORMATION: f32 = 1.216;
/// Longest move of the centre in one step, in units of the shortest semi-axis.
const CENTRE_LIMIT: f32 = 0.5;
/// Largest turn in one step, rad.
const ROTATION_LIMIT: f32 = 0.5;
/// Largest change of a logarithm in one step.
const SIZE_LIMIT: f32 = 0.3;

impl Normal {
    /// No information.
    pub const ZERO: Self = Self { matrix: Symmetric9::ZERO, gradient: [0.0; N], boxiness: Follower::STILL };

    /// From moments and the constants of the model.
    pub(crate) fn new(moments: &Moments, constants: &[f32; N]) -> Self {
        let (matrix, gradient) = moments.normal(constants);
        Self { matrix, gradient, boxiness: Follower::STILL }
    }

    /// Adds one residual `F` with weight `w / var`.
    #[inline]
    pub fn add(&mut self, derivatives: &[f32; N], value: f32, weight: f32) {
        self.matrix.add_outer(derivatives, weight);
        let scaled = weight * value;
        for k in 0..N {
            self.gradient[k] += scaled * derivatives[k];
        }
    }

    /// Adds the size prior.
    pub fn add_prior(&mut self, prior: &SizeTerm, ln_axes: &[f32; 3]) {
        let p = &prior.information;
        let d = p.times(prior.departure(ln_axes));
        let [.., a, b, c] = &mut self.gradient;
        for (entry, value) in [a, b, c].into_iter().zip(d) {
            *entry += value;
        }
        for (i, j, value) in
            [(6, 6, p.xx), (7, 7, p.yy), (8, 8, p.zz), (7, 6, p.xy), (8, 6, p.xz), (8, 7, p.yz)]
        {
            self.matrix.add_entry(i, j, value);
        }
    }
}

/// How the weight of a residual falls with its size.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Kernel {
    /// Geman and McClure: `1 / (1 + f^2 / m^2)^2`; `m^2`.
    GemanMcClure(f32),
    /// Tukey: `(1 - f^2 / k^2)^2` below `k`, 0 above; `k^2`.
    Tukey(f32),
}

/// Geman-McClure weights beyond this `f^2` are below a thousandth and not worth their arithmetic.
const NEGLIGIBLE: f32 = 100.0;

impl Kernel {
    /// The weight at `f^2`; nothing where it vanishes (NaN included).
    #[inline(always)]
    pub(crate) fn weight(self, square: f32) -> Option<f32> {
        match self {
            Self::GemanMcClure(m) => (square < NEGLIGIBLE).then(|| {
                let k = 1.0 + square / m;
                1.0 / (k * k)
            }),
            Self::Tukey(k) => (square < k).then(|| {
                let left = 1.0 - square / k;
                left * left
            }),
        }
    }
}

/// What a model is fitted to.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Evidence<'a> {
    pub(crate) cloud: &'a [Point3],
    /// Points near the model, ascending.
    pub(crate) members: &'a [u16],
    labels: &'a [u8],
    /// Points of the mask: those before this index.
    in_mask: usize,
    /// Label of the model's own points.
    own: u8,
    pub(crate) outline: &'a [OutlineRay],
}

/// How it is fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Terms {
    pub(crate) prior: SizeTerm,
    pub(crate) noise: Noise,
    pub(crate) viewpoint: Viewpoint,
    /// A point further than this from the model's point along the ray is not on the model.
    pub(crate) window_mm: f32,
    /// Standard deviation of the displacement common to all outline rays.
    pub(crate) offset_rad: f32,
    /// Factor on the deviations of outline rays.
    pub(crate) outline: f32,
    /// Standard deviation of the boxiness; 0: an ellipsoid.
    pub(crate) boxiness: f32,
    /// How much a point tells, 0 to 1.
    pub(crate) independence: f32,
}

/// `3^2`, Geman-McClure on outline rays.
pub(crate) const OUTLINE_KERNEL: Kernel = Kernel::GemanMcClure(9.0);
/// A ray that passes closer to the centre than half way does not ask the model to step aside.
const DEEP: f32 = 0.25;

impl<'a> Evidence<'a> {
    /// The first `members` listed points and the outline of the view, for the model whose points are labelled `own`.
    pub(crate) fn of(field: &'a Field<'_>, members: usize, own: u8) -> Self {
        Self {
            cloud: field.view.cloud,
            members: field.scratch.members.get(..members).unwrap_or(&[]),
            labels: field.scratch.labels,
            in_mask: field.view.in_mask,
            own,
            outline: field.view.outline,
        }
    }

    /// True when the point can lie on the model: it is in the mask, and nobody's or the model's own. Others cannot, but they
    /// can be seen beside or through it.
    pub(crate) fn is_open(&self, index: u16) -> bool {
        usize::from(index) < self.in_mask && self.is_unclaimed(index)
    }

    /// True when no other fruit has claimed the point.
    pub(crate) fn is_unclaimed(&self, index: u16) -> bool {
        self.labels.get(usize::from(index)).is_some_and(|&label| label == 0 || label == self.own)
    }

    /// What the outline rays that can be the model's demand of it, in order.
    pub(crate) fn touches<'b>(
        &'b self,
        model: &'b RayModel,
        ellipsoid: &Ellipsoid,
        terms: &Terms,
    ) -> impl Iterator<Item = Touch> + 'b {
        let ([long, _, short], axial_mm, wider) = (ellipsoid.semi_axes, terms.noise.axial_mm, terms.outline);
        self.outline
            .iter()
            .filter_map(move |ray| ray.touch(model, short, long, axial_mm))
            .map(move |touch| touch.widened(wider))
    }

    /// The normal equations at `estimate`: points in order, outline rays in order, displacement eliminated, prior.
    ///
    /// An open point within the window counts with its residual. A point further behind was seen past the model: where
    /// its ray hits, it counts with the residual of the ray's closest approach, which pushes the outline aside.
    pub(crate) fn normal(&self, estimate: &Estimate, terms: &Terms, kernel: Kernel) -> Normal {
        let ellipsoid = estimate.ellipsoid();
        let model = RayModel::new(&ellipsoid, &terms.noise, terms.viewpoint);
        let mut moments = Moments::ZERO;
        let mut nuisances = Nuisances::new([terms.offset_rad, terms.boxiness], estimate.boxiness);
        for &index in self.members {
            let mut contact = model.contact(&at(self.cloud, index));
            if contact.gap_mm > terms.window_mm {
                if !(contact.miss_squared > DEEP && contact.miss_squared < 1.0) {
                    continue;
                }
                contact = model.beside(&contact);
            } else if !(contact.gap_mm >= -terms.window_mm && self.is_open(index)) {
                continue;
            }
            let phi = fullness(contact.u);
            contact.value -= estimate.boxiness * phi;
            if let Some(weight) = kernel.weight(contact.square()) {
                let w = (weight * terms.independence) / contact.variance;
                moments.add(contact.u, contact.value, w);
                nuisances.add_point(contact.u, contact.value, w, phi);
            }
        }
        for touch in self.touches(&model, &ellipsoid, terms) {
            let phi = fullness(touch.u);
            let value = touch.value - estimate.boxiness * phi;
            if let Some(weight) = OUTLINE_KERNEL.weight((value * value) / touch.variance()) {
                let w = weight / touch.variance();
                moments.add(touch.u, value, w);
                nuisances.add_ray(touch.u, value, w, phi, touch.lever());
            }
        }
        let constants = model.constants();
        let mut normal = Normal::new(&moments, &constants);
        nuisances.eliminate(&mut normal, &constants);
        normal.add_prior(&terms.prior, &estimate.ln_axes);
        normal
    }
}

fn limited(step: [f32; 3], limit: f32) -> [f32; 3] {
    let square = step[0] * step[0] + step[1] * step[1] + step[2] * step[2];
    if square > limit * limit {
        let scale = limit / libm::sqrtf(square);
        step.map(|x| x * scale)
    } else {
        step
    }
}

impl Estimate {
    /// The ellipsoid it stands for, axes in the order of the prior.
    pub fn ellipsoid(&self) -> Ellipsoid {
        let [x, y, z] = self.centre;
        Ellipsoid { centre: Point3::new(x, y, z), semi_axes: self.ln_axes.map(libm::expf), axes: self.axes }
    }

    /// The longest semi-axis, mm.
    pub(crate) fn longest(&self) -> f32 {
        let [a, b, c] = self.ln_axes;
        let ab = if a > b { a } else { b };
        libm::expf(if ab > c { ab } else { c })
    }

    /// The ellipsoid with its semi-axes sorted and the sign rule of [`Ellipsoid`] applied, and for each of them its index
    /// here. Orthonormalised again: thirty small turns leave a few roundings.
    pub fn sorted(&self) -> (Ellipsoid, [usize; 3]) {
        let [a, b, c] = self.ln_axes.map(libm::expf);
        let [axis_a, axis_b, axis_c] = self.axes;
        let (mut first, mut second, mut third) = ((a, axis_a, 0), (b, axis_b, 1), (c, axis_c, 2));
        let exchange_if_larger = |front: &mut (f32, [f32; 3], usize), back: &mut (f32, [f32; 3], usize)| {
            if back.0 > front.0 {
                core::mem::swap(front, back);
            }
        };
        exchange_if_larger(&mut first, &mut second);
        exchange_if_larger(&mut second, &mut third);
        exchange_if_larger(&mut first, &mut second);
        let sorted = [first, second, third];
        let [x, y, z] = self.centre;
        let [a, b, _] = sorted.map(|(_, axis, _)| axis);
        let a = unit(a);
        let along = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let b = unit([b[0] - along * a[0], b[1] - along * a[1], b[2] - along * a[2]]);
        let axes = crate::ellipsoid::right_handed([a, b, third.1]);
        let [a, b, _] = axes;
        let ellipsoid = Ellipsoid {
            centre: Point3::new(x, y, z),
            semi_axes: sorted.map(|(size, ..)| size),
            axes: [a, b, cross(a, b)],
        };
        (ellipsoid, sorted.map(|(.., index)| index))
    }

    /// Solves the normal equations and moves. `None` when they are singular or the step is not finite.
    pub fn step(&self, normal: &Normal) -> Option<Self> {
        let mut matrix = normal.matrix;
        for k in 3..6 {
            matrix.add_diagonal(k, ROTATION_INFORMATION);
        }
        let d = matrix.factor()?.solve(&normal.gradient).map(|x| -x);
        let next = self.moved_by(&d, CENTRE_LIMIT * libm::expf(self.ln_axes[2]))?;
        Some(Self { boxiness: self.boxiness + normal.boxiness.follow(&d), ..next })
    }

    /// Moves by a step of the nine parameters, shortened where it is too bold: centre to `centre_limit`, rotation to half a
    /// radian, sizes to 30 %. `None` when the step is not finite.
    pub(crate) fn moved_by(&self, d: &[f32; N], centre_limit: f32) -> Option<Self> {
        let centre = limited([d[0], d[1], d[2]], centre_limit);
        let rotation = limited([d[3], d[4], d[5]], ROTATION_LIMIT);
        let sizes = limited([d[6], d[7], d[8]], SIZE_LIMIT);
        let next = Self {
            centre: moved(&self.centre, &self.axes, centre),
            axes: turned(&self.axes, rotation),
            ln_axes: [self.ln_axes[0] + sizes[0], self.ln_axes[1] + sizes[1], self.ln_axes[2] + sizes[2]],
            boxiness: self.boxiness,
        };
        d.iter().all(|x| x.is_finite()).then_some(next)
    }
}

/// `c + R^T d`, each component summed over the axes in order.
fn moved(centre: &[f32; 3], axes: &[[f32; 3]; 3], d: [f32; 3]) -> [f32; 3] {
    let mut result = *centre;
    for k in 0..3 {
        result[k] += d[0] * axes[0][k] + d[1] * axes[1][k] + d[2] * axes[2][k];
    }
    result
}

/// `Q R` with the Cayley transform `Q = I + 2 / (1 + w.w) (W + W W)`, `W` the cross-product matrix of `w = r / 2`: a
/// rotation by `r` to third order, exactly orthogonal but for rounding, without sine and cosine.
/// Row by row: `Q y = y + (2 / (1 + w.w)) (w x y + w x (w x y))`, applied to the columns of `R`.
fn turned(axes: &[[f32; 3]; 3], r: [f32; 3]) -> [[f32; 3]; 3] {
    let w = r.map(|x| 0.5 * x);
    let scale = 2.0 / (1.0 + (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]));
    let mut result = *axes;
    for k in 0..3 {
        let y = [axes[0][k], axes[1][k], axes[2][k]];
        let once = cross(w, y);
        let twice = cross(w, once);
        for i in 0..3 {
            result[i][k] = y[i] + scale * (once[i] + twice[i]);
        }
    }
    result
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let size = libm::sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    v.map(|x| x / size)
}
