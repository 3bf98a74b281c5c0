//! Measures the default search on seeded one-sided views.
use rayon::prelude::*;
use std::time::Instant;
use varsac_core::hypothesis::{SAMPLE, hypothesis};
use varsac_core::kdtree;
use varsac_core::prior::{SizePrior, SizeTerm};
use varsac_core::refine::{Estimate, Normal};
use varsac_core::residual::{Noise, RayModel};
use varsac_core::rng::Stream;
use varsac_core::visibility::{self, Evidence, Support, judge, support};
use varsac_core::Point3;
use varsac_host::synth::onesided::*;
use varsac_host::synth::shapes::{dot, length, minus};

#[derive(Clone, Copy)]
pub struct P {
    hyp: usize, radius: f32, steps: usize, keep: usize, rsteps: usize, window: f32, fsteps: usize, noise: Noise, reach: f32,
    mu: f32, oracle: usize, gam: f32, fs: f32, fsl: f32,
    fprune: usize,
}
impl Default for P {
    fn default() -> Self {
        P { hyp: 60, radius: 20.0, steps: 4, keep: 5, rsteps: 12, window: 8.0, fsteps: 8, noise: Noise { axial_mm: 1.0, lateral_rad: 0.001 }, reach: 27.0, mu: 2.0, oracle: 0, gam: 1e9, fs: 0.0, fsl: 1.0, fprune: 0 }
    }
}
struct Found { est: Estimate, support: Support, second: f32 }

fn refine(cloud: &[Point3], members: &[u16], start: Estimate, prior: &SizeTerm, noise: &Noise, steps: usize, window: f32, mu: f32, tukey: bool, p: &P) -> Option<Estimate> {
    let mut e = start;
    for _ in 0..steps {
        let model = RayModel::new(&e.ellipsoid(), noise);
        let mut normal = Normal::ZERO;
        normal.add_prior(prior, &e.ln_axes);
        for &i in members {
            let mut c = model.contact(&cloud[i as usize]);
            let mut weight = 1.0;
            let range = e.centre[2];
            let mut g2 = c.gap * range / p.gam; g2 *= g2;
            if c.gap > window || c.gap < -window {
                if p.fs > 0.0 && c.gap > window && c.miss_squared < 1.0 { c = model.passing(&cloud[i as usize]); c.variance *= p.fsl * p.fsl; weight = p.fs; g2 = 0.0; }
                else { continue; } }
            let f2 = c.value * c.value / c.variance + g2;
            let w = if tukey {
                let k = f2 / (mu * mu); if k >= 1.0 { continue } else { (1.0 - k) * (1.0 - k) }
            } else { let k = 1.0 + f2 / (mu * mu); 1.0 / (k * k) };
            normal.add_contact(&model, &c, w * weight);
        }
        let n = e.step(&normal)?;
        e = n;
    }
    Some(e)
}

fn search(cloud: &[Point3], order: &[u16], live: &[u16], prior: &SizeTerm, p: &P, stream: &mut Stream) -> Option<Found> {
    let mut members = vec![0u16; cloud.len()];
    let mut kept: Vec<(Estimate, Support)> = vec![];
    for _ in 0..p.hyp {
        let s = live[stream.below(live.len() as u32) as usize];
        let seed = cloud[s as usize];
        let n = kdtree::within(cloud, order, &seed, p.radius, &mut members);
        let mut sample = [0u16; SAMPLE];
        if !stream.sample(n as u32, &mut sample) { continue; }
        for i in &mut sample { *i = members[*i as usize]; }
        let Some(e) = hypothesis(cloud, &sample, &seed, prior, &p.noise, p.steps) else { continue };
        let Some(sc) = score(cloud, order, &e, p, prior, &mut members, f32::NEG_INFINITY) else { continue };
        insert(&mut kept, e, sc, p.keep);
    }
    let mut best: Option<(Estimate, Support)> = None;
    let mut all = vec![];
    for (e, _) in kept {
        let c = Point3::new(e.centre[0], e.centre[1], e.centre[2]);
        let n = kdtree::within(cloud, order, &c, p.reach, &mut members);
        let win = p.window / length(e.centre.map(f64::from)) as f32;
        let Some(e) = refine(cloud, &members[..n], e, prior, &p.noise, p.rsteps, win * 2.0, p.mu, false, p) else { continue };
        let Some(sc) = score(cloud, order, &e, p, prior, &mut members, f32::NEG_INFINITY) else { continue };
        all.push((e, sc));
        if best.is_none_or(|(_, b)| sc.score > b.score) { best = Some((e, sc)); }
    }
    let (e, sc) = best?;
    let second = all.iter().filter(|(o, _)| { let d = length(minus(o.centre.map(f64::from), e.centre.map(f64::from))); d > 3.0 && d < 18.0 }).map(|(_, s)| s.score).fold(0.0, f32::max);
    // final
    let c = Point3::new(e.centre[0], e.centre[1], e.centre[2]);
    let n = kdtree::within(cloud, order, &c, p.reach, &mut members);
    let win = p.window / length(e.centre.map(f64::from)) as f32;
    let model = RayModel::new(&e.ellipsoid(), &p.noise);
    let mut f: Vec<f32> = members[..n].iter().filter_map(|&i| { let c = model.contact(&cloud[i as usize]); match judge(&c, win) { Evidence::Explained(s) => Some(s), _ => None } }).collect();
    f.sort_by(f32::total_cmp);
    let med = if f.is_empty() { 1.0 } else { f[f.len() / 2] };
    let scale = (med.sqrt() / 0.6745 * 1.05).clamp(0.35, 2.0);
    let noise = Noise { axial_mm: p.noise.axial_mm * scale, lateral_rad: p.noise.lateral_rad * scale };
    let e = refine(cloud, &members[..n], e, prior, &noise, p.fsteps, win, 4.0, true, p).unwrap_or(e);
    Some(Found { est: e, support: sc, second })
}
fn score(cloud: &[Point3], order: &[u16], e: &Estimate, p: &P, prior: &SizeTerm, members: &mut [u16], floor: f32) -> Option<Support> {
    let c = Point3::new(e.centre[0], e.centre[1], e.centre[2]);
    let n = kdtree::within(cloud, order, &c, p.reach, members);
    let model = RayModel::new(&e.ellipsoid(), &p.noise);
    let win = p.window / length(e.centre.map(f64::from)) as f32;
    let mut s = support(cloud, &members[..n], &model, win, floor)?;
    s.score -= prior.cost(&e.ln_axes) / visibility::CUT;
    Some(s)
}
fn insert(kept: &mut Vec<(Estimate, Support)>, e: Estimate, s: Support, keep: usize) {
    // distinct: centres further than 4 mm or axes differ by > 20 deg
    let near = |o: &Estimate| {
        let d = length(minus(o.centre.map(f64::from), e.centre.map(f64::from)));
        let a = axis_angle_deg(o.axes[0].map(f64::from), e.axes[0].map(f64::from));
        d < 3.0 && a < 20.0
    };
    if let Some(k) = kept.iter().position(|(o, _)| near(o)) {
        if kept[k].1.score < s.score { kept[k] = (e, s); }
    } else { kept.push((e, s)); }
    kept.sort_by(|a, b| b.1.score.total_cmp(&a.1.score));
    kept.truncate(keep);
}

#[derive(Clone, Default)]
struct Row { found: bool, centre: f64, rms_c: f64, rms_s: f64, axis: f64, outliers: f64, points: usize, ms: f64, start: f64, dz: f64, da: f64, db: f64, dc: f64 }

fn run(family: &Family, seed: u64, p: &P, prior: &SizeTerm) -> Row {
    let scene = Scene::new(family, seed);
    let mask = scene.mask.clone();
    let (points, _inside) = scene.cloud(&mask);
    let cloud: Vec<Point3> = points.iter().map(|q| Point3::new(q[0], q[1], q[2])).collect();
    let Some(truth) = scene.fruit.first() else { return Row::default() };
    let on = points.iter().filter(|q| { let o = minus(q.map(f64::from), truth.pose.centre); let s: f64 = (0..3).map(|k| (dot(truth.pose.axes[k], o) / truth.semi_axes_mm[k]).powi(2)).sum(); s.sqrt() < 1.25 && s.sqrt() > 0.75 }).count();
    let clock = Instant::now();
    let mut order: Vec<u16> = (0..cloud.len() as u16).collect();
    kdtree::build(&cloud, &mut order);
    let mut live: Vec<u16> = (0..cloud.len() as u16).collect();
    let mut stream = Stream::new(seed);
    let mut best: Option<Found> = None;
    let mut bd = 1e9;
    if p.oracle > 0 {
        let e = Estimate { centre: truth.pose.centre.map(|x| x as f32), axes: truth.pose.axes.map(|a| a.map(|x| x as f32)), ln_axes: truth.semi_axes_mm.map(|x| (x as f32).ln()) };
        let mem: Vec<u16> = if p.oracle == 1 { live.clone() } else {
            live.iter().copied().filter(|&i| { let q = points[i as usize]; let w = &scene.patch.window; let u = (q[0] / q[2] * 365.456).round() as i64 - w.left; let v = (q[1] / q[2] * 365.456).round() as i64 - w.top; scene.patch.owner.get(u, v) == Some(1) }).collect() };
        let noise = if p.oracle == 3 { Noise { axial_mm: scene.sensor.axial_mm as f32, lateral_rad: (scene.sensor.lateral_px as f32 + 0.1) / 365.0 } } else { p.noise };
        let e = refine(&cloud, &mem, e, prior, &noise, 15, p.window / e.centre[2], if p.oracle == 1 { p.mu } else { 6.0 }, p.oracle != 1, p).unwrap();
        best = Some(Found { est: e, support: Support::default(), second: 0.0 });
    } else { for t in 0..scene.fruit.len() {
        let mut o2 = live.clone();
        kdtree::build(&cloud, &mut o2);
        if live.len() < 20 { break; }
        let Some(f) = search(&cloud, &o2, &live, prior, p, &mut stream) else { break };
        let d = length(minus(f.est.centre.map(f64::from), truth.pose.centre));
        let model = RayModel::new(&f.est.ellipsoid(), &p.noise);
        live.retain(|&i| !matches!(judge(&model.contact(&cloud[i as usize]), 0.02), Evidence::Explained(_)));
        if d < bd { bd = d; best = Some(f); }
        let _ = t;
    } }
    let ms = clock.elapsed().as_secs_f64() * 1e3 / scene.fruit.len() as f64;
    let Some(f) = best else { return Row { outliers: 1.0 - on as f64 / points.len().max(1) as f64, points: points.len(), ms, ..Row::default() } };
    let e = f.est;
    let mut c = minus(e.centre.map(f64::from), truth.pose.centre);
    let centre = length(c);
    for x in &mut c { *x = x.abs(); }
    let mut s: Vec<f64> = e.ln_axes.iter().map(|&l| f64::from(l).exp()).collect();
    s.sort_by(|a, b| b.total_cmp(a));
    let mut t = truth.semi_axes_mm; t.sort_by(|a, b| b.total_cmp(a));
    let rs = (0..3).map(|k| (s[k] - t[k]).abs()).sum::<f64>() / 3.0;
    let raw = minus(e.centre.map(f64::from), truth.pose.centre);
    let dz = dot(raw, truth.pose.centre) / length(truth.pose.centre);
    let axis = axis_angle_deg(e.axes[0].map(f64::from), truth.pose.axes[0]);
    Row { found: true, centre, rms_c: (c[0] + c[1] + c[2]) / 3.0, rms_s: rs, axis, outliers: 1.0 - on as f64 / points.len() as f64, points: points.len(), ms, start: 0.0, dz, da: s[0] - t[0], db: s[1] - t[1], dc: s[2] - t[2] }
}

fn quantile(v: &mut Vec<f64>, q: f64) -> f64 { if v.is_empty() { return f64::NAN } v.sort_by(f64::total_cmp); v[((v.len() - 1) as f64 * q) as usize] }

fn report(family: &Family, n: u64, p: &P, prior: &SizeTerm, base: u64) {
    let rows: Vec<Row> = (0..n).into_par_iter().map(|s| run(family, base + s, p, prior)).collect();
    let found: Vec<&Row> = rows.iter().filter(|r| r.found).collect();
    let good: Vec<&&Row> = found.iter().filter(|r| r.centre < 5.0).collect();
    let rms = |f: &dyn Fn(&Row) -> f64| (good.iter().map(|r| f(r) * f(r)).sum::<f64>() / good.len() as f64).sqrt();
    let mut c: Vec<f64> = found.iter().map(|r| r.centre).collect();
    let mut a: Vec<f64> = found.iter().map(|r| r.axis).collect();
    let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(f).sum::<f64>() / rows.len() as f64;
    let gm = |f: &dyn Fn(&Row) -> f64| good.iter().map(|r| f(r)).sum::<f64>() / good.len() as f64;
    println!("   bias dz {:.3} da {:.3} db {:.3} dc {:.3}  rms dz {:.3} da {:.3} db {:.3} dc {:.3}", gm(&|r| r.dz), gm(&|r| r.da), gm(&|r| r.db), gm(&|r| r.dc), rms(&|r| r.dz), rms(&|r| r.da), rms(&|r| r.db), rms(&|r| r.dc));
    println!("{:10} n {:5} <5mm {:.3} | rmsc {:.3} rmss {:.3} rmsaxis {:.2} | centre {:.2}/{:.2} p99 {:.2} axis {:.2}/{:.2} | out {:.2} pts {:.0} ms {:.2}",
        family.name, n, good.len() as f64 / rows.len() as f64, rms(&|r| r.rms_c), rms(&|r| r.rms_s), rms(&|r| r.axis),
        quantile(&mut c, 0.5), quantile(&mut c, 0.9), quantile(&mut c, 0.99), quantile(&mut a, 0.5), quantile(&mut a, 0.9), mean(&|r| r.outliers), mean(&|r| r.points as f64), mean(&|r| r.ms));
}

fn main() {
    let mut p = P::default();
    let mut n = 1000;
    let mut base = 0;
    let mut names: Vec<String> = vec![];
    for arg in std::env::args().skip(1) {
        if let Some((k, v)) = arg.split_once('=') {
            match k {
                "n" => n = v.parse().unwrap(),
                "base" => base = v.parse().unwrap(),
                "gam" => p.gam = v.parse().unwrap(), "fs" => p.fs = v.parse().unwrap(), "fsl" => p.fsl = v.parse().unwrap(),
                "oracle" => p.oracle = v.parse().unwrap(),
                "hyp" => p.hyp = v.parse().unwrap(),
                "radius" => p.radius = v.parse().unwrap(),
                "steps" => p.steps = v.parse().unwrap(),
                "keep" => p.keep = v.parse().unwrap(),
                "rsteps" => p.rsteps = v.parse().unwrap(),
                "fsteps" => p.fsteps = v.parse().unwrap(),
                "window" => p.window = v.parse().unwrap(),
                "reach" => p.reach = v.parse().unwrap(),
                "mu" => p.mu = v.parse().unwrap(),
                "ax" => p.noise.axial_mm = v.parse().unwrap(),
                "lat" => p.noise.lateral_rad = v.parse().unwrap(),
                _ => panic!("{k}"),
            }
        } else { names.push(arg); }
    }
    let prior = SizePrior::JUJUBE.term();
    let hard3 = Family { name: "hard3", rays: 3, ..HARD };
    let clean3 = Family { name: "clean3", rays: 3, ..CLEAN };
    let orch3 = Family { name: "orch3", rays: 3, ..ORCHARD };
    for f in [CLEAN, clean3, HARD, hard3, OCCLUDED, ORCHARD, orch3] {
        if names.is_empty() || names.iter().any(|x| x == f.name) { report(&f, n, &p, &prior, base); }
    }
}
