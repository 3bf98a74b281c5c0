//! The firmware's main loop: link and search take turns, neither ever waits for the other.
//!
//! A turn moves what bytes there are, takes at most one frame, and does one bounded step of the detector. Each target,
//! accepted or refused, goes out as soon as it is known; the search holds still only while a target waits for the one before it to be
//! acknowledged. The memory is all there from the start.

use varsac_core::link::message::{Answer, Message, Reason};
use varsac_core::link::payload::{
    Ending, Fault, OUTLINE_CAPACITY, REJECTIONS, Report, Search, Target, Welcome,
};
use varsac_core::link::{
    CloudReceiver, FrameReceiver, Incoming, Loss, MAX_PAYLOAD, MAX_WIRE, Nack, Session, Timing, ViewMemory,
};
use varsac_core::point::check_cloud;
use varsac_core::{
    Detector, Estimate, Observer, OutlineRay, Point3, Rejection, Score, Stage, Status, Step, Support, View,
    Workspace,
};

/// What the main loop runs on. Nothing in it may block.
pub trait Machine {
    /// The next byte from the host, if one is there.
    fn read(&mut self) -> Option<u8>;
    /// Sends some of the bytes; how many it took.
    fn write(&mut self, bytes: &[u8]) -> usize;
    /// Milliseconds since some moment, wrapping.
    fn now_ms(&mut self) -> u32;
    /// There is nothing to do: may sleep for about a millisecond.
    fn idle(&mut self) {}
    /// Deepest use of the stack so far, bytes, where it is measured.
    fn stack_bytes(&mut self) -> Option<u32> {
        None
    }
    /// Something worth a line in a log happened.
    fn log(&mut self, _event: Event) {}
    /// False ends the main loop; a board's goes on for ever.
    fn is_running(&mut self) -> bool {
        true
    }
}

/// A line of the log.
#[derive(Debug, Clone, Copy, PartialEq)]
#[cfg_attr(feature = "defmt", derive(defmt::Format))]
pub enum Event {
    /// A host opened this session.
    Opened(u32),
    /// The host was silent; its session is dropped.
    Lost(Loss),
    /// A message of this type was not taken.
    Refused(u8, Nack),
    /// The host did not take a message.
    Objected(Nack),
    /// A search begins.
    Search {
        /// Points of the cloud.
        points: u16,
        /// Its outline rays.
        outline_rays: u16,
        /// Its seed.
        seed: u64,
    },
    /// A target was found.
    Found {
        /// Its number.
        target: u8,
        /// Its support.
        score: Score,
        /// Accepted, or why not.
        status: Status,
    },
    /// A search is over.
    Done {
        /// Targets found.
        targets: u8,
        /// Detector steps taken.
        steps: u32,
    },
}

/// What a machine gives a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Number in the table of boards, or 0.
    pub board: u8,
    /// Points of a cloud at most; the memory's own limit holds too.
    pub capacity: u16,
    /// Detector steps of a search at most.
    pub step_budget: u32,
}

/// Repeat after a quarter of a second, then less and less often, eight times: 13.75 s in all.
pub const TIMING: Timing = Timing { resend_after: 250, resends: 8 };

const ORIGIN: Point3 = Point3::new(0.0, 0.0, 0.0);

/// All memory of the main loop: 17 bytes a point, what is found, the outline rays, and two frames. The state of a search is on
/// the stack while it runs.
#[derive(Debug)]
pub struct Memory<const N: usize> {
    line: Line,
    cloud: [Point3; N],
    outline: [OutlineRay; OUTLINE_CAPACITY],
    workspace: Workspace<N>,
}

impl<const N: usize> Memory<N> {
    /// For clouds of up to `N` points. Place it in a `static`.
    pub const fn new() -> Self {
        Self {
            line: Line { session: Session::device(TIMING), receiver: FrameReceiver::new() },
            cloud: [ORIGIN; N],
            outline: [OutlineRay { inner: ORIGIN, outer_mm: 0.0, sigma_rad: 0.0 }; OUTLINE_CAPACITY],
            workspace: Workspace::new(),
        }
    }
}

impl<const N: usize> Default for Memory<N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Serves hosts until [`Machine::is_running`] says no.
pub fn run<const N: usize>(machine: &mut impl Machine, memory: &mut Memory<N>, limits: &Limits) {
    let Memory { line, cloud, outline, workspace } = memory;
    let capacity = cloud.len().min(usize::from(limits.capacity));
    let cloud = cloud.get_mut(..capacity).unwrap_or(&mut []);
    let mut memory = ViewMemory { cloud, outline };
    let mut desk = Desk::new();
    while machine.is_running() {
        let turn = line.turn(machine, |message| desk.take(message, &mut memory));
        if turn.lost {
            desk = Desk::new();
        }
        if desk.greet && line.session.is_ready() {
            let welcome = welcome(limits.board, capacity);
            desk.greet = line.session.send(&Message::Welcome(welcome)).is_err();
        }
        if let Some(order) = desk.order.take()
            && let Some(detector) = &desk.detector
            && let Some(view) = desk.cloud.complete(&memory)
        {
            let budget = match order.step_budget {
                0 => limits.step_budget,
                asked => asked.min(limits.step_budget),
            };
            if search(machine, line, detector, &view, workspace, order.seed, budget) == After::NewSession {
                desk = Desk { greet: line.session.id().is_some(), ..Desk::new() };
            }
        } else if !turn.moved {
            machine.idle();
        }
    }
}

fn welcome(board: u8, capacity: usize) -> Welcome {
    Welcome {
        core_version: varsac_core::VERSION,
        board,
        max_payload: MAX_PAYLOAD as u16,
        capacity: capacity as u16,
        outline_capacity: OUTLINE_CAPACITY as u16,
    }
}

/// Session and receiver: what turns bytes into messages.
#[derive(Debug)]
struct Line {
    session: Session,
    receiver: FrameReceiver,
}

/// What a turn of the line came to.
struct Turn {
    moved: bool,
    lost: bool,
}

impl Line {
    /// Reads up to one frame's worth of bytes and at most one frame, answers it, writes what the machine takes.
    fn turn(&mut self, machine: &mut impl Machine, mut take: impl FnMut(&Message<'_>) -> Answer) -> Turn {
        let mut moved = false;
        for _ in 0..MAX_WIRE {
            let Some(byte) = machine.read() else { break };
            moved = true;
            let Some(frame) = self.receiver.push(byte) else { continue };
            match self.session.receive(&frame) {
                Incoming::Message(message) => {
                    let answer = take(&message);
                    self.session.answer(answer);
                    match answer {
                        Ok(()) if matches!(message, Message::Hello(_)) => {
                            machine.log(Event::Opened(frame.header.session));
                        }
                        Ok(()) => {}
                        Err(nack) => machine.log(Event::Refused(frame.header.kind, nack)),
                    }
                }
                Incoming::Answered(Err(nack)) => machine.log(Event::Objected(nack)),
                Incoming::Answered(Ok(())) | Incoming::Nothing | Incoming::Lost(_) => {}
            }
            break;
        }
        let now = machine.now_ms();
        loop {
            let bytes = self.session.outgoing(now);
            let taken = if bytes.is_empty() { 0 } else { machine.write(bytes) };
            if taken == 0 {
                break;
            }
            self.session.advance(taken, now);
            moved = true;
        }
        let loss = self.session.tick(now);
        if let Some(loss) = loss {
            machine.log(Event::Lost(loss));
        }
        Turn { moved, lost: loss.is_some() }
    }
}

/// What a session has brought so far.
struct Desk {
    detector: Option<Detector>,
    cloud: CloudReceiver,
    order: Option<Search>,
    /// Welcome is still to be said.
    greet: bool,
}

impl Desk {
    fn new() -> Self {
        Self { detector: None, cloud: CloudReceiver::new(), order: None, greet: false }
    }

    /// Takes a message while no search runs.
    fn take(&mut self, message: &Message<'_>, memory: &mut ViewMemory<'_>) -> Answer {
        match message {
            Message::Hello(_) => {
                *self = Self { greet: true, ..Self::new() };
                Ok(())
            }
            Message::Configure(config) => {
                self.detector =
                    Some(Detector::new(config.clone()).map_err(|_| Reason::Configuration.nack(0))?);
                Ok(())
            }
            Message::CloudBegin(begin) => self.cloud.begin(begin, memory),
            Message::CloudChunk(chunk) => self.cloud.chunk(chunk, memory),
            Message::OutlineChunk(chunk) => self.cloud.outline_chunk(chunk, memory),
            Message::CloudEnd(end) => {
                self.cloud.end(end)?;
                let points = self.cloud.complete(memory).map_or(&[][..], |view| view.cloud);
                check_cloud(points, memory.cloud.len()).map_err(|error| {
                    self.cloud = CloudReceiver::new();
                    match error {
                        varsac_core::CloudError::Coordinate { index, .. } => Reason::Coordinate.nack(index),
                        varsac_core::CloudError::TooManyPoints { capacity, .. } => {
                            Reason::Capacity.nack(capacity)
                        }
                        varsac_core::CloudError::TooManyRays { .. } => {
                            Reason::Capacity.nack(varsac_core::MAX_OUTLINE as u32)
                        }
                    }
                })
            }
            Message::Search(search) => {
                if self.detector.is_none() || self.cloud.complete(memory).is_none() {
                    return Err(Reason::Order.nack(0));
                }
                self.order = Some(*search);
                Ok(())
            }
            Message::Abort | Message::Poll => Ok(()),
            Message::Welcome(_) | Message::Target(_) | Message::Report(_) | Message::Fault(_) => {
                Err(Reason::Order.nack(0))
            }
        }
    }
}

/// How the main loop goes on after a search.
#[derive(PartialEq)]
enum After {
    SameSession,
    NewSession,
}

/// One search, from the order to the report.
fn search<const N: usize>(
    machine: &mut impl Machine,
    line: &mut Line,
    detector: &Detector,
    view: &View<'_>,
    workspace: &mut Workspace<N>,
    seed: u64,
    step_budget: u32,
) -> After {
    let (points, outline_rays) = (view.cloud.len() as u16, view.outline.len() as u16);
    machine.log(Event::Search { points, outline_rays, seed });
    let Ok(mut run) = detector.detect_view(view, workspace.scratch(), seed) else {
        // The cloud was checked when it was complete: the memory is not what it was.
        let _ = line.session.send(&Message::Fault(Fault { code: 1, value: u32::from(points) }));
        return After::SameSession;
    };
    let (mut tally, mut targets, mut steps) = (Tally::default(), 0, 0);
    let mut ending = None;
    let mut waiting: Option<Message<'static>> = None;
    while machine.is_running() {
        let (mut aborted, mut reopened) = (false, false);
        let turn = line.turn(machine, |message| match message {
            Message::Abort => {
                aborted = true;
                Ok(())
            }
            Message::Hello(_) => {
                reopened = true;
                Ok(())
            }
            Message::Poll => Ok(()),
            _ => Err(Reason::Busy.nack(0)),
        });
        if reopened || turn.lost {
            return After::NewSession;
        }
        if aborted {
            ending.get_or_insert(Ending::Aborted);
        }
        if let Some(message) = waiting.take() {
            if !line.session.is_ready() {
                waiting = Some(message);
                if !turn.moved {
                    machine.idle();
                }
            } else if line.session.send(&message).is_ok() && matches!(message, Message::Report(_)) {
                break;
            }
        } else if let Some(ending) = ending {
            machine.log(Event::Done { targets, steps });
            let stack_bytes = machine.stack_bytes();
            waiting = Some(Message::Report(tally.report(ending, targets, steps, stack_bytes)));
        } else if steps >= step_budget {
            ending = Some(Ending::BudgetSpent);
        } else {
            steps += 1;
            match run.step_observed(&mut tally) {
                Step::Working => {}
                Step::Missed(report) => tally.reported += report.trials,
                Step::Found(detection) => {
                    tally.reported += detection.report.trials;
                    targets = detection.target;
                    let (score, status) = (detection.score, detection.status);
                    machine.log(Event::Found { target: targets, score, status });
                    waiting = Some(Message::Target(Target::from(&detection)));
                }
                Step::Finished(finish) => ending = Some(Ending::Complete(finish)),
            }
        }
    }
    After::SameSession
}

/// Counts what becomes of the trials, so that a search that was cut short can still be reported. The search without a size prior
/// shows none while it runs; its reports count them.
#[derive(Debug, Clone, Copy, Default)]
struct Tally {
    /// Trials that were seen to end.
    trials: u32,
    /// Trials of the searches that are over.
    reported: u32,
    rejections: [u32; REJECTIONS],
    /// Where the latest estimate of the default search stood.
    stage: Option<Stage>,
}

impl Observer for Tally {
    fn rejected(&mut self, reason: Rejection) {
        self.trials += 1;
        if let Some(counter) = self.rejections.get_mut(reason as usize) {
            *counter += 1;
        }
    }

    fn score(&mut self, _score: Score) {
        self.trials += 1;
    }

    fn estimate(&mut self, stage: Stage, _estimate: &Estimate) {
        self.stage = Some(stage);
    }

    /// Of a hypothesis: a trial ends. Of one that was refined: its trial was counted before.
    fn support(&mut self, _support: &Support) {
        self.trials += u32::from(self.stage == Some(Stage::Hypothesis));
    }
}

impl Tally {
    fn report(&self, ending: Ending, targets: u8, steps: u32, stack_bytes: Option<u32>) -> Report {
        let trials = self.trials.max(self.reported);
        Report { ending, targets, trials, steps, rejections: self.rejections, stack_bytes }
    }
}
