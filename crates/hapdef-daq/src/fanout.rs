//! From one thread to viewers that may be slow: the latest value, or a bounded queue.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use arc_swap::ArcSwapOption;

/// Hands values to any number of viewers and never waits for one.
pub struct Fanout<T> {
    latest: Arc<Slot<T>>,
    queues: Vec<Queue<T>>,
    n_published: u64,
}

/// Sees the latest value, as many threads as like to.
pub struct Latest<T> {
    slot: Arc<Slot<T>>,
}

/// Receives every value that fits into its queue.
pub struct Bounded<T> {
    receiver: Receiver<Arc<T>>,
    n_dropped: Arc<AtomicU64>,
}

struct Slot<T> {
    value: ArcSwapOption<(u64, T)>,
}

struct Queue<T> {
    sender: SyncSender<Arc<T>>,
    n_dropped: Arc<AtomicU64>,
}

impl<T> Default for Fanout<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T> Fanout<T> {
    /// A fanout without viewers.
    #[must_use]
    pub fn new() -> Self {
        Self {
            latest: Arc::new(Slot { value: ArcSwapOption::empty() }),
            queues: Vec::new(),
            n_published: 0,
        }
    }

    /// A viewer of the latest value.
    #[must_use]
    pub fn latest(&self) -> Latest<T> {
        Latest { slot: Arc::clone(&self.latest) }
    }

    /// A viewer of all values, of which `len` may wait; the newest is dropped and counted when it is
    /// slower than that. A viewer that was dropped is forgotten.
    pub fn bounded(&mut self, len: usize) -> Bounded<T> {
        let (sender, receiver) = sync_channel(len);
        let n_dropped = Arc::new(AtomicU64::new(0));
        self.queues.push(Queue { sender, n_dropped: Arc::clone(&n_dropped) });
        Bounded { receiver, n_dropped }
    }

    /// Hands a value to everyone.
    pub fn publish(&mut self, value: T)
    where
        T: Clone,
    {
        self.n_published += 1;
        if !self.queues.is_empty() {
            let shared = Arc::new(value.clone());
            self.queues.retain(|queue| queue.send(Arc::clone(&shared)));
        }
        let numbered = Arc::new((self.n_published, value));
        self.latest.value.store(Some(numbered));
    }
}

impl<T: Clone> Latest<T> {
    /// The latest value and its number, from 1; none before the first. A jump of the number tells
    /// how many were not looked at.
    #[must_use]
    pub fn get(&self) -> Option<(u64, T)> {
        self.slot.value.load().as_deref().cloned()
    }
}

impl<T> Bounded<T> {
    /// The next value, if one is there.
    #[must_use]
    pub fn try_recv(&self) -> Option<Arc<T>> {
        self.receiver.try_recv().ok()
    }

    /// Values that were dropped because this viewer was too slow.
    #[must_use]
    pub fn n_dropped(&self) -> u64 {
        self.n_dropped.load(Ordering::Relaxed)
    }
}

impl<T> Queue<T> {
    /// False if the viewer is gone.
    fn send(&self, value: Arc<T>) -> bool {
        match self.sender.try_send(value) {
            Ok(()) => true,
            Err(TrySendError::Full(_)) => {
                self.n_dropped.fetch_add(1, Ordering::Relaxed);
                true
            }
            Err(TrySendError::Disconnected(_)) => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slow_viewers_lose_and_know_how_many() {
        let mut fanout = Fanout::new();
        let (latest, slow, gone) = (fanout.latest(), fanout.bounded(3), fanout.bounded(1));
        assert_eq!(latest.get(), None);
        drop(gone);
        for value in 10..20 {
            fanout.publish(value);
        }
        assert_eq!(latest.get(), Some((10, 19)));
        let got: Vec<i32> = std::iter::from_fn(|| slow.try_recv()).map(|v| *v).collect();
        assert_eq!((got, slow.n_dropped()), (vec![10, 11, 12], 7));
        assert_eq!(fanout.queues.len(), 1);
    }
}
