//! `FlowSolution_t`: fields at vertices and in cells.

use std::sync::Arc;

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use super::node::Node;
use crate::MeshData;
use crate::fields::{Numbers, Together, vectors};
use crate::hdf5::View;
use crate::pieces::sections::{Zone, ZoneArray};

/// The fields of a solution go to `zone`. Returns how many bytes they take.
pub(super) fn add(
    solution: &Node,
    zone: &mut Zone,
    nodes: &mut u64,
    data: &mut MeshData,
) -> Result<u64, Error> {
    let place = match solution.child("GridLocation_t")? {
        Some(node) => node.text()?,
        None => "Vertex".into(),
    };
    let (association, tuples) = match place.as_str() {
        "Vertex" => (Association::Point, zone.points),
        "CellCenter" => (Association::Cell, zone.cells),
        place => {
            let place: String = place.chars().take(40).collect();
            let (solution, zone) = (&solution.name, &zone.name);
            let note = format!("'{solution}' of '{zone}' left out: it is at each {place}");
            data.notes.push(note);
            return Ok(0);
        }
    };
    let rind = match solution.named("Rind")? {
        Some(node) => node.numbers(6)?.unwrap_or_default(),
        None => Vec::new(),
    };
    let has_rind = rind.iter().any(|&planes| planes != 0.0);
    let mut bytes = 0_u64;
    let mut names = Vec::new();
    for field in solution.children("DataArray_t")? {
        *nodes += 1;
        let view = field.view()?;
        let count = view.count();
        if has_rind || count != tuples {
            let (name, solution) = (&field.name, &solution.name);
            let why = match has_rind {
                true => "it has values beyond the zone (Rind)".to_owned(),
                false => format!("it has {count} values where {tuples} are needed"),
            };
            data.notes.push(format!(
                "'{name}' of '{solution}' of '{}' left out: {why}",
                zone.name
            ));
            data.left_out.push((field.name, why));
            continue;
        }
        bytes = bytes.saturating_add(view.bytes());
        names.push((field.name, view));
    }
    // Two solutions may have the same field.
    let known = zone.arrays_mut(association);
    names.retain(|(name, _)| known.iter().all(|array| array.name != *name));
    for (name, views) in vectors(&names) {
        known.push(array(name, views));
    }
    Ok(bytes)
}

fn array(name: String, views: Vec<View>) -> ZoneArray {
    let components = views.len();
    let mut views = views
        .into_iter()
        .map(|view| Arc::new(view) as Arc<dyn Numbers>);
    let (numbers, component_names): (Arc<dyn Numbers>, _) = match components {
        1 => (views.next().expect("it has one"), Vec::new()),
        _ => {
            let names = ["x", "y", "z"].map(|name| Some(name.to_owned()));
            (Arc::new(Together(views.collect())), names.into())
        }
    };
    ZoneArray {
        name,
        components: components as u64,
        component_names,
        numbers,
        active: false,
    }
}
