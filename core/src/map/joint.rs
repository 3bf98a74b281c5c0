//! Fruit that touch: which point is whose, and the fit of each to its own.
//!
//! Found one after the other, the first of two touching fruit was fitted to some points of the second. Here each fruit near
//! others takes its turn, three rounds long: it challenges for the points within its reach, and a point goes to the model
//! whose surface it lies nearer (`f^2` of [`crate::residual`], below `3.5^2`); then five steps of the final fit on what is its own.
//! Points of others still show where it is not.

use super::{FINAL_KERNEL, Fruit, REACH, Standing, distance_squared, noise::shown_noise};
use crate::{
    Observer, Point3, Stage,
    accept::contact_function,
    field::Field,
    point::at,
    refine::{Evidence, Terms},
    residual::RayModel,
};

/// Rounds of challenging and fitting.
const ROUNDS: u8 = 3;
/// Steps of the fit in each round.
const STEPS: u8 = 5;
/// `3.5^2`: a point further from a model is nobody's.
const OWN: f32 = 12.25;
/// Two fruit are near each other when their centres are within this part of the sum of their longest semi-axes.
const NEAR: f32 = 1.1;
/// Below this contact function (1 = touching) two finds are one body found twice.
const GHOST: f32 = 0.5;

/// Decides how the found fruit stand to each other; the points of ghosts are set free.
pub(crate) fn sort_out(field: &mut Field<'_>, found: &mut [Fruit]) {
    for k in 0..found.len() {
        let Some(&fruit) = found.get(k) else { return };
        let mut standing = Standing::Alone;
        for (j, other) in found.iter().enumerate() {
            if j == k || !near(&fruit, other) || other.standing == Standing::Ghost {
                continue;
            }
            let weaker = fruit.score < other.score || (fruit.score == other.score && j < k);
            if weaker && contact_function(&fruit.estimate.ellipsoid(), &other.estimate.ellipsoid()) < GHOST {
                standing = Standing::Ghost;
            } else if standing == Standing::Alone {
                standing = Standing::Contested;
            }
        }
        if standing == Standing::Ghost {
            let own = k as u8 + 1;
            for label in field.scratch.labels.iter_mut().filter(|label| **label == own) {
                *label = 0;
            }
        }
        if let Some(fruit) = found.get_mut(k) {
            fruit.standing = standing;
        }
    }
}

fn near(a: &Fruit, b: &Fruit) -> bool {
    let reach = NEAR * (a.estimate.longest() + b.estimate.longest());
    distance_squared(&a.estimate, &b.estimate) < reach * reach
}

/// Whose turn it is.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Joint {
    round: u8,
    turn: u8,
    /// 0: to challenge; then the steps of the fit.
    step: u8,
    members: usize,
}

impl Joint {
    pub(crate) fn new() -> Self {
        Self { round: 0, turn: 0, step: 0, members: 0 }
    }

    /// One challenge or one step of one fit; false when all is done.
    pub(crate) fn step(
        &mut self,
        field: &mut Field<'_>,
        found: &mut [Fruit],
        observer: &mut impl Observer,
    ) -> bool {
        let turn = usize::from(self.turn);
        let Some(&fruit) = found.get(turn) else {
            (self.round, self.turn) = (self.round + 1, 0);
            return self.round < ROUNDS && found.iter().any(|fruit| fruit.standing == Standing::Contested);
        };
        if fruit.standing != Standing::Contested {
            self.turn += 1;
            return true;
        }
        let own = self.turn + 1;
        if self.step == 0 {
            let [x, y, z] = fruit.estimate.centre;
            self.members = field.list_within(&Point3::new(x, y, z), REACH * fruit.estimate.longest());
            challenge(field, self.members, found, turn);
            self.step = 1;
            return true;
        }
        let evidence = Evidence::of(field, self.members, own);
        let next = fruit.estimate.step(&evidence.normal(&fruit.estimate, &fruit.terms, FINAL_KERNEL));
        let moved = next.unwrap_or(fruit.estimate);
        observer.estimate(Stage::Joint, &moved);
        let mut terms = fruit.terms;
        if next.is_none() || self.step >= STEPS {
            let assumed = Terms { noise: field.config.map.noise, outline: 1.0, ..terms };
            terms = shown_noise(&evidence, &moved, &assumed);
            observer.noise(&terms.noise);
            (self.turn, self.step) = (self.turn + 1, 0);
        } else {
            self.step += 1;
        }
        if let Some(fruit) = found.get_mut(turn) {
            (fruit.estimate, fruit.terms) = (moved, terms);
        }
        true
    }
}

/// The fruit whose turn it is lets go of listed points that are too far from it, takes free ones that are not, and those of
/// each neighbour, in order, that lie nearer to it than to their owner.
fn challenge(field: &mut Field<'_>, members: usize, found: &[Fruit], turn: usize) {
    let Some(fruit) = found.get(turn) else { return };
    let own = turn as u8 + 1;
    let model = Claim::new(fruit);
    let (cloud, scratch) = (field.view.cloud, &mut field.scratch);
    let members = scratch.members.get(..members).unwrap_or(&[]);
    for &index in members {
        if let Some(label) = scratch.labels.get_mut(usize::from(index))
            && (*label == 0 || *label == own)
        {
            *label = if model.distance(&at(cloud, index)) < OWN { own } else { 0 };
        }
    }
    for (j, other) in found.iter().enumerate() {
        if j == turn || other.standing != Standing::Contested || !near(fruit, other) {
            continue;
        }
        let theirs = Claim::new(other);
        for &index in members {
            if let Some(label) = scratch.labels.get_mut(usize::from(index))
                && *label == j as u8 + 1
            {
                let point = at(cloud, index);
                let mine = model.distance(&point);
                if mine < OWN && mine < theirs.distance(&point) {
                    *label = own;
                }
            }
        }
    }
}

/// A model that claims points.
struct Claim {
    model: RayModel,
    window_mm: f32,
}

impl Claim {
    fn new(fruit: &Fruit) -> Self {
        let Fruit { estimate, terms, .. } = fruit;
        let model = RayModel::new(&estimate.ellipsoid(), &terms.noise, terms.viewpoint);
        Self { model, window_mm: terms.window_mm }
    }

    /// `f^2` of a point within the window, infinity outside.
    fn distance(&self, point: &Point3) -> f32 {
        let contact = self.model.contact(point);
        if contact.gap_mm < self.window_mm && contact.gap_mm > -self.window_mm {
            contact.square()
        } else {
            f32::INFINITY
        }
    }
}
