//! What the limbs of a robot know of contacts, for the message of all of them.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::msg::{Contacts, Header, RobotContacts, Time};

/// Least time between two messages of all limbs, ns.
const PERIOD_NS: u64 = 10_000_000;

/// Where each limb of a robot leaves its newest contacts. Clones are the same board, one for each limb's encoder
/// ([`crate::RosEncoder::beside`]).
#[derive(Clone, Debug, Default)]
pub struct RobotBoard {
    shared: Arc<Mutex<Board>>,
}

#[derive(Debug, Default)]
struct Board {
    /// By the limbs' numbers; none of a limb that is silent.
    limbs: Vec<Option<(u64, Contacts)>>,
    next_ns: u64,
}

impl RobotBoard {
    /// Takes the newest contacts of limb number `limb`; the message of all limbs where it is time for one, 100 times a
    /// second.
    pub(crate) fn put(
        &self,
        limb: usize,
        stamp_ns: u64,
        contacts: Contacts,
    ) -> Option<RobotContacts> {
        let mut board = self.lock();
        board.set(limb, Some((stamp_ns, contacts)));
        if stamp_ns < board.next_ns {
            return None;
        }
        board.next_ns = stamp_ns + PERIOD_NS;
        let known = board.limbs.iter().flatten();
        let newest_ns = known.clone().map(|(stamp_ns, _)| *stamp_ns).max()?;
        Some(RobotContacts {
            header: Header { stamp: Time::from_ns(newest_ns), frame_id: String::new() },
            limbs: known.map(|(_, contacts)| contacts.clone()).collect(),
        })
    }

    /// Nothing is known of that limb any more.
    pub(crate) fn leave_out(&self, limb: usize) {
        self.lock().set(limb, None);
    }

    fn lock(&self) -> MutexGuard<'_, Board> {
        self.shared.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Board {
    fn set(&mut self, limb: usize, known: Option<(u64, Contacts)>) {
        if self.limbs.len() <= limb {
            self.limbs.resize(limb + 1, None);
        }
        self.limbs[limb] = known;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seqs(message: Option<RobotContacts>) -> Option<Vec<u32>> {
        message.map(|message| message.limbs.iter().map(|limb| limb.seq).collect())
    }

    #[test]
    fn all_limbs_are_told_a_hundred_times_a_second_by_whoever_speaks() {
        let board = RobotBoard::default();
        let other = board.clone();
        let of = |seq| Contacts { seq, ..Contacts::default() };
        let ms = 1_000_000;
        assert_eq!(seqs(board.put(1, 100 * ms, of(1))), Some(vec![1]));
        assert_eq!(seqs(other.put(0, 105 * ms, of(2))), None);
        let message = board.put(1, 110 * ms, of(3)).unwrap();
        assert_eq!(message.header.stamp, Time::from_ns(110 * ms));
        assert_eq!(seqs(Some(message)), Some(vec![2, 3]));
        other.leave_out(0);
        assert_eq!(seqs(board.put(1, 120 * ms, of(4))), Some(vec![4]));
    }
}
