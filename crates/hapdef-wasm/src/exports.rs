//! The functions that a browser calls. One session for a module; memory is handed over by address and length.
//!
//! A page asks for memory by [`hapdef_alloc`], writes there, and calls: [`hapdef_open`] with a model,
//! [`hapdef_hear`] with a message, [`hapdef_step`]. [`hapdef_next`] takes the next message for the page, which is
//! read at [`hapdef_message`].

#![allow(
    unsafe_code,
    reason = "functions of a WebAssembly module are exported by name, and what a page writes is read at its address"
)]

use std::cell::RefCell;

use crate::model::PageModel;
use crate::session::{PageMessage, Session};

/// What [`hapdef_next`] found.
const NOTHING: u32 = 0;
const TEXT: u32 = 1;
const BYTES: u32 = 2;

#[derive(Default)]
struct Module {
    session: Option<Session>,
    /// What a page has written, or is to write.
    inbox: Vec<u8>,
    /// The message that was taken, or why there is no session.
    message: Vec<u8>,
}

thread_local! {
    static MODULE: RefCell<Module> = RefCell::default();
}

/// Where the page may write `len` bytes for the next call.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_alloc(len: usize) -> *mut u8 {
    MODULE.with_borrow_mut(|module| {
        module.inbox.clear();
        module.inbox.resize(len, 0);
        module.inbox.as_mut_ptr()
    })
}

/// Opens the model that was written: 1, or 0 with the reason as the message.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_open() -> u32 {
    MODULE.with_borrow_mut(|module| {
        let packed = std::mem::take(&mut module.inbox);
        match PageModel::from_bytes(&packed).and_then(|model| Session::new(&model)) {
            Ok(session) => {
                module.session = Some(session);
                1
            }
            Err(error) => {
                module.message = error.to_string().into_bytes();
                0
            }
        }
    })
}

/// Frames per second; 0 where nothing is open.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_rate_hz() -> f64 {
    MODULE.with_borrow(|module| module.session.as_ref().map_or(0.0, Session::rate_hz))
}

/// Hears the message of the page that was written.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_hear() {
    MODULE.with_borrow_mut(|module| {
        let text = String::from_utf8_lossy(&module.inbox).into_owned();
        if let Some(session) = &mut module.session {
            session.hear(&text);
        }
    });
}

/// So many frames more; the last of them becomes a message.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_step(n_frames: u32) {
    MODULE.with_borrow_mut(|module| {
        if let Some(session) = &mut module.session {
            session.step(n_frames);
        }
    });
}

/// Takes the next message for the page: 0 there is none, 1 a text, 2 bytes.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_next() -> u32 {
    MODULE.with_borrow_mut(|module| {
        let (kind, message) = match module.session.as_mut().and_then(Session::next_message) {
            None => (NOTHING, Vec::new()),
            Some(PageMessage::Text(text)) => (TEXT, text.into_bytes()),
            Some(PageMessage::Bytes(bytes)) => (BYTES, bytes),
        };
        module.message = message;
        kind
    })
}

/// Where the message is that was taken last.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_message() -> *const u8 {
    MODULE.with_borrow(|module| module.message.as_ptr())
}

/// How many bytes it has.
#[unsafe(no_mangle)]
pub extern "C" fn hapdef_message_len() -> usize {
    MODULE.with_borrow(|module| module.message.len())
}
