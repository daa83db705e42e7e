//! What several rows need, computed once.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use crate::VerifyError;

/// Values by key.
pub(crate) struct Memo<K, V>(RefCell<BTreeMap<K, Rc<V>>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(RefCell::default())
    }
}

impl<K: Ord, V> Memo<K, V> {
    /// The value of `key`, which `make` gives the first time; its errors are not kept.
    pub(crate) fn get(
        &self,
        key: K,
        make: impl FnOnce() -> Result<V, VerifyError>,
    ) -> Result<Rc<V>, VerifyError> {
        if let Some(known) = self.0.borrow().get(&key) {
            return Ok(Rc::clone(known));
        }
        let made = Rc::new(make()?);
        self.0.borrow_mut().insert(key, Rc::clone(&made));
        Ok(made)
    }
}
