//! One HTML page: pictures inside, nothing from outside.

mod limb;

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hapdef_mesh::atomic_write;

pub use limb::{LimbMap, LimbView};

use crate::ReportError;
use crate::figure::{Figure, FigureContent};
use crate::headline::Headline;
use crate::named_text::NamedText;
use crate::text::{TextTable, escape_html as escape};

const STYLE: &str = include_str!("page.css");

const SCRIPT: &str = include_str!("page.js");

/// A page: a title, what it rests on, and its parts from top to bottom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Heading.
    pub title: String,
    /// What it rests on.
    pub facts: Vec<NamedText>,
    /// Its parts.
    pub blocks: Vec<Block>,
}

/// A part of a page.
#[derive(Clone, Debug, PartialEq)]
pub enum Block {
    /// A heading of what follows.
    Heading(String),
    /// What is to be remembered.
    Verdict {
        /// In words.
        text: String,
        /// Whether it warns.
        warns: bool,
    },
    /// What is read first.
    Lead(String),
    /// Numbers in large type, side by side.
    Headlines(Vec<Headline>),
    /// A paragraph.
    Note(String),
    /// A table.
    Table(TextTable),
    /// A picture and its caption.
    Figure(Figure),
    /// A limb from four sides, and to be turned.
    Limb(LimbView),
}

impl Page {
    /// The whole file.
    #[must_use]
    pub fn html(&self) -> String {
        let title = escape(&self.title);
        let mut text = format!(
            "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\"/>\n\
             <title>{title}</title>\n<style>\n{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n"
        );
        let mut limbs = Vec::new();
        for block in &self.blocks {
            text.push_str(&block.html(&mut limbs));
        }
        if !self.facts.is_empty() {
            text.push_str("<h2>What this rests on</h2>\n<dl>");
            for fact in &self.facts {
                let (name, what) = (escape(&fact.name), escape(&fact.text));
                let _ = write!(text, "<dt>{name}</dt><dd>{what}</dd>");
            }
            text.push_str("</dl>\n");
        }
        if !limbs.is_empty() {
            // Numbers and colours only: nothing in them ends the script element.
            let data = limb::data(&limbs);
            let _ = write!(
                text,
                "<script type=\"application/json\" id=\"data\">{data}</script>\n\
                 <script>\n//<![CDATA[\n{SCRIPT}//]]>\n</script>\n"
            );
        }
        text.push_str("</body></html>\n");
        text
    }

    /// Writes the file, whole or not at all; its folder must exist.
    ///
    /// # Errors
    /// [`ReportError::Io`] when the disk refuses.
    pub fn write(&self, path: &Path) -> Result<(), ReportError> {
        atomic_write(path, |file| file.write_all(self.html().as_bytes()))
            .map_err(ReportError::io("writing", path))
    }
}

impl Block {
    fn html<'a>(&'a self, limbs: &mut Vec<&'a LimbView>) -> String {
        match self {
            Self::Heading(text) => format!("<h2>{}</h2>\n", escape(text)),
            Self::Verdict { text, warns } => {
                let class = if *warns { "verdict warns" } else { "verdict" };
                format!("<p class=\"{class}\">{}</p>\n", escape(text))
            }
            Self::Lead(text) => format!("<p class=\"lead\">{}</p>\n", escape(text)),
            Self::Headlines(numbers) => {
                let cells: String = numbers.iter().map(headline_html).collect();
                format!("<div class=\"headlines\">{cells}</div>\n")
            }
            Self::Note(text) => format!("<p class=\"note\">{}</p>\n", escape(text)),
            Self::Table(table) => format!("<div class=\"scroll\">{}</div>\n", table.to_html()),
            Self::Figure(figure) => figure_html(figure),
            Self::Limb(view) => {
                limbs.push(view);
                view.html(limbs.len() - 1)
            }
        }
    }
}

fn headline_html(number: &Headline) -> String {
    let [value, what, beside] = [&number.value, &number.what, &number.beside].map(|t| escape(t));
    format!("<div><b>{value}</b><span>{what}</span><small>{beside}</small></div>")
}

fn figure_html(figure: &Figure) -> String {
    let caption = escape(&figure.caption);
    let picture = match &figure.content {
        FigureContent::Svg(svg) => svg[svg.find("<svg").unwrap_or(0)..].to_owned(),
        FigureContent::Png(bytes) => {
            let data = STANDARD.encode(bytes);
            format!("<img alt=\"{caption}\" src=\"data:image/png;base64,{data}\"/>")
        }
    };
    format!("<figure>{picture}<figcaption>{caption}</figcaption></figure>\n")
}
