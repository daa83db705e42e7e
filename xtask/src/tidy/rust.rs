//! As much of Rust's grammar as the rules of the tree need: words without comments and test items.

/// A word of Rust, with the line it stands on, from 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Token {
    pub(super) kind: Kind,
    pub(super) line: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Kind {
    /// A name, a keyword or a number.
    Word(String),
    /// The content of a string literal.
    Text(String),
    /// `::`
    Path,
    /// Any other sign.
    Sign(char),
}

impl Token {
    pub(super) fn word(&self) -> Option<&str> {
        match &self.kind {
            Kind::Word(word) => Some(word),
            _ => None,
        }
    }

    pub(super) fn is_word(&self, word: &str) -> bool {
        self.word() == Some(word)
    }

    pub(super) fn is_sign(&self, sign: char) -> bool {
        self.kind == Kind::Sign(sign)
    }
}

/// The words of a file.
pub(super) fn tokens(text: &str) -> Vec<Token> {
    let mut scanner = Scanner { signs: text.chars().collect(), at: 0, line: 0, found: Vec::new() };
    while scanner.at < scanner.signs.len() {
        scanner.step();
    }
    scanner.found
}

/// Indices of the words of items under `#[cfg(test)]`, as ranges with their ends, attributes included.
pub(super) fn test_items(tokens: &[Token]) -> Vec<std::ops::RangeInclusive<usize>> {
    let mut found = Vec::new();
    let mut at = 0;
    while at < tokens.len() {
        if is_test_attribute(&tokens[at..]) {
            let last = end_of_item(tokens, at);
            found.push(at..=last);
            at = last;
        }
        at += 1;
    }
    found
}

/// The words outside items under `#[cfg(test)]`.
pub(super) fn without_tests(tokens: &[Token]) -> Vec<Token> {
    let tests = test_items(tokens);
    let is_kept = |i: &usize| !tests.iter().any(|range| range.contains(i));
    (0..tokens.len()).filter(is_kept).map(|i| tokens[i].clone()).collect()
}

fn is_test_attribute(tokens: &[Token]) -> bool {
    let [hash, open, cfg, bracket, test, rest @ ..] = tokens else { return false };
    hash.is_sign('#')
        && open.is_sign('[')
        && cfg.is_word("cfg")
        && bracket.is_sign('(')
        && test.is_word("test")
        && rest.first().is_some_and(|token| token.is_sign(')'))
}

/// Where an item ends: at its semicolon, or at the brace that closes its body.
fn end_of_item(tokens: &[Token], start: usize) -> usize {
    let mut depth = 0_usize;
    for (i, token) in tokens.iter().enumerate().skip(start) {
        match token.kind {
            Kind::Sign('{' | '(' | '[') => depth += 1,
            Kind::Sign(')' | ']') => depth = depth.saturating_sub(1),
            Kind::Sign('}') => {
                depth = depth.saturating_sub(1);
                if depth == 0 {
                    return i;
                }
            }
            Kind::Sign(';') if depth == 0 => return i,
            _ => {}
        }
    }
    tokens.len() - 1
}

struct Scanner {
    signs: Vec<char>,
    at: usize,
    line: usize,
    found: Vec<Token>,
}

impl Scanner {
    fn step(&mut self) {
        match self.signs[self.at] {
            '/' if self.next_is("//") => self.skip_while(|sign| sign != '\n'),
            '/' if self.next_is("/*") => self.skip_block(),
            '"' => self.text(),
            'r' | 'b' if self.raw_hashes().is_some() => self.raw_text(),
            'b' if self.next_is("b\"") => {
                self.at += 1;
                self.text();
            }
            '\'' => self.letter_or_lifetime(),
            ':' if self.next_is("::") => {
                self.push(Kind::Path);
                self.at += 2;
            }
            sign if sign.is_alphanumeric() || sign == '_' => self.word(),
            sign => {
                if !sign.is_whitespace() {
                    self.push(Kind::Sign(sign));
                }
                self.advance();
            }
        }
    }

    fn push(&mut self, kind: Kind) {
        self.found.push(Token { kind, line: self.line });
    }

    fn advance(&mut self) {
        if self.signs.get(self.at) == Some(&'\n') {
            self.line += 1;
        }
        self.at += 1;
    }

    fn next_is(&self, text: &str) -> bool {
        text.chars().enumerate().all(|(i, sign)| self.signs.get(self.at + i) == Some(&sign))
    }

    fn skip_while(&mut self, is_skipped: impl Fn(char) -> bool) {
        while self.signs.get(self.at).is_some_and(|&sign| is_skipped(sign)) {
            self.advance();
        }
    }

    /// A block comment, which may hold others.
    fn skip_block(&mut self) {
        let mut depth = 0_usize;
        while self.at < self.signs.len() {
            if self.next_is("/*") {
                depth += 1;
                self.at += 2;
            } else if self.next_is("*/") {
                depth -= 1;
                self.at += 2;
                if depth == 0 {
                    return;
                }
            } else {
                self.advance();
            }
        }
    }

    fn text(&mut self) {
        let line = self.line;
        self.at += 1;
        let mut content = String::new();
        while let Some(&sign) = self.signs.get(self.at) {
            self.advance();
            match sign {
                '"' => break,
                '\\' => self.advance(),
                _ => content.push(sign),
            }
        }
        self.found.push(Token { kind: Kind::Text(content), line });
    }

    /// Signs before the quote, and hashes, of a raw string that begins here.
    fn raw_hashes(&self) -> Option<(usize, usize)> {
        let n_letters = usize::from(self.next_is("br")) + 1;
        let rest = self.signs.get(self.at..)?;
        let is_raw = rest[n_letters - 1] == 'r';
        let n_hashes = rest.iter().skip(n_letters).take_while(|&&sign| sign == '#').count();
        (is_raw && rest.get(n_letters + n_hashes) == Some(&'"')).then_some((n_letters, n_hashes))
    }

    fn raw_text(&mut self) {
        let Some((n_letters, n_hashes)) = self.raw_hashes() else { return };
        let line = self.line;
        self.at += n_letters + n_hashes + 1;
        let end = format!("\"{}", "#".repeat(n_hashes));
        let start = self.at;
        while self.at < self.signs.len() && !self.next_is(&end) {
            self.advance();
        }
        let content = self.signs[start..self.at.min(self.signs.len())].iter().collect();
        self.at += end.len();
        self.found.push(Token { kind: Kind::Text(content), line });
    }

    /// Letters are left out, and the quote of a lifetime.
    fn letter_or_lifetime(&mut self) {
        self.at += 1;
        if self.next_is("\\") {
            self.at += 2;
            self.skip_while(|sign| sign != '\'');
            self.at += 1;
        } else if self.signs.get(self.at + 1) == Some(&'\'') {
            self.advance();
            self.at += 1;
        }
    }

    fn word(&mut self) {
        let start = self.at;
        self.skip_while(|sign| sign.is_alphanumeric() || sign == '_');
        self.push(Kind::Word(self.signs[start..self.at].iter().collect()));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(text: &str) -> Vec<String> {
        let found = tokens(text).into_iter();
        found.filter_map(|token| token.word().map(str::to_owned)).collect()
    }

    #[test]
    fn comments_and_literals_are_no_words() {
        let text = "a // b\n/* c /* d */ e */ f \"g \\\" h\" r#\"i \" j\"# 'k' '\\'' '\\u{6c}' &'m n b\"o\" '\"' p";
        assert_eq!(words(text), ["a", "f", "m", "n", "p"]);
    }

    #[test]
    fn lines_are_counted_through_strings_and_comments() {
        let found = tokens("a\n\"x\ny\"\n/* z\n*/ b");
        assert_eq!(found.last().unwrap().line, 4);
    }

    #[test]
    fn items_of_tests_are_left_out() {
        let text = "fn a() {}\n#[cfg(test)]\nmod b {\n fn c() { [1; 2]; }\n}\n#[cfg(test)]\n\
                    #[path = \"d.rs\"]\nmod e;\nfn f() {}";
        let kept: Vec<Token> = without_tests(&tokens(text));
        let kept: Vec<&str> = kept.iter().filter_map(Token::word).collect();
        assert_eq!(kept, ["fn", "a", "fn", "f"]);
    }
}
