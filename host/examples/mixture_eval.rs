//! Measures the search without a size prior.
use rayon::prelude::*;
use varsac_core::accept::RefusalCode;
use varsac_core::mixture::{MixtureConfig, MixtureProgress, MixtureSearch, MixtureSolution};
use varsac_core::{Point3, View, Workspace, rng::Stream};
use varsac_host::eval::EllipsoidF64;
use varsac_host::outline::outline_rays;
use varsac_host::synth::surface::{Body, CLUTTERED, SURFACE, SurfaceFamily};
use varsac_host::synth::{SimulationOptions, onesided, simulate};

fn search(
    view: &View<'_>,
    config: &MixtureConfig,
    seed: u64,
    workspace: &mut Workspace<16384>,
) -> Result<MixtureSolution, RefusalCode> {
    let mut search = MixtureSearch::new();
    let mut stream = Stream::new(seed);
    let mut scratch = workspace.scratch();
    scratch.reset(view.cloud.len());
    loop {
        match search.step(config, view, &mut scratch, &mut stream) {
            MixtureProgress::Working => {}
            MixtureProgress::Nothing(refusal) => return Err(refusal.code),
            MixtureProgress::Found(solution) => return Ok(solution),
        }
    }
}

struct Row {
    seed: u64,
    centre: f64,
    size: f64,
    failed: bool,
    refusal: Option<RefusalCode>,
    us: f64,
    m: [f64; 3],
    sol: Option<MixtureSolution>,
    info: String,
}

fn maha(c: &varsac_core::Covariance, at: usize, x: [f64; 3]) -> f64 {
    let m = nalgebra::Matrix3::from_fn(|i, j| f64::from(c.entry(at + i, at + j)));
    let v = nalgebra::Vector3::from(x);
    m.try_inverse().map_or(f64::NAN, |inv| (v.transpose() * inv * v)[0])
}

fn judge(
    seed: u64,
    truth: &EllipsoidF64,
    found: Result<MixtureSolution, RefusalCode>,
    us: f64,
    info: String,
) -> Row {
    match found {
        Err(code) => Row {
            seed,
            centre: 99.0,
            size: 99.0,
            failed: true,
            refusal: Some(code),
            us,
            m: [0.0; 3],
            sol: None,
            info,
        },
        Ok(s) => {
            let e = EllipsoidF64::from(&s.ellipsoid);
            let dc: [f64; 3] = core::array::from_fn(|k| e.centre_mm[k] - truth.centre_mm[k]);
            let ds: [f64; 3] = core::array::from_fn(|k| e.semi_axes_mm[k] - truth.semi_axes_mm[k]);
            let centre = dc.iter().map(|x| x * x).sum::<f64>().sqrt();
            let size = ds.iter().map(|x| x.abs()).fold(0.0, f64::max);
            let rel = (0..3).map(|k| (ds[k] / truth.semi_axes_mm[k]).abs()).fold(0.0, f64::max);
            let failed = !(centre <= truth.semi_axes_mm[2] && rel <= 0.5);
            // rotation vector (cloud frame) from found to true axes, small angle
            let mut w = nalgebra::Vector3::zeros();
            for k in 0..3 {
                let a = nalgebra::Vector3::from(e.axes[k]);
                let mut b = nalgebra::Vector3::from(truth.axes[k]);
                if a.dot(&b) < 0.0 {
                    b = -b;
                }
                w += a.cross(&b) * 0.5;
            }
            let m = s
                .covariance
                .map_or([f64::NAN; 3], |c| [maha(&c, 0, dc), maha(&c, 3, ds), maha(&c, 6, w.into())]);
            Row { seed, centre, size, failed, refusal: s.refusal.map(|r| r.code), us, m, sol: Some(s), info }
        }
    }
}

fn q(v: &mut [f64], p: f64) -> f64 {
    if v.is_empty() {
        return f64::NAN;
    }
    v.sort_by(f64::total_cmp);
    v[((v.len() - 1) as f64 * p) as usize]
}

fn report(name: &str, rows: &[Row], verbose: bool) {
    let n = rows.len() as f64;
    let mut c: Vec<f64> = rows.iter().map(|r| r.centre).collect();
    let mut s: Vec<f64> = rows.iter().map(|r| r.size).collect();
    let failed = rows.iter().filter(|r| r.failed).count();
    let accepted: Vec<&Row> = rows.iter().filter(|r| r.refusal.is_none()).collect();
    let wrong = accepted.iter().filter(|r| r.failed).count();
    let mut us: Vec<f64> = rows.iter().map(|r| r.us).collect();
    let cover =
        |k: usize| accepted.iter().filter(|r| r.m[k] < 7.815).count() as f64 / accepted.len().max(1) as f64;
    let mut codes = std::collections::BTreeMap::new();
    for r in rows.iter().filter_map(|r| r.refusal) {
        *codes.entry(format!("{r:?}")).or_insert(0) += 1;
    }
    println!(
        "{name:14} centre {:.4}/{:.4}/{:.3} size {:.4}/{:.4} failed {:.4} ({failed}) accepted {:.3} wrong {wrong} cover {:.3} {:.3} {:.3} us {:.0}/{:.0} {codes:?}",
        q(&mut c, 0.5),
        q(&mut c, 0.9),
        q(&mut c, 0.99),
        q(&mut s, 0.5),
        q(&mut s, 0.9),
        failed as f64 / n,
        accepted.len() as f64 / n,
        cover(0),
        cover(1),
        cover(2),
        q(&mut us, 0.5),
        q(&mut us, 0.95)
    );
    if verbose {
        for r in rows.iter().filter(|r| r.failed).take(12) {
            println!(
                "   {} c {:.2} s {:.2} {:?} {} {:?}",
                r.seed,
                r.centre,
                r.size,
                r.refusal,
                r.info,
                r.sol.map(|s| (s.ellipsoid.semi_axes, s.sigma, s.findings))
            );
        }
    }
    let f: Vec<_> = rows.iter().filter_map(|r| r.sol.map(|s| s.findings)).collect();
    let show = |name: &str, get: &dyn Fn(&varsac_core::mixture::MixtureFindings) -> f32| {
        let mut v: Vec<f64> = f.iter().map(|f| f64::from(get(f))).collect();
        print!(
            " {name} {:.3}/{:.3}/{:.3}/{:.3}/{:.3}",
            q(&mut v, 0.01),
            q(&mut v, 0.1),
            q(&mut v, 0.5),
            q(&mut v, 0.9),
            q(&mut v, 0.99)
        );
    };
    print!("     ");
    show("gain", &|f| f.gain);
    show("cov", &|f| f.coverage);
    show("flat", &|f| f.flat);
    show("misfit", &|f| f.misfit);
    show("unc", &|f| f.uncertain);
    println!();
}

fn main() {
    let mut n = 400_u64;
    let mut base = 0_u64;
    let mut verbose = false;
    let mut names: Vec<String> = vec![];
    let mut config = MixtureConfig::SURFACE;
    let mut scale = 1.0_f32;
    let mut repeat = 1;
    let mut outline = false;
    let mut ib = None;
    let mut io = None;
    let mut aw = None;
    let mut spread = None;
    for arg in std::env::args().skip(1) {
        let Some((k, v)) = arg.split_once('=') else {
            names.push(arg);
            continue;
        };
        match k {
            "n" => n = v.parse().unwrap(),
            "base" => base = v.parse().unwrap(),
            "v" => verbose = true,
            "starts" => config.starts = v.parse().unwrap(),
            "sample" => config.sample = v.parse().unwrap(),
            "aw" => {
                config.area_weight = v.parse().unwrap();
                aw = Some(config.area_weight);
            }
            "spread" => spread = v.parse().ok(),
            "inft" => config.inflation_thin = v.parse().unwrap(),
            "inf" => config.inflation = v.parse().unwrap(),
            "ib" => ib = v.parse().ok(),
            "io" => io = v.parse().ok(),
            "outline" => outline = true,
            "repeat" => repeat = v.parse().unwrap(),
            "scale" => scale = v.parse().unwrap(),
            _ => panic!("{k}"),
        }
    }
    let wanted = |name: &str| names.is_empty() || names.iter().any(|x| name.starts_with(x.as_str()));
    let half = SurfaceFamily { coverage: (0.5, 0.5), outliers: (0.0, 0.3), aspect: (1.0, 4.0), ..SURFACE };
    let families = [
        SURFACE,
        SurfaceFamily { box_scale: (1.25, 1.25), ..SURFACE }.named("s.tight"),
        SurfaceFamily { box_scale: (2.0, 4.0), ..SURFACE }.named("s.wide"),
        SurfaceFamily { body: Body::EllipsoidByDirection, ..SURFACE }.named("s.direction"),
        SurfaceFamily { outliers: (0.6, 0.6), ..SURFACE }.named("s.out60"),
        SurfaceFamily { noise: (0.1, 0.1), ..SURFACE }.named("s.noise10"),
        SurfaceFamily { aspect: (10.0, 10.0), ..SURFACE }.named("s.aspect10"),
        SurfaceFamily { point_count: 300, ..SURFACE }.named("s.few"),
        SurfaceFamily { noise: (0.0, 0.001), ..SURFACE }.named("s.clean"),
        SurfaceFamily { outliers: (0.0, 0.0), ..SURFACE }.named("s.zero"),
        CLUTTERED,
        SurfaceFamily { plane: (0.6, 0.9), ..CLUTTERED }.named("clutter.dense"),
        SurfaceFamily { coverage: (0.7, 0.9), outliers: (0.0, 0.4), aspect: (1.0, 4.0), ..SURFACE }
            .named("cov80"),
        half.named("n.half"),
        SurfaceFamily { body: Body::Plane, ..half }.named("n.plane"),
        SurfaceFamily { body: Body::Pipe, coverage: (1.0, 1.0), ..half }.named("n.pipe"),
        SurfaceFamily { body: Body::Cylinder, coverage: (1.0, 1.0), ..half }.named("n.cylinder"),
        SurfaceFamily { body: Body::Box, coverage: (1.0, 1.0), ..half }.named("n.box"),
        SurfaceFamily { body: Body::Clutter, coverage: (1.0, 1.0), ..half }.named("n.clutter"),
    ];
    for family in families.iter().filter(|f| wanted(f.name)) {
        let rows: Vec<Row> = (0..n)
            .into_par_iter()
            .map_init(
                || Box::new(Workspace::<16384>::new()),
                |w, k| {
                    let seed = base + k;
                    let mut cloud = family.cloud(seed);
                    for p in &mut cloud.points {
                        *p *= scale;
                    }
                    let clock = cpu_ns();
                    let mut found = search(&View::from(cloud.points.as_slice()), &config, seed, w);
                    for _ in 1..repeat {
                        found = search(&View::from(cloud.points.as_slice()), &config, seed, w);
                    }
                    let us = (cpu_ns() - clock) * 1e-3 / f64::from(repeat);
                    if let Ok(s) = &mut found {
                        s.ellipsoid.centre /= scale;
                        s.ellipsoid.semi_axes = s.ellipsoid.semi_axes.map(|a| a / scale);
                        s.covariance = s.covariance.filter(|_| scale == 1.0);
                    }
                    judge(
                        seed,
                        &cloud.truth,
                        found,
                        us,
                        format!(
                            "noise {:.2} out {:.2} axes {:.1?}",
                            cloud.sigma, cloud.outliers, cloud.truth.semi_axes_mm
                        ),
                    )
                },
            )
            .collect();
        report(family.name, &rows, verbose);
    }
    let mut view = MixtureConfig { starts: config.starts, sample: config.sample, ..MixtureConfig::VIEW };
    if let Some(w) = aw {
        view.area_weight = w;
    }
    if let Some(w) = spread {
        view.shape_spread = w;
    }
    if let Some(x) = ib {
        view.inflation = x;
    }
    if let Some(x) = io {
        view.inflation_outliers = x;
    }
    let one = |f: &onesided::Family, name| onesided::Family { name, neighbour: 0.0, ..*f };
    for family in [
        onesided::CLEAN,
        one(&onesided::HARD, "o.hard1"),
        one(&onesided::OCCLUDED, "o.occluded"),
        one(
            &onesided::Family {
                clutter: (0.0, 0.0),
                margin_px: (0.0, 0.0),
                axial_mm: (0.5, 1.5),
                quantum_mm: 1.0,
                ..onesided::CLEAN
            },
            "o.noisy",
        ),
        onesided::HARD,
    ] {
        let name = if family.name.starts_with("o.") {
            family.name.to_string()
        } else {
            format!("o.{}", family.name)
        };
        if !wanted(&name) {
            continue;
        }
        let rows: Vec<Row> = (0..n)
            .into_par_iter()
            .map_init(
                || Box::new(Workspace::<16384>::new()),
                |w, k| {
                    let seed = base + k;
                    let scene = onesided::Scene::new(&family, seed);
                    let (points, points_in) = scene.cloud(&scene.mask);
                    let cloud: Vec<Point3> = points.iter().map(|q| Point3::new(q[0], q[1], q[2])).collect();
                    let win = scene.patch.window;
                    let f = scene.sensor.focal_px;
                    let rays = if outline {
                        outline_rays(
                            &scene.patch.depth,
                            (0..=scene.mask.width as i64 - 1, 0..=scene.mask.height as i64 - 1),
                            |u, v| scene.mask.get(u, v).is_some_and(|label| label > 0),
                            f,
                            |u, v| [(win.left as f64 + u) / f, (win.top as f64 + v) / f],
                            10.0,
                        )
                    } else {
                        vec![]
                    };
                    let seen = View { cloud: &cloud, in_mask: points_in, outline: &rays, pitch_rad: 0.0 };
                    let t = scene.fruit[0];
                    let truth = EllipsoidF64::sorted(t.pose.centre, t.semi_axes_mm, t.pose.axes);
                    let clock = cpu_ns();
                    let mut found = search(&seen, &view, seed, w);
                    for _ in 1..repeat {
                        found = search(&seen, &view, seed, w);
                    }
                    let us = (cpu_ns() - clock) * 1e-3 / f64::from(repeat);
                    judge(
                        seed,
                        &truth,
                        found,
                        us,
                        format!(
                            "n {} noise {:.2} axes {:.1?}",
                            cloud.len(),
                            scene.sensor.axial_mm,
                            truth.semi_axes_mm
                        ),
                    )
                },
            )
            .collect();
        report(&name, &rows, verbose);
    }
    for sigma in [0.02, 0.05, 0.1] {
        let name = format!("paper{sigma}");
        if !wanted(&name) {
            continue;
        }
        let rows: Vec<Row> = (0..n)
            .into_par_iter()
            .map_init(
                || Box::new(Workspace::<16384>::new()),
                |w, k| {
                    let seed = base + k;
                    let sim = simulate(&SimulationOptions {
                        seed,
                        point_count: 2000,
                        sigma,
                        ..SimulationOptions::default()
                    })
                    .unwrap();
                    let clock = cpu_ns();
                    let found = search(&View::from(sim.points.as_slice()), &config, seed, w);
                    let us = (cpu_ns() - clock) * 1e-3;
                    judge(seed, &sim.truth, found, us, String::new())
                },
            )
            .collect();
        report(&name, &rows, verbose);
    }
}

fn cpu_ns() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|s| s.split(' ').next()?.parse().ok())
        .unwrap_or(0.0)
}
