//! Which bodies may lie behind a place of the image: a grid of tiles, each with the bodies whose footprint touches it.
//!
//! Casting a ray then asks a handful of bodies instead of all of them. The grid is plain 2-D: a camera fills it with
//! what it sees of each body, the light with what the sun sees.

use nalgebra::{Point2, center, distance_squared};

/// Tiles an image may have along each side; of a larger image they are larger.
const MAX_TILES: usize = 512;

/// All places within `radius` of the line through `points`: contains what is seen of a body.
#[derive(Debug, Clone, Copy)]
pub(super) struct Footprint {
    pub(super) points: [Point2<f64>; 3],
    pub(super) radius: f64,
}

impl Footprint {
    /// The rectangle around it.
    pub(super) fn bounds(&self) -> Rectangle {
        let [a, b, c] = self.points;
        let (min, max) = (a.inf(&b).inf(&c), a.sup(&b).sup(&c));
        Rectangle { min: min.map(|x| x - self.radius), max: max.map(|x| x + self.radius) }
    }

    /// Whether a disc touches it.
    fn touches(&self, centre: &Point2<f64>, radius: f64) -> bool {
        let reach = self.radius + radius;
        self.points.windows(2).any(|ends| {
            let along = ends[1] - ends[0];
            let length2 = along.norm_squared();
            let share = if length2 > 0.0 { (centre - ends[0]).dot(&along) / length2 } else { 0.0 };
            distance_squared(&(ends[0] + along * share.clamp(0.0, 1.0)), centre) <= reach * reach
        })
    }
}

/// An axis-aligned rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub(super) min: Point2<f64>,
    pub(super) max: Point2<f64>,
}

impl Rectangle {
    /// The smallest rectangle around two.
    #[must_use]
    pub(super) fn join(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
    }

    /// Whether two have no place in common.
    fn is_apart(&self, other: &Self) -> bool {
        self.max.x < other.min.x
            || self.max.y < other.min.y
            || self.min.x > other.max.x
            || self.min.y > other.max.y
    }
}

/// The grid.
#[derive(Debug)]
pub(super) struct Tiles {
    area: Rectangle,
    tile: f64,
    columns: usize,
    rows: usize,
    bodies: Vec<Vec<u16>>,
}

impl Tiles {
    /// A grid over `area` with square tiles; `footprints` yields that of each body. Bodies are numbered in that order,
    /// and stay in it within a tile.
    pub(super) fn new(area: Rectangle, tile: f64, footprints: impl Iterator<Item = Footprint>) -> Self {
        let size = area.max - area.min;
        let tile = tile.max(size.x / MAX_TILES as f64).max(size.y / MAX_TILES as f64);
        let count = |length: f64| ((length / tile).ceil() as usize).clamp(1, MAX_TILES);
        let (columns, rows) = (count(size.x), count(size.y));
        let mut tiles = Self { area, tile, columns, rows, bodies: vec![Vec::new(); columns * rows] };
        for (body, footprint) in (0_u16..=u16::MAX).zip(footprints) {
            let bounds = footprint.bounds();
            if bounds.is_apart(&area) {
                continue;
            }
            let ((left, top), (right, bottom)) = (tiles.place(bounds.min), tiles.place(bounds.max));
            for row in top..=bottom {
                for column in left..=right {
                    let (centre, radius) = tiles.disc(column, row);
                    if footprint.touches(&centre, radius) {
                        tiles.bodies[row * columns + column].push(body);
                    }
                }
            }
        }
        tiles
    }

    /// The bodies that may lie behind a place; outside the area those of the nearest tile.
    #[inline]
    pub(super) fn at(&self, x: f64, y: f64) -> &[u16] {
        let (column, row) = self.place(Point2::new(x, y));
        &self.bodies[row * self.columns + column]
    }

    fn place(&self, point: Point2<f64>) -> (usize, usize) {
        // Casts saturate: what lies left of the area is column 0.
        let column = ((point.x - self.area.min.x) / self.tile) as usize;
        let row = ((point.y - self.area.min.y) / self.tile) as usize;
        (column.min(self.columns - 1), row.min(self.rows - 1))
    }

    /// The disc around a tile.
    fn disc(&self, column: usize, row: usize) -> (Point2<f64>, f64) {
        let corner = |column: usize, row: usize| {
            let place = |index: usize, min: f64| min + index as f64 * self.tile;
            Point2::new(place(column, self.area.min.x), place(row, self.area.min.y))
        };
        // A little more than half the diagonal, against rounding.
        (center(&corner(column, row), &corner(column + 1, row + 1)), 0.71 * self.tile)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_place_of_a_footprint_finds_its_body() {
        let area = Rectangle { min: Point2::new(-10.0, 5.0), max: Point2::new(90.0, 65.0) };
        let points = [Point2::new(0.0, 10.0), Point2::new(40.0, 30.0), Point2::new(80.0, 25.0)];
        let footprint = Footprint { points, radius: 6.0 };
        let elsewhere = Footprint { points: [Point2::new(300.0, 300.0); 3], radius: 50.0 };
        let tiles = Tiles::new(area, 4.0, [elsewhere, footprint].into_iter());
        let (mut inside, mut empty) = (0, 0);
        for y in 5..65 {
            for x in -10..90 {
                let place = Point2::new(f64::from(x) + 0.3, f64::from(y) + 0.7);
                let found = tiles.at(place.x, place.y);
                assert!(found.iter().all(|&body| body == 1));
                if footprint.touches(&place, 0.0) {
                    inside += 1;
                    assert_eq!(found, [1], "{place}");
                }
                empty += u32::from(found.is_empty());
            }
        }
        assert!(inside > 800 && empty > 3000, "{inside} {empty}");
    }

    #[test]
    fn an_endless_footprint_is_everywhere() {
        let area = Rectangle { min: Point2::origin(), max: Point2::new(20.0, 20.0) };
        let footprint = Footprint { points: [Point2::origin(); 3], radius: f64::INFINITY };
        let tiles = Tiles::new(area, 8.0, [footprint].into_iter());
        assert!((0..20).all(|x| tiles.at(f64::from(x), 3.0) == [0]));
    }
}
