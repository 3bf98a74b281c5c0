//! Measures the default search on seeded one-sided views.
use rayon::prelude::*;
use varsac_core::SizePrior;
use varsac_core::{Config, Detection, Detector, Point3, Status, View, Workspace};
use varsac_core::{Refusal, RefusalCode};
use varsac_host::outline::outline_rays;
use varsac_host::synth::onesided::shapes::{V3, dot, length, minus};
use varsac_host::synth::onesided::*;

#[derive(Clone)]
struct Setup {
    config: Config,
    outline: bool,
    n: u64,
    base: u64,
    mask_grow: i64,
    mask_shift: (i64, i64),
    repeat: u32,
    dump: bool,
    targets: Option<u8>,
    thin: usize,
    csv: bool,
    export: Option<String>,
}

#[derive(Clone, Default)]
struct Row {
    found: bool,
    centre: f64,
    rms_c: f64,
    rms_s: f64,
    axis: f64,
    outliers: f64,
    points: usize,
    us: f64,
    accepted: bool,
    maha: f64,
    maha_s: f64,
    maha_r: f64,
    code: Option<RefusalCode>,
    false_accepts: u32,
    detections: u32,
    wrong_accepts: u32,
    dz: f64,
    ds: V3,
    seed: u64,
    visible: f64,
    short: f64,
    rays: usize,
    accepted_total: u32,
    dist: f64,
}

fn errors(d: &Detection, t: &Truth) -> (f64, V3) {
    let c = [d.ellipsoid.centre.x, d.ellipsoid.centre.y, d.ellipsoid.centre.z].map(f64::from);
    let e = minus(c, t.pose.centre);
    (length(e), e)
}

/// x^T C^-1 x for a 3x3 block.
fn mahalanobis(cov: &[[f32; 9]; 9], at: usize, x: V3) -> f64 {
    let m = nalgebra::Matrix3::from_fn(|i, j| f64::from(cov[at + i][at + j]));
    let v = nalgebra::Vector3::from(x);
    m.try_inverse().map_or(f64::NAN, |inv| (v.transpose() * inv * v)[0])
}

fn run(family: &Family, seed: u64, s: &Setup, detector: &Detector) -> Row {
    let scene = Scene::new(family, seed);
    let mask = scene.mask_with(s.mask_grow, s.mask_shift);
    let (points, in_mask) = scene.cloud(&mask);
    let cloud: Vec<Point3> = points.iter().map(|q| Point3::new(q[0], q[1], q[2])).collect();
    let w = scene.patch.window;
    let f = scene.sensor.focal_px;
    let mut outline = if s.outline {
        outline_rays(
            &scene.patch.depth,
            (0..=mask.width as i64, 0..=mask.height as i64),
            |u, v| mask.get(u, v).is_some_and(|x| x > 0),
            f,
            |u, v| [(w.left as f64 + u) / f, (w.top as f64 + v) / f],
            10.0,
        )
    } else {
        vec![]
    };
    if s.thin > 0 && outline.len() > s.thin {
        let n = outline.len();
        outline = (0..s.thin).map(|k| outline[k * n / s.thin]).collect();
    }
    let view = View {
        cloud: &cloud,
        in_mask: if s.outline { in_mask } else { cloud.len() },
        outline: &outline,
        pitch_rad: (1.0 / f) as f32,
    };
    if let Some(path) = &s.export {
        use std::io::Write;
        let mut file = std::fs::OpenOptions::new().append(true).create(true).open(path).unwrap();
        let mut bytes: Vec<u8> = vec![];
        bytes.extend((cloud.len() as u32).to_le_bytes());
        bytes.extend((view.in_mask as u32).to_le_bytes());
        for q in &cloud {
            for x in [q.x, q.y, q.z] {
                bytes.extend(x.to_le_bytes());
            }
        }
        bytes.extend((outline.len() as u32).to_le_bytes());
        for o in &outline {
            for x in [o.inner.x, o.inner.y, o.inner.z, o.outer_mm, o.sigma_rad] {
                bytes.extend(x.to_le_bytes());
            }
        }
        file.write_all(&bytes).unwrap();
    }
    let mut workspace = Box::new(Workspace::<8192>::new());
    let mut detections: Vec<Detection> = vec![];
    let clock = cpu_ns();
    for _ in 0..s.repeat {
        detections = detector.detect_view(&view, workspace.scratch(), seed).unwrap().collect();
    }
    let us = (cpu_ns() - clock) * 1e-3 / f64::from(s.repeat);
    let mut row = Row {
        points: points.len(),
        us: us / detections.len().max(1) as f64,
        detections: detections.len() as u32,
        seed,
        rays: outline.len(),
        ..Row::default()
    };
    let accepted = |d: &&Detection| matches!(d.status, Status::Accepted);
    row.accepted_total = detections.iter().filter(accepted).count() as u32;
    // an accepted detection is right if within 5 mm of some true fruit
    for d in detections.iter().filter(accepted) {
        if !scene.fruit.iter().any(|t| errors(d, t).0 < 5.0) {
            row.wrong_accepts += 1;
        }
    }
    if s.csv {
        for d in &detections {
            let Some(f) = d.findings else { continue };
            let best = scene.fruit.iter().map(|t| (errors(d, t), t)).min_by(|a, b| a.0.0.total_cmp(&b.0.0));
            let (err, e, t) = best.map_or((999.0, [0.0; 3], None), |((err, e), t)| (err, e, Some(t)));
            let m = d.covariance.map_or(-1.0, |c| mahalanobis(&c.rows(), 0, e));
            let (mut ms, mut vis, mut ax) = (-1.0, 0.0, 0.0);
            if let Some(t) = t {
                vis = t.visible;
                ax = axis_angle_deg(d.ellipsoid.axes[0].map(f64::from), t.pose.axes[0]);
                let mut tt = t.semi_axes_mm;
                tt.sort_by(|a, b| b.total_cmp(a));
                let ds: V3 = core::array::from_fn(|k| f64::from(d.ellipsoid.semi_axes[k]) - tt[k]);
                ms = d.covariance.map_or(-1.0, |c| mahalanobis(&c.rows(), 3, ds));
            }
            let z = f64::from(d.ellipsoid.centre.z);
            println!(
                "CSV,{},{seed},{err:.3},{ax:.2},{vis:.3},{z:.0},{:.2},{},{},{:.3},{:.4},{},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.3},{:.2}",
                family.name,
                scene.sensor.axial_mm,
                f.explained,
                f.through,
                f.size_conflict,
                f.rival,
                f.outline_rays,
                f.outline,
                f.visible,
                f.colour,
                f.sigma_mm,
                f.flat,
                f.size_sigma,
                m,
                ms,
                f.clutter
            );
        }
    }
    if s.dump && scene.fruit.is_empty() {
        if let Some(d) = detections.iter().find(|d| d.status == Status::Accepted) {
            println!("seed {seed} {:?} {:?} {:?}", scene.bodies[0].shape, d.ellipsoid, d.findings);
        }
    }
    let Some(truth) = scene.fruit.first() else {
        row.false_accepts = row.accepted_total;
        return row;
    };
    row.visible = truth.visible;
    row.dist = length(truth.pose.centre);
    let on = points
        .iter()
        .filter(|q| {
            let o = minus(q.map(f64::from), truth.pose.centre);
            let l: f64 = (0..3).map(|k| (dot(truth.pose.axes[k], o) / truth.semi_axes_mm[k]).powi(2)).sum();
            (l.sqrt() - 1.0).abs() < 0.25
        })
        .count();
    row.outliers = 1.0 - on as f64 / points.len().max(1) as f64;
    let Some(d) = detections.iter().min_by(|a, b| errors(a, truth).0.total_cmp(&errors(b, truth).0)) else {
        return row;
    };
    row.found = true;
    let (centre, e) = errors(d, truth);
    row.centre = centre;
    row.rms_c = (e[0].abs() + e[1].abs() + e[2].abs()) / 3.0;
    row.dz = dot(e, truth.pose.centre) / length(truth.pose.centre);
    let mut t = truth.semi_axes_mm;
    t.sort_by(|a, b| b.total_cmp(a));
    row.short = t[2];
    for k in 0..3 {
        row.ds[k] = f64::from(d.ellipsoid.semi_axes[k]) - t[k];
    }
    row.rms_s = row.ds.iter().map(|x| x.abs()).sum::<f64>() / 3.0;
    row.axis = axis_angle_deg(d.ellipsoid.axes[0].map(f64::from), truth.pose.axes[0]);
    row.accepted = matches!(d.status, Status::Accepted);
    if let Status::Refused(Refusal { code, .. }) = d.status {
        row.code = Some(code);
    }
    if let Some(c) = &d.covariance {
        let r = c.rows();
        row.maha = mahalanobis(&r, 0, e);
        row.maha_s = mahalanobis(&r, 3, row.ds);
        let a = d.ellipsoid.axes[0].map(f64::from);
        let mut ta = truth.pose.axes[0];
        if dot(a, ta) < 0.0 {
            ta = ta.map(|x| -x);
        }
        // long axis: project rotation covariance perpendicular to a: 2-dof test in the plane b, c
        let (b, cc) = (d.ellipsoid.axes[1].map(f64::from), d.ellipsoid.axes[2].map(f64::from));
        // a turned by w: a + w x a ; component along b: w.(a x b) = w.c ; along c: w.(a x c) = -w.b
        let rot = nalgebra::Matrix3::from_fn(|i, j| f64::from(r[6 + i][6 + j]));
        let (vb, vc) = (nalgebra::Vector3::from(cc), -nalgebra::Vector3::from(b));
        let m = nalgebra::Matrix2::new(
            (vb.transpose() * rot * vb)[0],
            (vb.transpose() * rot * vc)[0],
            (vc.transpose() * rot * vb)[0],
            (vc.transpose() * rot * vc)[0],
        );
        let x = nalgebra::Vector2::new(dot(ta, b), dot(ta, cc));
        row.maha_r = m.try_inverse().map_or(f64::NAN, |inv| (x.transpose() * inv * x)[0]);
    }
    if s.dump && (row.centre > 5.0 || !row.accepted) {
        println!(
            "seed {seed} centre {:.1} axis {:.1} vis {:.2} z {:.0} pts {} rays {} {:?} {:?}",
            row.centre, row.axis, row.visible, row.dist, row.points, row.rays, d.status, d.findings
        );
    }
    row
}

/// CPU time of this thread, ns: waiting for a busy machine does not count.
fn cpu_ns() -> f64 {
    std::fs::read_to_string("/proc/thread-self/schedstat")
        .ok()
        .and_then(|s| s.split(' ').next()?.parse().ok())
        .unwrap_or(0.0)
}

fn quantile(v: &mut [f64], q: f64) -> f64 {
    if v.is_empty() {
        return f64::NAN;
    }
    v.sort_by(f64::total_cmp);
    v[((v.len() - 1) as f64 * q) as usize]
}

fn report(family: &Family, s: &Setup) {
    let mut config = s.config.clone();
    config.max_targets = s.targets.unwrap_or(if family.neighbour > 0.0 { 2 } else { 1 });
    config.max_failures = 1;
    let detector = Detector::new(config).unwrap();
    let rows: Vec<Row> = (0..s.n).into_par_iter().map(|k| run(family, s.base + k, s, &detector)).collect();
    let n = rows.len() as f64;
    let accepted_all: u32 = rows.iter().map(|r| r.accepted_total).sum();
    let wrong: u32 = rows.iter().map(|r| r.wrong_accepts).sum();
    let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(f).sum::<f64>() / n;
    let t: Vec<f64> = rows.iter().map(|r| r.us).collect();
    if rows.iter().all(|r| r.visible == 0.0) {
        let fa = rows.iter().filter(|r| r.false_accepts > 0).count();
        println!(
            "{:12} decoys n {n:5} accepted {:.4} | pts {:.0} us {:.0}",
            family.name,
            fa as f64 / n,
            mean(&|r| r.points as f64),
            t.iter().sum::<f64>() / n
        );
        return;
    }
    let found: Vec<&Row> = rows.iter().filter(|r| r.found).collect();
    let good: Vec<&&Row> = found.iter().filter(|r| r.centre < 5.0).collect();
    let g = good.len() as f64;
    let rms = |f: &dyn Fn(&Row) -> f64| (good.iter().map(|r| f(r) * f(r)).sum::<f64>() / g).sqrt();
    let gm = |f: &dyn Fn(&Row) -> f64| good.iter().map(|r| f(r)).sum::<f64>() / g;
    let mut c: Vec<f64> = found.iter().map(|r| r.centre).collect();
    let mut a: Vec<f64> = found.iter().map(|r| r.axis).collect();
    let acc: Vec<&&Row> = found.iter().filter(|r| r.accepted).collect();
    let cover = |f: &dyn Fn(&Row) -> f64, lim: f64| {
        acc.iter().filter(|r| f(r) < lim).count() as f64 / acc.len().max(1) as f64
    };
    let bad = found.iter().filter(|r| r.centre > r.short).count();
    println!(
        "{:12} n {n:5} <5mm {:.4} >short {:.4} | rmsc {:.3} rmss {:.3} rmsax {:.2} | centre {:.2}/{:.2}/{:.2} axis {:.2}/{:.2} | acc {:.3} wrong {:.4} ({wrong}/{accepted_all}) cov c {:.3} s {:.3} ax {:.3}",
        family.name,
        g / n,
        bad as f64 / n,
        rms(&|r| r.rms_c),
        rms(&|r| r.rms_s),
        rms(&|r| r.axis),
        quantile(&mut c, 0.5),
        quantile(&mut c, 0.9),
        quantile(&mut c, 0.99),
        quantile(&mut a, 0.5),
        quantile(&mut a, 0.9),
        acc.len() as f64 / n,
        f64::from(wrong) / f64::from(accepted_all.max(1)),
        cover(&|r| r.maha, 7.815),
        cover(&|r| r.maha_s, 7.815),
        cover(&|r| r.maha_r, 5.991)
    );
    let mut codes = std::collections::BTreeMap::new();
    for r in found.iter().filter_map(|r| r.code) {
        *codes.entry(format!("{r:?}")).or_insert(0) += 1;
    }
    println!(
        "      bias dz {:.2} ds {:.2} {:.2} {:.2} | out {:.2} pts {:.0} rays {:.0} us {:.0} | {:?}",
        gm(&|r| r.dz),
        gm(&|r| r.ds[0]),
        gm(&|r| r.ds[1]),
        gm(&|r| r.ds[2]),
        mean(&|r| r.outliers),
        mean(&|r| r.points as f64),
        mean(&|r| r.rays as f64),
        t.iter().sum::<f64>() / n,
        codes
    );
}

fn touching(family: &Family, s: &Setup) {
    let mut config = s.config.clone();
    config.max_targets = s.targets.unwrap_or(8);
    config.max_failures = 1;
    let detector = Detector::new(config).unwrap();
    let results: Vec<_> = (0..s.n)
        .into_par_iter()
        .map(|k| {
            let scene = Scene::new(family, s.base + k);
            let mask = scene.mask_with(s.mask_grow, s.mask_shift);
            let (points, in_mask) = scene.cloud(&mask);
            let cloud: Vec<Point3> = points.iter().map(|q| Point3::new(q[0], q[1], q[2])).collect();
            let w = scene.patch.window;
            let f = scene.sensor.focal_px;
            let outline = if s.outline {
                outline_rays(
                    &scene.patch.depth,
                    (0..=mask.width as i64, 0..=mask.height as i64),
                    |u, v| mask.get(u, v).is_some_and(|x| x > 0),
                    f,
                    |u, v| [(w.left as f64 + u) / f, (w.top as f64 + v) / f],
                    10.0,
                )
            } else {
                vec![]
            };
            let view = View {
                cloud: &cloud,
                in_mask: if s.outline { in_mask } else { cloud.len() },
                outline: &outline,
                pitch_rad: (1.0 / f) as f32,
            };
            let mut workspace = Box::new(Workspace::<8192>::new());
            let clock = cpu_ns();
            let found: Vec<Detection> =
                detector.detect_view(&view, workspace.scratch(), s.base + k).unwrap().collect();
            let us = (cpu_ns() - clock) * 1e-3;
            let fruit: Vec<&Truth> = scene.fruit.iter().filter(|t| t.visible >= 0.4).collect();
            let (mut hit, mut hit_acc, mut wrong, mut false_t, mut acc) = (0, 0, 0, 0, 0);
            let mut errs = vec![];
            let mut codes = vec![];
            for t in &fruit {
                let best = found.iter().map(|d| (errors(d, t).0, d)).min_by(|a, b| a.0.total_cmp(&b.0));
                if let Some((e, d)) = best
                    && e < 5.0
                {
                    hit += 1;
                    errs.push(e);
                    if d.status == Status::Accepted {
                        hit_acc += 1;
                    } else if let Status::Refused(r) = d.status {
                        codes.push(r.code);
                    }
                }
            }
            for d in found.iter().filter(|d| d.status == Status::Accepted) {
                acc += 1;
                let e = scene.fruit.iter().map(|t| errors(d, t).0).fold(f64::INFINITY, f64::min);
                if e > 5.0 {
                    wrong += 1;
                }
                if e > 11.0 {
                    false_t += 1;
                }
            }
            if s.dump && hit_acc < fruit.len() {
                println!(
                    "seed {} fruit {} hit {hit} acc {hit_acc}; found {:?}",
                    s.base + k,
                    fruit.len(),
                    found
                        .iter()
                        .map(|d| (
                            d.score.inliers,
                            d.status,
                            scene.fruit.iter().map(|t| errors(d, t).0 as f32).fold(f32::INFINITY, f32::min)
                        ))
                        .collect::<Vec<_>>()
                );
            }
            (fruit.len(), hit, hit_acc, acc, wrong, false_t, errs, us, codes)
        })
        .collect();
    let sum = |f: &dyn Fn(
        &(usize, usize, usize, usize, usize, usize, Vec<f64>, f64, Vec<RefusalCode>),
    ) -> usize| results.iter().map(f).sum::<usize>() as f64;
    let mut e: Vec<f64> = results.iter().flat_map(|r| r.6.clone()).collect();
    let n = sum(&|r| r.0);
    let mut codes = std::collections::BTreeMap::new();
    for c in results.iter().flat_map(|r| r.8.clone()) {
        *codes.entry(format!("{c:?}")).or_insert(0) += 1;
    }
    println!(
        "{:16} fruit {n} recall {:.4} accepted recall {:.4} | accepted {} wrong {} false {} | centre {:.2}/{:.2} us {:.0} {codes:?}",
        family.name,
        sum(&|r| r.1) / n,
        sum(&|r| r.2) / n,
        sum(&|r| r.3),
        sum(&|r| r.4),
        sum(&|r| r.5),
        quantile(&mut e, 0.5),
        quantile(&mut e, 0.9),
        results.iter().map(|r| r.7).sum::<f64>() / results.len() as f64
    );
}

fn main() {
    let mut s = Setup {
        config: Config::jujube(),
        outline: false,
        n: 1000,
        base: 0,
        mask_grow: 0,
        mask_shift: (0, 0),
        repeat: 1,
        dump: false,
        targets: None,
        thin: 0,
        csv: false,
        export: None,
    };
    let mut names: Vec<String> = vec![];
    for arg in std::env::args().skip(1) {
        let Some((k, v)) = arg.split_once('=') else {
            names.push(arg);
            continue;
        };
        let m = &mut s.config.map;
        let f = || v.parse::<f32>().unwrap();
        let u = || v.parse::<u16>().unwrap();
        match k {
            "n" => s.n = v.parse().unwrap(),
            "base" => s.base = v.parse().unwrap(),
            "outline" => s.outline = u() > 0,
            "grow" => s.mask_grow = v.parse().unwrap(),
            "shift" => s.mask_shift = (v.parse().unwrap(), 0),
            "repeat" => s.repeat = v.parse().unwrap(),
            "dump" => s.dump = true,
            "export" => s.export = Some(v.to_string()),
            "csv" => s.csv = true,
            "targets" => s.targets = Some(u() as u8),
            "thin" => s.thin = v.parse().unwrap(),
            "hyp" => m.hypotheses = u(),
            "hsteps" => m.hypothesis_steps = u() as u8,
            "keep" => m.kept = u() as u8,
            "rsteps" => m.refine_steps = u() as u8,
            "fsteps" => m.final_steps = u() as u8,
            "ax" => m.noise.axial_mm = f(),
            "lat" => m.noise.lateral_rad = f(),
            "off" => m.outline_offset_rad = f() / 365.456,
            "box" => m.boxiness = f(),
            "inf" => m.inflation.base = f(),
            "infc" => m.inflation.per_conflict = f(),
            "infm" => m.inflation.per_clutter = f(),
            "spread" => m.prior = SizePrior { spread: [f(); 3], ..SizePrior::JUJUBE },
            "gunk" => m.gate.size_unknown = f(),
            "gsize" => m.gate.size_conflict = f(),
            "gamb" => m.gate.ambiguous = f(),
            "gout" => m.gate.outline = f(),
            "gvis" => m.gate.visible = f(),
            "gcol" => m.gate.colour = f(),
            "gunc" => m.gate.uncertain_mm = f(),
            "gflat" => m.gate.flat = f(),
            "gthr" => m.gate.through = f(),
            _ => panic!("{k}"),
        }
    }
    for f in [TOUCHING, TOUCHING_LEAVES, Family { name: "touching3", rays: 3, ..TOUCHING }] {
        if names.iter().any(|x| f.name == x) {
            touching(&f, &s);
        }
    }
    let families = [
        CLEAN,
        Family { name: "clean3", rays: 3, ..CLEAN },
        HARD,
        Family { name: "hard3", rays: 3, ..HARD },
        OCCLUDED,
        Family { name: "occluded3", rays: 3, ..OCCLUDED },
        ORCHARD,
        Family { name: "orchard3", rays: 3, ..ORCHARD },
        HARD.of("hard2.5", boxy_jujube(2.5)),
        HARD.of("hard3.0", boxy_jujube(3.0)),
        ORCHARD.of("orch2.5", boxy_jujube(2.5)),
        ORCHARD.of("orch3.0", boxy_jujube(3.0)),
        HARD.of("varied", VARIED_JUJUBE),
        Family { neighbour: 0.0, ..ORCHARD.of("d.ball", Subject::Ball(10.0, 17.0)) },
        Family { neighbour: 0.0, ..ORCHARD.of("d.apple", Subject::Ball(32.0, 42.0)) },
        Family { neighbour: 0.0, ..ORCHARD.of("d.disc", Subject::Disc) },
        Family { neighbour: 0.0, ..ORCHARD.of("d.branch", Subject::Branch(6.0, 12.0)) },
        Family { neighbour: 0.0, ..ORCHARD }.decoy("d.0.7x", scaled_jujube(0.7)),
        Family { neighbour: 0.0, ..ORCHARD }.decoy("d.1.3x", scaled_jujube(1.3)),
    ];
    for f in families {
        if names.is_empty()
            || names
                .iter()
                .any(|x| f.name == x || (x.ends_with('*') && f.name.starts_with(x.trim_end_matches('*'))))
        {
            report(&f, &s);
        }
    }
}
