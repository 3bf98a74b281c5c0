//! Bytes to and from a co-processor, whatever lies between.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Write};
use std::os::unix::fs::FileExt;
use std::os::unix::net::UnixStream;
use std::time::{Duration, Instant};

use varsac_firmware_sim::native::Native;
use varsac_firmware_sim::rings::{self, Ring};

use crate::error::InputError;

/// A stream of bytes in both directions.
pub trait Transport {
    /// Appends what came to `into`; waits up to `patience` for the first byte.
    ///
    /// # Errors
    /// When the other end is gone for good.
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()>;

    /// Sends all of it.
    ///
    /// # Errors
    /// When the other end is gone for good.
    fn write(&mut self, bytes: &[u8]) -> io::Result<()>;
}

impl<T: Transport + ?Sized> Transport for Box<T> {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()> {
        (**self).read(patience, into)
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        (**self).write(bytes)
    }
}

/// A co-processor in a thread of this program.
pub struct Thread(pub Native);

impl Transport for Thread {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()> {
        self.0.read(patience, into);
        Ok(())
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write(bytes);
        Ok(())
    }
}

/// The UART of an emulated board.
pub struct Socket(pub UnixStream);

impl Transport for Socket {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()> {
        self.0.set_read_timeout(Some(patience.max(Duration::from_millis(1))))?;
        let mut buffer = [0; 4096];
        match self.0.read(&mut buffer) {
            Ok(0) => Err(io::Error::new(ErrorKind::UnexpectedEof, "the emulator has ended")),
            other => append(other, &buffer, into),
        }
    }

    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.0.write_all(bytes)
    }
}

/// A real co-processor.
pub struct Serial(Box<dyn serialport::SerialPort>);

impl Serial {
    /// Opens `device` with 8 data bits, no parity, one stop bit.
    ///
    /// # Errors
    /// When the device cannot be opened.
    pub fn open(device: &str, baud: u32) -> Result<Self, InputError> {
        let port = serialport::new(device, baud).timeout(Duration::from_millis(10)).open();
        port.map(Self).map_err(|error| {
            InputError::at(
                device,
                format!("cannot be opened as a serial port ({error})"),
                "check the name, the cable and your permission to use it",
            )
        })
    }
}

impl Transport for Serial {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()> {
        self.0.set_timeout(patience.max(Duration::from_millis(1)))?;
        let mut buffer = [0; 4096];
        append(self.0.read(&mut buffer), &buffer, into)
    }

    fn write(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        // A slow line takes its time; a stuck one has ten seconds.
        let deadline = Instant::now() + Duration::from_secs(10);
        while !bytes.is_empty() {
            match self.0.write(bytes) {
                Ok(count) => bytes = bytes.get(count..).unwrap_or(&[]),
                Err(error) if is_patience(&error) && Instant::now() < deadline => {}
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }
}

/// Memory shared with an emulated board, as the file that the emulator maps. Plain reads and writes of the file are
/// the same memory; they need no mapping on this side.
pub struct Rings {
    file: File,
    /// Next byte to write.
    write: u32,
    /// Next byte to read.
    read: u32,
}

impl Rings {
    /// Lays the rings out in `file`, before the board starts.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn lay_out(file: File, length: u64) -> io::Result<Self> {
        file.set_len(length)?;
        file.write_all_at(&vec![0; rings::LENGTH as usize], 0)?;
        file.write_all_at(&rings::MAGIC.to_le_bytes(), u64::from(rings::MAGIC_AT))?;
        Ok(Self { file, write: 0, read: 0 })
    }

    fn word(&self, at: u32) -> io::Result<u32> {
        let mut bytes = [0; 4];
        self.file.read_exact_at(&mut bytes, u64::from(at))?;
        Ok(u32::from_le_bytes(bytes))
    }

    fn set_word(&self, at: u32, value: u32) -> io::Result<()> {
        self.file.write_all_at(&value.to_le_bytes(), u64::from(at))
    }
}

impl Transport for Rings {
    fn read(&mut self, patience: Duration, into: &mut Vec<u8>) -> io::Result<()> {
        let Ring { write_at, read_at, bytes_at } = rings::TO_HOST;
        let start = Instant::now();
        let filled = loop {
            let filled = rings::filled(self.word(write_at)?, self.read);
            if filled > 0 || start.elapsed() >= patience {
                break filled;
            }
            // Answers come within microseconds while a cloud is on its way, within milliseconds while it is searched.
            if start.elapsed() > Duration::from_micros(200) {
                std::thread::sleep(Duration::from_micros(50));
            } else {
                std::thread::yield_now();
            }
        };
        let mut buffer = vec![0; filled as usize];
        let from = self.read % rings::RING;
        let straight = (rings::RING - from).min(filled) as usize;
        let (head, tail) = buffer.split_at_mut(straight);
        self.file.read_exact_at(head, u64::from(bytes_at + from))?;
        self.file.read_exact_at(tail, u64::from(bytes_at))?;
        self.read = self.read.wrapping_add(filled);
        self.set_word(read_at, self.read)?;
        into.extend(buffer);
        Ok(())
    }

    fn write(&mut self, mut bytes: &[u8]) -> io::Result<()> {
        let Ring { write_at, read_at, bytes_at } = rings::TO_BOARD;
        let deadline = Instant::now() + Duration::from_secs(10);
        while !bytes.is_empty() {
            let room = rings::RING - rings::filled(self.write, self.word(read_at)?);
            let to = self.write % rings::RING;
            let (now, later) = bytes.split_at(bytes.len().min(room.min(rings::RING - to) as usize));
            if now.is_empty() {
                if Instant::now() > deadline {
                    return Err(io::Error::new(ErrorKind::TimedOut, "the board does not read"));
                }
                std::thread::yield_now();
            }
            self.file.write_all_at(now, u64::from(bytes_at + to))?;
            self.write = self.write.wrapping_add(now.len() as u32);
            self.set_word(write_at, self.write)?;
            bytes = later;
        }
        Ok(())
    }
}

fn append(read: io::Result<usize>, buffer: &[u8], into: &mut Vec<u8>) -> io::Result<()> {
    match read {
        Ok(count) => into.extend(buffer.iter().take(count)),
        Err(error) if is_patience(&error) => {}
        Err(error) => return Err(error),
    }
    Ok(())
}

fn is_patience(error: &io::Error) -> bool {
    matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}
