//! The part of an `.inp` deck that the solver's own reader leaves out: three-node shells, and single
//! motions that are held.

use std::collections::BTreeMap;
use std::path::Path;

use hapdef_report::ReportError;
use nalgebra::Point3;

use crate::VerifyError;

/// A deck as it stands.
#[derive(Debug, Default, PartialEq)]
pub(super) struct InpDeck {
    /// Node positions by label.
    pub(super) nodes: BTreeMap<usize, Point3<f64>>,
    /// Labels of the corners of three-node elements.
    pub(super) elements: Vec<[usize; 3]>,
    /// Node sets by upper-case name.
    pub(super) sets: BTreeMap<String, Vec<usize>>,
    /// Node or set, and the degree of freedom held, from 0.
    pub(super) held: Vec<(String, usize)>,
    /// Node or set, degree of freedom from 0, force.
    pub(super) forces: Vec<(String, usize, f64)>,
    /// Pressure on all elements.
    pub(super) pressure: f64,
    /// Young's modulus and Poisson's ratio.
    pub(super) elastic: Option<[f64; 2]>,
    /// Of the wall.
    pub(super) thickness: Option<f64>,
}

impl InpDeck {
    /// Reads the deck in `path`.
    pub(super) fn read(path: &Path) -> Result<Self, VerifyError> {
        let text = std::fs::read_to_string(path).map_err(ReportError::io("reading", path))?;
        Ok(Self::parse(&text))
    }

    /// Reads what it knows; other blocks and lines of other shapes are passed over.
    pub(super) fn parse(text: &str) -> Self {
        let mut deck = Self::default();
        let mut keyword = String::new();
        for line in text.lines().map(str::trim).filter(|l| !l.starts_with("**")) {
            if line.starts_with('*') {
                keyword = line.to_uppercase().replace(' ', "");
            } else if !line.is_empty() {
                let words: Vec<&str> = line.split(',').map(str::trim).collect();
                deck.add(&keyword, &words);
            }
        }
        deck
    }

    /// The labels of a node or set.
    pub(super) fn labels(&self, name: &str) -> Vec<usize> {
        let single = || name.parse().ok().map(|label| vec![label]);
        self.sets.get(name).cloned().or_else(single).unwrap_or_default()
    }

    fn add(&mut self, keyword: &str, words: &[&str]) {
        let block = keyword.split(',').next().unwrap_or_default();
        let number = |i: usize| words.get(i).and_then(|w| w.parse::<f64>().ok());
        let whole = |i: usize| words.get(i).and_then(|w| w.parse::<usize>().ok());
        let name = words.first().map(|w| w.to_uppercase()).unwrap_or_default();
        match block {
            "*NODE" => {
                if let (Some(label), [Some(x), Some(y), Some(z)]) =
                    (whole(0), [1, 2, 3].map(number))
                {
                    self.nodes.insert(label, Point3::new(x, y, z));
                }
            }
            "*ELEMENT" => {
                if let ([Some(_), Some(a), Some(b), Some(c)], 4) =
                    ([0, 1, 2, 3].map(whole), words.len())
                {
                    self.elements.push([a, b, c]);
                }
            }
            "*NSET" => {
                let set = keyword.split("NSET=").nth(1).unwrap_or_default();
                let set = set.split(',').next().unwrap_or_default().to_owned();
                self.sets.entry(set).or_default().extend((0..words.len()).filter_map(whole));
            }
            "*BOUNDARY" => {
                if let Some(first) = whole(1) {
                    let last = whole(2).unwrap_or(first);
                    self.held.extend((first..=last).map(|dof| (name.clone(), dof - 1)));
                }
            }
            "*CLOAD" => {
                if let (Some(dof), Some(force)) = (whole(1), number(2)) {
                    self.forces.push((name, dof - 1, force));
                }
            }
            "*DSLOAD" => self.pressure = number(2).unwrap_or_default(),
            "*ELASTIC" => self.elastic = number(0).zip(number(1)).map(<[f64; 2]>::from),
            "*USERSECTION" => self.thickness = number(0),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_are_read() {
        let deck = InpDeck::parse(
            "** note\n*Node,Nset=Nall\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n\
             *Element, type=us3, ELSET=E\n 1, 1, 2, 3\n*Nset, nset=Set-1, \n 1, 3,\n\
             *USER SECTION,ELSET=E\n0.05\n*Elastic\n 2.1e+11, 0.3\n*Boundary\nSet-1, 1, 2\n\
             *Cload\n3, 1, 1.\n*Dsload\nSurf-1, P, 100.\n*Elset, elset=Set-1\n 1\n",
        );
        assert_eq!((deck.nodes.len(), &deck.elements[..]), (3, &[[1, 2, 3]][..]));
        assert_eq!(deck.labels("SET-1"), [1, 3]);
        assert_eq!(deck.labels("2"), [2]);
        let held = [("SET-1".to_owned(), 0), ("SET-1".to_owned(), 1)];
        assert_eq!((&deck.held[..], deck.thickness), (&held[..], Some(0.05)));
        assert_eq!(deck.forces, [("3".to_owned(), 0, 1.0)]);
        assert_eq!((deck.pressure, deck.elastic), (100.0, Some([2.1e11, 0.3])));
    }
}
