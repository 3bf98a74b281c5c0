//! Which bodies may lie behind a place of the image: a grid of tiles, each with the bodies whose bounds touch it.
//!
//! Casting a ray then asks a handful of bodies instead of all of them. The grid is plain 2-D: a camera fills it with
//! projected bounding spheres, the light with bounding circles seen from the sun.

use nalgebra::Point2;

/// Tiles an image may have along each side; of a larger image they are larger.
const MAX_TILES: usize = 512;

/// An axis-aligned rectangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Rectangle {
    pub(super) min: Point2<f64>,
    pub(super) max: Point2<f64>,
}

impl Rectangle {
    /// The square around a circle.
    pub(super) fn of_circle(centre: Point2<f64>, radius: f64) -> Self {
        Self { min: centre.map(|x| x - radius), max: centre.map(|x| x + radius) }
    }

    /// The smallest rectangle around two.
    #[must_use]
    pub(super) fn join(self, other: Self) -> Self {
        Self { min: self.min.inf(&other.min), max: self.max.sup(&other.max) }
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
    /// A grid over `area` with square tiles; `bounds` yields the rectangle of each body. Bodies are numbered in that
    /// order, and stay in it within a tile.
    pub(super) fn new(area: Rectangle, tile: f64, bounds: impl Iterator<Item = Rectangle>) -> Self {
        let size = area.max - area.min;
        let tile = tile.max(size.x / MAX_TILES as f64).max(size.y / MAX_TILES as f64);
        let count = |length: f64| ((length / tile).ceil() as usize).clamp(1, MAX_TILES);
        let (columns, rows) = (count(size.x), count(size.y));
        let mut tiles = Self { area, tile, columns, rows, bodies: vec![Vec::new(); columns * rows] };
        for (body, bounds) in bounds.enumerate() {
            let outside = bounds.max.x < area.min.x
                || bounds.max.y < area.min.y
                || bounds.min.x > area.max.x
                || bounds.min.y > area.max.y;
            if outside {
                continue;
            }
            let ((left, top), (right, bottom)) = (tiles.place(bounds.min), tiles.place(bounds.max));
            for row in top..=bottom {
                for column in left..=right {
                    tiles.bodies[row * columns + column].push(body as u16);
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
}
