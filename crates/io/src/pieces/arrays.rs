//! The fields of a mesh from the arrays of its pieces.

use std::collections::HashMap;
use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use super::Piece;
use crate::MeshData;
use crate::fields::{Array, GHOSTS, Numbers};
use crate::source::count;

/// Which arrays of several pieces become fields.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fields {
    /// Those that all pieces have: they are parts of one mesh.
    Common,
    /// All, NaN where a piece has none: the pieces are meshes of their own. Those without
    /// volume are left out.
    All,
}

/// An array of a piece.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PieceArray<'a> {
    /// May be empty.
    pub(crate) name: &'a str,
    pub(crate) components: u64,
    /// As far as the file names them.
    pub(crate) component_names: &'a [Option<String>],
    /// The file marks it as the one to draw.
    pub(crate) active: bool,
    /// Its components are the channels of colors.
    pub(crate) colors: bool,
}

/// The most arrays that are filled up where a piece has none.
pub(crate) const MOST_FILLED: usize = 1000;

/// The point and cell data of the pieces.
pub(super) fn find_arrays<P: Piece>(
    pieces: &[P],
    fields: Fields,
    data: &mut MeshData,
) -> Vec<Array> {
    let mut arrays = Vec::new();
    let mut filled = 0;
    for association in [Association::Point, Association::Cell] {
        let tuples = |piece: &P| match association {
            Association::Point => piece.points(),
            Association::Cell => piece.cells(),
        };
        let of_pieces: Vec<_> = pieces.iter().map(|p| p.arrays(association)).collect();
        for twins in twins(&of_pieces) {
            let (first, index) = twins[0];
            let array = of_pieces[first][index];
            let name = match array.name {
                "" => format!("unnamed-{index}"),
                name => name.to_owned(),
            };
            let is_ghost = GHOSTS.contains(&array.name);
            if twins.len() < pieces.len() && !is_ghost {
                // The first piece without it is where the numbers of those with it part from
                // the natural ones.
                let mut numbers = twins.iter().zip(0..);
                let lacking = numbers.find(|((piece, _), number)| piece != number);
                let lacking = lacking.map_or(twins.len(), |(_, number)| number);
                let why = match pieces[lacking].name() {
                    Some(file) => format!("'{file}' has no such array"),
                    None => format!(
                        "piece {} of {} has no such array",
                        lacking + 1,
                        pieces.len()
                    ),
                };
                let components = count(array.components, "component");
                filled += 1;
                if fields == Fields::Common || filled > MOST_FILLED {
                    let why = format!("{why} of {components}");
                    data.notes
                        .push(format!("array '{}' left out: {why}", array.name));
                    data.left_out.push((array.name.to_owned(), why));
                    continue;
                }
                let lack = pieces.len() - twins.len();
                data.notes.push(format!(
                    "'{name}' is NaN in {lack} of {} pieces, which have no such array",
                    pieces.len()
                ));
            }
            let chain = Chain::new(pieces, &twins, (association, array.components), is_ghost);
            arrays.push(Array {
                name,
                association,
                components: array.components as usize,
                component_names: array.component_names.to_vec(),
                tuples: pieces.iter().map(tuples).sum::<u64>() as usize, // counted
                numbers: Arc::new(chain),
                active: array.active,
                colors: array.colors,
            });
        }
    }
    arrays
}

/// Arrays of one name and number of components: the number of a piece, and that of its array.
type Twins = Vec<(usize, usize)>;

/// The arrays of all pieces, those with one name together, in the order in which they come.
fn twins(of_pieces: &[Vec<PieceArray>]) -> Vec<Twins> {
    let mut known: HashMap<(&str, u64, usize), usize> = HashMap::new();
    let mut all: Vec<Twins> = Vec::new();
    for (number, arrays) in of_pieces.iter().enumerate() {
        // Arrays without a name are told apart by their order.
        let mut unnamed = 0;
        for (index, array) in arrays.iter().enumerate() {
            unnamed += usize::from(array.name.is_empty());
            let order = if array.name.is_empty() { unnamed } else { 0 };
            let at = *known
                .entry((array.name, array.components, order))
                .or_insert(all.len());
            match all.get_mut(at) {
                None => all.push(vec![(number, index)]),
                Some(twins) => twins.push((number, index)),
            }
        }
    }
    all
}

/// The numbers of the same array of several pieces, one after the other.
#[derive(Debug)]
struct Chain(Vec<Link>);

#[derive(Debug)]
enum Link {
    Stored(Arc<dyn Numbers>),
    /// So many times the same, where pieces have no such array.
    Same(u64, f64),
}

impl Chain {
    /// Without ghosts, all points and cells are a piece's own: 0.
    fn new<P: Piece>(
        pieces: &[P],
        twins: &Twins,
        (association, components): (Association, u64),
        is_ghost: bool,
    ) -> Chain {
        let filler = if is_ghost { 0.0 } else { f64::NAN };
        let mut links = Vec::new();
        let fill = |links: &mut Vec<Link>, pieces: &[P]| {
            let missing = pieces.iter().map(|piece| match association {
                Association::Point => piece.points(),
                Association::Cell => piece.cells(),
            });
            let missing = missing.sum::<u64>();
            if missing > 0 {
                links.push(Link::Same(missing * components, filler));
            }
        };
        let mut done = 0;
        for &(piece, array) in twins {
            fill(&mut links, &pieces[done..piece]);
            links.push(Link::Stored(pieces[piece].numbers(association, array)));
            done = piece + 1;
        }
        fill(&mut links, &pieces[done..]);
        Chain(links)
    }
}

impl Numbers for Chain {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        for link in &self.0 {
            match link {
                Link::Stored(stored) => stored.each(each)?,
                Link::Same(count, value) => (0..*count).for_each(|_| each(*value)),
            }
        }
        Ok(())
    }
}
