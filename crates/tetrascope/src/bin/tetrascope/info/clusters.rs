//! The contents of a mesh in clusters, as far as they are known without reading these.

use serde_json::json;
use tetrascope::core::clusters::MeshClusters;
use tetrascope::core::number;
use tetrascope::volumes::Loaded;

use crate::output::{Output, Stop};

pub(super) fn print(loaded: &Loaded, mesh: &MeshClusters, output: &Output) -> Result<(), Stop> {
    let clusters = mesh.source().clusters();
    let largest = clusters.iter().map(|c| c.cells).max().unwrap_or(0);
    let points: u64 = clusters.iter().map(|c| u64::from(c.points)).sum();
    let bounds = mesh.bounds();
    if output.json() {
        return output.json_result(&json!({
            "tetrahedra": mesh.cell_count(),
            "clusters": clusters.len(),
            "largest_cluster": largest,
            "points": points,
            "fields": loaded.fields,
            "field": loaded.field,
            "bounds": (!bounds.is_empty()).then_some([bounds.min, bounds.max]),
            "checksum": mesh.source().checksum().map(|sum| format!("{sum:08x}")),
            "notes": loaded.notes,
            "steps": [],
        }));
    }
    let mut lines = vec![
        format!("tetrahedra     {}", mesh.cell_count()),
        format!(
            "clusters       {}, of at most {largest} tetrahedra",
            clusters.len()
        ),
        format!("points         {points}, with those that clusters have in common in each"),
    ];
    lines.extend(super::fields(&loaded.fields));
    if !bounds.is_empty() {
        lines.push(format!("bounds         {}", number::bounds(&bounds)));
    }
    if let Some(checksum) = mesh.source().checksum() {
        lines.push(format!("checksum       {checksum:08x}"));
    }
    lines.extend(super::notes(&loaded.notes));
    output.lines(&lines)
}
