//! Tiles of products by AMX: the processor's eight tile registers hold 16 rows of 64 bytes each.
//!
//! Intel 64 and IA-32 Architectures Software Developer's Manual, volume 1, chapter 18.

#![expect(
    unsafe_code,
    reason = "the tile instructions, which Rust has no stable functions for; all are in this file, \
              and each says why it is sound"
)]

use std::arch::asm;
use std::arch::x86_64::__cpuid_count;

use super::{LeftGroup, RightGroup, TILE_COLUMNS, TILE_ROWS, Target};

/// Proof that the processor has AMX with bfloat16 and that the kernel lets this process use it.
#[derive(Clone, Copy, Debug)]
pub(in crate::train) struct Amx(());

/// Proof that this thread's tile registers are set up.
pub(super) struct Tiles(());

/// What LDTILECFG reads: the palette, then bytes a row and rows of every register.
#[repr(C, align(64))]
struct Config {
    palette: u8,
    start_row: u8,
    reserved: [u8; 14],
    row_bytes: [u16; 16],
    rows: [u8; 16],
}

impl Amx {
    pub(super) fn detect() -> Option<Self> {
        const BF16: u32 = 1 << 22;
        const TILE: u32 = 1 << 24;
        let has_both =
            __cpuid_count(0, 0).eax >= 7 && __cpuid_count(7, 0).edx & (BF16 | TILE) == BF16 | TILE;
        (has_both && is_permitted()).then_some(Self(()))
    }

    /// Runs `work` with tile registers set up; they are given back afterwards.
    pub(super) fn with_tiles(self, work: impl FnOnce(&Tiles)) {
        static CONFIG: Config = Config {
            palette: 1,
            start_row: 0,
            reserved: [0; 14],
            row_bytes: [64, 64, 64, 64, 64, 64, 64, 64, 0, 0, 0, 0, 0, 0, 0, 0],
            rows: [16, 16, 16, 16, 16, 16, 16, 16, 0, 0, 0, 0, 0, 0, 0, 0],
        };
        // SAFETY: `Amx` exists only where the processor and the kernel allow it; the instruction
        // reads the 64 bytes of CONFIG.
        unsafe { asm!("ldtilecfg [{}]", in(reg) &raw const CONFIG, options(nostack, readonly)) }
        work(&Tiles(()));
        // SAFETY: as above; nothing reads the registers any more.
        unsafe { asm!("tilerelease", options(nostack, nomem)) }
    }
}

impl Tiles {
    /// The target takes the sum over the groups of products of rows and columns.
    pub(super) fn multiply(&self, mut target: Target<'_>, a: &[LeftGroup], b: &[RightGroup]) {
        if target.is_whole() {
            let at = &mut target.rows[target.at..];
            assert!(at.len() >= (TILE_ROWS - 1) * target.columns + TILE_COLUMNS, "room for a tile");
            // SAFETY: the assertion says that 16 rows of 48 sums, a row of the result apart, lie
            // within the slice.
            unsafe { self.add(at.as_mut_ptr(), target.columns, target.is_first, a, b) }
        } else {
            let mut tile = [[0.0; TILE_COLUMNS]; TILE_ROWS];
            target.read(&mut tile);
            // SAFETY: a tile is 16 rows of 48 sums.
            unsafe {
                self.add(tile.as_mut_ptr().cast(), TILE_COLUMNS, target.is_first, a, b);
            }
            target.write(&tile);
        }
    }

    /// The 16 × 48 sums at `sums`, `stride` of them from row to row, become the sum over the groups
    /// of products of rows and columns, plus what they were unless `is_first`.
    ///
    /// # Safety
    ///
    /// The sums must be this caller's to write.
    unsafe fn add(
        &self,
        sums: *mut f32,
        stride: usize,
        is_first: bool,
        a: &[LeftGroup],
        b: &[RightGroup],
    ) {
        assert!(a.len() == b.len() && !a.is_empty(), "groups of a product");
        // SAFETY: `Tiles` exists only while the registers are set up for 16 rows of 64 bytes. A
        // step of the loop reads one group of each side, 1024 and 3072 bytes; rows of `b` are 192
        // bytes apart, those of `sums` as the caller says, and three registers side by side cover
        // them.
        unsafe {
            asm!(
                "test {is_first}, {is_first}",
                "jz 2f",
                "tilezero tmm0",
                "tilezero tmm1",
                "tilezero tmm2",
                "jmp 3f",
                "2:",
                "tileloadd tmm0, [{sums} + {stride}]",
                "tileloadd tmm1, [{sums} + {stride} + 64]",
                "tileloadd tmm2, [{sums} + {stride} + 128]",
                "3:",
                "tileloadd tmm3, [{a} + {a_row}]",
                "tileloadd tmm4, [{b} + {b_row}]",
                "tdpbf16ps tmm0, tmm3, tmm4",
                "tileloadd tmm5, [{b} + {b_row} + 64]",
                "tdpbf16ps tmm1, tmm3, tmm5",
                "tileloadd tmm6, [{b} + {b_row} + 128]",
                "tdpbf16ps tmm2, tmm3, tmm6",
                "add {a}, 1024",
                "add {b}, 3072",
                "dec {n}",
                "jnz 3b",
                "tilestored [{sums} + {stride}], tmm0",
                "tilestored [{sums} + {stride} + 64], tmm1",
                "tilestored [{sums} + {stride} + 128], tmm2",
                is_first = in(reg) u64::from(is_first),
                a = inout(reg) a.as_ptr() => _,
                b = inout(reg) b.as_ptr() => _,
                n = inout(reg) a.len() => _,
                sums = in(reg) sums,
                stride = in(reg) 4 * stride,
                a_row = in(reg) 64_usize,
                b_row = in(reg) 192_usize,
                out("tmm0") _, out("tmm1") _, out("tmm2") _, out("tmm3") _,
                out("tmm4") _, out("tmm5") _, out("tmm6") _,
                options(nostack),
            );
        }
    }
}

/// Whether the kernel lets this process use tile registers: asked for once, held from then on.
#[cfg(target_os = "linux")]
fn is_permitted() -> bool {
    const SYS_ARCH_PRCTL: i64 = 158;
    const REQUEST: i64 = 0x1023;
    const TILE_DATA: i64 = 18;
    let answer: i64;
    // SAFETY: arch_prctl(ARCH_REQ_XCOMP_PERM, XFEATURE_XTILEDATA) reads and writes no memory of
    // ours; a kernel that does not know it answers with an error.
    unsafe {
        asm!(
            "syscall",
            inlateout("rax") SYS_ARCH_PRCTL => answer,
            in("rdi") REQUEST,
            in("rsi") TILE_DATA,
            lateout("rcx") _,
            lateout("r11") _,
            options(nostack),
        );
    }
    answer == 0
}

/// Other systems are not asked.
#[cfg(not(target_os = "linux"))]
fn is_permitted() -> bool {
    false
}
