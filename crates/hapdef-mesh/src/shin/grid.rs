//! The grid of columns over the unrolled outer surface: lines, holes, rims, diagonals.

use std::f64::consts::TAU;

use super::ShinParams;
use super::lines::{BandPart, lines_along, lines_around};
use super::rim::{Ellipse, Place, ellipses, turn};

/// What a cell of the surface is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cell {
    /// Wall only.
    Panel,
    /// Wall with a rib below it.
    Rib,
    /// Part of an end ring.
    EndRing,
    /// Left out, by the hole's place in the list.
    Hole(usize),
}

/// Columns and cells over the unrolled surface. Column `(i, j)` stands at line `i` around and line
/// `j` along; cell `(i, j)` has it as its corner with the smallest angle and height.
pub(super) struct Grid {
    pub(super) n_around: usize,
    pub(super) n_along: usize,
    places: Vec<Place>,
    cells: Vec<Cell>,
    rims: Vec<Option<usize>>,
    ellipses: Vec<Ellipse>,
    other_diagonals: bool,
}

/// Rounds of averaging that spread the rims' displacement over the columns around them.
const SMOOTHING_ROUNDS: usize = 4;

impl Grid {
    pub(super) fn new(params: &ShinParams) -> Self {
        let around = lines_around(params);
        let along = lines_along(params);
        let (n_around, n_along) = (around.lines.len(), along.lines.len() - 1);
        let places = along
            .lines
            .iter()
            .flat_map(|&y_m| around.lines.iter().map(move |&theta| Place { theta, y_m }))
            .collect();
        let ellipses = ellipses(params, &around, &along);
        let mut grid = Self {
            n_around,
            n_along,
            places,
            cells: Vec::new(),
            rims: vec![None; n_around * (n_along + 1)],
            ellipses,
            other_diagonals: params.other_diagonals,
        };
        grid.cells = grid.classify(&around.parts, &along.parts);
        grid.snap_rims();
        grid.smooth();
        grid
    }

    pub(super) fn column(&self, i: usize, j: usize) -> usize {
        j * self.n_around + i % self.n_around
    }

    pub(super) fn cell(&self, i: usize, j: usize) -> Cell {
        self.cells[j * self.n_around + i % self.n_around]
    }

    pub(super) fn place(&self, column: usize) -> Place {
        self.places[column]
    }

    /// Half way between two columns: on the rim if both stand next to each other on one hole's.
    pub(super) fn between(&self, a: usize, b: usize) -> Place {
        let middle = self.average(&[a, b]);
        match (self.rims[a], self.rims[b]) {
            (Some(hole), Some(other)) if hole == other && self.is_rim_edge(a, b) => {
                self.ellipses[hole].project(middle)
            }
            _ => middle,
        }
    }

    /// The columns of cell `(i, j)` as two triangles, counterclockwise in (θ, y). The diagonal is
    /// the one that leaves the larger smallest angle; where that is a draw it alternates.
    pub(super) fn triangles(&self, i: usize, j: usize) -> [[usize; 3]; 2] {
        let [a, b, c, d] = self.corners(i, j);
        let (one, other) = ([[a, b, c], [a, c, d]], [[a, b, d], [b, c, d]]);
        let smallest = |split: &[[usize; 3]; 2]| {
            split.iter().map(|t| self.smallest_angle(t)).fold(f64::INFINITY, f64::min)
        };
        let gain = smallest(&one) - smallest(&other);
        let draw = gain.abs() < 0.02;
        if (draw && (i + j).is_multiple_of(2) != self.other_diagonals) || (!draw && gain > 0.0) {
            one
        } else {
            other
        }
    }

    fn corners(&self, i: usize, j: usize) -> [usize; 4] {
        [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| self.column(i, j))
    }

    fn classify(&self, around: &[Option<usize>], along: &[BandPart]) -> Vec<Cell> {
        let mut cells = Vec::with_capacity(self.n_around * self.n_along);
        for (j, part) in along.iter().enumerate() {
            for (i, sector) in around.iter().enumerate() {
                cells.push(match (part, sector) {
                    (BandPart::EndRing, _) => Cell::EndRing,
                    (BandPart::Rib, _) | (_, None) => Cell::Rib,
                    (BandPart::Band, Some(_)) => {
                        let centre = self.average(&self.corners(i, j));
                        let hole = self.ellipses.iter().position(|e| e.distance(centre) < 1.0);
                        hole.map_or(Cell::Panel, Cell::Hole)
                    }
                });
            }
        }
        cells
    }

    /// The four cells around a column; fewer at the ends.
    fn cells_around(&self, i: usize, j: usize) -> Vec<Cell> {
        let before = i + self.n_around - 1;
        let rows = (j.saturating_sub(1)..=j).filter(|row| *row < self.n_along);
        rows.flat_map(|row| [self.cell(before, row), self.cell(i, row)]).collect()
    }

    fn snap_rims(&mut self) {
        for j in 1..self.n_along {
            for i in 0..self.n_around {
                let cells = self.cells_around(i, j);
                let Some(hole) = sole_hole(&cells) else {
                    continue;
                };
                let column = self.column(i, j);
                self.rims[column] = Some(hole);
                self.places[column] = self.ellipses[hole].project(self.places[column]);
            }
        }
    }

    /// Moves the free columns of panels to the middle of their neighbours, some rounds.
    fn smooth(&mut self) {
        for _ in 0..SMOOTHING_ROUNDS {
            let mut moved = self.places.clone();
            for j in 1..self.n_along {
                for i in 0..self.n_around {
                    if self.cells_around(i, j).iter().all(|cell| *cell == Cell::Panel) {
                        let near = [(i + self.n_around - 1, j), (i + 1, j), (i, j - 1), (i, j + 1)];
                        let column = self.column(i, j);
                        moved[column] =
                            self.average_about(column, &near.map(|(i, j)| self.column(i, j)));
                    }
                }
            }
            self.places = moved;
        }
    }

    fn average(&self, columns: &[usize]) -> Place {
        let mut place = self.average_about(columns[0], columns);
        place.theta = place.theta.rem_euclid(TAU);
        place
    }

    /// The mean place of `columns`, angles taken within half a turn of `reference`.
    fn average_about(&self, reference: usize, columns: &[usize]) -> Place {
        let origin = self.places[reference].theta;
        let n = columns.len() as f64;
        let theta = columns.iter().map(|c| turn(self.places[*c].theta - origin)).sum::<f64>() / n;
        let y_m = columns.iter().map(|c| self.places[*c].y_m).sum::<f64>() / n;
        Place { theta: origin + theta, y_m }
    }

    /// Is one of the two cells beside this grid edge left out, and the other there?
    fn is_rim_edge(&self, a: usize, b: usize) -> bool {
        let (ia, ja) = (a % self.n_around, a / self.n_around);
        let (ib, jb) = (b % self.n_around, b / self.n_around);
        let n = self.n_around;
        let beside = if ja == jb && (ia + 1) % n == ib {
            [(ia, ja.wrapping_sub(1)), (ia, ja)]
        } else if ja == jb && (ib + 1) % n == ia {
            [(ib, ja.wrapping_sub(1)), (ib, ja)]
        } else if ia == ib && ja.abs_diff(jb) == 1 {
            [(ia + n - 1, ja.min(jb)), (ia, ja.min(jb))]
        } else {
            return false;
        };
        let holes =
            beside.map(|(i, j)| j < self.n_along && matches!(self.cell(i, j), Cell::Hole(_)));
        holes[0] != holes[1]
    }

    fn smallest_angle(&self, triangle: &[usize; 3]) -> f64 {
        let radius_m = self.ellipses.first().map_or(1.0, |ellipse| ellipse.radius_m);
        let origin = self.places[triangle[0]];
        let flat = triangle.map(|column| {
            let place = self.places[column];
            [turn(place.theta - origin.theta) * radius_m, place.y_m - origin.y_m]
        });
        (0..3)
            .map(|k| angle(flat[k], flat[(k + 1) % 3], flat[(k + 2) % 3]))
            .fold(f64::INFINITY, f64::min)
    }
}

/// The hole among `cells`, if there is one, not more, and all others are panel.
fn sole_hole(cells: &[Cell]) -> Option<usize> {
    let mut holes = cells.iter().filter_map(|cell| match cell {
        Cell::Hole(hole) => Some(*hole),
        _ => None,
    });
    let first = holes.next()?;
    let alone = holes.all(|hole| hole == first);
    let panel = cells.iter().filter(|cell| **cell == Cell::Panel).count();
    let same = cells.iter().filter(|cell| **cell == Cell::Hole(first)).count();
    (alone && panel > 0 && panel + same == cells.len()).then_some(first)
}

fn angle(at: [f64; 2], a: [f64; 2], b: [f64; 2]) -> f64 {
    let (u, v) = ([a[0] - at[0], a[1] - at[1]], [b[0] - at[0], b[1] - at[1]]);
    // signed, so that a triangle that has turned over counts as worse than any
    (u[0] * v[1] - u[1] * v[0]).atan2(u[0] * v[0] + u[1] * v[1])
}
