//! Files that import from each other.

use std::collections::{BTreeMap, BTreeSet};

use super::modules::{Imports, Modules};

/// The circles of every crate, examples included, and of the page's JavaScript, a line each.
pub(super) fn all(files: &[String], read: impl Fn(&str) -> Option<String>) -> Vec<String> {
    let mut found = Vec::new();
    for root in files.iter().filter(|file| is_root(file)) {
        found.extend(of(&Modules::of_root(root, &read).imports()));
    }
    found.extend(of(&of_scripts(files, read)));
    found
}

/// A file that is compiled by itself, with the modules that it declares.
fn is_root(file: &str) -> bool {
    let parts: Vec<&str> = file.split('/').collect();
    match parts.as_slice() {
        ["crates", _, rest @ ..] | [_, rest @ ..] => {
            matches!(rest, ["src", "lib.rs" | "main.rs"] | ["src", "bin", _])
                || matches!(rest, ["examples", _, "main.rs"])
        }
        [] => false,
    }
}

/// Pairs of files that import from each other, and groups of three and more each of which leads to all others.
fn of(imports: &Imports) -> Vec<String> {
    let has = |from: &str, to: &str| imports.get(from).is_some_and(|all| all.contains(to));
    let mut lines = Vec::new();
    for (from, all) in imports {
        let back = all.iter().filter(|to| from < *to && has(to, from));
        lines.extend(back.map(|to| format!("{from} <-> {to}")));
    }
    for group in components(imports) {
        if group.len() > 2 {
            lines.push(group_line(&group, imports));
        }
    }
    lines
}

/// Every import within a group.
fn group_line(group: &BTreeSet<String>, imports: &Imports) -> String {
    let within = |from: &String| {
        let all = imports.get(from).into_iter().flatten().filter(|to| group.contains(*to));
        let names: Vec<&str> = all.map(|to| name_of(to)).collect();
        format!("{} -> {}", name_of(from), names.join(", "))
    };
    let arrows: Vec<String> = group.iter().map(within).collect();
    let folder = group.first().map_or("", |file| crate_of(file));
    format!("{} files of {folder}: {}", group.len(), arrows.join("; "))
}

/// `crates/a` of `crates/a/src/b/c.rs`.
fn crate_of(file: &str) -> &str {
    file.split_once("/src/")
        .or_else(|| file.split_once("/examples/"))
        .map_or(file, |(before, _)| before)
}

/// `b/c.rs` of `crates/a/src/b/c.rs`.
fn name_of(file: &str) -> &str {
    file.split_once("/src/").map_or(file, |(_, after)| after)
}

/// Groups of files, each of which reaches every other.
fn components(imports: &Imports) -> Vec<BTreeSet<String>> {
    let reached = |start: &str| {
        let mut all = BTreeSet::new();
        let mut open = vec![start];
        while let Some(file) = open.pop() {
            for next in imports.get(file).into_iter().flatten() {
                if all.insert(next.clone()) {
                    open.push(next);
                }
            }
        }
        all
    };
    let all: BTreeMap<&String, BTreeSet<String>> =
        imports.keys().map(|file| (file, reached(file))).collect();
    let mut groups = BTreeSet::new();
    for (file, reach) in &all {
        let is_back = |to: &&String| all.get(*to).is_some_and(|back| back.contains(*file));
        let group: BTreeSet<String> = reach.iter().filter(is_back).cloned().collect();
        if !group.is_empty() {
            groups.insert(group);
        }
    }
    groups.into_iter().collect()
}

/// `import … from "./other.js"`, in one folder.
fn of_scripts(files: &[String], read: impl Fn(&str) -> Option<String>) -> Imports {
    let is_own = |file: &&String| file.ends_with(".js") && !file.contains("/vendor/");
    let mut imports = Imports::new();
    for file in files.iter().filter(is_own) {
        let text = read(file).unwrap_or_default();
        let folder = file.rsplit_once('/').map_or("", |(folder, _)| folder);
        let names = text.split("from \"./").skip(1).filter_map(|rest| rest.split('"').next());
        imports.insert(file.clone(), names.map(|name| format!("{folder}/{name}")).collect());
    }
    imports
}

#[cfg(test)]
mod tests {
    use super::*;

    fn circles(files: &[(&str, &str)]) -> Vec<String> {
        let names: Vec<String> = files.iter().map(|(name, _)| (*name).to_owned()).collect();
        let read = |file: &str| {
            let mut pairs = files.iter();
            pairs.find_map(|(name, text)| (*name == file).then(|| (*text).to_owned()))
        };
        all(&names, read)
    }

    #[test]
    fn files_that_import_from_each_other_are_a_circle() {
        let root = ("crates/a/src/lib.rs", "mod b; mod c; pub use c::C;");
        let c = ("crates/a/src/c.rs", "pub struct C; fn f() { super::b::g() }");
        for b in ["use crate::c::C;", "use super::c;", "fn f(_: crate::c::C) {}", "use crate::C;"] {
            let b = ("crates/a/src/b.rs", b);
            assert_eq!(circles(&[root, b, c]).len(), 1, "{b:?}");
        }
        for b in ["use std::c::C;", "// crate::c\n", "#[cfg(test)] mod tests { use crate::c::C; }"]
        {
            let b = ("crates/a/src/b.rs", b);
            assert_eq!(circles(&[root, b, c]).len(), 0, "{b:?}");
        }
    }

    #[test]
    fn a_parent_and_its_children_are_none() {
        let root = ("crates/a/src/lib.rs", "mod b; use b::{B, d::D}; pub struct A;");
        let b = ("crates/a/src/b/mod.rs", "pub mod d; use crate::A; pub struct B(d::D);");
        let d = ("crates/a/src/b/d.rs", "use super::B; use crate::{self as all, A}; pub struct D;");
        assert_eq!(circles(&[root, b, d]), Vec::<String>::new());
    }

    #[test]
    fn a_longer_way_round_is_a_circle() {
        let root = ("crates/a/src/main.rs", "mod b; mod c; mod d;");
        let files = [
            root,
            ("crates/a/src/b.rs", "use crate::{c::{self, C}};"),
            ("crates/a/src/c.rs", "use crate::d::*;"),
            ("crates/a/src/d.rs", "use crate::b::B as Other;"),
        ];
        let found = circles(&files);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].ends_with("b.rs -> c.rs; c.rs -> d.rs; d.rs -> b.rs"), "{found:?}");
    }

    #[test]
    fn names_of_a_glob_lead_to_where_they_are() {
        let root = ("crates/a/src/lib.rs", "mod b; mod c; mod d; pub use c::*; use d::D;");
        let b = ("crates/a/src/b.rs", "use super::*; fn f(_: C) {}");
        let c = ("crates/a/src/c.rs", "use crate::b::f; pub struct C;");
        let d = ("crates/a/src/d.rs", "use crate::b::f; pub struct D;");
        assert_eq!(circles(&[root, b, c, d]), ["crates/a/src/b.rs <-> crates/a/src/c.rs"]);
    }

    #[test]
    fn scripts_are_looked_at_too() {
        let files = [
            ("v/js/a.js", "import { b } from \"./b.js\";"),
            ("v/js/b.js", "import a from \"./a.js\""),
        ];
        assert_eq!(circles(&files).len(), 1);
    }
}
