//! Cells, points and attributes of grids.

use std::collections::HashSet;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, glam};

use super::document::Id;
use super::grids::Grid;
use super::item::Item;
use super::items::{Items, numbers};
use super::shapes;
use crate::MeshData;
use crate::fields::{MOST_COMPONENTS, Together};
use crate::grid::GridData;
use crate::grid::header::clip;
use crate::grid::payload::{UNPACK, most_unpacked};
use crate::pieces::sections::{
    Coordinates, Layout, Section, Topology, Zone, ZoneArray, lattice_counts,
};
use crate::pieces::{Budget, Fields, join};
use crate::read::FileData;
use crate::vtu::structured::{MOST_POINTS, even_steps, note_of_steps};
use crate::vtu::{Box3, Image, ImageArray, ImageFields};

/// Attributes of all grids.
const MOST_ATTRIBUTES: usize = 1 << 20;

/// How the points of a lattice lie.
#[derive(Clone, Copy, PartialEq)]
enum Lattice {
    Even,
    Axes,
    Free,
}

enum Cells {
    Listed(Layout),
    /// With so many points along each axis.
    Lattice(Lattice, [u64; 3]),
    /// They have no volume.
    Flat,
}

/// An attribute of a grid.
struct Attribute {
    name: String,
    association: Association,
    item: Item,
    components: u64,
    component_names: Vec<Option<String>>,
    active: bool,
}

/// Reads the mesh that grids make, or the one regular grid.
pub(super) fn read(items: Items, grids: Vec<Grid>, notes: Vec<String>) -> Result<FileData, Error> {
    let document = items.document;
    let mut data = MeshData {
        notes,
        ..MeshData::default()
    };
    let mut zones = Vec::new();
    let (mut images, mut attributes, mut bytes) = (Vec::new(), 0, 0_u64);
    let is_alone = grids.len() == 1;
    for grid in &grids {
        let cells = cells(&items, grid)?;
        let place = match &cells {
            Cells::Flat => None,
            Cells::Listed(_) => points(&items, grid)?,
            Cells::Lattice(Lattice::Free, _) => points(&items, grid)?,
            Cells::Lattice(_, points) => Some(axes(&items, grid, *points)?),
        };
        let Some(Place {
            coordinates,
            points,
            epsilon,
            bytes: of_points,
        }) = place
        else {
            let note = format!("'{}' left out: it has no cells with a volume", grid.name);
            data.notes.push(note);
            continue;
        };
        bytes = bytes.saturating_add(of_points);
        let (topology, cells, of_cells) = topology(&items, grid, &cells, points)?;
        bytes = bytes.saturating_add(of_cells);
        let all = found_attributes(&items, grid, (points, cells), &mut data)?;
        attributes += all.len();
        if attributes > MOST_ATTRIBUTES {
            return Err(document.error(
                grid.id,
                format!("more than {MOST_ATTRIBUTES} attributes are not read"),
            ));
        }
        for attribute in &all {
            bytes = bytes.saturating_add(attribute.item.bytes());
        }
        let length = items.length();
        if bytes > most_unpacked(length) {
            let what = format!("{bytes} bytes are packed in {length}, which is refused");
            return Err(document
                .source
                .error_with_help("its data items", what, UNPACK));
        }
        let mut zone = Zone {
            path: document.source.path.clone(),
            name: grid.name.clone(),
            points,
            cells,
            coordinates,
            topology,
            arrays: [Vec::new(), Vec::new()],
        };
        if is_alone && let Some(image) = image(&zone, epsilon) {
            images.push((image, all));
            continue;
        }
        for attribute in all {
            zone.arrays_mut(attribute.association).push(ZoneArray {
                name: attribute.name,
                components: attribute.components,
                component_names: attribute.component_names,
                numbers: Arc::new(attribute.item),
                active: attribute.active,
            });
        }
        zones.push(zone);
    }
    let source = document.source.clone();
    let (length, files) = (items.length(), items.files());
    if let Some(((image, note), attributes)) = images.pop() {
        let mut grid = samples(&source, &image, attributes, data.notes)?;
        grid.notes.extend(note);
        grid.files = files;
        return Ok(FileData::Grid(grid));
    }
    if zones.is_empty() {
        return Err(source.error("the grids", "none has cells with a volume"));
    }
    let implied = zones
        .iter()
        .any(|zone| matches!(zone.coordinates, Coordinates::Axes(_)));
    let budget = Budget::new(source.path.clone(), length, implied);
    let mut mesh = join(&budget, zones, Fields::All, data)?;
    mesh.files = files;
    Ok(FileData::Mesh(mesh))
}

fn cells(items: &Items, grid: &Grid) -> Result<Cells, Error> {
    let (document, id) = (items.document, grid.topology);
    let kind = document
        .attribute(id, &["topologytype", "type"])
        .unwrap_or_default();
    let kind = kind.to_ascii_lowercase();
    let lattice = match kind.as_str() {
        "3dcorectmesh" => Lattice::Even,
        "3drectmesh" => Lattice::Axes,
        "3dsmesh" => Lattice::Free,
        "mixed" => return Ok(Cells::Listed(Layout::Mixed(shapes::coded))),
        kind => {
            let shape = shapes::named(&clip(kind)).map_err(|what| document.error(id, what))?;
            return Ok(shape.map_or(Cells::Flat, |shape| Cells::Listed(Layout::Same(shape))));
        }
    };
    let words = document
        .attribute(id, &["dimensions", "numberofelements"])
        .unwrap_or_default();
    match numbers(words).as_deref() {
        Some(&[k, j, i]) if lattice_counts([i, j, k]).is_some() => {
            Ok(Cells::Lattice(lattice, [i, j, k]))
        }
        _ => Err(document.error(
            id,
            format!(
                "Dimensions are '{}', not three numbers of 2 and more points",
                clip(words)
            ),
        )),
    }
}

/// Points of a grid.
struct Place {
    coordinates: Coordinates,
    points: u64,
    /// Relative rounding of the coordinates' type.
    epsilon: f64,
    /// How many bytes they take in the files.
    bytes: u64,
}

fn geometry_type(items: &Items, grid: &Grid, natural: &str) -> String {
    let kind = items
        .document
        .attribute(grid.geometry, &["geometrytype", "type"]);
    kind.unwrap_or(natural).to_ascii_uppercase()
}

/// The points of a grid, each with its own place; `None` for those in a plane.
fn points(items: &Items, grid: &Grid) -> Result<Option<Place>, Error> {
    let id = grid.geometry;
    let list = items.of(id)?;
    let kind = geometry_type(items, grid, "XYZ");
    let wrong = |what: String| items.document.error(id, what);
    let numbers: u64 = list.iter().map(Item::count).fold(0, u64::saturating_add);
    let (coordinates, epsilon): (Coordinates, f64) = match (kind.as_str(), &list[..]) {
        ("XY" | "X_Y", _) => return Ok(None),
        ("XYZ", [item]) if numbers.is_multiple_of(3) => {
            (Coordinates::Each(Arc::new(item.clone())), item.epsilon())
        }
        ("X_Y_Z", [x, y, z]) if x.count() == y.count() && x.count() == z.count() => {
            let axes = [x, y, z].map(|item| Arc::new(item.clone()) as _);
            (
                Coordinates::Each(Arc::new(Together(axes.into()))),
                x.epsilon(),
            )
        }
        ("XYZ" | "X_Y_Z", _) => {
            return Err(wrong(format!(
                "{numbers} numbers in {} data items are not x, y and z of points",
                list.len()
            )));
        }
        (kind, _) => {
            return Err(wrong(format!(
                "a geometry of the type {} is not read here",
                clip(kind)
            )));
        }
    };
    Ok(Some(Place {
        coordinates,
        points: numbers / 3,
        epsilon,
        bytes: numbers.saturating_mul(8),
    }))
}

/// The coordinates along each axis of a lattice of so many points.
fn axes(items: &Items, grid: &Grid, points: [u64; 3]) -> Result<Place, Error> {
    let id = grid.geometry;
    let list = items.of(id)?;
    let kind = geometry_type(items, grid, "ORIGIN_DXDYDZ");
    let wrong = |what: String| items.document.error(id, what);
    if points.iter().any(|&points| points > MOST_POINTS) {
        return Err(wrong(format!(
            "{points:?} points along the axes are not read"
        )));
    }
    let (axes, epsilon) = match (kind.as_str(), &list[..]) {
        ("VXVYVZ", [x, y, z]) => {
            let axis = |item: &Item, axis: usize| {
                let numbers = item.floats(MOST_POINTS)?;
                match numbers.len() as u64 == points[axis] {
                    true => Ok(numbers),
                    false => Err(item.error(format!(
                        "{} numbers of {} points",
                        numbers.len(),
                        points[axis]
                    ))),
                }
            };
            ([axis(x, 0)?, axis(y, 1)?, axis(z, 2)?], x.epsilon())
        }
        ("ORIGIN_DXDYDZ", [origin, spacing]) => {
            // Both along z, y and x.
            let (origin, spacing) = (origin.floats(3)?, spacing.floats(3)?);
            let (&[z, y, x], &[dz, dy, dx]) = (&origin[..], &spacing[..]) else {
                return Err(wrong("origin and spacing need three numbers each".into()));
            };
            let axis = |first: f64, step: f64, points: u64| {
                (0..points).map(|i| first + i as f64 * step).collect()
            };
            (
                [
                    axis(x, dx, points[0]),
                    axis(y, dy, points[1]),
                    axis(z, dz, points[2]),
                ],
                f64::EPSILON,
            )
        }
        (kind, list) => {
            let what = format!(
                "a geometry of the type {} with {} data items is not read here",
                clip(kind),
                list.len()
            );
            return Err(wrong(what));
        }
    };
    let (points, _) = lattice_counts(points).expect("`cells` has counted");
    Ok(Place {
        coordinates: Coordinates::Axes(axes),
        points,
        epsilon,
        bytes: 0,
    })
}

/// The cells of a grid of so many points, how many they are, and how many bytes they take.
fn topology(
    items: &Items,
    grid: &Grid,
    cells: &Cells,
    points: u64,
) -> Result<(Topology, u64, u64), Error> {
    let id = grid.topology;
    let layout = match cells {
        Cells::Listed(layout) => *layout,
        Cells::Lattice(_, dimensions) => {
            let (needed, cells) = lattice_counts(*dimensions).expect("`cells` has counted");
            if points != needed {
                let what = format!("{points} points where {needed} are needed");
                return Err(items.document.error(grid.geometry, what));
            }
            return Ok((Topology::Lattice(*dimensions), cells, 0));
        }
        Cells::Flat => return Ok((Topology::Sections(Vec::new()), 0, 0)),
    };
    let [item] = &items.of(id)?[..] else {
        return Err(items
            .document
            .error(id, "a topology of cells needs one data item"));
    };
    let first = items.document.attribute(id, &["baseoffset"]);
    let first = first.and_then(|word| word.parse().ok()).unwrap_or(0);
    let section = Section {
        path: items.document.source.path.clone(),
        at: format!("the topology of '{}'", grid.name),
        indices: Arc::new(item.clone()),
        layout,
        first,
    };
    let cells = section.cells()?;
    Ok((Topology::Sections(vec![section]), cells, item.bytes()))
}

/// The attributes of a grid of so many points and cells that can be drawn, each name once.
fn found_attributes(
    items: &Items,
    grid: &Grid,
    (points, cells): (u64, u64),
    data: &mut MeshData,
) -> Result<Vec<Attribute>, Error> {
    let document = items.document;
    let (mut found, mut known) = (Vec::new(), HashSet::new());
    for &id in &grid.attributes {
        let name = document
            .attribute(id, &["name"])
            .unwrap_or_default()
            .to_owned();
        let center = document.attribute(id, &["center"]).unwrap_or("Node");
        let association = match center.to_ascii_lowercase().as_str() {
            "node" => Some(Association::Point),
            "cell" => Some(Association::Cell),
            _ => None,
        };
        let why = match association {
            None => format!("it is at each {}, not at points or in cells", clip(center)),
            Some(association) => {
                let tuples = match association {
                    Association::Point => points,
                    Association::Cell => cells,
                };
                // A grid of the mesh alone and those of the functions may have the same.
                if !known.insert((name.clone(), association == Association::Cell)) {
                    continue;
                }
                match attribute(items, id, tuples)? {
                    Ok((item, components)) => {
                        let kind = document.attribute(id, &["attributetype", "type"]);
                        found.push(Attribute {
                            component_names: component_names(kind.unwrap_or_default(), components),
                            name,
                            association,
                            item,
                            components,
                            active: document.attribute(id, &["active"]) == Some("1"),
                        });
                        continue;
                    }
                    Err(why) => why,
                }
            }
        };
        data.notes
            .push(format!("attribute '{}' left out: {why}", clip(&name)));
        data.left_out.push((name, why));
    }
    Ok(found)
}

/// The numbers of an attribute with so many tuples, and how many components it has; or why it
/// cannot be drawn.
fn attribute(items: &Items, id: Id, tuples: u64) -> Result<Result<(Item, u64), String>, Error> {
    let kind = items
        .document
        .attribute(id, &["itemtype"])
        .unwrap_or_default();
    if kind.eq_ignore_ascii_case("FiniteElementFunction") {
        return Ok(Err(
            "it is a function of finite elements, not values at points or in cells".into(),
        ));
    }
    let list = items.of(id)?;
    let [item] = &list[..] else {
        return Err(items
            .document
            .error(id, format!("{} data items where one is needed", list.len())));
    };
    let count = item.count();
    if tuples == 0 || !count.is_multiple_of(tuples) || count == 0 {
        return Err(item.error(format!("{count} numbers for {tuples} points or cells")));
    }
    let components = count / tuples;
    if components > MOST_COMPONENTS as u64 {
        return Ok(Err(format!(
            "it has {components} components; 1 to {MOST_COMPONENTS} are read"
        )));
    }
    Ok(Ok((item.clone(), components)))
}

/// The components of symmetric tensors, which XDMF has in this order.
fn component_names(kind: &str, components: u64) -> Vec<Option<String>> {
    let names = ["XX", "XY", "XZ", "YY", "YZ", "ZZ"];
    match kind.eq_ignore_ascii_case("Tensor6") && components == 6 {
        true => names.map(|name| Some(name.to_owned())).into(),
        false => Vec::new(),
    }
}

/// The image that a lattice is, and what is to be said of it, if its axes are evenly spaced.
fn image(zone: &Zone, epsilon: f64) -> Option<(Image, Option<String>)> {
    let (Coordinates::Axes(axes), Topology::Lattice(points)) = (&zone.coordinates, &zone.topology)
    else {
        return None;
    };
    let (mut origin, mut spacing, mut worst) = ([0.0; 3], [0.0; 3], 0.0_f64);
    for (axis, coordinates) in axes.iter().enumerate() {
        let (first, step, off) = even_steps(coordinates, epsilon)?;
        (origin[axis], spacing[axis], worst) = (first, step, worst.max(off));
    }
    let [i, j, k] = points.map(|points| points as i64 - 1); // counted
    let image = Image {
        extent: [0, i, 0, j, 0, k],
        origin: DVec3::from_array(origin),
        spacing: DVec3::from_array(spacing),
        direction: DMat3::IDENTITY,
    };
    Some((
        image,
        (epsilon != f64::EPSILON || worst > 0.0).then(|| note_of_steps(worst)),
    ))
}

/// The samples of a regular grid.
fn samples(
    source: &crate::source::Source,
    image: &Image,
    attributes: Vec<Attribute>,
    notes: Vec<String>,
) -> Result<GridData, Error> {
    let mut fields = ImageFields::new(notes);
    for association in [Association::Point, Association::Cell] {
        let of_it = attributes.iter().filter(|a| a.association == association);
        let of_it: Vec<_> = of_it.collect();
        if of_it.is_empty() {
            continue;
        }
        let whole = Box3::of(&image.extent, association);
        let whole = whole.ok_or_else(|| source.error("the grid", "it is empty"))?;
        let lattice = fields.lattice(image, &whole, association);
        let lattice = lattice.map_err(|error| source.error("the grid", error.to_string()))?;
        let Some(lattice) = lattice else { continue };
        for attribute in of_it {
            let array = ImageArray {
                name: attribute.name.clone(),
                components: attribute.components as usize, // at most 64
                active: attribute.active,
                kind: attribute.item.number,
                numbers: attribute.item.numbers()?,
            };
            fields.add(array, lattice, association);
        }
    }
    let data = fields.finish();
    data.ok_or_else(|| source.error("the grid", "it has no attribute of numbers"))
}
