//! The boards: what the linker, the emulator and the main loop need to know of each.
//!
//! The build script reads this file too, so it uses `core` alone.

/// What the processor's floating point can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Float {
    /// Nothing: the compiler's library does it in integers.
    Soft,
    /// 32 bits.
    Single,
    /// 32 and 64 bits.
    Double,
}

/// A piece of memory: address and bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// First address.
    pub origin: u32,
    /// Bytes.
    pub length: u32,
}

/// One line of the table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Board {
    /// Number on the wire. 0 is the native simulation.
    pub number: u8,
    /// Name on the command line.
    pub name: &'static str,
    /// Processor.
    pub processor: &'static str,
    /// Name of the emulator's machine.
    pub machine: &'static str,
    /// Target of the compiler.
    pub target: &'static str,
    /// `target-cpu` of the compiler where the target's own is too general.
    pub cpu: Option<&'static str>,
    /// Floating point.
    pub float: Float,
    /// Code.
    pub flash: Region,
    /// Data and stack.
    pub ram: Region,
    /// Base address of the CMSDK UART that carries the link.
    pub uart: u32,
    /// Clock of the SysTick timer.
    pub clock_hz: u32,
    /// Memory that the emulator can share with the host.
    pub shared: Option<Region>,
    /// Largest cloud, points. 17 bytes a point, chosen as a controller of that class could spare them.
    pub capacity: u16,
    /// Most detector steps one search may take; a search that asks for more, or for no limit, gets this.
    pub step_budget: u32,
}

const KIB: u32 = 1024;
const MIB: u32 = 1024 * KIB;

/// Bytes of stack the linker script sets aside and paints.
pub const STACK_BYTES: u32 = 32 * KIB;

/// All boards.
pub const BOARDS: [Board; 5] = [
    Board {
        number: 1,
        name: "m3",
        processor: "Cortex-M3",
        machine: "mps2-an385",
        target: "thumbv7m-none-eabi",
        cpu: None,
        float: Float::Soft,
        flash: Region { origin: 0, length: 4 * MIB },
        ram: Region { origin: 0x2000_0000, length: 4 * MIB },
        uart: 0x4000_4000,
        clock_hz: 25_000_000,
        shared: Some(Region { origin: 0x2100_0000, length: 16 * MIB }),
        capacity: 2_048,
        step_budget: 20_000,
    },
    Board {
        number: 2,
        name: "m4f",
        processor: "Cortex-M4F",
        machine: "mps2-an386",
        target: "thumbv7em-none-eabihf",
        cpu: None,
        float: Float::Single,
        flash: Region { origin: 0, length: 4 * MIB },
        ram: Region { origin: 0x2000_0000, length: 4 * MIB },
        uart: 0x4000_4000,
        clock_hz: 25_000_000,
        shared: Some(Region { origin: 0x2100_0000, length: 16 * MIB }),
        capacity: 4_096,
        step_budget: 100_000,
    },
    Board {
        number: 3,
        name: "m7",
        processor: "Cortex-M7",
        machine: "mps2-an500",
        target: "thumbv7em-none-eabihf",
        cpu: Some("cortex-m7"),
        float: Float::Double,
        flash: Region { origin: 0, length: 4 * MIB },
        ram: Region { origin: 0x2000_0000, length: 4 * MIB },
        uart: 0x4000_4000,
        clock_hz: 25_000_000,
        shared: Some(Region { origin: 0x6000_0000, length: 16 * MIB }),
        capacity: 16_384,
        step_budget: 100_000,
    },
    Board {
        number: 4,
        name: "m33",
        processor: "Cortex-M33",
        machine: "mps2-an505",
        target: "thumbv8m.main-none-eabihf",
        cpu: None,
        float: Float::Single,
        flash: Region { origin: 0x1000_0000, length: 4 * MIB },
        ram: Region { origin: 0x3800_0000, length: 2 * MIB },
        uart: 0x5020_0000,
        clock_hz: 20_000_000,
        shared: None,
        capacity: 8_192,
        step_budget: 100_000,
    },
    Board {
        number: 5,
        name: "m55",
        processor: "Cortex-M55",
        machine: "mps3-an547",
        // Not `target-cpu=cortex-m55`: the compiler would vectorise, and the vector unit flushes subnormals.
        target: "thumbv8m.main-none-eabihf",
        cpu: None,
        float: Float::Double,
        flash: Region { origin: 0, length: 512 * KIB },
        ram: Region { origin: 0x2000_0000, length: 512 * KIB },
        uart: 0x5930_3000,
        clock_hz: 32_000_000,
        shared: None,
        capacity: 16_384,
        step_budget: 100_000,
    },
];

/// Looks a board up by its name.
pub fn by_name(name: &str) -> Option<&'static Board> {
    BOARDS.iter().find(|board| board.name == name)
}
