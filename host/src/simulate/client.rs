//! The host's end of the link: one job at a time, from configuration and view to targets and report.
//!
//! When the session is lost (the co-processor was restarted, or was silent too long), the client opens a new one and
//! does the job again from the start; a search is the same bits each time, so nobody can tell from the result.

use std::hash::{BuildHasher, Hasher, RandomState};
use std::io;
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

use varsac_core::link::message::Nack;
use varsac_core::link::payload::{Fault, Hello, Report, Search, Target, Welcome};
use varsac_core::link::{
    CloudSender, FrameReceiver, Incoming, Loss, MAX_PAYLOAD, Message, Reason, SendError, Session, Timing,
    VERSION,
};
use varsac_core::{Config, View};

use super::transport::Transport;

/// The host's patience with an answer: as the firmware's.
const TIMING: Timing = varsac_firmware_sim::app::TIMING;
/// Silence after which the co-processor is asked whether it is still there.
const POLL_AFTER: Duration = Duration::from_secs(1);
/// Sessions tried for one job. The first may find a board that is still starting.
const SESSIONS: u32 = 10;

/// What is to be searched, and how.
#[derive(Debug, Clone, Copy)]
pub struct Job<'a> {
    /// Configuration of the search.
    pub config: &'a Config,
    /// Points, mask and outline; camera frame, mm.
    pub view: View<'a>,
    /// Seed of the random stream.
    pub seed: u64,
    /// Detector steps at most; 0: as many as the co-processor allows.
    pub step_budget: u32,
}

/// What came of it.
#[derive(Debug, Clone, PartialEq)]
pub struct Outcome {
    /// In the order of detection.
    pub targets: Vec<Target>,
    /// How the search ended.
    pub report: Report,
    /// Who did it.
    pub welcome: Welcome,
    /// Sessions that were opened for it: 0 when the one of the job before went on.
    pub sessions: u32,
}

/// Why there is no outcome.
#[derive(Debug, thiserror::Error)]
pub enum ClientError {
    /// The transport is gone.
    #[error("the connection to the co-processor is gone ({0}); start it again")]
    Transport(#[from] io::Error),
    /// No session lasted long enough.
    #[error("the co-processor {}; {}", loss_text(*.0), loss_remedy(*.0))]
    Lost(Loss),
    /// The co-processor did not take a message.
    #[error("the co-processor refuses: {}", nack_text(*.0))]
    Refused(Nack),
    /// The co-processor has a fault of its own.
    #[error("the co-processor reports fault {} (value {}); restart it", .0.code, .0.value)]
    Fault(Fault),
    /// A message is larger than a frame, or was sent while another was under way: a mistake of this program.
    #[error("a message could not be sent ({0:?}); this is a mistake in varsac, please report it")]
    Send(SendError),
}

fn loss_text(loss: Loss) -> String {
    match loss {
        Loss::Silence => "does not answer".into(),
        Loss::Unknown => "keeps forgetting the session".into(),
        Loss::Version(version) => {
            format!("speaks version {version} of the link, this program version {VERSION}")
        }
    }
}

fn loss_remedy(loss: Loss) -> &'static str {
    match loss {
        Loss::Silence => "check that it runs, the cable and the baud rate",
        Loss::Unknown => "check its power supply: it seems to restart",
        Loss::Version(_) => "update the older of the two",
    }
}

fn nack_text(nack: Nack) -> String {
    let detail = nack.detail;
    match nack.reason {
        Reason::Capacity => {
            format!(
                "its memory holds {detail} of what it was sent, points or outline rays; thin them or choose a larger board"
            )
        }
        Reason::Coordinate => {
            format!("point {detail} has a coordinate that is not finite or too large; clean the cloud")
        }
        Reason::Configuration => {
            "a value of the configuration is out of range; check it with the core".into()
        }
        Reason::Busy => "a search is running; wait for its report or abort it".into(),
        Reason::Version => format!("it speaks version {detail} of the link; update the older of the two"),
        Reason::NoSession | Reason::Malformed | Reason::Order | Reason::Offset | Reason::Checksum => {
            format!(
                "{:?} (detail {detail}); this is a mistake in one of the two programs, please report it",
                nack.reason
            )
        }
    }
}

/// Why a job has to stop here.
enum Halt {
    /// The session is over; another may do.
    Lost(Loss),
    Final(ClientError),
}

impl From<io::Error> for Halt {
    fn from(error: io::Error) -> Self {
        Self::Final(ClientError::Transport(error))
    }
}

/// A host with its session and its transport.
pub struct Client<T> {
    transport: T,
    session: Session,
    receiver: FrameReceiver,
    start: Instant,
    /// Bytes that came and are not yet looked at, the next one last.
    unread: Vec<u8>,
    welcome: Option<Welcome>,
    configured: Option<Config>,
    ids: RandomState,
    opened: u64,
    arrived: Arrived,
}

/// What came without being an answer.
#[derive(Default)]
struct Arrived {
    targets: Vec<Target>,
    report: Option<Report>,
    fault: Option<Fault>,
}

impl<T: Transport> Client<T> {
    /// A client that has not yet said anything.
    pub fn new(transport: T) -> Self {
        Self {
            transport,
            session: Session::host(TIMING),
            receiver: FrameReceiver::new(),
            start: Instant::now(),
            unread: Vec::new(),
            welcome: None,
            configured: None,
            ids: RandomState::new(),
            opened: 0,
            arrived: Arrived::default(),
        }
    }

    /// The transport underneath.
    pub fn transport(&mut self) -> &mut T {
        &mut self.transport
    }

    /// Gives the transport up; the co-processor keeps its session until another is opened.
    pub fn into_transport(self) -> T {
        self.transport
    }

    /// Does one job. `on_target` sees each target as it arrives and may end the search.
    ///
    /// # Errors
    /// See [`ClientError`]; a lost session is none until several were lost in a row.
    pub fn search(
        &mut self,
        job: &Job<'_>,
        mut on_target: impl FnMut(&Target) -> ControlFlow<()>,
    ) -> Result<Outcome, ClientError> {
        let before = self.opened;
        loop {
            match self.attempt(job, &mut on_target) {
                Ok((report, welcome)) => {
                    let targets = std::mem::take(&mut self.arrived.targets);
                    return Ok(Outcome { targets, report, welcome, sessions: (self.opened - before) as u32 });
                }
                Err(Halt::Final(error)) => return Err(error),
                Err(Halt::Lost(loss)) => {
                    self.welcome = None;
                    if self.opened - before >= u64::from(SESSIONS) || matches!(loss, Loss::Version(_)) {
                        return Err(ClientError::Lost(loss));
                    }
                }
            }
        }
    }

    fn attempt(
        &mut self,
        job: &Job<'_>,
        on_target: &mut impl FnMut(&Target) -> ControlFlow<()>,
    ) -> Result<(Report, Welcome), Halt> {
        self.arrived = Arrived::default();
        let welcome = match self.welcome {
            Some(welcome) if self.session.id().is_some() => welcome,
            _ => self.open()?,
        };
        if self.configured.as_ref() != Some(job.config) {
            self.exchange(&Message::Configure(job.config.clone()))?;
            self.configured = Some(job.config.clone());
        }
        let mut sender = CloudSender::new(&job.view);
        while let Some(message) = sender.next_message() {
            self.exchange(&message)?;
        }
        self.exchange(&Message::Search(Search { seed: job.seed, step_budget: job.step_budget }))?;
        let mut shown = 0;
        loop {
            let mut stop = false;
            while let Some(target) = self.arrived.targets.get(shown) {
                stop |= on_target(target).is_break();
                shown += 1;
            }
            if let Some(fault) = self.arrived.fault {
                return Err(Halt::Final(ClientError::Fault(fault)));
            }
            if let Some(report) = self.arrived.report {
                // Its acknowledgement is still to go out.
                self.flush()?;
                return Ok((report, welcome));
            }
            if stop {
                self.exchange(&Message::Abort)?;
            } else {
                self.wait(|client| client.arrived.report.is_some() || client.arrived.targets.len() > shown)?;
            }
        }
    }

    fn open(&mut self) -> Result<Welcome, Halt> {
        self.opened += 1;
        self.configured = None;
        let mut number = self.ids.build_hasher();
        number.write_u64(self.opened);
        number.write_u128(self.start.elapsed().as_nanos());
        let hello = Hello { max_payload: MAX_PAYLOAD as u16 };
        self.session
            .open(number.finish() as u32, hello)
            .map_err(|error| Halt::Final(ClientError::Send(error)))?;
        self.wait(|client| client.welcome.is_some() && client.session.is_ready())?;
        self.welcome.ok_or(Halt::Lost(Loss::Silence))
    }

    /// Sends a message and waits for its answer, which must be that it was taken.
    fn exchange(&mut self, message: &Message<'_>) -> Result<(), Halt> {
        self.session.send(message).map_err(|error| Halt::Final(ClientError::Send(error)))?;
        self.wait(|client| client.session.is_ready())
    }

    /// Moves bytes until `enough`; asks for a sign of life now and then.
    fn wait(&mut self, enough: impl Fn(&Self) -> bool) -> Result<(), Halt> {
        let mut heard = Instant::now();
        while !enough(self) {
            if self.turn(Duration::from_millis(20))? {
                heard = Instant::now();
            } else if heard.elapsed() > POLL_AFTER && self.session.is_ready() {
                heard = Instant::now();
                let _ = self.session.send(&Message::Poll);
            }
            if self.arrived.fault.is_some() {
                return Ok(());
            }
        }
        Ok(())
    }

    /// Writes what is due, then reads up to the next frame that means something. True when one came.
    fn turn(&mut self, patience: Duration) -> Result<bool, Halt> {
        self.flush()?;
        if self.unread.is_empty() {
            self.transport.read(patience, &mut self.unread)?;
            self.unread.reverse();
        }
        while let Some(byte) = self.unread.pop() {
            let Some(frame) = self.receiver.push(byte) else { continue };
            match self.session.receive(&frame) {
                Incoming::Nothing => continue,
                Incoming::Message(message) => {
                    match message {
                        Message::Welcome(welcome) => self.welcome = Some(welcome),
                        Message::Target(target) => self.arrived.targets.push(target),
                        Message::Report(report) => self.arrived.report = Some(report),
                        Message::Fault(fault) => self.arrived.fault = Some(fault),
                        _ => {}
                    }
                    self.session.answer(Ok(()));
                }
                Incoming::Answered(Ok(())) => {}
                Incoming::Answered(Err(nack)) => return Err(Halt::Final(ClientError::Refused(nack))),
                Incoming::Lost(loss) => return Err(Halt::Lost(loss)),
            }
            return Ok(true);
        }
        let now = self.now_ms();
        self.session.tick(now).map_or(Ok(false), |loss| Err(Halt::Lost(loss)))
    }

    fn flush(&mut self) -> Result<(), Halt> {
        let now = self.now_ms();
        loop {
            let bytes = self.session.outgoing(now);
            if bytes.is_empty() {
                return Ok(());
            }
            self.transport.write(bytes)?;
            let count = bytes.len();
            self.session.advance(count, now);
        }
    }

    fn now_ms(&self) -> u32 {
        self.start.elapsed().as_millis() as u32
    }
}
