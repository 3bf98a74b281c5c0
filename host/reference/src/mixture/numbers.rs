//! Limits and logarithms of semi-axes: contract, chapter X1.

use crate::map::algebra::Vector;

/// X1: `within(x, least, most)`; NaN gives `least`, and so do crossed limits.
pub(crate) fn within(x: f32, least: f32, most: f32) -> f32 {
    let x = if x > most { most } else { x };
    if x > least { x } else { least }
}

/// X1: the exponential of the smallest of three logarithms.
pub(crate) fn smallest([x1, x2, x3]: Vector) -> f32 {
    libm::expf(if x1 < x2 && x1 < x3 {
        x1
    } else if x2 < x3 {
        x2
    } else {
        x3
    })
}

/// X1: the largest of three logarithms.
pub(crate) fn longest_ln([x1, x2, x3]: Vector) -> f32 {
    if x1 > x2 && x1 > x3 {
        x1
    } else if x2 > x3 {
        x2
    } else {
        x3
    }
}

/// X1: the exponential of the largest of three logarithms.
pub(crate) fn longest(x: Vector) -> f32 {
    libm::expf(longest_ln(x))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_decides_where_a_number_does_not() {
        assert_eq!(within(0.5, 0.0, 1.0), 0.5);
        assert_eq!((within(-1.0, 0.0, 1.0), within(2.0, 0.0, 1.0)), (0.0, 1.0));
        assert_eq!((within(f32::NAN, 0.0, 1.0), within(0.5, 1.0, 0.0)), (0.0, 1.0));
    }

    #[test]
    fn every_place_can_be_the_smallest_and_the_longest() {
        for x in [[0.0, 1.0, 2.0], [1.0, 0.0, 2.0], [2.0, 1.0, 0.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0]] {
            assert_eq!(smallest(x), 1.0);
            assert_eq!(longest_ln(x), 2.0);
            assert_eq!(longest(x), libm::expf(2.0));
        }
    }
}
