//! The co-processor, native and on every emulated board: the same bits as the host, whatever carries the frames, and
//! either side may be restarted.

use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use varsac_core::link::payload::{Ending, OUTLINE_CAPACITY};
use varsac_core::link::{Message, Reason};
use varsac_core::mixture::MixtureConfig;
use varsac_core::{Config, Detector, Finish, Point3, RefusalCode, Workspace};
use varsac_firmware_sim::app::{Event, Limits};
use varsac_firmware_sim::board::{BOARDS, Board, by_name};
use varsac_firmware_sim::body;
use varsac_firmware_sim::native::{Native, limits};
use varsac_firmware_sim::scene::{self, Digested, SCENE_POINTS};
use varsac_firmware_sim::view::{self, Canvas};
use varsac_host::region_view::RegionView;
use varsac_host::simulate::client::ClientError;
use varsac_host::simulate::expected::{demo_body, demo_cloud, demo_view};
use varsac_host::simulate::firmware::{Program, build};
use varsac_host::simulate::transport::Thread;
use varsac_host::simulate::{Carrier, Client, Emulator, Job, Outcome, Transport, compare, emulator};

/// Ends the test with the sentence a user would read.
fn must<T, E: std::fmt::Display>(result: Result<T, E>) -> T {
    result.unwrap_or_else(|error| panic!("{error}"))
}

fn native(limits: Limits) -> Client<Thread> {
    Client::new(Thread(Native::start(limits, |_| {})))
}

fn search(client: &mut Client<impl Transport>, config: &Config, view: &RegionView, seed: u64) -> Outcome {
    let job = Job { config, view: view.view(), seed, step_budget: 0 };
    must(client.search(&job, |_| ControlFlow::Continue(())))
}

/// Searches and compares with the host.
fn checked(client: &mut Client<impl Transport>, config: &Config, view: &RegionView, seed: u64) -> Outcome {
    let job = Job { config, view: view.view(), seed, step_budget: 0 };
    let outcome = must(client.search(&job, |_| ControlFlow::Continue(())));
    let detector = must(Detector::new(config.clone()));
    if let Some(difference) = must(compare(&detector, &job, &outcome)) {
        panic!("seed {seed}, {} points: {difference}", view.points.len());
    }
    outcome
}

#[test]
fn the_native_co_processor_finds_what_the_core_finds() {
    let mut client = native(limits(None));
    let mut targets = 0;
    for number in 0..40 {
        let cloud = demo_cloud(number, 300);
        let outcome = checked(&mut client, &scene::config(number), &cloud, number);
        assert_eq!(outcome.sessions, u32::from(number == 0), "one session for all of them");
        assert!(matches!(outcome.report.ending, Ending::Complete(_)));
        targets += outcome.targets.len();
    }
    assert!(targets > 40, "only {targets} targets: the scenes prove nothing");
}

#[test]
fn the_default_search_goes_over_the_link_with_mask_outline_verdict_and_covariance() {
    let mut client = native(limits(None));
    let (mut accepted, mut refused, mut shared) = (0, 0, 0);
    for number in 0..40 {
        let view = demo_view(number);
        let outcome = checked(&mut client, &view::config(number), &view, number);
        assert!(matches!(outcome.report.ending, Ending::Complete(_)));
        for target in &outcome.targets {
            assert!(target.findings.is_some());
            match target.refusal {
                None => {
                    accepted += 1;
                    let sigma = target.covariance.expect("how sure").sigma_centre_max_mm();
                    assert!(sigma > 0.0 && sigma < 1.8, "{sigma}");
                }
                Some(refusal) => {
                    refused += 1;
                    shared += u32::from(refusal.code == RefusalCode::SharedVolume);
                }
            }
        }
    }
    println!("40 views: {accepted} accepted, {refused} refused ({shared} for shared volume)");
    assert!(accepted >= 35 && refused > 0, "{accepted} accepted, {refused} refused: the views prove nothing");

    // The outline and the mask matter: without them other bits come out.
    let (view, config) = (demo_view(0), view::config(0));
    let with = checked(&mut client, &config, &view, 0).targets;
    let without = RegionView { outline: Vec::new(), ..view.clone() };
    assert_ne!(with, checked(&mut client, &config, &without, 0).targets);
    let all_in_mask = RegionView { in_mask: view.points.len(), ..view };
    assert_ne!(with, checked(&mut client, &config, &all_in_mask, 0).targets);
}

#[test]
fn the_search_without_a_size_prior_goes_over_the_link() {
    let mut client = native(limits(None));
    let (mut accepted, mut refused) = (0, 0);
    for number in 0..8 {
        let (cloud, config) = (demo_body(number, 300), Config::surface());
        let outcome = checked(&mut client, &config, &cloud, number);
        assert!(outcome.report.trials > u32::from(config.mixture.starts));
        accepted += outcome.targets.iter().filter(|target| target.refusal.is_none()).count();
        refused += outcome.targets.iter().filter(|target| target.refusal.is_some()).count();
        // Of one view, too: mask and outline bear on it.
        let view = demo_view(number);
        let with = checked(&mut client, &Config::unknown(), &view, number).targets;
        let without = RegionView { outline: Vec::new(), ..view };
        assert_ne!(with, checked(&mut client, &Config::unknown(), &without, number).targets, "view {number}");
        assert!(with.iter().all(|target| target.covariance.is_some() && target.findings.is_none()));
    }
    println!("8 surfaces: {accepted} accepted, {refused} refused");
    assert!(
        accepted >= 6 && refused >= 2,
        "{accepted} accepted, {refused} refused: the scenes prove nothing"
    );
}

#[test]
fn too_many_outline_rays_are_refused_and_the_session_goes_on() {
    let mut client = native(limits(None));
    let (mut view, config) = (demo_view(0), view::config(0));
    let kept = view.outline.clone();
    while view.outline.len() <= OUTLINE_CAPACITY {
        view.outline.extend_from_slice(&kept);
    }
    let job = Job { config: &config, view: view.view(), seed: 1, step_budget: 0 };
    match client.search(&job, |_| ControlFlow::Continue(())) {
        Err(ClientError::Refused(nack)) => assert_eq!(nack, Reason::Capacity.nack(OUTLINE_CAPACITY as u32)),
        other => panic!("{other:?}"),
    }
    view.outline.truncate(OUTLINE_CAPACITY);
    let outcome = checked(&mut client, &config, &view, 1);
    assert_eq!((outcome.sessions, outcome.welcome.outline_capacity), (0, OUTLINE_CAPACITY as u16));
}

#[test]
fn the_limits_of_a_board_hold_natively_too() {
    let m3 = by_name("m3").unwrap();
    let mut client = native(limits(Some(m3)));
    let too_large = demo_cloud(1, usize::from(m3.capacity) + 1);
    let config = Config::jujube().paper();
    let job = Job { config: &config, view: too_large.view(), seed: 1, step_budget: 0 };
    match client.search(&job, |_| ControlFlow::Continue(())) {
        Err(ClientError::Refused(nack)) => assert_eq!(nack, Reason::Capacity.nack(u32::from(m3.capacity))),
        other => panic!("{other:?}"),
    }
    // The session goes on.
    let outcome = checked(&mut client, &config, &demo_cloud(1, 300), 1);
    assert_eq!(
        (outcome.sessions, outcome.welcome.board, outcome.welcome.capacity),
        (0, m3.number, m3.capacity)
    );

    // A search that would take more steps than the board gives.
    let budget = 50;
    let mut client = native(Limits { board: 0, capacity: 1000, step_budget: budget });
    let outcome =
        search(&mut client, &Config { max_trials: 3000, min_ratio: 1.0, ..config }, &demo_cloud(2, 300), 1);
    assert_eq!((outcome.report.ending, outcome.report.steps), (Ending::BudgetSpent, budget));
    assert!(outcome.report.trials > 0 && outcome.report.trials < budget);
}

#[test]
fn a_search_can_be_ended_by_budget_and_by_the_first_target() {
    let mut client = native(limits(None));
    let config = scene::config(2);
    let cloud = demo_cloud(2, 300);
    let all = checked(&mut client, &config, &cloud, 2);
    assert!(all.targets.len() > 1);
    let job = Job { config: &config, view: cloud.view(), seed: 2, step_budget: 3 };
    let cut = must(client.search(&job, |_| ControlFlow::Continue(())));
    assert_eq!((cut.report.ending, cut.report.steps), (Ending::BudgetSpent, 3));
    let first = must(client.search(&Job { step_budget: 0, ..job }, |_| ControlFlow::Break(())));
    assert_eq!(first.targets[0], all.targets[0]);
    // The abort may come too late: then the search has simply ended.
    assert!(matches!(first.report.ending, Ending::Aborted | Ending::Complete(_)), "{:?}", first.report);
}

#[test]
fn clouds_that_are_no_clouds_are_refused_with_the_reason() {
    let mut client = native(limits(None));
    let config = Config::jujube().paper();
    let mut cloud = demo_cloud(1, 300);
    cloud.points[117].y = f32::NAN;
    let job = Job { config: &config, view: cloud.view(), seed: 1, step_budget: 0 };
    match client.search(&job, |_| ControlFlow::Continue(())) {
        Err(ClientError::Refused(nack)) => assert_eq!(nack, Reason::Coordinate.nack(117)),
        other => panic!("{other:?}"),
    }
    let bad = Config { shell: 2.0, ..Config::jujube().paper() };
    match client.search(&Job { config: &bad, ..job }, |_| ControlFlow::Continue(())) {
        Err(ClientError::Refused(nack)) => assert_eq!(nack.reason, Reason::Configuration),
        other => panic!("{other:?}"),
    }
    let empty = checked(&mut client, &config, &RegionView::default(), 1);
    assert_eq!(empty.report.ending, Ending::Complete(Finish::FewPoints));
}

/// A native co-processor that can be killed between two writes.
struct Mortal {
    native: Native,
    writes_left: u32,
}

impl Transport for Mortal {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> std::io::Result<()> {
        self.native.read(patience, into);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> std::io::Result<()> {
        self.writes_left = self.writes_left.saturating_sub(1);
        if self.writes_left == 1 {
            self.native = Native::start(limits(None), |_| {});
        }
        self.native.write(bytes);
        Ok(())
    }
}

#[test]
fn a_restarted_co_processor_costs_one_session_and_no_bit() {
    let config = scene::config(1);
    let cloud = demo_cloud(1, 300);
    let expected = search(&mut native(limits(None)), &config, &cloud, 1).targets;
    for writes_left in 2..14 {
        let native = Native::start(limits(None), |_| {});
        let mut client = Client::new(Mortal { native, writes_left });
        let outcome = search(&mut client, &config, &cloud, 1);
        assert_eq!(outcome.targets, expected, "restarted before write {writes_left}");
        assert!(outcome.sessions <= 2);
    }
}

/// Starts the firmware of a board.
fn board(name: &str, carrier: Carrier) -> (Emulator, Client<Box<dyn Transport>>) {
    let board = by_name(name).unwrap();
    let elf = must(build(board, Program::Firmware, None));
    let (emulator, transport) = must(Emulator::start(board, &elf, carrier));
    (emulator, Client::new(transport))
}

#[test]
fn a_large_cloud_through_the_emulated_uart_is_answered() {
    let (_emulator, mut client) = board("m4f", Carrier::Uart);
    let config = Config { max_trials: 200, ..Config::jujube().paper() };
    // The first search carries the start of the board with it.
    checked(&mut client, &config, &demo_cloud(0, 100), 0);
    let cloud = demo_cloud(1, 2000);
    let start = Instant::now();
    let outcome = checked(&mut client, &config, &cloud, 1);
    println!(
        "2000 points through the emulated UART and searched in {:.2} s: {} targets, {} trials, {:?} bytes of stack",
        start.elapsed().as_secs_f64(),
        outcome.targets.len(),
        outcome.report.trials,
        outcome.report.stack_bytes,
    );
    assert_eq!(outcome.sessions, 0);
    assert!(outcome.report.stack_bytes.is_some_and(|bytes| bytes > 500));
}

#[test]
fn shared_memory_carries_clouds_in_bulk() {
    let (_emulator, mut client) = board("m4f", Carrier::Memory);
    let config = Config { max_trials: 9, ..Config::jujube().paper() };
    checked(&mut client, &config, &demo_cloud(0, 200), 0);
    let start = Instant::now();
    let clouds = 200;
    for number in 0..clouds {
        checked(&mut client, &config, &demo_cloud(number, 200), number);
    }
    let rate = clouds as f64 / start.elapsed().as_secs_f64();
    println!(
        "clouds of 200 points through shared memory, searched with up to 9 trials a fruit and checked: {rate:.0} a second"
    );
}

#[test]
fn either_side_of_an_emulated_link_may_be_restarted() {
    let config = Config { max_trials: 50, ..Config::jujube().paper() };
    let cloud = demo_cloud(5, 600);
    let detector = must(Detector::new(config.clone()));
    let job = Job { config: &config, view: cloud.view(), seed: 5, step_budget: 0 };

    // The host is killed in mid-transfer: its bytes stop, another takes over on the same line.
    let (emulator, mut first) = board("m4f", Carrier::Uart);
    search(&mut first, &config, &demo_cloud(0, 100), 0);
    let mut wire = [0; 1024];
    let begin = Message::CloudBegin(varsac_core::link::payload::CloudBegin {
        points: 600,
        in_mask: 600,
        outline_rays: 0,
        pitch_rad: 0.0,
    });
    let used = begin.encode(7, 1, &mut wire).unwrap();
    let mut line = first.into_transport();
    must(line.write(&wire[..used / 2]));
    let mut second = Client::new(line);
    let outcome = must(second.search(&job, |_| ControlFlow::Continue(())));
    assert_eq!(must(compare(&detector, &job, &outcome)), None);
    drop(emulator);

    // The board is killed: the same host goes on with the board that comes after it.
    let (mut emulator, transport) = {
        let m4f = by_name("m4f").unwrap();
        let elf = must(build(m4f, Program::Firmware, None));
        must(Emulator::start(m4f, &elf, Carrier::Uart))
    };
    let mut client = Client::new(transport);
    search(&mut client, &config, &demo_cloud(0, 100), 0);
    emulator.kill();
    let (_emulator, replacement) = {
        let m4f = by_name("m4f").unwrap();
        let elf = must(build(m4f, Program::Firmware, None));
        must(Emulator::start(m4f, &elf, Carrier::Uart))
    };
    *client.transport() = replacement;
    let outcome = must(client.search(&job, |_| ControlFlow::Continue(())));
    assert_eq!(must(compare(&detector, &job, &outcome)), None);
    assert_eq!(outcome.sessions, 1, "the old session was refused by the new board, the next one held");
}

#[test]
fn every_board_answers_over_its_uart_with_the_bits_of_the_host() {
    for entry in &BOARDS {
        let (_emulator, mut client) = board(entry.name, Carrier::Uart);
        for number in 0..4 {
            let outcome = checked(&mut client, &scene::config(number), &demo_cloud(number, 120), number);
            assert_eq!((outcome.welcome.board, outcome.welcome.capacity), (entry.number, entry.capacity));
            let outcome = checked(&mut client, &view::config(number), &demo_view(number), number);
            assert!(!outcome.targets.is_empty(), "{}: view {number}", entry.name);
        }
        let mixture = MixtureConfig { sample: 100, starts: 1, ..MixtureConfig::SURFACE };
        let outcome = checked(&mut client, &Config { mixture, ..Config::surface() }, &demo_body(0, 100), 0);
        assert!(!outcome.targets.is_empty(), "{}: a body without a size prior", entry.name);
    }
}

#[test]
fn the_log_of_the_board_can_be_read() {
    let m4f = by_name("m4f").unwrap();
    let elf = must(build(m4f, Program::Firmware, None));
    let (mut emulator, transport) = must(Emulator::start(m4f, &elf, Carrier::Uart));
    let mut client = Client::new(transport);
    let outcome = search(&mut client, &scene::config(0), &demo_cloud(0, 100), 0);
    emulator.kill();
    let lines = must(varsac_host::simulate::log::decode(&elf, &emulator.log_path()));
    let text = lines.join("\n");
    assert!(lines[0].contains("Cortex-M4F") && lines[0].contains("info"), "{text}");
    assert!(text.contains("Opened"), "{text}");
    assert!(text.contains("points: 100"), "{text}");
    assert!(
        text.contains(&format!("targets: {}, steps: {}", outcome.targets.len(), outcome.report.steps)),
        "{text}"
    );
}

#[test]
fn the_native_log_tells_the_same_story() {
    let (sender, events) = std::sync::mpsc::channel();
    let log = move |event| sender.send(event).unwrap_or_default();
    let mut client = Client::new(Thread(Native::start(limits(None), log)));
    let outcome = search(&mut client, &scene::config(0), &demo_cloud(0, 100), 0);
    drop(client);
    let events: Vec<Event> = events.iter().collect();
    assert!(matches!(events[0], Event::Opened(_)), "{events:?}");
    assert!(events.contains(&Event::Search { points: 100, outline_rays: 0, seed: 0 }), "{events:?}");
    let done = Event::Done { targets: outcome.targets.len() as u8, steps: outcome.report.steps };
    assert_eq!(events.last(), Some(&done));
}

#[test]
fn a_missing_target_is_said_with_what_to_install() {
    // A target that the compiler knows and for which no library is distributed: it is missing everywhere.
    let strange = Board { target: "thumbv4t-none-eabi", ..*by_name("m3").unwrap() };
    let error = build(&strange, Program::Firmware, None).unwrap_err().to_string();
    assert!(error.contains("rustup target add thumbv4t-none-eabi"), "{error}");
}

/// Searches whose digests every board must reproduce: the paper's, the default one's, and those without a size prior.
const DIGESTS: u64 = 1000;
const VIEW_DIGESTS: u64 = 100;
const BODY_DIGESTS: u64 = 16;

#[test]
fn a_thousand_searches_have_the_same_digest_on_every_board() {
    let mut cloud = [Point3::origin(); SCENE_POINTS];
    let mut workspace = Workspace::new();
    let paper: Vec<Digested> =
        (0..DIGESTS).map(|number| scene::search_digest(number, &mut cloud, &mut workspace)).collect();
    let targets: u32 = paper.iter().map(|found| found.targets).sum();
    assert!(u64::from(targets) > DIGESTS, "only {targets} targets: the scenes prove nothing");
    same_on_every_board("digests", &paper);
}

#[test]
fn a_hundred_default_searches_have_the_same_digest_on_every_board() {
    let mut canvas = Box::new(Canvas::new());
    let mut workspace = Workspace::new();
    let found: Vec<Digested> =
        (0..VIEW_DIGESTS).map(|number| view::search_digest(number, &mut canvas, &mut workspace)).collect();
    let accepted: u32 = found.iter().map(|found| found.accepted).sum();
    let targets: u32 = found.iter().map(|found| found.targets).sum();
    assert!(u64::from(accepted) * 4 > VIEW_DIGESTS * 3, "only {accepted} accepted: the views prove nothing");
    assert!(targets > accepted, "nothing was refused: the views prove nothing about refusals");
    same_on_every_board("views", &found);
}

#[test]
fn searches_without_a_size_prior_have_the_same_digest_on_every_board() {
    let mut canvas = Box::new(Canvas::new());
    let mut workspace = Workspace::new();
    let found: Vec<Digested> =
        (0..BODY_DIGESTS).map(|number| body::search_digest(number, &mut canvas, &mut workspace)).collect();
    let accepted: u32 = found.iter().map(|found| found.accepted).sum();
    let targets: u32 = found.iter().map(|found| found.targets).sum();
    assert!(
        accepted >= 4 && targets >= accepted + 4,
        "{accepted} of {targets} accepted: the scenes prove nothing"
    );
    same_on_every_board("bodies", &found);
}

/// Has `prove` do the same searches on all boards.
fn same_on_every_board(searches: &str, expected: &[Digested]) {
    let targets: u32 = expected.iter().map(|found| found.targets).sum();
    let expected: Vec<String> =
        expected.iter().enumerate().map(|(number, found)| format!("{number} {found}")).collect();
    // The emulators run side by side; the M3, which computes floats in software, takes as long as all the others.
    std::thread::scope(|scope| {
        for board in &BOARDS {
            let expected = &expected;
            scope.spawn(move || {
                let start = Instant::now();
                let found = must(digests(board, searches, expected.len()));
                let lines: Vec<&str> = found.lines().collect();
                let first = expected.iter().zip(&lines).find(|(here, there)| here != there);
                assert_eq!(first, None, "{}: host, board", board.name);
                assert_eq!(lines.len(), expected.len(), "{}", board.name);
                let seconds = start.elapsed().as_secs_f64();
                println!(
                    "{:4} {} searches, {targets} targets, 0 differing ({seconds:.0} s)",
                    board.name,
                    expected.len()
                );
            });
        }
    });
}

fn digests(board: &Board, searches: &str, count: usize) -> Result<String, varsac_host::error::InputError> {
    let elf = build(board, Program::Prove, None)?;
    let arguments = [searches, &count.to_string()];
    let (text, code) = emulator::run(board, &elf, &arguments, false, Duration::from_secs(900))?;
    assert_eq!(code, 0, "{}: {text}", board.name);
    Ok(text)
}

#[test]
fn flush_to_zero_is_refused_at_start() {
    for board in &BOARDS {
        let elf = must(build(board, Program::Prove, None));
        let (_, code) = must(emulator::run(board, &elf, &["flush-to-zero"], false, Duration::from_secs(60)));
        // The M3 has no such switch.
        let expected = if board.name == "m3" { 0 } else { 103 };
        assert_eq!(code, expected, "{}", board.name);
    }
}
