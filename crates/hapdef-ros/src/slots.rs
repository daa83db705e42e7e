//! Which contact is which wrench: a contact keeps its slot while it lasts.

use hapdef_contact::Contact;

/// Slots by the contacts' ids.
#[derive(Clone, Debug)]
pub(crate) struct Slots {
    ids: Vec<Option<u32>>,
}

/// What became of a slot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Slot<'a> {
    /// A contact is in it.
    Held(&'a Contact),
    /// The contact in it has just gone.
    Left,
    /// Nothing is in it.
    Free,
}

impl Slots {
    pub(crate) fn new(n_slots: usize) -> Self {
        Self { ids: vec![None; n_slots] }
    }

    /// Gives each contact whose normal is known its slot; what finds none, the last, goes without.
    /// `[n_slots]`
    pub(crate) fn place<'a>(&mut self, contacts: &'a [Contact]) -> Vec<Slot<'a>> {
        let numbered =
            || contacts.iter().enumerate().map(|(i, contact)| (contact.number(i), contact));
        let known = || numbered().filter(|(_, contact)| contact.direction.is_some());
        let find = |id: u32| known().find(|(number, _)| *number == id);
        let mut placed: Vec<Slot<'a>> = self
            .ids
            .iter()
            .map(|id| match id.map(find) {
                Some(Some((_, contact))) => Slot::Held(contact),
                Some(None) => Slot::Left,
                None => Slot::Free,
            })
            .collect();
        for (id, contact) in known() {
            if self.ids.contains(&Some(id)) {
                continue;
            }
            let is_free = |slot: &Slot<'_>| !matches!(slot, Slot::Held(_));
            let Some(free) = placed.iter().position(is_free) else {
                break;
            };
            placed[free] = Slot::Held(contact);
            self.ids[free] = Some(id);
        }
        for (id, slot) in self.ids.iter_mut().zip(&placed) {
            if !matches!(slot, Slot::Held(_)) {
                *id = None;
            }
        }
        placed
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    fn contacts(ids: &[u32]) -> Vec<Contact> {
        let contact = |&id: &u32| Contact {
            id: Some(id.into()),
            direction: Some(-Vector3::z()),
            ..Contact::new(Point3::origin(), 1.0)
        };
        ids.iter().map(contact).collect()
    }

    #[track_caller]
    fn check(slots: &mut Slots, ids: &[u32], expected: &str) {
        let contacts = contacts(ids);
        let placed = slots.place(&contacts);
        let words = placed.iter().map(|slot| match slot {
            Slot::Held(contact) => contact.number(0).to_string(),
            Slot::Left => "left".to_owned(),
            Slot::Free => "-".to_owned(),
        });
        assert_eq!(words.collect::<Vec<_>>().join(" "), expected);
    }

    #[test]
    fn a_contact_keeps_its_slot() {
        let mut slots = Slots::new(2);
        check(&mut slots, &[7], "7 -");
        check(&mut slots, &[9, 7], "7 9");
        check(&mut slots, &[9, 7, 8], "7 9");
        check(&mut slots, &[9], "left 9");
        check(&mut slots, &[9], "- 9");
        check(&mut slots, &[8, 9], "8 9");
        check(&mut slots, &[5], "5 left");
        check(&mut slots, &[], "left -");
        check(&mut slots, &[], "- -");
    }
}
