//! The report as one HTML page: pictures inside, no scripts, no network.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::{Figure, FigureContent, Report, record_tables};
use crate::tables::claims_text;
use crate::tables::text::escape_html as escape;

const STYLE: &str = "
:root{color-scheme:light dark;--ink:#222;--paper:#fff;--line:#ddd;--soft:#f5f5f5;--held:#00734f}
@media(prefers-color-scheme:dark){:root{--ink:#ddd;--paper:#16181b;--line:#3a3d42;--soft:#1f2226;--held:#4fd1a0}}
body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:70rem;margin:0 auto;padding:1.5rem}
h1{font-size:1.6rem}h2{font-size:1.2rem;margin-top:2.5rem;border-bottom:1px solid var(--line)}
table{border-collapse:collapse;font-size:.9rem;font-variant-numeric:tabular-nums}
th,td{padding:.25rem .7rem;border-bottom:1px solid var(--line);text-align:left;vertical-align:top}
th{background:var(--soft)}strong{color:var(--held)}
.scroll{overflow-x:auto}
figure{margin:1.5rem 0}figure svg,figure img{max-width:100%;height:auto;background:#fff;border-radius:6px}
figcaption,.note{font-size:.9rem;opacity:.85}
dl{display:grid;grid-template-columns:max-content 1fr;gap:.1rem 1rem}dt{opacity:.7}dd{margin:0;overflow-wrap:anywhere}
@media print{:root{--ink:#000;--paper:#fff;--line:#bbb;--soft:#eee;--held:#000}body{max-width:none;padding:0;font-size:11pt}figure,tr{break-inside:avoid}h2{break-after:avoid}}
";

/// The whole page.
pub(super) fn page(report: &Report) -> String {
    let title = escape(&report.title);
    let mut text = format!(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style></head>\n<body>\n<h1>{title}</h1>\n\
         <dl><dt>scene</dt><dd>{}</dd>",
        escape(&report.scene)
    );
    for fact in &report.facts {
        text.push_str(&format!(
            "<dt>{}</dt><dd>{}</dd>",
            escape(&fact.name),
            escape(&fact.text)
        ));
    }
    text.push_str("</dl>\n");
    if !report.claims.is_empty() {
        let claims = claims_text(&report.claims).to_html();
        text.push_str(&section("What the paper claims", &claims));
    }
    for table in &report.tables {
        text.push_str(&section(&table.title, &table.text.to_html()));
        if !table.note.is_empty() {
            text.push_str(&format!("<p class=\"note\">{}</p>\n", escape(&table.note)));
        }
    }
    if !report.figures.is_empty() {
        text.push_str("<h2>Figures</h2>\n");
    }
    report
        .figures
        .iter()
        .for_each(|figure| text.push_str(&figure_html(figure)));
    for (title, table) in record_tables(report) {
        text.push_str(&section(title, &table.to_html()));
    }
    text.push_str("</body></html>\n");
    text
}

fn section(title: &str, table: &str) -> String {
    format!(
        "<h2>{}</h2>\n<div class=\"scroll\">{table}</div>\n",
        escape(title)
    )
}

fn figure_html(figure: &Figure) -> String {
    let caption = escape(&figure.caption);
    let picture = match &figure.content {
        FigureContent::Svg(svg) => svg[svg.find("<svg").unwrap_or(0)..].to_owned(),
        FigureContent::Png(bytes) => {
            let data = STANDARD.encode(bytes);
            format!("<img alt=\"{caption}\" src=\"data:image/png;base64,{data}\">")
        }
    };
    format!("<figure>{picture}<figcaption>{caption}</figcaption></figure>\n")
}
