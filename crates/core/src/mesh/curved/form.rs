//! The kind of a curved cell of a file: by its type, its number of nodes and its degrees.

use std::collections::HashMap;

use super::shapes::{Curved, Family};
use super::simplex::MOST_ORDER;
use super::{Extra, nodes};
use crate::mesh::Cells;
use crate::mesh::type_name;
use crate::{Error, mesh::cell_type::Kind};

/// The functions between nodes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Basis {
    /// Through the values at nodes.
    Lagrange,
    /// Those of Bézier cells: values at nodes that are not corners are coefficients.
    Bernstein,
}

/// All that tells kinds of curved cells apart.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) struct Form {
    pub(super) family: Family,
    pub(super) basis: Basis,
    /// Orders along three axes. A wedge has the first and the last of them, a tetrahedron the first.
    pub(super) orders: [usize; 3],
    pub(super) nodes: usize,
}

/// Whether some cells of this VTK type are cut into straight ones.
pub(super) fn is_curved(cell_type: u8) -> bool {
    matches!(cell_type, 24..=27 | 29 | 31..=33 | 71..=73 | 78..=80)
}

impl Form {
    /// The form of a cell, `None` where it is not cut: straight ones and those that are drawn by their
    /// corners. `degrees` are of hexahedra and wedges of any order.
    ///
    /// # Errors
    /// Why there is no such cell.
    pub(super) fn of(
        cell_type: u8,
        nodes: usize,
        degrees: Option<[f64; 3]>,
    ) -> Result<Option<Form>, String> {
        use Family::{Hexahedron, Pyramid, Tetrahedron, Wedge};
        let quadratic = |family, orders| {
            Ok(Some(Form {
                family,
                basis: Basis::Lagrange,
                orders,
                nodes,
            }))
        };
        let (family, basis) = match cell_type {
            24 => return quadratic(Tetrahedron, [2; 3]),
            25 | 29 | 33 => return quadratic(Hexahedron, [2; 3]),
            26 | 32 => return quadratic(Wedge, [2; 3]),
            27 => return quadratic(Pyramid, [2; 3]),
            31 => return quadratic(Wedge, [2, 2, 1]),
            71 => (Tetrahedron, Basis::Lagrange),
            72 => (Hexahedron, Basis::Lagrange),
            73 => (Wedge, Basis::Lagrange),
            78 => (Tetrahedron, Basis::Bernstein),
            79 => (Hexahedron, Basis::Bernstein),
            80 => (Wedge, Basis::Bernstein),
            _ => return Ok(None),
        };
        // VTK's tetrahedron of 15 nodes and its wedge of 21, which no order has.
        if matches!((family, nodes), (Tetrahedron, 15) | (Wedge, 21)) {
            return Ok(None);
        }
        let orders = match degrees.filter(|_| family != Tetrahedron) {
            Some(degrees) => given_orders(family, nodes, degrees)?,
            None => even_orders(family, nodes)?,
        };
        let is_cut = orders.iter().all(|order| *order <= MOST_ORDER);
        Ok(is_cut.then_some(Form {
            family,
            basis,
            orders,
            nodes,
        }))
    }
}

/// How many nodes there are.
fn count(family: Family, [p, q, r]: [usize; 3]) -> usize {
    match family {
        Family::Tetrahedron => (p + 1) * (p + 2) * (p + 3) / 6,
        Family::Wedge => (p + 1) * (p + 2) / 2 * (r + 1),
        _ => (p + 1) * (q + 1) * (r + 1),
    }
}

/// The greatest order that is known, though not cut: VTK's.
const MOST_KNOWN: usize = 10;

/// The same order along all axes, by the number of nodes.
fn even_orders(family: Family, nodes: usize) -> Result<[usize; 3], String> {
    let orders = (1..=MOST_KNOWN).map(|order| [order; 3]);
    let found = orders
        .clone()
        .find(|orders| count(family, *orders) == nodes);
    found.ok_or_else(|| {
        let counts = orders
            .take(MOST_ORDER)
            .map(|orders| count(family, orders).to_string());
        format!(
            "no order has so many: it must have {}",
            counts.collect::<Vec<_>>().join(", ")
        )
    })
}

/// The orders that the file gives.
fn given_orders(family: Family, nodes: usize, degrees: [f64; 3]) -> Result<[usize; 3], String> {
    let [a, b, c] = degrees;
    let wrong = |why: &str| {
        Err(format!(
            "its degrees in the file are {a}, {b} and {c}: {why}"
        ))
    };
    let is_degree = |d: f64| d.fract() == 0.0 && (1.0..=MOST_KNOWN as f64).contains(&d);
    if !degrees.iter().all(|d| is_degree(*d)) {
        return wrong("they must be whole numbers from 1 to 10");
    }
    let orders = degrees.map(|d| d as usize);
    if family == Family::Wedge && a != b {
        return wrong("the first two must be the same, as both are of the triangle");
    }
    match count(family, orders) {
        needed if needed == nodes => Ok(orders),
        needed => wrong(&format!("these need {needed} points")),
    }
}

/// The forms of a mesh's cells.
pub(super) struct Forms {
    /// In the order in which they come first.
    pub(super) kinds: Vec<Curved>,
    /// By cell, the number of its form, or [`STRAIGHT`].
    pub(super) of_cells: Vec<u16>,
}

/// In place of a form's number: the cell stays as it is.
pub(super) const STRAIGHT: u16 = u16::MAX;

impl Forms {
    /// The forms of checked cells.
    ///
    /// # Errors
    /// With the cell: a number of points that no order has, degrees that the cell cannot have, and weights of
    /// points that are not above 0.
    pub(super) fn new(cells: &Cells, extra: &Extra) -> Result<Forms, Error> {
        let mut known: HashMap<Form, u16> = HashMap::new();
        let mut forms = Forms {
            kinds: Vec::new(),
            of_cells: Vec::with_capacity(cells.types.len()),
        };
        // Most cells are of the form of the one before.
        let mut last = None;
        for (cell, &cell_type) in cells.types.iter().enumerate() {
            if !is_curved(cell_type) {
                forms.of_cells.push(STRAIGHT);
                continue;
            }
            let count = nodes(cells, cell).len();
            let degrees = extra.degrees.get(cell).copied();
            let degrees = degrees.filter(|degrees| !degrees.iter().all(|d| d.is_nan()));
            let key = (cell_type, count, degrees);
            if let Some((_, number)) = last.filter(|(known, _)| *known == key) {
                forms.of_cells.push(number);
                continue;
            }
            let wrong = |why: String| {
                Error::Invalid {
                what: format!("cell {cell} is a {} of {count} points: {why}", type_name(cell_type)),
                help: Some(match Kind::of(cell_type) {
                    Kind::AnyOrder(_) => {
                        "orders that differ along the axes belong in the cell array HigherOrderDegrees".into()
                    }
                    _ => "the file's cell types and offsets do not belong together".into(),
                }),
            }
            };
            let number = match Form::of(cell_type, count, degrees).map_err(wrong)? {
                None => STRAIGHT,
                Some(form) => *known.entry(form).or_insert_with_key(|form| {
                    forms.kinds.push(Curved::new(form));
                    // Orders have few values.
                    u16::try_from(forms.kinds.len() - 1).expect("fewer than a thousand")
                }),
            };
            forms.of_cells.push(number);
            last = Some((key, number));
        }
        forms.check_weights(cells, &extra.weights)?;
        Ok(forms)
    }

    /// The form of a cell that is cut.
    pub(super) fn of(&self, cell: usize) -> Option<&Curved> {
        self.kinds.get(usize::from(self.of_cells[cell]))
    }

    /// Whether all functions of all forms are linear along edges.
    pub(super) fn are_straight(&self, extra: &Extra) -> bool {
        let is_straight = |kind: &Curved| {
            kind.order == 1 && (kind.basis == Basis::Lagrange || extra.weights.is_empty())
        };
        self.kinds.iter().all(is_straight)
    }

    /// The cells that are cut.
    pub(super) fn cut(&self) -> impl Iterator<Item = (usize, &Curved)> {
        let all = 0..self.of_cells.len();
        all.filter_map(|cell| Some((cell, self.of(cell)?)))
    }

    fn check_weights(&self, cells: &Cells, weights: &[f64]) -> Result<(), Error> {
        if weights.is_empty() {
            return Ok(());
        }
        let rational = self
            .cut()
            .filter(|(_, kind)| kind.basis == Basis::Bernstein);
        for (cell, _) in rational {
            for &node in nodes(cells, cell) {
                let weight = weights[node as usize];
                if !(weight > 0.0 && weight.is_finite()) {
                    return Err(Error::invalid(format!(
                        "cell {cell} uses point {node} with the weight {weight}; weights of Bézier cells must be above 0"
                    )));
                }
            }
        }
        Ok(())
    }
}
