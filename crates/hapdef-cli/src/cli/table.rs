//! Tables of numbers as loggers and spreadsheets write them: commas, semicolons or tabs between,
//! decimal commas, comments, a byte-order mark, names in the first line, columns of other things; or the
//! messages of a topic in an MCAP file.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use hapdef_cli::shown;
use hapdef_daq::record::{NumbersTopic, is_mcap};

use super::topic::TopicArgs;

/// The topic of the tared readings in a recording with contacts.
const GAUGES: &str = "/hapdef/gauges";

/// A row and where it stands.
#[derive(Debug, PartialEq)]
pub(super) struct Row {
    /// Its line or message, from 1, in words.
    pub(super) place: String,
    /// The columns that were asked for, in their order.
    pub(super) values: Vec<f64>,
}

/// Reads the columns `leading` and then one for each of `gauges` from the table at `path`.
///
/// A first line that is no numbers names the columns: a gauge's has its name, with or without `_ue`,
/// and columns with other names, such as the time, are passed over. Where it names no gauge at all,
/// or numbers them as `hapdef probe` does, and without names, the columns are all there are, in order.
/// Lines that start with `#` are comments. Of an MCAP file the numbers of a topic's messages are the
/// columns, by their names where they have some.
///
/// # Errors
/// A table without rows, a column that is not there, or what is no finite number, with its line.
pub(super) fn read_table(
    path: &Path,
    topic: &TopicArgs,
    leading: &[&str],
    gauges: &[&str],
) -> Result<Vec<Row>> {
    let file = shown(path);
    if is_mcap(path)? {
        let topic = topic.topic.as_deref().unwrap_or(GAUGES);
        return message_rows(NumbersTopic::open(path, topic)?, leading, gauges).context(file);
    }
    ensure!(topic.topic.is_none(), "{file}: --topic: no MCAP file, so it has no topics");
    let bytes = std::fs::read(path).with_context(|| format!("{file}: reading"))?;
    rows(&String::from_utf8_lossy(&bytes), leading, gauges).context(file)
}

/// Names of the columns of the contact number `i` from 0, in m and N, as `hapdef probe` writes them.
pub(super) fn contact_columns(i: usize) -> [String; 4] {
    let number = if i == 0 { String::new() } else { (i + 1).to_string() };
    let at = |axis: char| format!("{axis}{number}_m");
    [at('x'), at('y'), at('z'), format!("force{number}_n")]
}

/// How many contacts the first line of the table at `path` names.
///
/// # Errors
/// A table that names none.
pub(super) fn n_contacts(path: &Path) -> Result<usize> {
    let names = column_names(path)?;
    let is_named = |name: &String| names.iter().any(|found| found.eq_ignore_ascii_case(name));
    let n = (0..).take_while(|&i| contact_columns(i).iter().all(is_named)).count();
    ensure!(
        n > 0,
        "{}: names of columns: expected {}, found {}",
        shown(path),
        contact_columns(0).join(", "),
        names.join(", ")
    );
    Ok(n)
}

/// The fields of the first line of the table at `path`, which are names where it has some.
///
/// # Errors
/// A file that can't be read.
pub(super) fn column_names(path: &Path) -> Result<Vec<String>> {
    let bytes = std::fs::read(path).with_context(|| format!("{}: reading", shown(path)))?;
    let text = String::from_utf8_lossy(&bytes);
    let first = lines(&text).next().map(|(_, line)| fields(line, separator(line)));
    Ok(first.unwrap_or_default().into_iter().map(str::to_owned).collect())
}

fn rows(text: &str, leading: &[&str], gauges: &[&str]) -> Result<Vec<Row>> {
    let mut lines = lines(text);
    let Some((first_line, first)) = lines.next() else {
        bail!("no row of numbers: the table is empty");
    };
    let separator = separator(first);
    let names = fields(first, separator);
    let is_header =
        names.iter().any(|field| !field.is_empty() && number(field, separator).is_none());
    let n_wanted = leading.len() + gauges.len();
    let columns = match is_header {
        true => named_columns(&names, leading, gauges)
            .with_context(|| format!("line {first_line}: names of columns"))?,
        false => (0..n_wanted).collect(),
    };
    let n_columns = if is_header { names.len() } else { n_wanted };
    let head = (!is_header).then_some((first_line, first));
    let mut rows = Vec::new();
    for (line, text) in head.into_iter().chain(lines) {
        let fields = fields(text, separator);
        ensure!(
            fields.len() == n_columns,
            "line {line}: expected {n_columns} numbers{}, found {}; name the columns in a first line \
             where there are others",
            expected(leading, gauges, is_header),
            fields.len()
        );
        let value = |column: &usize| {
            let name = if is_header { format!(" ({})", names[*column]) } else { String::new() };
            let value = number(fields[*column], separator).with_context(|| {
                format!(
                    "line {line}, column {}{name}: expected a number, found {:?}",
                    column + 1,
                    fields[*column]
                )
            })?;
            reading(value).with_context(|| format!("line {line}, column {}{name}", column + 1))
        };
        let values = columns.iter().map(value).collect::<Result<_>>()?;
        rows.push(Row { place: format!("line {line}"), values });
    }
    ensure!(!rows.is_empty(), "no row of numbers: the table has names only");
    Ok(rows)
}

/// Lines that are neither empty nor comments, with their numbers from 1.
fn lines(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let lines = text.lines().enumerate().map(|(i, line)| (i + 1, line.trim_end()));
    lines.filter(|(_, l)| !l.trim().is_empty() && !l.trim_start().starts_with('#'))
}

/// What stands between the fields of a table with this line.
fn separator(line: &str) -> char {
    [';', '\t'].into_iter().find(|s| line.contains(*s)).unwrap_or(',')
}

/// The rows of a topic.
fn message_rows(mut topic: NumbersTopic, leading: &[&str], gauges: &[&str]) -> Result<Vec<Row>> {
    let (n_wanted, n_found) = (leading.len() + gauges.len(), topic.n_values());
    let columns = match topic.names() {
        Some(names) => {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            named_columns(&names, leading, gauges).context("names of the numbers")?
        }
        None => (0..n_wanted).collect(),
    };
    ensure!(
        topic.names().is_some() || n_found == n_wanted,
        "message 1: expected {n_wanted} numbers{}, found {n_found}",
        expected(leading, gauges, false)
    );
    let mut rows = Vec::new();
    while let Some(row) = topic.next_row()? {
        let place = format!("message {}", row.number);
        let value = |column: &usize| {
            reading(row.values[*column]).with_context(|| format!("{place}, number {}", column + 1))
        };
        let values = columns.iter().map(value).collect::<Result<_>>()?;
        rows.push(Row { place, values });
    }
    Ok(rows)
}

/// A number that a gauge can read.
fn reading(value: f64) -> Result<f64> {
    ensure!(
        value.is_finite(),
        "{value} is no reading; leave the row out, or find out why the gauge has none"
    );
    Ok(value)
}

fn expected(leading: &[&str], gauges: &[&str], is_header: bool) -> String {
    match (is_header, leading.is_empty()) {
        (true, _) => " as in the line of names".into(),
        (false, true) => ", one for each gauge".into(),
        (false, false) => format!(" ({}, then {} gauges)", leading.join(", "), gauges.len()),
    }
}

/// The fields of a line, without quotes around them; a separator at its end closes the last.
fn fields(line: &str, separator: char) -> Vec<&str> {
    let line = line.strip_suffix(separator).unwrap_or(line);
    line.split(separator).map(|field| field.trim().trim_matches('"').trim()).collect()
}

/// A number; with a decimal comma where commas don't separate.
fn number(field: &str, separator: char) -> Option<f64> {
    match separator {
        ',' => field.parse().ok(),
        _ => field.replacen(',', ".", 1).parse().ok(),
    }
}

/// The places of the wanted columns among `names`.
fn named_columns(names: &[&str], leading: &[&str], gauges: &[&str]) -> Result<Vec<usize>> {
    let plain = |name: &str| {
        let name = name.to_lowercase();
        name.strip_suffix("_ue").map_or(name.clone(), str::to_owned)
    };
    let names: Vec<String> = names.iter().map(|name| plain(name)).collect();
    let wanted: Vec<String> = leading.iter().chain(gauges).map(|name| plain(name)).collect();
    let numbered = |i: usize, name: &String| *name == format!("g{i}");
    let of_gauges = names.get(leading.len()..).unwrap_or_default();
    let as_probe_writes = of_gauges.len() == gauges.len()
        && of_gauges.iter().enumerate().all(|(i, name)| numbered(i, name));
    let has_gauge = wanted[leading.len()..].iter().any(|gauge| names.contains(gauge));
    if !gauges.is_empty() && (as_probe_writes || (!has_gauge && names.len() == wanted.len())) {
        return Ok((0..wanted.len()).collect());
    }
    let place = |name: &String| {
        let place = names.iter().position(|found| found == name);
        place.with_context(|| format!("expected one named {name:?}, found {}", names.join(", ")))
    };
    wanted.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use hapdef_daq::record::{RecordParams, TopicDef, record};
    use hapdef_daq::source::ReplaySource;
    use hapdef_daq::{AcquireParams, acquire};

    use super::*;

    const GAUGES: [&str; 2] = ["g0", "Tip"];

    #[track_caller]
    fn check(text: &str, expected: &[[f64; 2]]) {
        let rows = rows(text, &[], &GAUGES).unwrap();
        let values: Vec<_> = rows.iter().map(|row| row.values.as_slice()).collect();
        assert_eq!(
            values,
            expected.iter().map(|row| row.as_slice()).collect::<Vec<_>>(),
            "{text:?}"
        );
    }

    #[track_caller]
    fn refused(text: &str, expected: &str) {
        let error = rows(text, &["x_m"], &GAUGES).unwrap_err();
        let found = format!("{error:#}");
        assert!(found.contains(expected), "{text:?}: {found}");
    }

    #[test]
    fn tables_as_loggers_write_them() {
        check("1,2\n3.5,-4e1\n", &[[1.0, 2.0], [3.5, -40.0]]);
        check("\u{feff}g0_ue,tip_ue\r\n1,2\r\n", &[[1.0, 2.0]]);
        check("# a comment\nTIP;g0\n1,5;2\n\n# another\n-3;4,25\n", &[[2.0, 1.5], [4.25, -3.0]]);
        check("1,5\t2\n", &[[1.5, 2.0]]);
        check("\"g0\",\"Tip\"\n\"1\",\"2\"\n", &[[1.0, 2.0]]);
        check("1,2,\n3,4,\n", &[[1.0, 2.0], [3.0, 4.0]]);
        check("time,g0_ue,tip_ue,note\n0.1,1,2,soft\n0.2,3,4,nan\n", &[[1.0, 2.0], [3.0, 4.0]]);
        // names of no gauge: by place, as are the numbers that `hapdef probe` writes
        check("left,right\n1,2\n", &[[1.0, 2.0]]);
        check("g0_ue,g1_ue\n1,2\n", &[[1.0, 2.0]]);
    }

    #[test]
    fn a_table_that_says_too_little_is_refused_with_its_place() {
        refused("", "the table is empty");
        refused("# only a comment\n", "the table is empty");
        refused("x_m,g0,tip\n", "has names only");
        refused("1,2,3\n1,2\n", "line 2: expected 3 numbers (x_m, then 2 gauges), found 2");
        refused(
            "1,2,3,4\n",
            "line 1: expected 3 numbers (x_m, then 2 gauges), found 4; name the columns",
        );
        refused(
            "x_m,g0,tip\n1,2,3,4\n",
            "line 2: expected 3 numbers as in the line of names, found 4",
        );
        refused(
            "x_m,g0,other\n1,2,3\n",
            "line 1: names of columns: expected one named \"tip\", found x_m, g0, other",
        );
        refused(
            "Reading: 8388607\nReading: 1\n",
            "line 1: names of columns: expected one named \"x_m\"",
        );
        refused("1,2,3\n4,nan,6\n", "line 2, column 2: NaN is no reading");
        refused("x_m,g0,tip\n4,5,inf\n", "line 2, column 3 (tip): inf is no reading");
        refused(
            "x_m,g0,tip\n4,5,six\n",
            "line 2, column 3 (tip): expected a number, found \"six\"",
        );
    }

    /// An MCAP file with messages of JSON on a topic.
    fn logged(path: &Path, messages: &[&str]) {
        let nobody = ReplaySource::new("nobody", std::iter::empty(), 1.0);
        let (_acquisition, mut receivers) = acquire(nobody, AcquireParams::default()).unwrap();
        let topic = TopicDef {
            name: "/presses".into(),
            message_encoding: "json".into(),
            schema_name: String::new(),
            schema_encoding: String::new(),
            schema: String::new(),
        };
        let params = RecordParams { topics: vec![topic], ..RecordParams::default() };
        let recorder = record(receivers.remove(0), path, params).unwrap();
        let topics = recorder.topics();
        assert!((0..).zip(messages).all(|(i, json)| topics.put(0, i, json.as_bytes().to_vec())));
        recorder.finish().unwrap();
    }

    #[test]
    fn messages_are_rows() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("log.mcap");
        let topic = |name: Option<&str>| TopicArgs { topic: name.map(str::to_owned) };
        let read = |messages: &[&str], name| {
            logged(&path, messages);
            let rows = read_table(&path, &topic(name), &["x_m"], &GAUGES);
            std::fs::remove_file(&path).unwrap();
            rows
        };
        #[track_caller]
        fn refused(found: Result<Vec<Row>>, expected: &str) {
            let found = format!("{:#}", found.unwrap_err());
            assert!(found.contains(expected), "{found}");
        }
        let presses = Some("/presses");
        let rows = read(&["[1, 2, 3]", "[4, 5, 6]"], presses).unwrap();
        assert_eq!(rows[1], Row { place: "message 2".into(), values: vec![4.0, 5.0, 6.0] });
        let named = r#"{"t": 0, "tip": 3, "X_m": 1, "g0_ue": 2}"#;
        assert_eq!(read(&[named], presses).unwrap()[0].values, [1.0, 2.0, 3.0]);
        refused(read(&["[1, 2]"], presses), "message 1: expected 3 numbers (x_m, then 2 gauges)");
        refused(read(&[r#"{"x_m": 1, "g0": 2}"#], presses), "expected one named \"tip\"");
        refused(read(&["[1, 2, null]"], presses), "message 1, number 3: NaN is no reading");
        refused(read(&["[1, 2, 3]"], None), "no topic /hapdef/gauges; it has /gauges");
        let table = folder.path().join("table.csv");
        std::fs::write(&table, "1,2,3\n").unwrap();
        refused(read_table(&table, &topic(presses), &["x_m"], &GAUGES), "--topic: no MCAP file");
    }

    /// What loggers wrote, of ten gauges.
    #[test]
    #[allow(clippy::print_stdout, reason = "what is skipped is said")]
    fn tables_from_the_field() {
        let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared");
        let shared = std::env::var("HAPDEF_SHARED").unwrap_or_else(|_| default.into());
        let folder = Path::new(&shared).join("inputs/field/csv");
        if !folder.exists() {
            println!("skipped: {} is absent (set HAPDEF_SHARED)", folder.display());
            return;
        }
        let names: Vec<String> = (0..10).map(|i| format!("g{i}")).collect();
        let gauges: Vec<&str> = names.iter().map(String::as_str).collect();
        let read = |file: &str| read_table(&folder.join(file), &TopicArgs::default(), &[], &gauges);
        let last = [12.1, -3.2, 5.5, 0.1, 7.7, -2.2, 1.0, 0.4, 3.3, -1.1];
        for file in [
            "bom_crlf",
            "ok",
            "ok_header",
            "quoted",
            "semicolon_decimalcomma",
            "tab",
            "timestamped",
            "trailing_comma",
        ] {
            let rows = read(&format!("{file}.csv")).unwrap();
            assert_eq!((rows.len(), rows[1].values.as_slice()), (2, last.as_slice()), "{file}");
        }
        let found = format!("{:#}", read("nan.csv").unwrap_err());
        assert!(found.contains("line 3, column 1") && found.contains("NaN"), "{found}");
        let found = format!("{:#}", read("hx711.csv").unwrap_err());
        assert!(
            found.contains("names of columns") && found.contains("reading: 8388607"),
            "{found}"
        );
    }
}
