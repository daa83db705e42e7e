//! The modules of a crate and what each imports from the others.

use std::collections::{BTreeMap, BTreeSet};

use super::rust::{Kind, Token, tokens, without_tests};

/// From each file of a crate to those that it imports from.
pub(super) type Imports = BTreeMap<String, BTreeSet<String>>;

/// `crate::a::b` is `["a", "b"]`.
type Path = Vec<String>;

/// The modules that a root declares, each of which is a file.
pub(super) struct Modules(BTreeMap<Path, Module>);

struct Module {
    file: String,
    tokens: Vec<Token>,
    /// What `use` brings in: the name here, and whole path it stands for.
    uses: Vec<(String, Path)>,
    /// Modules all of whose names are brought in.
    globs: Vec<Path>,
    /// Other paths within the crate, as they stand in the code.
    paths: Vec<Path>,
}

/// A module to be read: its path, its file, and the folder of its own modules.
struct Found {
    path: Path,
    file: String,
    folder: String,
}

const ITEMS: [&str; 10] =
    ["struct", "enum", "fn", "trait", "const", "static", "type", "union", "mod", "macro_rules"];

/// Re-exports are followed so many times at most.
const MOST_STEPS: usize = 8;

impl Modules {
    pub(super) fn of_root(root: &str, read: impl Fn(&str) -> Option<String>) -> Self {
        let folder = folder_of(root).to_owned();
        let mut open = vec![Found { path: Path::new(), file: root.to_owned(), folder }];
        let mut texts = BTreeMap::new();
        while let Some(found) = open.pop() {
            let text = read(&found.file).unwrap_or_default();
            let tokens = without_tests(&tokens(&text));
            open.extend(declared(&found, &tokens, &read));
            texts.insert(found.path, (found.file, tokens));
        }
        let paths: BTreeSet<Path> = texts.keys().cloned().collect();
        let modules = texts.into_iter().map(|(path, (file, tokens))| {
            let module = Module::of(&path, file, tokens, &paths);
            (path, module)
        });
        Self(modules.collect())
    }

    /// Imports between files, those between a module and the modules in it left out.
    pub(super) fn imports(&self) -> Imports {
        let mut imports = Imports::new();
        for (from, module) in &self.0 {
            let used = module.uses.iter().map(|(_, path)| path).chain(&module.paths);
            let mut targets: BTreeSet<Path> =
                used.filter_map(|path| self.target(path, MOST_STEPS)).collect();
            for glob in &module.globs {
                targets.extend(self.of_glob(glob, module));
            }
            targets.retain(|to| !to.starts_with(from) && !from.starts_with(to));
            let files = targets.iter().filter_map(|to| self.0.get(to));
            imports.insert(module.file.clone(), files.map(|to| to.file.clone()).collect());
        }
        imports
    }

    /// The module that defines what a path names, through re-exports.
    fn target(&self, path: &[String], steps: usize) -> Option<Path> {
        let n = (0..=path.len()).rev().find(|&n| self.0.contains_key(&path[..n]))?;
        let (inside, rest) = path.split_at(n);
        let module = self.0.get(inside)?;
        let (Some(name), true) = (rest.first(), steps > 0) else {
            return Some(inside.to_vec());
        };
        if let Some((_, whole)) = module.uses.iter().find(|(own, _)| own == name) {
            return self.target(&[whole, &rest[1..]].concat(), steps - 1);
        }
        if module.defines(name) {
            return Some(inside.to_vec());
        }
        let mut globs = module.globs.iter().filter(|glob| glob.as_slice() != inside);
        let other = globs.find_map(|glob| {
            let found = self.target(&[glob, rest].concat(), steps - 1)?;
            self.0.get(&found).filter(|module| module.defines(name)).map(|_| found)
        });
        Some(other.unwrap_or_else(|| inside.to_vec()))
    }

    /// Where the names that a module takes from a glob are.
    fn of_glob(&self, glob: &[String], user: &Module) -> BTreeSet<Path> {
        let mut targets: BTreeSet<Path> = self.target(glob, MOST_STEPS).into_iter().collect();
        let words: BTreeSet<&str> = user.tokens.iter().filter_map(Token::word).collect();
        let inside = self.0.get(glob);
        let names = inside.into_iter().flat_map(|m| m.uses.iter().map(|(name, _)| name.as_str()));
        let mut names: Vec<&str> = names.filter(|name| words.contains(name)).collect();
        if inside.is_some_and(|module| !module.globs.is_empty()) {
            names = words.into_iter().collect();
        }
        targets.extend(
            names
                .into_iter()
                .filter_map(|name| self.target(&[glob, &[name.to_owned()]].concat(), MOST_STEPS)),
        );
        targets
    }
}

impl Module {
    fn of(path: &Path, file: String, tokens: Vec<Token>, modules: &BTreeSet<Path>) -> Self {
        let mut module = Self {
            file,
            tokens: Vec::new(),
            uses: Vec::new(),
            globs: Vec::new(),
            paths: Vec::new(),
        };
        let mut at = 0;
        let mut scopes = Scopes::new(path);
        while at < tokens.len() {
            scopes.step(&tokens, at);
            if tokens[at].is_word("use") {
                at = module.add_use(&tokens, at + 1, scopes.path(), Path::new(), modules);
            } else {
                at = module.add_path(&tokens, at, scopes.path());
            }
        }
        module.tokens = tokens;
        module
    }

    fn defines(&self, name: &str) -> bool {
        let is_item = |pair: &[Token]| {
            let is_named = pair[1].is_word(name) || pair[1].is_sign('!');
            is_named && pair[0].word().is_some_and(|word| ITEMS.contains(&word))
        };
        let mut pairs = self.tokens.windows(2);
        pairs.any(|pair| is_item(pair) && pair[1].is_word(name))
            || self.tokens.windows(3).any(|t| t[0].is_word("macro_rules") && t[2].is_word(name))
    }

    /// A tree of `use`, from behind what it begins with; returns where it ends.
    fn add_use(
        &mut self,
        tokens: &[Token],
        start: usize,
        scope: &[String],
        prefix: Path,
        modules: &BTreeSet<Path>,
    ) -> usize {
        let mut at = start;
        let mut path = prefix;
        while let Some(token) = tokens.get(at) {
            match &token.kind {
                Kind::Word(word) if word == "as" => {
                    let name = tokens.get(at + 1).and_then(Token::word).unwrap_or_default();
                    self.bring_in(name, &path, scope, modules);
                    return at + 2;
                }
                Kind::Word(word) => path.push(word.clone()),
                Kind::Path => {}
                Kind::Sign('*') => {
                    self.globs.extend(resolved(&path, scope, modules));
                    return at + 1;
                }
                Kind::Sign('{') => {
                    at += 1;
                    while tokens.get(at).is_some_and(|token| !token.is_sign('}')) {
                        at = self.add_use(tokens, at, scope, path.clone(), modules);
                        at += usize::from(tokens.get(at).is_some_and(|token| token.is_sign(',')));
                    }
                    return at + 1;
                }
                _ => break,
            }
            at += 1;
        }
        let name = path.last().cloned().unwrap_or_default();
        self.bring_in(&name, &path, scope, modules);
        at.max(start + usize::from(path.is_empty()))
    }

    fn bring_in(
        &mut self,
        name: &str,
        path: &[String],
        scope: &[String],
        modules: &BTreeSet<Path>,
    ) {
        let is_self = path.len() > 1 && path.last().is_some_and(|word| word == "self");
        let path = if is_self { &path[..path.len() - 1] } else { path };
        let name = if name == "self" { path.last().map_or("", String::as_str) } else { name };
        self.uses.extend(resolved(path, scope, modules).map(|path| (name.to_owned(), path)));
    }

    /// A path that begins with `crate`, `super` or `self`, outside `use`; returns where to go on.
    fn add_path(&mut self, tokens: &[Token], start: usize, scope: &[String]) -> usize {
        let is_path = |at: usize| tokens.get(at).is_some_and(|token| token.kind == Kind::Path);
        let begins = tokens[start].word().is_some_and(|w| ["crate", "super", "self"].contains(&w));
        if !begins || !is_path(start + 1) {
            return start + 1;
        }
        let mut path = Path::new();
        let mut at = start;
        while let Some(word) = tokens.get(at).and_then(Token::word) {
            path.push(word.to_owned());
            if !is_path(at + 1) {
                break;
            }
            at += 2;
        }
        self.paths.extend(resolved(&path, scope, &BTreeSet::new()));
        start + 1
    }
}

/// The path from the crate's root; none for what other crates have.
fn resolved(path: &[String], scope: &[String], modules: &BTreeSet<Path>) -> Option<Path> {
    let (first, rest) = path.split_first()?;
    match first.as_str() {
        "crate" => Some(rest.to_vec()),
        "self" => Some([scope, rest].concat()),
        "super" => {
            let parent = scope.split_last().map_or(scope, |(_, parent)| parent);
            let is_again = rest.first().is_some_and(|word| word == "super");
            if is_again {
                return resolved(rest, parent, modules);
            }
            Some([parent, rest].concat())
        }
        _ => {
            let is_own = modules.contains(&[scope, &path[..1]].concat());
            is_own.then(|| [scope, path].concat())
        }
    }
}

/// The module that a word stands in: the file's own, or one written out in it.
struct Scopes {
    path: Path,
    /// For each open brace, whether it opened a module.
    braces: Vec<bool>,
}

impl Scopes {
    fn new(path: &[String]) -> Self {
        Self { path: path.to_vec(), braces: Vec::new() }
    }

    fn path(&self) -> &[String] {
        &self.path
    }

    fn step(&mut self, tokens: &[Token], at: usize) {
        if tokens[at].is_sign('{') {
            let is_module = at >= 2 && tokens[at - 2].is_word("mod");
            if let (true, Some(name)) =
                (is_module, tokens.get(at.wrapping_sub(1)).and_then(Token::word))
            {
                self.path.push(name.to_owned());
            }
            self.braces.push(is_module);
        } else if tokens[at].is_sign('}') && self.braces.pop() == Some(true) {
            self.path.pop();
        }
    }
}

/// The files of the modules that a file declares.
fn declared(
    parent: &Found,
    tokens: &[Token],
    read: &impl Fn(&str) -> Option<String>,
) -> Vec<Found> {
    let mut found = Vec::new();
    for (i, three) in tokens.windows(3).enumerate() {
        let [word, name, end] = three else { continue };
        let (true, Some(name), true) = (word.is_word("mod"), name.word(), end.is_sign(';')) else {
            continue;
        };
        let path = [parent.path.as_slice(), &[name.to_owned()]].concat();
        let inside = |folder: &str| format!("{folder}/{name}");
        let folder = inside(&parent.folder);
        if let Some(named) = path_attribute(&tokens[..i]) {
            let file = joined(folder_of(&parent.file), named);
            let folder = folder_of(&file).to_owned();
            found.push(Found { path, file, folder });
            continue;
        }
        let files = [format!("{folder}.rs"), format!("{folder}/mod.rs")];
        let file = files.into_iter().find(|file| read(file).is_some());
        found.extend(file.map(|file| Found { path, file, folder }));
    }
    found
}

/// `#[path = "…"]` before a declaration.
fn path_attribute(before: &[Token]) -> Option<&str> {
    let is_visibility = |t: &&Token| t.is_word("pub") || t.is_word("crate") || t.is_word("super");
    let is_skipped = |t: &&Token| is_visibility(t) || t.is_sign('(') || t.is_sign(')');
    let mut words = before.iter().rev().skip_while(is_skipped);
    let (close, text, equals, path) = (words.next()?, words.next()?, words.next()?, words.next()?);
    match &text.kind {
        Kind::Text(text) if close.is_sign(']') && equals.is_sign('=') && path.is_word("path") => {
            Some(text)
        }
        _ => None,
    }
}

fn folder_of(file: &str) -> &str {
    file.rsplit_once('/').map_or("", |(folder, _)| folder)
}

/// `a/b` and `../c` is `a/c`.
fn joined(folder: &str, path: &str) -> String {
    let mut parts: Vec<&str> = folder.split('/').collect();
    for part in path.split('/') {
        match part {
            ".." => {
                parts.pop();
            }
            "." => {}
            _ => parts.push(part),
        }
    }
    parts.join("/")
}
