//! The co-processor without a board: the main loop in a thread, its bytes through two queues.
//!
//! It is held to the limits of a board where one is chosen: the cloud it takes, the steps a search may have.

use std::boxed::Box;
use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use std::vec::Vec;

use crate::app::{self, Event, Limits, Machine, Memory};
use crate::board::Board;

/// Points of the largest cloud the core takes at all.
const CAPACITY: usize = varsac_core::point::MAX_POINTS;

/// Bytes on their way in one direction.
#[derive(Debug, Default)]
struct Queue {
    bytes: Mutex<VecDeque<u8>>,
    arrived: Condvar,
}

impl Queue {
    fn push(&self, bytes: &[u8]) {
        self.bytes.lock().unwrap_or_else(PoisonError::into_inner).extend(bytes);
        self.arrived.notify_one();
    }

    /// All that is there; waits up to `patience` if that is nothing.
    fn take(&self, patience: Duration, into: &mut Vec<u8>) {
        let mut bytes = self.bytes.lock().unwrap_or_else(PoisonError::into_inner);
        if bytes.is_empty() && !patience.is_zero() {
            bytes =
                self.arrived.wait_timeout(bytes, patience).map_or_else(|e| e.into_inner().0, |woken| woken.0);
        }
        into.extend(bytes.drain(..));
    }
}

/// Limits of a search on `board`; without one, the core's own.
pub fn limits(board: Option<&Board>) -> Limits {
    match board {
        Some(board) => {
            Limits { board: board.number, capacity: board.capacity, step_budget: board.step_budget }
        }
        None => Limits { board: 0, capacity: u16::MAX, step_budget: u32::MAX },
    }
}

/// A running co-processor. Dropping it ends its thread.
#[derive(Debug)]
pub struct Native {
    to_device: Arc<Queue>,
    to_host: Arc<Queue>,
    running: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Native {
    /// Starts one with these limits; what it logs goes to `log`.
    pub fn start(limits: Limits, log: impl FnMut(Event) + Send + 'static) -> Self {
        let (to_device, to_host) = (Arc::new(Queue::default()), Arc::new(Queue::default()));
        let running = Arc::new(AtomicBool::new(true));
        let mut machine = Thread {
            incoming: Vec::new(),
            next: 0,
            from: Arc::clone(&to_device),
            to: Arc::clone(&to_host),
            running: Arc::clone(&running),
            start: Instant::now(),
            log,
        };
        let thread = std::thread::spawn(move || {
            let mut memory = Box::new(Memory::<CAPACITY>::new());
            app::run(&mut machine, &mut memory, &limits);
        });
        Self { to_device, to_host, running, thread: Some(thread) }
    }

    /// Sends bytes to it.
    pub fn write(&self, bytes: &[u8]) {
        self.to_device.push(bytes);
    }

    /// Appends what it sent to `into`; waits up to `patience` for the first byte.
    pub fn read(&self, patience: Duration, into: &mut Vec<u8>) {
        self.to_host.take(patience, into);
    }
}

impl Drop for Native {
    fn drop(&mut self) {
        self.running.store(false, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A panic in there has been printed already.
            let _ = thread.join();
        }
    }
}

/// The machine of [`Native`].
struct Thread<L> {
    incoming: Vec<u8>,
    next: usize,
    from: Arc<Queue>,
    to: Arc<Queue>,
    running: Arc<AtomicBool>,
    start: Instant,
    log: L,
}

impl<L: FnMut(Event)> Thread<L> {
    fn fill(&mut self, patience: Duration) {
        self.incoming.clear();
        self.next = 0;
        self.from.take(patience, &mut self.incoming);
    }
}

impl<L: FnMut(Event)> Machine for Thread<L> {
    fn read(&mut self) -> Option<u8> {
        if self.next >= self.incoming.len() {
            self.fill(Duration::ZERO);
        }
        let byte = self.incoming.get(self.next).copied();
        self.next += usize::from(byte.is_some());
        byte
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        self.to.push(bytes);
        bytes.len()
    }

    fn now_ms(&mut self) -> u32 {
        self.start.elapsed().as_millis() as u32
    }

    fn idle(&mut self) {
        if self.next >= self.incoming.len() {
            self.fill(Duration::from_millis(1));
        }
    }

    fn log(&mut self, event: Event) {
        (self.log)(event);
    }

    fn is_running(&mut self) -> bool {
        self.running.load(Ordering::Relaxed)
    }
}
