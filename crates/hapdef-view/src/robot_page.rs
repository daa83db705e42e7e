//! The page of a robot: its limbs' pages side by side, in frames.

/// Where the page of a limb is, below the robot's.
pub(crate) fn limb_path(name: &str) -> String {
    format!("/limb/{name}/")
}

/// The page, with the robot's name and a frame for each limb, whose names are words.
pub(crate) fn robot_page(robot: &str, limbs: &[String]) -> String {
    let robot = escaped(robot);
    let frames: String = limbs.iter().map(|name| limb_frame(name)).collect();
    format!(
        "<!doctype html>\n\
         <html lang=\"en\">\n\
         <head>\n\
         <meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"dark light\">\n\
         <title>{robot}</title>\n\
         <link rel=\"icon\" href=\"icon.svg\">\n\
         <link rel=\"stylesheet\" href=\"style.css\">\n\
         <link rel=\"stylesheet\" href=\"robot.css\">\n\
         <script type=\"module\" src=\"js/robot.js\"></script>\n\
         </head>\n\
         <body>\n\
         <header><h1>{robot}</h1></header>\n\
         <main id=\"limbs\">\n\
         {frames}\
         </main>\n\
         </body>\n\
         </html>\n"
    )
}

fn limb_frame(name: &str) -> String {
    let name = escaped(name);
    format!(
        "<section aria-label=\"{name}\">\n\
         <h2><a data-limb=\"{name}\" title=\"{name} alone\">{name}</a></h2>\n\
         <iframe data-limb=\"{name}\" title=\"{name}\"></iframe>\n\
         </section>\n"
    )
}

/// Text as it stands in HTML.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in hapdef_contact::printable(text).chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            _ => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::robot_page;
    use crate::assets::find;

    #[test]
    fn nothing_is_inline_and_a_name_is_no_markup() {
        let page = robot_page("<b onclick=\"x\">'&", &["a".to_owned()]);
        assert!(page.contains("&lt;b onclick=&quot;x&quot;&gt;&#39;&amp;"), "{page}");
        assert_eq!(page.matches("<script").count(), 1);
        for inline in ["style=", "<style", "<b ", "src=\"/", "href=\"/"] {
            assert!(!page.contains(inline), "{inline}");
        }
    }

    #[test]
    fn its_files_are_served() {
        let page = robot_page("arm", &[]);
        for (name, quoted) in [("href", "href=\""), ("src", "src=\"")] {
            for rest in page.split(quoted).skip(1) {
                let file = rest.split('"').next().unwrap();
                assert!(find(&format!("/{file}")).is_some(), "{name} {file}");
            }
        }
    }
}
