//! Asking a serial driver to hand on bytes at once.
//!
//! Linux: ASYNC_LOW_LATENCY by TIOCSSERIAL (linux/serial.h, linux/tty_flags.h); for FTDI chips it
//! sets the latency timer from 16 ms to 1 ms. No crate offers the call, hence the `unsafe`.

/// True if the driver has agreed.
#[cfg(target_os = "linux")]
#[expect(unsafe_code, reason = "two ioctls that no crate wraps")]
pub(crate) fn ask(port: &impl std::os::fd::AsRawFd) -> bool {
    use std::os::fd::BorrowedFd;

    use rustix::ioctl::{Getter, Setter, ioctl};

    // SAFETY: `port` owns the descriptor and lives as long as the borrow.
    let fd = unsafe { BorrowedFd::borrow_raw(port.as_raw_fd()) };
    // SAFETY: TIOCGSERIAL fills a `struct serial_struct`, which `SerialStruct` mirrors.
    let got = unsafe { ioctl(fd, Getter::<TIOCGSERIAL, SerialStruct>::new()) };
    let Ok(mut settings) = got else { return false };
    settings.flags |= ASYNC_LOW_LATENCY;
    // SAFETY: TIOCSSERIAL reads a `struct serial_struct`, here the kernel's own with one flag more.
    unsafe { ioctl(fd, Setter::<TIOCSSERIAL, SerialStruct>::new(settings)) }.is_ok()
}

/// False: this system has no such call.
#[cfg(not(target_os = "linux"))]
pub(crate) fn ask<Port>(_port: &Port) -> bool {
    false
}

#[cfg(target_os = "linux")]
const TIOCGSERIAL: rustix::ioctl::Opcode = 0x541e;
#[cfg(target_os = "linux")]
const TIOCSSERIAL: rustix::ioctl::Opcode = 0x541f;
#[cfg(target_os = "linux")]
const ASYNC_LOW_LATENCY: i32 = 1 << 13;

/// `struct serial_struct` of linux/serial.h.
#[cfg(target_os = "linux")]
#[repr(C)]
struct SerialStruct {
    kind: i32,
    line: i32,
    port: u32,
    irq: i32,
    flags: i32,
    xmit_fifo_size: i32,
    custom_divisor: i32,
    baud_base: i32,
    close_delay: u16,
    io_type: u8,
    reserved_char: [u8; 1],
    hub6: i32,
    closing_wait: u16,
    closing_wait2: u16,
    iomem_base: usize,
    iomem_reg_shift: u16,
    port_high: u32,
    iomap_base: usize,
}

#[cfg(all(test, target_os = "linux", target_pointer_width = "64"))]
mod tests {
    #[test]
    fn the_mirror_has_the_kernels_size() {
        // sizeof(struct serial_struct) on 64-bit Linux.
        assert_eq!(size_of::<super::SerialStruct>(), 72);
    }
}
