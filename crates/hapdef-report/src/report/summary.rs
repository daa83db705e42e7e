//! What a reader sees first: a sentence, a few numbers, a picture, and where to go on.

use serde::Serialize;

use crate::figure::Figure;
use crate::headline::Headline;
use crate::page::Block;

/// The top of a report.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// What was found.
    pub sentence: String,
    /// The numbers that matter.
    pub numbers: Vec<Headline>,
    /// The picture that shows it, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub picture: Option<Figure>,
    /// What to open or to do next, a line each.
    pub next: Vec<String>,
}

impl Summary {
    pub(super) fn blocks(&self) -> Vec<Block> {
        let mut blocks = vec![Block::Lead(self.sentence.clone())];
        if !self.numbers.is_empty() {
            blocks.push(Block::Headlines(self.numbers.clone()));
        }
        blocks.extend(self.picture.clone().map(Block::Figure));
        if !self.next.is_empty() {
            blocks.push(Block::Heading("Next".into()));
            blocks.extend(self.next.iter().cloned().map(Block::Note));
        }
        blocks
    }

    pub(super) fn markdown(&self) -> String {
        let mut text = format!("\n{}\n\n", self.sentence);
        for number in &self.numbers {
            text.push_str(&format!(
                "- {}: **{}** ({})\n",
                number.what, number.value, number.beside
            ));
        }
        if let Some(picture) = &self.picture {
            text.push_str(&format!("\n![]({})\n\n{}\n", picture.file, picture.caption));
        }
        for line in &self.next {
            text.push_str(&format!("\n- {line}"));
        }
        text + "\n"
    }
}
