//! Algorithms by cases: how far each was from the truth.

use std::fmt::Write as _;

use super::case::Group;
use super::judge::{Judgment, Outcome};

/// All cases with all algorithms.
#[derive(Clone, Debug)]
pub struct Matrix {
    /// The algorithms beside the ground truth.
    pub columns: Vec<&'static str>,
    /// A line a case.
    pub lines: Vec<Line>,
}

/// A case.
#[derive(Clone, Debug)]
pub struct Line {
    /// The reason for which it is hard.
    pub group: Group,
    /// A few words.
    pub name: String,
    /// How far the ground truth is from what is known.
    pub truth: Judgment,
    /// One of each of [`Matrix::columns`].
    pub cells: Vec<Cell>,
}

/// An algorithm in a case.
#[derive(Clone, Debug)]
pub enum Cell {
    /// Its settings that drew it.
    Drawn(Vec<(&'static str, Judgment)>),
    /// None did, and why.
    NotDrawn(String),
}

impl Cell {
    /// The sum of its settings' outcomes.
    pub(super) fn of(outcomes: Vec<(&'static str, Outcome)>) -> Cell {
        let mut drawn = Vec::new();
        let mut why = None;
        for (setting, outcome) in outcomes {
            match outcome {
                Outcome::Drawn(judgment) => drawn.push((setting, judgment)),
                Outcome::NotDrawn(reason) => why = why.or(Some(reason)),
            }
        }
        match (drawn.is_empty(), why) {
            (true, Some(reason)) => Cell::NotDrawn(reason),
            (true, None) => Cell::NotDrawn("it has no setting".into()),
            (false, _) => Cell::Drawn(drawn),
        }
    }

    /// The worst of the settings that promise most; of those with a fault, if there are any.
    pub(super) fn worst(&self) -> Option<&Judgment> {
        let Cell::Drawn(settings) = self else {
            return None;
        };
        let rank = |j: &Judgment| (j.fault.is_none(), j.allowed.unwrap_or(f64::INFINITY));
        let judgments = settings.iter().map(|(_, judgment)| judgment);
        judgments.min_by(|a, b| {
            let ((well_a, may_a), (well_b, may_b)) = (rank(a), rank(b));
            let by_promise = well_a.cmp(&well_b).then(may_a.total_cmp(&may_b));
            by_promise.then(b.greatest.total_cmp(&a.greatest))
        })
    }
}

impl Line {
    /// Whether nothing is wrong.
    pub fn is_well(&self) -> bool {
        let mut judgments = self.cells.iter().filter_map(Cell::worst);
        self.truth.fault.is_none() && judgments.all(|judgment| judgment.fault.is_none())
    }
}

impl Matrix {
    /// Without a line yet.
    pub(super) fn new(columns: Vec<&'static str>) -> Matrix {
        Matrix {
            columns,
            lines: Vec::new(),
        }
    }

    /// The faults, a sentence each: case, algorithm, setting and place.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        for line in &self.lines {
            let subject = format!("{}: {}", line.group.name(), line.name);
            if let Some(fault) = &line.truth.fault {
                faults.push(format!("{subject}: the ground truth: {fault}"));
            }
            for (column, cell) in self.columns.iter().zip(&line.cells) {
                let Cell::Drawn(settings) = cell else {
                    continue;
                };
                for (setting, judgment) in settings {
                    if let Some(fault) = &judgment.fault {
                        let who = format!("{column} {setting}");
                        faults.push(format!("{subject}: {}: {fault}", who.trim_end()));
                    }
                }
            }
        }
        faults
    }

    /// Whether something was drawn and nothing is wrong.
    pub fn passed(&self) -> bool {
        !self.lines.is_empty() && self.faults().is_empty()
    }

    /// One line for the end.
    pub fn verdict(&self) -> String {
        let drawn = |line: &Line| {
            let settings = line.cells.iter().map(|cell| match cell {
                Cell::Drawn(settings) => settings.len(),
                Cell::NotDrawn(_) => 0,
            });
            settings.sum::<usize>() + 1
        };
        let pictures: usize = self.lines.iter().map(drawn).sum();
        let explained = |line: &Line| {
            let settings = line.cells.iter().flat_map(|cell| match cell {
                Cell::Drawn(settings) => settings.as_slice(),
                Cell::NotDrawn(_) => &[],
            });
            line.truth.explained + settings.map(|(_, j)| j.explained).sum::<usize>()
        };
        let explained: usize = self.lines.iter().map(explained).sum();
        match self.faults().len() {
            _ if self.lines.is_empty() => "nothing was drawn".into(),
            0 => format!(
                "{} cases, {pictures} settings: all keep what they promise; {explained} pixels show what a \
                 ray beside theirs does",
                self.lines.len()
            ),
            faults => format!(
                "{faults} of {pictures} settings are wrong, in {} cases",
                self.lines.len()
            ),
        }
    }

    /// The greatest differences in parts of the greatest channel.
    pub fn to_table(&self) -> String {
        let width = self
            .lines
            .iter()
            .map(|line| line.name.chars().count())
            .max();
        let width = width.unwrap_or(0) + 2;
        let mut table = String::new();
        let names = std::iter::once("reference").chain(self.columns.iter().copied());
        let names: Vec<String> = names.map(|name| format!("{name:>12}")).collect();
        let mut group = None;
        for line in &self.lines {
            if group != Some(line.group) {
                group = Some(line.group);
                let pad = width - line.group.name().len();
                _ = writeln!(table, "{}{:pad$}{}", line.group.name(), "", names.concat());
            }
            let pad = width - 2 - line.name.chars().count();
            _ = write!(
                table,
                "  {}{:pad$}{}",
                line.name,
                "",
                shown(Some(&line.truth))
            );
            for cell in &line.cells {
                table += &shown(cell.worst());
            }
            table.push('\n');
        }
        table += "A channel's greatest difference from what is known (reference) and from the truth, in parts \
                  of the greatest channel;\n? nothing is promised, - is not drawn, ! is wrong.\n";
        table
    }
}

fn shown(judgment: Option<&Judgment>) -> String {
    let Some(judgment) = judgment else {
        return format!("{:>12}", "-");
    };
    let mark = match (&judgment.fault, judgment.allowed) {
        (Some(_), _) => "!",
        (None, None) => "?",
        (None, Some(_)) => "",
    };
    format!("{:>12}", format!("{:.1e}{mark}", judgment.greatest))
}
