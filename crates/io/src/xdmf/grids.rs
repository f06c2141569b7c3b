//! The grids of a file at a time step.

use std::collections::HashMap;

use tetrascope_core::{Error, number};

use super::document::Id;
use super::items::Items;
use super::{MOST_GRIDS, MOST_TIMES};
use crate::grid::header::clip;

/// Cells, points and the attributes of all grids that have these.
pub(super) struct Grid {
    pub(super) name: String,
    pub(super) topology: Id,
    pub(super) geometry: Id,
    pub(super) attributes: Vec<Id>,
    /// Its element.
    pub(super) id: Id,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Uniform,
    Temporal,
    /// A collection in space, or a tree.
    Several,
}

fn kind(items: &Items, id: Id) -> Result<Kind, Error> {
    let document = items.document;
    let kind = document
        .attribute(id, &["gridtype", "type"])
        .unwrap_or("Uniform");
    let collection = document
        .attribute(id, &["collectiontype"])
        .unwrap_or("Spatial");
    match kind.to_ascii_lowercase().as_str() {
        "uniform" => Ok(Kind::Uniform),
        "collection" if collection.eq_ignore_ascii_case("Temporal") => Ok(Kind::Temporal),
        "collection" | "tree" => Ok(Kind::Several),
        _ => Err(document.error(id, format!("a grid of the type {} is not read", clip(kind)))),
    }
}

fn grids_in(items: &Items, id: Id) -> Vec<Id> {
    let children = items.document.own(id).iter().copied();
    children
        .filter(|&id| items.document.name(id) == "Grid")
        .collect()
}

fn domains(items: &Items) -> impl Iterator<Item = Id> {
    let document = items.document;
    let children = document.own(document.root()).iter().copied();
    children.filter(|&id| document.name(id) == "Domain")
}

/// The first domain.
fn domain(items: &Items) -> Result<Id, Error> {
    let document = items.document;
    let found = domains(items).next();
    found.ok_or_else(|| document.error(document.root(), "there is no <Domain>"))
}

/// The times of the first collection in time; none if there is no such collection.
pub(super) fn temporal(items: &Items) -> Result<Vec<f64>, Error> {
    let mut waiting = grids_in(items, domain(items)?);
    waiting.reverse();
    while let Some(id) = waiting.pop() {
        match kind(items, id)? {
            Kind::Temporal => return times(items, id),
            Kind::Several => waiting.extend(grids_in(items, id).into_iter().rev()),
            Kind::Uniform => {}
        }
    }
    Ok(Vec::new())
}

/// The times of the grids of a collection; their numbers where the file does not say them.
fn times(items: &Items, id: Id) -> Result<Vec<f64>, Error> {
    let document = items.document;
    let grids = grids_in(items, id);
    let time_of = |id: Id| {
        let mut children = document.own(id).iter().copied();
        children.find(|&id| document.name(id) == "Time")
    };
    if let Some(time) = time_of(id) {
        let kind = document
            .attribute(time, &["timetype", "type"])
            .unwrap_or_default();
        let numbers = match &items.of(time)?[..] {
            [item] => item.floats(MOST_TIMES)?,
            _ => Vec::new(),
        };
        let times = match (kind.to_ascii_lowercase().as_str(), &numbers[..]) {
            ("list", _) => numbers,
            ("hyperslab", &[start, stride, _]) => {
                let times = (0..grids.len()).map(|i| start + i as f64 * stride);
                times.collect()
            }
            _ => Vec::new(),
        };
        if times.len() == grids.len() {
            return Ok(times);
        }
        if !times.is_empty() {
            let what = format!("there are {} times of {} grids", times.len(), grids.len());
            return Err(document.error(time, what));
        }
    }
    let times = grids.iter().enumerate().map(|(number, &grid)| {
        let Some(time) = time_of(grid) else {
            return Ok(number as f64);
        };
        let value = document.attribute(time, &["value"]).unwrap_or_default();
        let value = value.parse::<f64>().ok().filter(|value| value.is_finite());
        value.ok_or_else(|| document.error(time, "its Value is not a number"))
    });
    times.collect()
}

/// The grids of time step `step`. Collections in time with other times than `times`, and domains but the first, are
/// left out, with a note.
pub(super) fn find(
    items: &Items,
    step: usize,
    times_read: &[f64],
    notes: &mut Vec<String>,
) -> Result<Vec<Grid>, Error> {
    let document = items.document;
    let domain = domain(items)?;
    let later = domains(items).skip(1);
    let later = later.filter(|&domain| !grids_in(items, domain).is_empty());
    match later.count() as u64 {
        0 => {}
        later => notes.push(format!(
            "the first <Domain> is read, and {} with grids left out",
            number::count(later, "other", "others")
        )),
    }
    let mut waiting = grids_in(items, domain);
    waiting.reverse();
    let mut known: HashMap<String, usize> = HashMap::new();
    let mut found: Vec<Grid> = Vec::new();
    while let Some(id) = waiting.pop() {
        match kind(items, id)? {
            Kind::Several => waiting.extend(grids_in(items, id).into_iter().rev()),
            Kind::Temporal => {
                if times(items, id)? != times_read {
                    let name = clip(document.attribute(id, &["name"]).unwrap_or_default());
                    notes.push(format!("'{name}' left out: its time steps are others"));
                } else {
                    waiting.extend(grids_in(items, id).get(step));
                }
            }
            Kind::Uniform => add(items, id, &mut known, &mut found)?,
        }
        if found.len() > MOST_GRIDS {
            return Err(document.error(id, format!("more than {MOST_GRIDS} grids are not read")));
        }
    }
    match found.is_empty() {
        true => Err(document.error(domain, "the file has no <Grid>")),
        false => Ok(found),
    }
}

/// Adds a grid, or its attributes to those of one with the same cells and points.
fn add(
    items: &Items,
    id: Id,
    known: &mut HashMap<String, usize>,
    found: &mut Vec<Grid>,
) -> Result<(), Error> {
    let document = items.document;
    let one = |name: &str| match document.named(id, name)?[..] {
        [one] => Ok(one),
        ref all => {
            let what = format!("the grid has {} <{name}> where one is needed", all.len());
            Err(document.error(id, what))
        }
    };
    let (topology, geometry) = (one("Topology")?, one("Geometry")?);
    let attributes = document.named(id, "Attribute")?;
    let key = format!(
        "{}\n{}",
        signature(items, topology)?,
        signature(items, geometry)?
    );
    match known.get(&key) {
        Some(&grid) => found[grid].attributes.extend(attributes),
        None => {
            known.insert(key, found.len());
            let name = document
                .attribute(id, &["name"])
                .filter(|name| !name.is_empty());
            found.push(Grid {
                name: clip(name.unwrap_or("grid")),
                topology,
                geometry,
                attributes,
                id,
            });
        }
    }
    Ok(())
}

/// The same for elements that are the same, or have the same numbers of other files.
fn signature(items: &Items, id: Id) -> Result<String, Error> {
    let list = items.of(id)?;
    if list.is_empty() {
        return Ok(format!("{id:?}"));
    }
    let signatures: Vec<String> = list.into_iter().map(|item| item.signature).collect();
    Ok(signatures.join(", "))
}
