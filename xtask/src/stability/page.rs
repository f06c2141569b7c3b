//! The matrix as a page: a line a case, with what each algorithm drew.

use serde::Serialize;

use super::judge::Judgment;
use super::matrix::{Cell, Line, Matrix};
use crate::page::{address, html};

/// The data of the template.
#[derive(Serialize)]
struct Page<'a> {
    adapter: Option<&'a str>,
    columns: &'a [&'static str],
    groups: Vec<ShownGroup>,
    faults: Vec<String>,
    verdict: String,
    stress: &'a str,
}

#[derive(Serialize)]
struct ShownGroup {
    name: &'static str,
    lines: Vec<ShownLine>,
}

#[derive(Serialize)]
struct ShownLine {
    name: String,
    cells: Vec<ShownCell>,
}

/// The outcome of a case with an algorithm.
#[derive(Serialize)]
struct ShownCell {
    /// "good", "open" where nothing is promised, "bad", or "none" where it is not drawn.
    class: &'static str,
    number: Option<String>,
    /// Why it is not drawn, or what is wrong.
    why: Option<String>,
    picture: Option<String>,
}

impl ShownCell {
    fn of(judgment: &Judgment) -> ShownCell {
        ShownCell {
            class: match (&judgment.fault, judgment.allowed) {
                (Some(_), _) => "bad",
                (None, Some(_)) => "good",
                (None, None) => "open",
            },
            number: Some(format!("{:.0e}", judgment.greatest)),
            why: judgment.fault.clone(),
            picture: judgment.picture.as_deref().map(address),
        }
    }

    fn of_cell(cell: &Cell) -> ShownCell {
        match (cell.worst(), cell) {
            (Some(judgment), _) => ShownCell::of(judgment),
            (None, Cell::NotDrawn(why)) => ShownCell {
                class: "none",
                number: None,
                why: Some(why.clone()),
                picture: None,
            },
            (None, Cell::Drawn(_)) => unreachable!("what is drawn is judged"),
        }
    }
}

impl ShownLine {
    fn of(line: &Line) -> ShownLine {
        let truth = ShownCell::of(&line.truth);
        ShownLine {
            name: line.name.clone(),
            cells: std::iter::once(truth)
                .chain(line.cells.iter().map(ShownCell::of_cell))
                .collect(),
        }
    }
}

impl Matrix {
    /// The page, which needs no other file; `stress` says how long the ground truth took.
    pub fn to_html(&self, adapter: Option<&str>, stress: &str) -> String {
        let groups = self.lines.chunk_by(|a, b| a.group == b.group);
        let groups = groups.map(|lines| ShownGroup {
            name: lines[0].group.name(),
            lines: lines.iter().map(ShownLine::of).collect(),
        });
        let page = Page {
            adapter,
            columns: &self.columns,
            groups: groups.collect(),
            faults: self.faults(),
            verdict: self.verdict(),
            stress,
        };
        html(include_str!("page.html"), &page, |_| ())
    }
}
