//! Wall clock of every contender, by criterion: `cargo bench -p varsac-bench`.
//!
//! Criterion measures one contender after the other; on a machine that does other things as well,
//! `varsac experiment speed` compares better, because there they take turns.

use std::time::Duration;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use varsac_bench::{Group, render_frame};

fn ratios(criterion: &mut Criterion) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    render_frame(folder.path()).expect("a rendered frame can be written");
    for group in Group::ALL {
        let measured = group.with(folder.path(), |contenders| {
            let mut measured = criterion.benchmark_group(group.name());
            measured.sample_size(20).measurement_time(Duration::from_secs(2));
            for mut contender in contenders {
                measured.throughput(Throughput::Elements((contender.work)()));
                measured.bench_function(contender.name, |bencher| bencher.iter(|| (contender.work)()));
            }
            measured.finish();
        });
        measured.expect("the frame that was just written can be read");
    }
}

criterion_group!(all, ratios);
criterion_main!(all);
