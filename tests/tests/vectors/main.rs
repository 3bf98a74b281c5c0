//! Golden vectors of every stage: made by the reference, kept in `tests/vectors`, and read back for the core.
//!
//! They are what another machine needs to prove that it computes the same, without the reference beside it.

mod fits;
mod format;
mod maps;
mod mixtures;
mod searches;
mod singles;
mod stages;
mod traces;

use format::Case;
use varsac_core::jacobi::Symmetric3;
use varsac_core::{CentralQuadric, Point3};
use varsac_reference as reference;

/// A number in `low..high` from the stream.
pub(crate) fn between(stream: &mut reference::Stream, low: f32, high: f32) -> f32 {
    low + (high - low) * (stream.below(1 << 16) as f32 / 65_536.0)
}

/// `count` points near the camera's side of a jujube, 21.7 x 10.9 x 10.9 mm, 700 mm away.
pub(crate) fn view(stream: &mut reference::Stream, count: usize) -> Vec<reference::Point> {
    let mut points = Vec::new();
    while points.len() < count {
        let [x, y, z] = [(); 3].map(|()| between(stream, -1.0, 1.0));
        let square = x * x + y * y + z * z;
        if z < 0.2 && square > 0.1 && square < 1.0 {
            let r = 1.0 / square.sqrt();
            let noise = between(stream, -0.3, 0.3);
            points.push([30.0 + 21.7 * x * r, -20.0 + 10.9 * y * r, 700.0 + 10.9 * z * r + noise]);
        }
    }
    points
}

/// A shape with semi-axes between 8 and 25 mm or so, full or diagonal.
pub(crate) fn surface(stream: &mut reference::Stream, off: f32) -> reference::Central {
    let [xx, yy, zz] = [(); 3].map(|()| between(stream, 0.002, 0.015));
    let [xy, xz, yz] = [(); 3].map(|()| off * between(stream, -0.001, 0.001));
    let centre = [(); 3].map(|()| between(stream, -50.0, 50.0));
    reference::Central { centre, shape: reference::Symmetric { xx, yy, zz, xy, xz, yz } }
}

pub(crate) fn surface_numbers(c: &reference::Central) -> [f32; 9] {
    let ([x, y, z], s) = (c.centre, &c.shape);
    [x, y, z, s.xx, s.yy, s.zz, s.xy, s.xz, s.yz]
}

pub(crate) fn surface_read(case: &Case) -> CentralQuadric {
    let [x, y, z, xx, yy, zz, xy, xz, yz] = case.numbers("surface")[..] else { panic!("nine numbers") };
    CentralQuadric { centre: Point3::new(x, y, z), shape: Symmetric3 { xx, yy, zz, xy, xz, yz } }
}

pub(crate) fn points_read(case: &Case) -> Vec<Point3> {
    case.numbers("points").chunks(3).map(|p| Point3::new(p[0], p[1], p[2])).collect()
}

pub(crate) fn everything(count: usize) -> Vec<u16> {
    (0..count as u16).collect()
}
