//! Families of scenes: what they are made of, from the easiest to everything at once.

use super::subject::{JUJUBE, Subject};

/// A family of scenes: every pair is a range drawn from uniformly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Family {
    /// Name in tables.
    pub name: &'static str,
    /// What is in the middle.
    pub subject: Subject,
    /// True when the subject is not the fruit that is looked for: the scene has no truth.
    pub decoy: bool,
    /// Distance of its centre from the camera, mm.
    pub distance_mm: (f64, f64),
    /// Axial noise, mm.
    pub axial_mm: (f64, f64),
    /// Growth of the noise with the angle of incidence, 1 = Kinect v2.
    pub slant: f64,
    /// Lateral noise, pixels.
    pub lateral_px: (f64, f64),
    /// Depth counts, mm.
    pub quantum_mm: f64,
    /// Covered share of the pixels it would show alone.
    pub occlusion: (f64, f64),
    /// Chance of a second fruit near it.
    pub neighbour: f64,
    /// Further fruit that touch it or each other.
    pub touching: (f64, f64),
    /// Leaves and twigs around and behind it.
    pub clutter: (f64, f64),
    /// Distance of the background behind the fruit, mm.
    pub background_mm: (f64, f64),
    /// Chance of flying pixels, of holes at edges, of holes anywhere.
    pub defects: [f64; 3],
    /// Rays across a pixel, each way ([`Sensor::rays`](super::patch::Sensor::rays)).
    pub rays: u32,
    /// The region is the fruit-coloured mask grown by so many pixels.
    pub margin_px: (f64, f64),
}

/// Nothing in the way, little noise, 0.5-0.9 m.
pub const CLEAN: Family = Family {
    name: "clean",
    subject: JUJUBE,
    decoy: false,
    distance_mm: (500.0, 900.0),
    axial_mm: (0.4, 0.6),
    slant: 0.0,
    lateral_px: (0.0, 0.1),
    quantum_mm: 0.0,
    occlusion: (0.0, 0.0),
    neighbour: 0.0,
    touching: (0.0, 0.0),
    clutter: (0.0, 0.0),
    background_mm: (100.0, 400.0),
    defects: [0.0, 0.5, 0.0],
    rays: 1,
    margin_px: (0.0, 1.0),
};

/// 0.6-1.2 m, noise to 1.5 mm, half with a neighbour, leaves, about 44 % outliers in the region.
pub const HARD: Family = Family {
    name: "hard",
    subject: JUJUBE,
    decoy: false,
    distance_mm: (600.0, 1200.0),
    axial_mm: (0.4, 1.5),
    slant: 1.0,
    lateral_px: (0.0, 0.3),
    quantum_mm: 1.0,
    occlusion: (0.0, 0.0),
    neighbour: 0.5,
    touching: (0.0, 0.0),
    clutter: (0.0, 4.0),
    background_mm: (30.0, 300.0),
    defects: [0.4, 0.3, 0.01],
    rays: 1,
    margin_px: (0.0, 2.0),
};

/// One fruit, 0-50 % of it behind leaves.
pub const OCCLUDED: Family = Family {
    name: "occluded",
    distance_mm: (500.0, 1000.0),
    axial_mm: (0.4, 1.2),
    occlusion: (0.0, 0.5),
    neighbour: 0.0,
    margin_px: (0.0, 2.0),
    clutter: (0.0, 2.0),
    ..HARD
};

/// Everything at once over the whole range: the family the gate is measured on.
pub const ORCHARD: Family = Family {
    name: "orchard",
    distance_mm: (500.0, 1300.0),
    occlusion: (0.0, 0.6),
    neighbour: 0.3,
    margin_px: (1.0, 3.0),
    ..HARD
};

/// Two to four fruit that touch, nothing in front of them.
pub const TOUCHING: Family = Family {
    name: "touching",
    distance_mm: (500.0, 1000.0),
    axial_mm: (0.4, 1.2),
    neighbour: 0.0,
    touching: (1.0, 3.999),
    clutter: (0.0, 2.0),
    ..HARD
};

/// The same behind leaves.
pub const TOUCHING_LEAVES: Family = Family { name: "touching, leaves", occlusion: (0.0, 0.4), ..TOUCHING };

impl Family {
    /// The same family under another name.
    pub const fn named(self, name: &'static str) -> Self {
        Self { name, ..self }
    }

    /// The same family with another subject.
    pub const fn of(self, name: &'static str, subject: Subject) -> Self {
        Self { name, subject, ..self }
    }

    /// The same family with a subject that must not be taken for the fruit, whatever it is, and no true fruit beside it.
    pub const fn decoy(self, name: &'static str, subject: Subject) -> Self {
        Self { name, subject, decoy: true, neighbour: 0.0, ..self }
    }

    /// The same family through pixels that average what they cover, as those of a real camera do.
    pub const fn averaged(self, name: &'static str) -> Self {
        Self { name, rays: 3, ..self }
    }
}
