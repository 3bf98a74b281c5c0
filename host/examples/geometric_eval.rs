//! Fits real recordings and compares with their reference fits.
use varsac_core::geometric::{Criterion, fit};
use varsac_core::mixture::{MixtureConfig, MixtureProgress, MixtureSearch};
use varsac_core::{Point3, View, Workspace, rng::Stream};

fn main() {
    for path in std::env::args().skip(1) {
        let cloud =
            varsac_host::cloud::Cloud::read(path.as_ref(), Some(varsac_host::cloud::Unit::Millimetre))
                .unwrap()
                .points_mm;
        let points: Vec<Point3> = cloud;
        let list: Vec<u16> = (0..points.len() as u16).collect();
        let truth: serde_json::Value = serde_json::from_str(
            &std::fs::read_to_string(std::path::Path::new(&path).with_extension("truth.json")).unwrap(),
        )
        .unwrap();
        for (criterion, name) in [(Criterion::Algebraic, "algebraic"), (Criterion::Geometric, "geometric")] {
            let Ok(f) = fit(&points, &list, criterion) else {
                println!("{path} {name} none");
                continue;
            };
            let r = &truth["reference_fits"][name];
            let axes: Vec<f64> = (0..3).map(|k| r["semiaxes"][k].as_f64().unwrap()).collect();
            let centre: Vec<f64> = (0..3).map(|k| r["center"][k].as_f64().unwrap()).collect();
            let rel: Vec<f64> =
                (0..3).map(|k| (f64::from(f.ellipsoid.semi_axes[k]) / axes[k] - 1.0) * 100.0).collect();
            let c = f.ellipsoid.centre;
            let dc = [f64::from(c.x) - centre[0], f64::from(c.y) - centre[1], f64::from(c.z) - centre[2]];
            println!(
                "{path} {name}: axes off {rel:.4?} % centre {dc:.4?} rms {:.4} / {} sigma {:?}",
                f.rms,
                r["rms_distance"],
                f.covariance.map(|c| c.sigma_centre_mm())
            );
        }
        let mut workspace = Box::new(Workspace::<65535>::new());
        let mut scratch = workspace.scratch();
        scratch.reset(points.len());
        let (mut search, mut stream) = (MixtureSearch::new(), Stream::new(1));
        let solution = loop {
            match search.step(
                &MixtureConfig::SURFACE,
                &View::from(points.as_slice()),
                &mut scratch,
                &mut stream,
            ) {
                MixtureProgress::Working => {}
                other => break other,
            }
        };
        match solution {
            MixtureProgress::Found(s) => println!(
                "   mixture {:?} sigma {:.4} {:?} {:?}",
                s.ellipsoid.semi_axes, s.sigma, s.refusal, s.findings
            ),
            other => println!("   mixture {other:?}"),
        }
    }
}
