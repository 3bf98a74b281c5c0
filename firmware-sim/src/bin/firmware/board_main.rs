//! The main loop's machine on a board: UART or shared memory, SysTick, log through the emulator.

use core::sync::atomic::{AtomicU32, Ordering};

use cortex_m::peripheral::syst::SystClkSource;
use cortex_m_rt::{entry, exception};
use defmt_semihosting as _;
use varsac_firmware_sim::app::{self, Event, Limits, Machine, Memory};

use crate::hardware::{SharedMemory, Uart, stack_high_water};
use crate::startup::{BOARD, check_arithmetic};

/// Milliseconds since start.
static NOW_MS: AtomicU32 = AtomicU32::new(0);

defmt::timestamp!("{=u32:ms}", NOW_MS.load(Ordering::Relaxed));

/// Polls without a byte after which the core sleeps to the next tick: long enough not to sleep between two bytes.
const PATIENCE: u32 = 20_000;

struct Hardware {
    uart: Uart,
    shared: Option<SharedMemory>,
    idle_turns: u32,
}

impl Machine for Hardware {
    fn read(&mut self) -> Option<u8> {
        let byte = match &mut self.shared {
            Some(shared) => shared.read(),
            None => self.uart.read(),
        };
        if byte.is_some() {
            self.idle_turns = 0;
        }
        byte
    }

    fn write(&mut self, bytes: &[u8]) -> usize {
        let taken = |&&byte: &&u8| match &mut self.shared {
            Some(shared) => shared.write(byte),
            None => self.uart.write(byte),
        };
        bytes.iter().take_while(taken).count()
    }

    fn now_ms(&mut self) -> u32 {
        NOW_MS.load(Ordering::Relaxed)
    }

    fn idle(&mut self) {
        self.idle_turns += 1;
        if self.idle_turns > PATIENCE {
            cortex_m::asm::wfi();
        }
    }

    fn stack_bytes(&mut self) -> Option<u32> {
        Some(stack_high_water())
    }

    fn log(&mut self, event: Event) {
        match event {
            Event::Refused(..) | Event::Objected(_) | Event::Lost(_) => defmt::warn!("{}", event),
            Event::Found { .. } => defmt::debug!("{}", event),
            _ => defmt::info!("{}", event),
        }
    }
}

#[entry]
fn main() -> ! {
    check_arithmetic();
    let memory = cortex_m::singleton!(: Memory<{ BOARD.capacity as usize }> = Memory::new());
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SYST.set_clock_source(SystClkSource::Core);
        core.SYST.set_reload(BOARD.clock_hz / 1000 - 1);
        core.SYST.clear_current();
        core.SYST.enable_interrupt();
        core.SYST.enable_counter();
    }
    let shared = BOARD.shared.and_then(|region| SharedMemory::find(region.origin));
    defmt::info!("{=str}, {=u16} points, rings {=bool}", BOARD.processor, BOARD.capacity, shared.is_some());
    let mut machine = Hardware { uart: Uart::new(BOARD.uart), shared, idle_turns: 0 };
    let limits = Limits { board: BOARD.number, capacity: BOARD.capacity, step_budget: BOARD.step_budget };
    if let Some(memory) = memory {
        app::run(&mut machine, memory, &limits);
    }
    unreachable!("the memory is taken once and the machine runs for ever")
}

#[exception]
fn SysTick() {
    // One core, one writer: no need for an atomic addition, which not all cores have.
    NOW_MS.store(NOW_MS.load(Ordering::Relaxed).wrapping_add(1), Ordering::Relaxed);
}
