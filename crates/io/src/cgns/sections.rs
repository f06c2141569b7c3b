//! `Elements_t`: cells of unstructured zones.

use std::sync::Arc;

use tetrascope_core::Error;

use super::node::Node;
use crate::MeshData;
use crate::hdf5::View;
use crate::pieces::sections::{Coded, Layout, Polyhedra, Section, Shape, Topology};
use crate::pieces::{Budget, Faces, check_ends};
use crate::source::count;

/// Edges around the base, then those that rise, then those of the top; VTK has these last two
/// the other way round. Faces: −z, −y, +x, +y, −x and +z; VTK has −x, +x, −y, +y, −z and +z.
const HEXAHEDRON: [usize; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, // corners
    8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15, // edges
    24, 22, 21, 23, 20, 25, 26, // faces and the middle
];
/// As of hexahedra; the faces are in VTK's order.
const WEDGE: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17];

const MIXED: u64 = 20;
const NGON: u64 = 22;
const NFACE: u64 = 23;

/// The shape of a type by its number in `ElementType_t`.
fn shape(kind: u64) -> Option<Shape> {
    let ordered = |vtk, nodes, order| Shape { vtk, nodes, order };
    Some(match kind {
        10 => Shape::same(10, 4),
        11 => Shape::same(24, 10),
        12 => Shape::same(14, 5),
        // The middle of the base is passed over.
        13 => ordered(27, 14, Shape::same(27, 13).order),
        14 => Shape::same(13, 6),
        15 => ordered(26, 15, &WEDGE[..15]),
        16 => ordered(32, 18, &WEDGE[..]),
        17 => Shape::same(12, 8),
        18 => ordered(25, 20, &HEXAHEDRON[..20]),
        19 => ordered(29, 27, &HEXAHEDRON[..]),
        21 => Shape::same(27, 13),
        _ => return None,
    })
}

/// How many nodes cells without a volume have: points, lines and surfaces.
fn flat(kind: u64) -> Option<usize> {
    Some(match kind {
        2 => 1,
        3 => 2,
        4 | 5 => 3,
        6 => 6,
        7 | 24 => 4,
        8 => 8,
        9 | 25 => 9,
        26 => 10,
        27 => 12,
        28 => 16,
        _ => return None,
    })
}

/// The meaning of a number in a mixed section. Surfaces are passed over: solutions in cells
/// have no values for them.
fn coded(kind: u64) -> Result<Coded, String> {
    match (shape(kind), flat(kind)) {
        (Some(shape), _) => Ok(Coded::Cell(shape)),
        (None, Some(nodes)) => Ok(Coded::PassedOver(nodes)),
        (None, None) => Err(format!("is of type {kind}, which is not read")),
    }
}

/// A section.
struct Elements {
    node: Node,
    kind: u64,
    first: u64,
    last: u64,
}

impl Elements {
    fn of(node: Node) -> Result<Elements, Error> {
        let kind = node.indices(2)?;
        let range = node.needed("ElementRange")?.indices(2)?;
        match (&kind[..], &range[..]) {
            (&[kind, ..], &[first, last]) if first <= last => Ok(Elements {
                node,
                kind,
                first,
                last,
            }),
            _ => Err(node.error("its type or its ElementRange is not what it must be")),
        }
    }

    fn connectivity(&self) -> Result<View, Error> {
        self.node.needed("ElementConnectivity")?.view()
    }

    /// Where lists of nodes or faces begin, since CGNS 4.0.
    fn offsets(&self) -> Result<Option<View>, Error> {
        let node = self.node.named("ElementStartOffset")?;
        node.map(|node| node.view()).transpose()
    }
}

/// The cells of a zone, how many they are, and how many bytes their lists take.
pub(super) fn read(
    zone: &Node,
    name: &str,
    data: &mut MeshData,
) -> Result<(Topology, u64, u64), Error> {
    let mut all = Vec::new();
    for node in zone.children("Elements_t")? {
        all.push(Elements::of(node)?);
    }
    // Solutions have this order.
    all.sort_by_key(|elements| elements.first);
    let (mut sections, mut faces, mut cells) = (Vec::new(), Vec::new(), Vec::new());
    let (mut number, mut bytes) = (0, 0_u64);
    for elements in all {
        let layout = match (elements.kind, shape(elements.kind)) {
            (NGON, _) => {
                faces.push(elements);
                continue;
            }
            (NFACE, _) => {
                cells.push(elements);
                continue;
            }
            (MIXED, _) => Layout::Mixed(coded),
            (_, Some(shape)) => Layout::Same(shape),
            (kind, None) if flat(kind).is_some() => {
                let section = &elements.node.name;
                let note =
                    format!("'{section}' of '{name}' left out: it has no cells with a volume");
                data.notes.push(note);
                continue;
            }
            (kind, None) => {
                let what = format!("elements of type {kind} are not read");
                return Err(elements.node.error_with_help(what, "save the mesh as .vtu"));
            }
        };
        let connectivity = elements.connectivity()?;
        bytes = bytes.saturating_add(connectivity.bytes());
        let section = Section {
            path: zone.path().to_owned(),
            at: format!("section '{}' of '{name}'", elements.node.name),
            indices: Arc::new(connectivity),
            layout,
            first: 1,
        };
        let found = section.cells()?;
        let listed = elements.last - elements.first + 1;
        let fits = match layout {
            Layout::Same(_) => found == listed,
            Layout::Mixed(_) => found <= listed,
        };
        if !fits {
            let what = format!("{} where ElementRange has {listed}", count(found, "cell"));
            return Err(elements.node.error(what));
        }
        number += found;
        sections.push(section);
    }
    if cells.is_empty() {
        return Ok((Topology::Sections(sections), number, bytes));
    }
    if !sections.is_empty() {
        let what = "the zone has polyhedra and other cells";
        return Err(zone.error_with_help(what, "save the mesh as .vtu"));
    }
    let number = cells
        .iter()
        .map(|e| e.last - e.first + 1)
        .fold(0, u64::saturating_add);
    let topology = Topology::Polyhedra(Box::new(Ngons { faces, cells }));
    Ok((topology, number, bytes))
}

/// Polyhedra by their faces.
struct Ngons {
    /// `NGON_n`, by their numbers.
    faces: Vec<Elements>,
    /// `NFACE_n`.
    cells: Vec<Elements>,
}

impl Ngons {
    /// The numbers of lists and where each list ends among them.
    fn lists(budget: &Budget, all: &[Elements]) -> Result<(Vec<f64>, Vec<u64>), Error> {
        let (mut numbers, mut ends) = (Vec::new(), Vec::new());
        for elements in all {
            let (connectivity, offsets) = (elements.connectivity()?, elements.offsets()?);
            let listed = elements.last - elements.first + 1;
            budget.check(
                0,
                (numbers.len() as u64).saturating_add(connectivity.count()),
            )?;
            let values = connectivity.floats()?;
            let before = numbers.len() as u64;
            let wrong = |what: String| elements.node.error(what);
            match offsets {
                Some(offsets) => {
                    if offsets.count() != listed.saturating_add(1) {
                        let what = format!("{} offsets of {listed} elements", offsets.count());
                        return Err(wrong(what));
                    }
                    budget.check(0, (ends.len() as u64).saturating_add(listed))?;
                    let mut offsets = offsets.indices()?;
                    check_ends(&offsets, |what| {
                        wrong(format!("of 'ElementStartOffset', {what}"))
                    })?;
                    let last = offsets.last().copied().unwrap_or(0);
                    if offsets.first() != Some(&0) || last > values.len() as u64 {
                        let what = format!(
                            "the offsets do not cover {} numbers from the first on",
                            values.len()
                        );
                        return Err(wrong(what));
                    }
                    ends.extend(offsets.drain(1..).map(|end| before + end));
                    numbers.extend_from_slice(&values[..last as usize]);
                }
                // Before 4.0 each list begins with its length.
                None => {
                    let mut rest = &values[..];
                    while let Some((&length, tail)) = rest.split_first() {
                        let list = (length >= 0.0).then(|| tail.get(..length as usize));
                        let list = list.flatten();
                        let list =
                            list.ok_or_else(|| wrong("its last list is not whole".into()))?;
                        numbers.extend_from_slice(list);
                        ends.push(numbers.len() as u64);
                        rest = &tail[list.len()..];
                    }
                }
            }
        }
        let listed = all
            .iter()
            .map(|e| e.last - e.first + 1)
            .fold(0, u64::saturating_add);
        match (all.first(), ends.len() as u64 == listed) {
            (Some(elements), false) => Err(elements
                .node
                .error(format!("{} lists of {listed} elements", ends.len()))),
            _ => Ok((numbers, ends)),
        }
    }

    /// The place of a face among all, by its number in the zone.
    fn face(&self, number: u64) -> Option<u64> {
        let mut before = 0;
        for elements in &self.faces {
            if (elements.first..=elements.last).contains(&number) {
                return Some(before + number - elements.first);
            }
            before += elements.last - elements.first + 1;
        }
        None
    }
}

impl Polyhedra for Ngons {
    fn faces(&self, budget: &Budget) -> Result<Faces, Error> {
        let (points, face_ends) = Ngons::lists(budget, &self.faces)?;
        let (of_cells, cell_ends) = Ngons::lists(budget, &self.cells)?;
        let wrong = |what: String| self.cells[0].node.error(what);
        let points = points.into_iter().map(|number| match number >= 1.0 {
            true => Ok(number as u64 - 1),
            false => Err(wrong(format!(
                "a face has node {number}, and the first is 1"
            ))),
        });
        let of_cells = of_cells.into_iter().map(|number| {
            // Below 0 where a face is turned over.
            let face = self.face(number.abs() as u64);
            face.ok_or_else(|| wrong(format!("a cell has face {number}, which is not there")))
        });
        Ok(Faces {
            of_cells: of_cells.collect::<Result<_, _>>()?,
            cell_ends,
            points: points.collect::<Result<_, _>>()?,
            face_ends,
        })
    }
}
