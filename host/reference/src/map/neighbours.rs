//! Fruit beside each other: standings and joint rounds (contract, chapters M16 and M17).

use super::algebra::{Vector, adj, det, dot, entrywise, minus, product};
use super::contact::{Contact, Kernel};
use super::evidence::{Evidence, listed};
use super::fruit::{Fruit, Standing};
use super::model::{Estimate, Model, apart2};
use super::noise::estimated;
use super::normal::normal_equations;
use super::prior::Terms;
use super::step::step;
use super::view::{MapConfig, View};
use crate::fault::{self, Fault};
use crate::{Event, Phase, Symmetric};

/// M16: whether two fruit could touch.
fn near(a: &Estimate, b: &Estimate) -> bool {
    let h = 1.1 * (a.longest() + b.longest());
    apart2(a, b) < h * h
}

/// Centre, semi-axes and axes of an ellipsoid, sorted or not.
pub(crate) struct Body {
    pub(crate) centre: Vector,
    pub(crate) semi_axes: Vector,
    pub(crate) axes: [[f32; 3]; 3],
}

impl Body {
    /// The ellipsoid of an estimate, not sorted.
    pub(crate) fn of(estimate: &Estimate) -> Self {
        Self { centre: estimate.centre, semi_axes: estimate.semi_axes(), axes: estimate.axes }
    }

    /// M16: its extent.
    fn extent(&self) -> Symmetric {
        let mut sum = Symmetric::default();
        for k in 0..3 {
            let s = self.semi_axes[k] * self.semi_axes[k];
            let r = self.axes[k];
            sum.xx += s * (r[0] * r[0]);
            sum.yy += s * (r[1] * r[1]);
            sum.zz += s * (r[2] * r[2]);
            sum.xy += s * (r[0] * r[1]);
            sum.xz += s * (r[0] * r[2]);
            sum.yz += s * (r[1] * r[2]);
        }
        sum
    }
}

/// M16: the contact function of two ellipsoids, 1 where they touch.
pub(crate) fn contact_function(first: &Body, second: &Body) -> f32 {
    let (a, b) = (first.extent(), second.extent());
    let d = minus(second.centre, first.centre);
    let mut largest = 0.0;
    for k in 1..16 {
        let l = k as f32 / 16.0;
        let m = 1.0 - l;
        let mix = entrywise(&a, &b, |a, b| m * a + l * b);
        let g = product(&adj(&mix), d);
        let value = if fault::is(Fault::ContactFunction) {
            l * (m * (dot(d, g) / det(&mix)))
        } else {
            (l * m) * (dot(d, g) / det(&mix))
        };
        if value > largest {
            largest = value;
        }
    }
    libm::sqrtf(largest)
}

/// M16: the standing of every fruit; the points of ghosts are set free.
pub(crate) fn standings(fruit: &mut [Fruit], labels: &mut [u8]) {
    for index in 0..fruit.len() {
        let standing = standing(fruit, index);
        fruit[index].standing = standing;
        if standing == Standing::Ghost {
            for label in labels.iter_mut() {
                if *label == fruit[index].label {
                    *label = 0;
                }
            }
        }
    }
}

/// M16: the standing of one fruit among those before and after it.
fn standing(fruit: &[Fruit], index: usize) -> Standing {
    let a = &fruit[index];
    let mut standing = Standing::Alone;
    for (other, b) in fruit.iter().enumerate() {
        if other == index || b.standing == Standing::Ghost || !near(&a.estimate, &b.estimate) {
            continue;
        }
        let mut weaker = a.score < b.score || (a.score == b.score && other < index);
        if fault::is(Fault::Standings) {
            weaker = !weaker;
        }
        if weaker && contact_function(&Body::of(&a.estimate), &Body::of(&b.estimate)) < 0.5 {
            standing = Standing::Ghost;
        } else if standing == Standing::Alone {
            standing = Standing::Contested;
        }
    }
    standing
}

/// M17: three rounds at most in which contested fruit are refitted beside each other.
pub(crate) fn joint_rounds(
    view: &View,
    labels: &mut [u8],
    fruit: &mut [Fruit],
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) {
    for _round in 0..3 {
        for index in 0..fruit.len() {
            if fruit[index].standing == Standing::Contested {
                turn(view, labels, fruit, index, config, observe);
            }
        }
    }
}

/// M17: the turn of one fruit.
fn turn(
    view: &View,
    labels: &mut [u8],
    fruit: &mut [Fruit],
    index: usize,
    config: &MapConfig,
    observe: &mut dyn FnMut(Event),
) {
    let mut estimate = fruit[index].estimate;
    let members = listed(view, estimate.centre, 1.25 * estimate.longest());
    challenge(view, labels, fruit, index, &members);
    observe(Event::Labels(labels.to_vec()));
    let evidence = Evidence { view, labels, members: &members, label: fruit[index].label };
    let steps = if fault::is(Fault::Joint) { 4 } else { 5 };
    for _ in 0..steps {
        let normal = normal_equations(&estimate, evidence, &fruit[index].terms, Kernel::Tukey(16.0));
        let taken = step(&estimate, &normal);
        estimate = taken.unwrap_or(estimate);
        observe(Event::Estimate(Phase::Joint, estimate));
        if taken.is_none() {
            break;
        }
    }
    let shown = estimated(&estimate, evidence, &Terms::assumed(config));
    observe(Event::Noise(shown.noise));
    fruit[index].estimate = estimate;
    fruit[index].terms = shown.entered(fruit[index].terms);
}

/// M17.2: the fruit takes the members that are nearer to it than to those that have them.
fn challenge(view: &View, labels: &mut [u8], fruit: &[Fruit], index: usize, members: &[u16]) {
    let this = &fruit[index];
    for &member in members {
        let label = &mut labels[member as usize];
        if *label == 0 || *label == this.label {
            *label = if distance(view, this, member) < 12.25 { this.label } else { 0 };
        }
    }
    for (number, other) in fruit.iter().enumerate() {
        let rival =
            number != index && other.standing == Standing::Contested && near(&this.estimate, &other.estimate);
        if !rival {
            continue;
        }
        for &member in members {
            let label = &mut labels[member as usize];
            if *label == other.label {
                let mine = distance(view, this, member);
                let nearer = mine < distance(view, other, member) || fault::is(Fault::Challenge);
                if mine < 12.25 && nearer {
                    *label = this.label;
                }
            }
        }
    }
}

/// M17.2: the distance of a point from a fruit.
fn distance(view: &View, fruit: &Fruit, member: u16) -> f32 {
    let model = Model::new(&fruit.estimate, fruit.terms.noise, fruit.terms.viewpoint);
    let contact = Contact::new(&model, view.points[member as usize]);
    if contact.within(fruit.terms.window) { contact.f2() } else { f32::INFINITY }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_equal_balls_touch_at_two_radii() {
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let ball = |x: f32| Body { centre: [x, 0.0, 0.0], semi_axes: [2.0; 3], axes };
        assert_eq!(contact_function(&ball(0.0), &ball(4.0)), 1.0);
        assert_eq!(contact_function(&ball(1.0), &ball(-1.0)), 0.5);
    }
}
