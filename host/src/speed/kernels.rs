//! Scoring points against a model, a point at a time as the unit: the ways of counting between two ellipsoids, the
//! default search's residual along the ray, and the comparison method's distance and normal.

use std::hint::black_box;

use varsac_core::{
    CentralQuadric, Ellipsoid, MapConfig, Point3, SizePrior,
    residual::RayModel,
    tebc::Shell,
    visibility::{Sight, sight},
};

use super::{race::Contender, workload};
use crate::{
    baseline::{RansacOptions, neighbours::NeighbourTree, normals::normals, score::Score},
    eval::EllipsoidF64,
    wide,
};

/// Points, a model among them, and what the methods need to know beforehand.
#[derive(Debug)]
pub struct Scoring {
    cloud: Vec<Point3>,
    list: Vec<u16>,
    wide: Vec<[f64; 3]>,
    normals: Vec<[f64; 3]>,
    model: Ellipsoid,
    model_f64: EllipsoidF64,
    shell: Shell,
    options: RansacOptions,
}

impl Scoring {
    /// So many points, at most 65 535.
    pub fn new(count: usize, seed: u64) -> Self {
        let cloud = workload::points(count, seed);
        let wide: Vec<[f64; 3]> = cloud.iter().map(|p| [p.x, p.y, p.z].map(f64::from)).collect();
        let options = RansacOptions::default();
        let model = workload::jujube();
        let model_f64 = EllipsoidF64::from(&model);
        Self {
            list: (0..cloud.len()).map(|index| index as u16).collect(),
            normals: normals(&NeighbourTree::new(wide.clone()), options.normal_neighbours),
            shell: Shell::new(&CentralQuadric::from(&model_f64), workload::paper().shell),
            cloud,
            wide,
            model,
            model_f64,
            options,
        }
    }

    /// TEBC as a plain loop over the list, a point after the other: that a point might not be there keeps a compiler from
    /// taking several at a time.
    pub fn tebc_one_by_one(&self) -> u32 {
        let (shell, mut inliers) = (*black_box(&self.shell), 0);
        for &index in &self.list {
            let point = self.cloud.get(usize::from(index)).copied().unwrap_or(Point3::new(0.0, 0.0, 0.0));
            inliers += u32::from(shell.contains(&point));
        }
        inliers
    }

    /// TEBC over a list of indices: a neighbourhood.
    pub fn tebc_list(&self) -> u32 {
        black_box(&self.shell).score(&self.cloud, &self.list).inliers
    }

    /// TEBC over the whole cloud, in the registers that every PC has.
    pub fn tebc_cloud(&self) -> u32 {
        black_box(&self.shell).count(&self.cloud)
    }

    /// TEBC over the whole cloud, in the widest registers of this machine.
    pub fn tebc_wide(&self) -> u32 {
        let shell = black_box(&self.shell);
        wide::run(
            #[inline(always)]
            || shell.count(&self.cloud),
        )
    }

    /// Explained points of the default search: residual along the viewing ray, and what is seen through the model.
    pub fn along_the_ray(&self) -> u32 {
        let MapConfig { noise, viewpoint, prior, .. } = MapConfig::of(SizePrior::JUJUBE);
        let model = RayModel::new(black_box(&self.model), &noise, viewpoint);
        let window_mm = 0.55 * prior.semi_axes_mm[2];
        let explained = |point| matches!(sight(&model.contact(point), window_mm), Sight::Explained(_));
        self.cloud.iter().map(|point| u32::from(explained(point))).sum()
    }

    /// Inliers of the comparison method, `f64`, exact closest point; the normals were estimated before.
    pub fn distance_and_normal(&self) -> u32 {
        let RansacOptions { distance_mm, normal_cosine, .. } = self.options;
        let score = Score::new(black_box(&self.model_f64), distance_mm, normal_cosine);
        let both = self.wide.iter().zip(&self.normals);
        both.map(|(&point, &normal)| u32::from(score.is_inlier(point, normal))).sum()
    }

    /// All of them; the first is the plain loop.
    pub fn contenders(&self) -> Vec<Contender<'_>> {
        let points = self.cloud.len() as u64;
        let contender = |name, count: fn(&Self) -> u32| {
            Contender::new(name, move || {
                black_box(count(self));
                points
            })
        };
        vec![
            contender("TEBC, one point after the other", Self::tebc_one_by_one),
            contender("TEBC, listed points", Self::tebc_list),
            contender("TEBC, all points", Self::tebc_cloud),
            contender("TEBC, all points, widest registers", Self::tebc_wide),
            contender("residual along the ray (default search)", Self::along_the_ray),
            contender("distance and normal (RANSAC)", Self::distance_and_normal),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_of_counting_count_the_same() {
        for count in [0, 1, 7, 8, 9, 1000, 4099] {
            let scoring = Scoring::new(count, 3);
            let expected = scoring.tebc_one_by_one();
            assert_eq!([scoring.tebc_list(), scoring.tebc_cloud(), scoring.tebc_wide()], [expected; 3]);
            assert!(expected > 0 || count < 100, "{count}");
        }
    }

    #[test]
    fn every_method_finds_most_of_the_fruits_points() {
        let scoring = Scoring::new(4000, 3);
        for count in [scoring.tebc_cloud(), scoring.along_the_ray(), scoring.distance_and_normal()] {
            assert!((500..3000).contains(&count), "{count}");
        }
    }
}
