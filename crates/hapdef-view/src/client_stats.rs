//! Counts of what a page was sent and what it took.

use std::sync::atomic::{AtomicU64, Ordering};

/// Most frames sent to a page that it has not yet acknowledged.
const MAX_ON_THE_WAY: u64 = 3;

/// What one page was sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ClientInfo {
    /// Frames sent.
    pub n_sent: u64,
    /// Frames that the page says it took, to draw them or the next.
    pub n_taken: u64,
    /// Number of the frame that the page says it drew last, 0: none.
    pub last_drawn: u64,
    /// Frames replaced by newer ones before they were sent.
    pub n_skipped: u64,
}

/// Counts of one page.
#[derive(Default)]
pub(crate) struct ClientStats {
    n_before: u64,
    n_sent: AtomicU64,
    n_taken: AtomicU64,
    last_drawn: AtomicU64,
}

impl ClientStats {
    /// Counts of a page that comes after `n_before` frames.
    pub(crate) fn new(n_before: u64) -> Self {
        Self { n_before, ..Self::default() }
    }

    /// One more was sent.
    pub(crate) fn sent(&self) {
        self.n_sent.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn info(&self, n_pushed: u64) -> ClientInfo {
        let n_sent = self.n_sent.load(Ordering::Relaxed);
        ClientInfo {
            n_sent,
            n_taken: self.n_taken.load(Ordering::Relaxed),
            last_drawn: self.last_drawn.load(Ordering::Relaxed).min(n_pushed),
            n_skipped: (n_pushed - self.n_before).saturating_sub(n_sent),
        }
    }

    /// Whether another frame may be sent.
    pub(crate) fn has_room(&self) -> bool {
        let n_taken = self.n_taken.load(Ordering::Relaxed);
        self.n_sent.load(Ordering::Relaxed) < n_taken + MAX_ON_THE_WAY
    }

    /// One more was taken, never more than were sent; `drawn` is the number of the last one drawn.
    pub(crate) fn took(&self, drawn: Option<u64>) {
        let n_sent = self.n_sent.load(Ordering::Relaxed);
        let n_taken = self.n_taken.load(Ordering::Relaxed);
        self.n_taken.store((n_taken + 1).min(n_sent), Ordering::Relaxed);
        if let Some(drawn) = drawn {
            self.last_drawn.store(drawn, Ordering::Relaxed);
        }
    }
}
