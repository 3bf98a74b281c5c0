//! Loops in the widest registers of the machine they run on.
//!
//! A program for "any PC" may only count on registers of 128 bits. [`run`] has a second and a third translation of a
//! loop at hand, for 256 and for 512 bits, and takes the widest that the processor has. The bits of a result do not
//! depend on it: each lane rounds as a single number does, no sum of floats is reordered, and the compiler never
//! joins a multiplication and an addition by itself, although the wider registers come with an instruction that would.

/// Runs `work` as translated for this machine's registers: what of it is inlined, so mark the closure and all that it
/// calls `#[inline(always)]`. The choice costs a few nanoseconds.
#[inline]
pub fn run<T>(work: impl FnOnce() -> T) -> T {
    pulp::Arch::new().dispatch(work)
}

#[cfg(test)]
mod tests {
    use varsac_core::{CentralQuadric, Point3, jacobi::Symmetric3, rng::Stream, tebc::Shell};

    #[test]
    fn wide_lanes_round_like_a_single_number() {
        let mut stream = Stream::new(8);
        let mut uniform = |half: f32| (stream.below(1 << 24) as f32 / (1 << 23) as f32 - 1.0) * half;
        let points: Vec<Point3> =
            (0..1003).map(|_| Point3::new(uniform(30.0), uniform(30.0), 700.0 + uniform(30.0))).collect();
        let shape = Symmetric3 { xx: 2.1e-3, yy: 8.3e-3, zz: 7.9e-3, xy: 3e-4, xz: -2e-4, yz: 1e-4 };
        let surface = CentralQuadric { centre: Point3::new(0.3, -0.4, 700.7), shape };
        let mut wide = vec![0.0_f32; points.len()];
        super::run(
            #[inline(always)]
            || {
                for (value, point) in wide.iter_mut().zip(&points) {
                    *value = surface.value(point);
                }
            },
        );
        for (value, point) in wide.iter().zip(&points) {
            assert_eq!(value.to_bits(), surface.value(std::hint::black_box(point)).to_bits(), "{point}");
        }
        for d in [0.03, 0.1, 0.3, 0.9] {
            let shell = Shell::new(&surface, d);
            let one_by_one =
                points.iter().filter(|&p| shell.contains(std::hint::black_box(p))).count() as u32;
            let counted = super::run(
                #[inline(always)]
                || shell.count(&points),
            );
            assert!(one_by_one > 0);
            assert_eq!(counted, one_by_one, "d {d}");
        }
    }
}
