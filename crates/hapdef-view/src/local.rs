//! A page that is reached without a server: its messages, and what it says.

use crate::command::{PageMessage, ViewCommand};
use crate::device::DeviceState;
use crate::error::ViewError;
use crate::frame::ViewFrame;
use crate::offers::Offers;
use crate::picture::LimbPicture;
use crate::wire;

/// The messages between a program and the one page that it reaches by itself.
#[derive(Clone, Debug)]
pub struct LocalPage {
    picture: LimbPicture,
    offers: Offers,
    n_frames: u64,
}

impl LocalPage {
    /// Of a limb; whoever sees the page may do all that is offered.
    ///
    /// # Errors
    /// [`ViewError`] for a picture or an offer that can't be shown.
    pub fn new(picture: LimbPicture, offers: Offers) -> Result<Self, ViewError> {
        offers.check()?;
        picture.check()?;
        Ok(Self { picture, offers, n_frames: 0 })
    }

    /// The limb.
    #[must_use]
    pub fn picture(&self) -> &LimbPicture {
        &self.picture
    }

    /// The first message, a text.
    #[must_use]
    pub fn hello(&self) -> String {
        serde_json::json!(wire::Hello::new(&self.picture, &self.offers, true)).to_string()
    }

    /// Where readings come from, a text.
    #[must_use]
    pub fn device(&self, state: &DeviceState) -> String {
        wire::device(state)
    }

    /// The limb's surface, bytes.
    #[must_use]
    pub fn surface(&self) -> Vec<u8> {
        wire::surface(&self.picture)
    }

    /// A frame, bytes.
    ///
    /// # Errors
    /// [`ViewError`] for a frame that does not fit the picture, or has a contact that is not finite.
    pub fn frame(&mut self, frame: &ViewFrame) -> Result<Vec<u8>, ViewError> {
        frame.check(self.picture.vertices_m.len(), self.picture.gauges.len())?;
        self.n_frames += 1;
        Ok(wire::frame(frame, self.n_frames))
    }

    /// Words for whoever sees the page, a text.
    #[must_use]
    pub fn notice(&self, words: &str) -> String {
        wire::notice(&hapdef_contact::printable(words))
    }

    /// What the page asks for by a message, if that is a command.
    ///
    /// # Errors
    /// The text that answers a message that is none, or asks for what is not offered.
    pub fn read(&self, text: &str) -> Result<Option<ViewCommand>, String> {
        let command = PageMessage::parse(text).and_then(|message| message.command(&self.offers));
        command.map_err(|why| wire::refusal(&why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::offers::PressOffer;

    fn page() -> LocalPage {
        let picture = LimbPicture {
            title: "limb".to_owned(),
            vertices_m: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            normals: vec![[0.0, 0.0, 1.0]; 3],
            triangles: vec![[0, 1, 2]],
            ..LimbPicture::default()
        };
        let press = Some(PressOffer { default_n: 1.0, max_n: 2.0 });
        LocalPage::new(picture, Offers { press, ..Offers::default() }).unwrap()
    }

    #[test]
    fn it_has_the_messages_of_the_server() {
        let mut page = page();
        let hello: serde_json::Value = serde_json::from_str(&page.hello()).unwrap();
        assert_eq!(hello["type"], "hello");
        assert_eq!(hello["offers"]["press"]["max_n"], 2.0);
        assert_eq!(page.surface()[..2], [1, 4]);
        let bytes = page.frame(&ViewFrame::default()).unwrap();
        assert_eq!(bytes[..8], [2, 4, 0, 0, 1, 0, 0, 0]);
        let wrong = ViewFrame { readings_ue: vec![0.0], ..ViewFrame::default() };
        assert!(page.frame(&wrong).is_err());
    }

    #[test]
    fn commands_are_read_and_others_refused() {
        let page = page();
        assert_eq!(page.read(r#"{"cmd":"release"}"#), Ok(Some(ViewCommand::Release)));
        assert_eq!(page.read(r#"{"cmd":"got","drawn":1}"#), Ok(None));
        for text in [r#"{"cmd":"tare"}"#, "nonsense"] {
            let answer = page.read(text).unwrap_err();
            assert!(answer.contains(r#""type":"refused""#), "{answer}");
        }
    }
}
