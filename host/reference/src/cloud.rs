//! The cloud and what it must satisfy: contract, chapter 2.

/// One point in millimetres: x right, y down, z forward.
pub type Point = [f32; 3];

/// Why a cloud is refused before the first draw.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CloudError {
    /// More than 65535 points.
    TooManyPoints(usize),
    /// More than 4096 outline rays (chapter M2).
    TooManyRays(usize),
    /// A coordinate that is not finite or exceeds 1e9 in magnitude.
    Coordinate {
        /// The first such point.
        index: usize,
        /// Its first such coordinate.
        value: f32,
    },
}

/// Contract, chapter 2: at most 65535 points, every coordinate finite and at most 1e9 in magnitude.
///
/// # Errors
/// The first thing that is wrong.
pub fn check_cloud(cloud: &[Point]) -> Result<(), CloudError> {
    if cloud.len() > 65535 {
        return Err(CloudError::TooManyPoints(cloud.len()));
    }
    for (index, point) in cloud.iter().enumerate() {
        for &value in point {
            if !value.is_finite() || libm::fabsf(value) > 1e9 {
                return Err(CloudError::Coordinate { index, value });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_limits_are_inclusive() {
        assert_eq!(check_cloud(&[]), Ok(()));
        assert_eq!(check_cloud(&[[1e9, -1e9, 0.0]]), Ok(()));
        let far = 1.000_000_1e9;
        let refused = Err(CloudError::Coordinate { index: 1, value: far });
        assert_eq!(check_cloud(&[[0.0; 3], [0.0, far, 0.0]]), refused);
        assert!(check_cloud(&[[f32::NAN, 0.0, 0.0]]).is_err());
        assert!(check_cloud(&[[0.0, 0.0, f32::NEG_INFINITY]]).is_err());
        assert_eq!(check_cloud(&vec![[0.0; 3]; 65535]), Ok(()));
        assert_eq!(check_cloud(&vec![[0.0; 3]; 65536]), Err(CloudError::TooManyPoints(65536)));
    }
}
