//! From a file's arrays to scalar fields.

use tetrascope_core::Scalars;
use tetrascope_core::mesh::Association;

/// The array in which VTK marks duplicate and hidden cells and points.
const GHOST_TYPE: &str = "vtkGhostType";

/// Its predecessor: 0 for a cell of one's own.
pub(crate) const GHOST_LEVELS: &str = "vtkGhostLevels";

/// A field with any number of components.
#[derive(Clone, Debug)]
pub(crate) struct Array {
    pub(crate) name: String,
    pub(crate) association: Association,
    pub(crate) components: usize,
    /// All components of the first tuple, then of the next.
    pub(crate) values: Vec<f64>,
    /// The file marks it as the one to draw.
    pub(crate) active: bool,
}

/// Takes out the arrays that mark ghosts.
pub(crate) fn take_ghosts(arrays: &mut Vec<Array>) -> Vec<Array> {
    let is_ghost =
        |a: &mut Array| a.components == 1 && [GHOST_TYPE, GHOST_LEVELS].contains(&a.name.as_str());
    arrays.extract_if(.., is_ghost).collect()
}

/// The fields to choose from: active scalars, other scalars, parts of vectors,
/// identifiers; in the order of the file within each kind.
pub(crate) fn to_scalars(arrays: Vec<Array>) -> Vec<Scalars> {
    let mut ranked = Vec::new();
    for array in arrays {
        let association = array.association;
        let scalars = |name: String, values: Vec<f64>| Scalars {
            name,
            association,
            values,
        };
        let n = array.components;
        if n == 1 {
            let rank = match () {
                () if array.active => 0,
                () if is_identifier(&array.name) => 3,
                () => 1,
            };
            ranked.push((rank, scalars(array.name, array.values)));
            continue;
        }
        let magnitude = |tuple: &[f64]| tuple.iter().map(|v| v * v).sum::<f64>().sqrt();
        if n == 2 || n == 3 {
            let values = array.values.chunks_exact(n).map(magnitude).collect();
            ranked.push((2, scalars(format!("{}-magnitude", array.name), values)));
        }
        for component in 0..n {
            let values = array.values.iter().skip(component).step_by(n);
            let name = format!("{}-{}", array.name, component_name(component, n));
            ranked.push((2, scalars(name, values.copied().collect())));
        }
    }
    ranked.sort_by_key(|&(rank, _)| rank); // stable
    ranked.into_iter().map(|(_, scalars)| scalars).collect()
}

/// "x", or VTK's names for the parts of tensors, or the number.
pub(crate) fn component_name(component: usize, components: usize) -> String {
    let names: &[&str] = match components {
        2 | 3 => &["x", "y", "z"],
        6 => &["xx", "yy", "zz", "xy", "yz", "xz"],
        9 => &["xx", "xy", "xz", "yx", "yy", "yz", "zx", "zy", "zz"],
        _ => &[],
    };
    match names.get(component) {
        Some(&name) => name.into(),
        None => component.to_string(),
    }
}

/// Numbers of points and cells, which nobody wants to look at unasked.
fn is_identifier(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.ends_with("id") || name.ends_with("ids") || name.starts_with("vtkoriginal")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_become_their_parts_after_the_scalars() {
        let array = |name: &str, components, values: &[f64], active| Array {
            name: name.into(),
            association: Association::Point,
            components,
            values: values.into(),
            active,
        };
        let fields = to_scalars(vec![
            array("GlobalNodeId", 1, &[1.0, 2.0], false),
            array("v", 3, &[1.0, 2.0, 2.0, 0.0, 3.0, 4.0], false),
            array("a", 1, &[5.0, 6.0], false),
            array("b", 1, &[7.0, 8.0], true),
        ]);
        let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).collect();
        assert_eq!(
            names,
            ["b", "a", "v-magnitude", "v-x", "v-y", "v-z", "GlobalNodeId"]
        );
        assert_eq!(fields[2].values, [3.0, 5.0]);
        assert_eq!(fields[4].values, [2.0, 3.0]);
    }
}
