//! From a file's arrays to scalar fields, and which of them a name means.

use std::fmt::Debug;
use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use crate::higher_order::says_shape;

/// The array in which VTK marks duplicate and hidden cells and points.
const GHOST_TYPE: &str = "vtkGhostType";

/// Its predecessor: 0 for a cell of one's own.
pub(crate) const GHOST_LEVELS: &str = "vtkGhostLevels";

/// Both.
pub(crate) const GHOSTS: [&str; 2] = [GHOST_TYPE, GHOST_LEVELS];

/// More would be a table, not a field.
pub(crate) const MOST_COMPONENTS: usize = 64;

/// The numbers of an array.
pub(crate) trait Numbers: Debug + Send + Sync {
    /// Calls `each` with every number, all components of the first tuple, then of the next.
    ///
    /// # Errors
    /// Those of the file, where the numbers are read only now.
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error>;
}

/// Numbers in memory.
#[derive(Debug)]
pub(crate) struct Loaded(pub(crate) Vec<f64>);

impl Numbers for Loaded {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        self.0.iter().for_each(|&value| each(value));
        Ok(())
    }
}

/// Numbers that are the same up to a place, then up to the next: the end of each run and its
/// number. Ends ascend.
#[derive(Debug)]
pub(crate) struct Runs(pub(crate) Vec<(u64, f64)>);

impl Numbers for Runs {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let mut start = 0;
        for &(end, value) in &self.0 {
            (start..end).for_each(|_| each(value));
            start = end;
        }
        Ok(())
    }
}

/// Arrays of one number for each point or cell, which together are the components of another.
#[derive(Debug)]
pub(crate) struct Together(pub(crate) Vec<Arc<dyn Numbers>>);

impl Numbers for Together {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        let Some((first, others)) = self.0.split_first() else {
            return Ok(());
        };
        let mut columns = Vec::new();
        for numbers in others {
            let mut column = Vec::new();
            numbers.each(&mut |value| column.push(value))?;
            columns.push(column);
        }
        let mut tuple = 0;
        first.each(&mut |value| {
            each(value);
            for column in &columns {
                each(column.get(tuple).copied().unwrap_or(f64::NAN));
            }
            tuple += 1;
        })
    }
}

/// A field with any number of components.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) association: Association,
    /// Numbers of a tuple; at most [`MOST_COMPONENTS`].
    pub(crate) components: usize,
    /// The file's names of its components; may be shorter or empty.
    pub(crate) component_names: Vec<Option<String>>,
    pub(crate) tuples: usize,
    pub(crate) numbers: Arc<dyn Numbers>,
    /// The file marks it as the one to draw.
    pub(crate) active: bool,
    /// Its components are the channels of colors.
    pub(crate) colors: bool,
}

/// How a scalar field is made of an array's tuples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Part {
    Component(usize),
    Magnitude,
}

impl Part {
    /// The field's value for a tuple.
    pub(crate) fn of(self, tuple: &[f64]) -> f64 {
        match self {
            Part::Component(component) => tuple[component],
            Part::Magnitude => tuple.iter().map(|v| v * v).sum::<f64>().sqrt(),
        }
    }
}

impl Array {
    /// A number for each point or cell, which are `tuples`.
    pub(crate) fn scalar(
        name: &str,
        association: Association,
        tuples: usize,
        numbers: Arc<dyn Numbers>,
    ) -> Array {
        Array {
            name: name.into(),
            association,
            components: 1,
            component_names: Vec::new(),
            tuples,
            numbers,
            active: false,
            colors: false,
        }
    }

    /// The scalar fields that the array offers, by name: of a vector its magnitude, then
    /// its components.
    pub(crate) fn parts(&self) -> Vec<(String, Part)> {
        if self.components == 1 {
            return vec![(self.name.clone(), Part::Component(0))];
        }
        let mut parts = Vec::new();
        if self.components <= 3 {
            parts.push((magnitude_name(&self.name), Part::Magnitude));
        }
        for component in 0..self.components {
            let suffix = component_name(component, &self.component_names);
            parts.push((
                format!("{}-{suffix}", self.name),
                Part::Component(component),
            ));
        }
        parts
    }

    /// Where it comes in a list of fields: the file's active scalars, other scalars,
    /// parts of vectors, then what nobody wants to look at unasked.
    pub(crate) fn rank(&self) -> u8 {
        match () {
            () if is_helper(&self.name) => 3,
            () if self.components > 1 => 2,
            () if self.active => 0,
            () => 1,
        }
    }
}

/// Takes out the arrays that mark ghosts.
pub(crate) fn take_ghosts(arrays: &mut Vec<Array>) -> Vec<Array> {
    let is_ghost = |a: &mut Array| a.components == 1 && GHOSTS.contains(&a.name.as_str());
    arrays.extract_if(.., is_ghost).collect()
}

fn magnitude_name(array: &str) -> String {
    format!("{array}-magnitude")
}

/// The file's name of a component, or its number where the file gives it no name or one
/// that an earlier component has.
pub(crate) fn component_name(component: usize, names: &[Option<String>]) -> String {
    let name_of = |i: usize| names.get(i)?.as_deref().filter(|name| !name.is_empty());
    name_of(component)
        .filter(|name| (0..component).all(|earlier| name_of(earlier) != Some(name)))
        .map_or_else(|| component.to_string(), str::to_owned)
}

/// Joins arrays, of which each has a name and something else, that follow each other and end in X, Y and Z, or x, y and z.
#[cfg(any(feature = "exodus", feature = "hdf5"))]
pub(crate) fn vectors<T: Clone>(names: &[(String, T)]) -> Vec<(String, Vec<T>)> {
    let stem = |name: &str, ends: [char; 2]| {
        let stem = name.strip_suffix(ends)?;
        let stem = stem.trim_end_matches(['_', ' ', '-']);
        (!stem.is_empty()).then(|| stem.to_owned())
    };
    let (mut rest, mut fields) = (names, Vec::new());
    while let Some(((name, number), tail)) = rest.split_first() {
        if let [(y, second), (z, third), ..] = tail
            && let Some(x) = stem(name, ['x', 'X'])
            && stem(y, ['y', 'Y']).as_ref() == Some(&x)
            && stem(z, ['z', 'Z']).as_ref() == Some(&x)
        {
            fields.push((x, vec![number.clone(), second.clone(), third.clone()]));
            rest = &tail[2..];
        } else {
            fields.push((name.clone(), vec![number.clone()]));
            rest = tail;
        }
    }
    fields
}

/// The customary meaning of components without a name: places in space, colors, and the parts of
/// tensors in VTK's order.
const GUESSES: [(&[&str], &str); 7] = [
    (&["x", "y"], "x y"),
    (&["x", "y", "z"], "x y z"),
    (&["red", "green", "blue"], "red green blue"),
    (&["r", "g", "b"], "r g b"),
    (&["red", "green", "blue", "alpha"], "red green blue alpha"),
    (
        &["xx", "yy", "zz", "xy", "yz", "xz"],
        "xx yy zz xy yz xz, VTK's order",
    ),
    (
        &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
        "xx xy xz yx yy yz zx zy zz, row by row",
    ),
];

/// Numbers of points and cells, marks and masks, and how cells are curved.
fn is_helper(name: &str) -> bool {
    let lower = name.to_ascii_lowercase();
    is_identifier(name)
        || says_shape(name)
        || lower.ends_with("mask")
        || lower.contains("ghost")
        || lower.starts_with("vtkoriginal")
}

/// "id", "node_id", "PointIds", but not "fluid".
fn is_identifier(name: &str) -> bool {
    let bytes = name.as_bytes();
    ["id", "ids"].iter().any(|word| {
        let Some(start) = bytes.len().checked_sub(word.len()) else {
            return false;
        };
        let (stem, end) = bytes.split_at(start);
        let is_own_word = match stem.last() {
            None => true,
            Some(b) if !b.is_ascii_alphabetic() => true,
            Some(b) => b.is_ascii_lowercase() && end[0] == b'I',
        };
        end.eq_ignore_ascii_case(word.as_bytes()) && is_own_word
    })
}

/// Which field to draw, and what is to be said about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Choice {
    pub(crate) index: usize,
    pub(crate) note: Option<String>,
}

impl Choice {
    fn silent(index: usize) -> Choice {
        Choice { index, note: None }
    }
}

/// The field that `wanted` means, of those that are listed; `None` if it means none.
///
/// That is, in this order, a field's name; `NAME (cell)`, `NAME (point)`, `cell:NAME` and
/// `point:NAME`, where a name is at points and in cells (alone it means the points');
/// a vector's name, for its magnitude; and `NAME-x` or the like where the file does not
/// name the components. Without a name, the first field that varies, marks and numbers of
/// points last. `varies` is asked only for as many as needed.
pub(crate) fn choose(
    fields: &[(&str, Association)],
    wanted: Option<&str>,
    mut varies: impl FnMut(usize) -> bool,
) -> Option<Choice> {
    if let Some(wanted) = wanted {
        return choose_named(fields, wanted);
    }
    let (mut order, helpers): (Vec<usize>, Vec<usize>) =
        (0..fields.len()).partition(|&i| !is_helper(fields[i].0));
    order.extend(helpers);
    let first = *order.first()?;
    let index = order.into_iter().find(|&i| varies(i)).unwrap_or(first);
    let mut choice = Choice::silent(index);
    if index != first {
        choice.note = Some(format!(
            "field '{}' is the same everywhere: '{}' is drawn",
            fields[first].0, fields[index].0
        ));
    } else if has_twin(fields, index) {
        choice = with_twin(fields, index);
    }
    Some(choice)
}

fn choose_named(fields: &[(&str, Association)], wanted: &str) -> Option<Choice> {
    let both = [Association::Point, Association::Cell];
    if let Some(index) = find(fields, &both, |name| name == wanted) {
        return Some(with_twin(fields, index));
    }
    for association in both {
        let word = association_name(association);
        let qualified = wanted
            .strip_prefix(word)
            .and_then(|rest| rest.strip_prefix(':'))
            .or_else(|| wanted.strip_suffix(&format!(" ({word})")));
        if let Some(name) = qualified {
            return match find(fields, &[association], |n| n == name) {
                Some(index) => Some(Choice::silent(index)),
                None => choose_part(fields, name, &[association]),
            };
        }
    }
    choose_part(fields, wanted, &both)
}

/// "point" or "cell".
pub(crate) fn association_name(association: Association) -> &'static str {
    match association {
        Association::Point => "point",
        Association::Cell => "cell",
    }
}

/// The first field of that name, points before cells.
fn find(
    fields: &[(&str, Association)],
    among: &[Association],
    is_it: impl Fn(&str) -> bool,
) -> Option<usize> {
    among
        .iter()
        .find_map(|a| fields.iter().position(|f| f.1 == *a && is_it(f.0)))
}

fn has_twin(fields: &[(&str, Association)], index: usize) -> bool {
    let (name, association) = fields[index];
    fields.iter().any(|f| f.0 == name && f.1 != association)
}

/// A note if the name stands for two fields.
fn with_twin(fields: &[(&str, Association)], index: usize) -> Choice {
    let (name, association) = fields[index];
    let note = has_twin(fields, index).then(|| {
        let (drawn, other) = match association {
            Association::Point => ("at points", "cell"),
            Association::Cell => ("in cells", "point"),
        };
        format!(
            "'{name}' is at points and in cells: the one {drawn} is drawn; '{other}:{name}' is the other"
        )
    });
    Choice { index, note }
}

/// A vector by its name, or a component by the name that it has by custom.
fn choose_part(
    fields: &[(&str, Association)],
    wanted: &str,
    among: &[Association],
) -> Option<Choice> {
    let magnitude = magnitude_name(wanted);
    if let Some(index) = find(fields, among, |name| name == magnitude) {
        let note = Some(format!("'{wanted}' is a vector: its magnitude is drawn"));
        return Some(Choice { index, note });
    }
    let (array, suffix) = wanted.rsplit_once(['-', '_', ':', '.'])?;
    among.iter().find_map(|association| {
        let component = |c: usize| {
            let name = format!("{array}-{c}");
            find(fields, &[*association], |n| n == name)
        };
        let count = (0..MOST_COMPONENTS)
            .take_while(|&c| component(c).is_some())
            .count();
        let (guess, order) = GUESSES.iter().find_map(|(names, order)| {
            let is_it = |name: &&str| suffix.eq_ignore_ascii_case(name);
            let at = names.iter().position(is_it)?;
            (names.len() == count).then_some((at, order))
        })?;
        let index = component(guess)?;
        let note = format!(
            "'{wanted}' is taken for '{}': the file does not name the components of '{array}', and the order {order} is a guess",
            fields[index].0
        );
        Some(Choice {
            index,
            note: Some(note),
        })
    })
}

/// Whether a range is more than the rounding of equal numbers, a few units of the last place.
pub(crate) fn is_wide(range: Option<(f64, f64)>) -> bool {
    range.is_some_and(|(low, high)| high - low > 8.0 * f64::EPSILON * low.abs().max(high.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn array(name: &str, components: usize, names: &[&str]) -> Array {
        Array {
            name: name.into(),
            association: Association::Point,
            components,
            component_names: names.iter().map(|n| Some(n.to_string())).collect(),
            tuples: 0,
            numbers: Arc::new(Loaded(Vec::new())),
            active: false,
            colors: false,
        }
    }

    fn names(array: &Array) -> Vec<String> {
        array.parts().into_iter().map(|(name, _)| name).collect()
    }

    #[test]
    fn components_have_the_names_of_the_file_or_numbers() {
        assert_eq!(names(&array("p", 1, &["only"])), ["p"]);
        assert_eq!(
            names(&array("v", 3, &[])),
            ["v-magnitude", "v-0", "v-1", "v-2"]
        );
        assert_eq!(
            names(&array("s", 6, &["XX", "YY", "ZZ", "YZ", "XZ", "XY"])),
            ["s-XX", "s-YY", "s-ZZ", "s-YZ", "s-XZ", "s-XY"]
        );
        // One name twice, one missing: numbers there.
        assert_eq!(
            names(&array("w", 4, &["a", "a", ""])),
            ["w-a", "w-1", "w-2", "w-3"]
        );
        assert_eq!(Part::Magnitude.of(&[1.0, 2.0, 2.0]), 3.0);
        assert_eq!(Part::Component(1).of(&[1.0, 2.0, 2.0]), 2.0);
    }

    use Association::{Cell, Point};

    const FIELDS: [(&str, Association); 14] = [
        ("k", Point),
        ("T", Point),
        ("T", Cell),
        ("U-magnitude", Point),
        ("U-0", Point),
        ("U-1", Point),
        ("U-2", Point),
        ("s-XX", Cell),
        ("s-XY", Cell),
        ("cell:odd", Point),
        ("odd", Cell),
        ("RGBA-0", Cell),
        ("RGBA-1", Cell),
        ("GlobalNodeId", Point),
    ];

    fn chosen(wanted: &str) -> Option<(usize, bool)> {
        let choice = choose(&FIELDS, Some(wanted), |_| unreachable!("not asked"))?;
        Some((choice.index, choice.note.is_some()))
    }

    #[test]
    fn a_name_at_points_and_in_cells_can_be_told_apart() {
        assert_eq!(chosen("T"), Some((1, true)));
        for name in ["T (cell)", "cell:T"] {
            assert_eq!(chosen(name), Some((2, false)), "{name}");
        }
        for name in ["T (point)", "point:T"] {
            assert_eq!(chosen(name), Some((1, false)), "{name}");
        }
        assert_eq!(chosen("k"), Some((0, false)));
        assert_eq!(chosen("cell:k"), None);
        // A name that looks like a choice is still a name.
        assert_eq!(chosen("cell:odd"), Some((9, false)));
        assert_eq!(chosen("odd (cell)"), Some((10, false)));
    }

    #[test]
    fn a_vector_is_its_magnitude_and_guesses_are_noted() {
        assert_eq!(chosen("U"), Some((3, true)));
        assert_eq!(chosen("point:U"), Some((3, true)));
        assert_eq!(chosen("cell:U"), None);
        assert_eq!(chosen("U-y"), Some((5, true)));
        assert_eq!(chosen("U-blue"), Some((6, true)));
        assert_eq!(chosen("U-2"), Some((6, false)));
        assert_eq!(chosen("U-w"), None);
        // The file names the components, so that nothing is to be guessed.
        assert_eq!(chosen("s-xy"), None);
        assert_eq!(chosen("s-XY"), Some((8, false)));
        // Two components are not a color.
        assert_eq!(chosen("RGBA-red"), None);
        assert_eq!(chosen("U-"), None);
    }

    #[test]
    fn the_default_varies_and_is_no_mark() {
        let fields = [
            ("PointId", Point),
            ("k", Point),
            ("vtkValidPointMask", Point),
            ("rho", Cell),
        ];
        let choice = choose(&fields, None, |i| i != 1).expect("there are fields");
        assert_eq!(choice.index, 3);
        assert!(choice.note.is_some_and(|note| note.contains("'k'")));
        // Only what nobody asks for varies.
        let choice = choose(&fields, None, |i| i == 0).expect("there are fields");
        assert_eq!(choice.index, 0);
        // Nothing varies.
        let choice = choose(&fields, None, |_| false).expect("there are fields");
        assert_eq!(
            choice,
            Choice {
                index: 1,
                note: None
            }
        );
        assert_eq!(choose(&[], None, |_| true), None);
    }

    #[test]
    fn identifiers_are_words_of_their_own() {
        for name in [
            "id",
            "IDS",
            "my id",
            "node_id",
            "GlobalNodeId",
            "PointIds",
            "part7id",
            "é id",
        ] {
            assert!(is_helper(name), "{name}");
        }
        for name in ["fluid", "Solid", "VOID", "grid", "identity", "", "i"] {
            assert!(!is_helper(name), "{name}");
        }
    }

    #[test]
    fn rounding_is_no_variation() {
        assert!(!is_wide(None));
        assert!(!is_wide(Some((3.0, 3.0))));
        assert!(!is_wide(Some((0.3, 0.1 + 0.2))));
        assert!(is_wide(Some((1.6e9, 1.6e9 + 1.0))));
        assert!(is_wide(Some((0.0, 1e-300))));
    }
}
