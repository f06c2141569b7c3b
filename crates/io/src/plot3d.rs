//! Plot3D: curvilinear grids of NASA's flow solvers, a file of points and one of values.
//!
//! P. P. Walatka, P. G. Buning, L. Pierce and P. A. Elson, "PLOT3D User's
//! Manual", NASA TM-101067, 1990.
//!
//! `…xyz.bin` goes with `…q.bin`, and `.xyz`, `.x`, `.g`, `.grd` and `.p3d` with
//! `.q`. Each cell of the grid is a hexahedron; cells that touch a point with
//! IBLANK 0 are left out. Blocks become one mesh and keep their own points.
//!
//! Fields: Q1…Q5 as `density`, `momentum-x`, `-y`, `-z` and `energy` (stagnation
//! energy per volume), `momentum-magnitude`, and `velocity-*`. Where the density
//! varies and the energy is that of a gas, also `pressure`, `temperature` and
//! `mach` with γ = 1.4 and a gas constant of 1, as VTK's Plot3D reader does:
//! p = (γ − 1)(e − ρ|v|²/2), T = p/ρ, M = |v|/√(γ p/ρ).

mod layout;

use std::path::{Path, PathBuf};

use glam::DVec3;
use tetrascope_core::glam;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, Scalars};

use self::layout::{Dimensions, Kind, Layout, describe_blocks, points};
use crate::MeshData;
use crate::mesh_data::add_hexahedra;
use crate::read::check;
use crate::source::{Source, count};

/// Ratio of specific heats of air.
const GAMMA: f64 = 1.4;

/// Extensions of a grid file whose solution has the extension `.q`.
const GRID_EXTENSIONS: [&str; 6] = ["xyz", "x", "g", "grd", "grid", "p3d"];

/// Whether the name is that of a Plot3D file.
pub(crate) fn has_extension(extension: &str) -> bool {
    extension == "bin" || extension == "q" || GRID_EXTENSIONS.contains(&extension)
}

/// Reads a grid with its solution.
///
/// `path` may also be the solution's; the other file is then found by its name.
/// `solution` names it where it is not. A grid without solution has no fields.
///
/// # Errors
/// [`Error::Io`] and [`Error::Format`].
pub fn read(path: &Path, solution: Option<&Path>) -> Result<MeshData, Error> {
    let (grid_path, solution_path) = match (solution, grid_of(path)) {
        (Some(solution), _) => (path.to_owned(), Some(solution.to_owned())),
        (None, Some(grid)) => (grid, Some(path.to_owned())),
        (None, None) => (
            path.to_owned(),
            candidates(path).into_iter().find(|p| p.is_file()),
        ),
    };
    let grid = Source::open(&grid_path)?;
    let solution = solution_path.as_deref().map(Source::open).transpose()?;
    let mut data = read_sources(&grid, solution.as_ref())?;
    data.files = [Some(grid_path), solution_path]
        .into_iter()
        .flatten()
        .collect();
    Ok(data)
}

/// Reads a grid and its solution from memory.
fn read_sources(grid: &Source, solution: Option<&Source>) -> Result<MeshData, Error> {
    let (mut data, dimensions) = read_grid(grid)?;
    match solution {
        Some(solution) => read_solution(solution, &dimensions, &mut data)?,
        None => {
            let tried: Vec<String> = candidates(&grid.path)
                .iter()
                .filter_map(|p| Some(p.file_name()?.to_string_lossy().into_owned()))
                .collect();
            data.notes.push(if tried.is_empty() {
                "no solution file: its name cannot be guessed from the grid's".into()
            } else {
                format!(
                    "no solution file: there is no {} beside the grid",
                    tried.join(" or ")
                )
            });
        }
    }
    check(&grid.path, &data)?;
    Ok(data)
}

/// Points and hexahedra.
fn read_grid(source: &Source) -> Result<(MeshData, Vec<Dimensions>), Error> {
    let layout = Layout::detect(source, Kind::Grid)?;
    if !layout.is_exact(source)
        && (extension(&source.path) == "q"
            || Layout::detect(source, Kind::Solution).is_ok_and(|l| l.is_exact(source)))
    {
        return Err(source.error_with_help(
            "byte 0",
            "this is a Plot3D solution, and its grid was not found by name",
            "give the grid's file first and this one with --solution FILE",
        ));
    }
    let dimensions: Vec<Dimensions> = layout.blocks.iter().map(|b| b.dimensions).collect();
    let mut data = MeshData {
        notes: vec![format!(
            "Plot3D grid of {}: {}{}",
            describe_blocks(&dimensions),
            layout.encoding.describe(),
            trailing(source, &layout)
        )],
        ..MeshData::default()
    };
    data.cells.offsets.push(0);
    let mut keep = Vec::new();
    let mut flat_blocks = 0;
    for block in &layout.blocks {
        let n = points(block.dimensions) as usize;
        let base = data.points.len() as u64;
        let coordinates = layout.encoding.floats(source, block.values, 3 * n);
        data.points.extend(
            (0..n).map(|p| DVec3::new(coordinates[p], coordinates[n + p], coordinates[2 * n + p])),
        );
        if block.dimensions.contains(&1) {
            flat_blocks += 1;
            continue;
        }
        let first = data.cells.types.len();
        add_hexahedra(&mut data.cells, block.dimensions.map(u64::from), base);
        if let Some(offset) = block.blanks {
            let blank = |point: u64| {
                let at = offset + 4 * (point - base) as usize;
                layout.encoding.endian.i32(&source.bytes[at..at + 4]) == 0
            };
            keep.extend(
                data.cells.connectivity[8 * first..]
                    .chunks_exact(8)
                    .map(|hexahedron| !hexahedron.iter().any(|&p| blank(p))),
            );
        } else {
            keep.resize(data.cells.types.len(), true);
        }
    }
    if data.cells.types.is_empty() {
        return Err(source.error_with_help(
            "byte 0",
            format!(
                "the grid ({}) has no cells: it is a surface or a line",
                describe_blocks(&dimensions)
            ),
            "volume rendering needs at least 2 points along i, j and k",
        ));
    }
    if flat_blocks > 0 {
        data.notes.push(format!(
            "{} without volume left out",
            count(flat_blocks, "block")
        ));
    }
    data.retain_cells(&keep, "they touch a point that IBLANK blanks out");
    if data.cells.types.is_empty() {
        return Err(source.error("IBLANK", "every cell of the grid is blanked out"));
    }
    Ok((data, dimensions))
}

/// The fields on a grid of those dimensions.
fn read_solution(
    source: &Source,
    grid_dimensions: &[Dimensions],
    data: &mut MeshData,
) -> Result<(), Error> {
    let layout = Layout::detect(source, Kind::Solution)?;
    let dimensions: Vec<Dimensions> = layout.blocks.iter().map(|b| b.dimensions).collect();
    if dimensions != grid_dimensions {
        return Err(source.error_with_help(
            "byte 0",
            format!(
                "the solution has {}, but the grid has {}",
                describe_blocks(&dimensions),
                describe_blocks(grid_dimensions)
            ),
            "give the solution that belongs to this grid with --solution FILE",
        ));
    }
    let conditions = layout
        .encoding
        .floats(source, layout.blocks[0].conditions, 4);
    let name = source
        .path
        .file_name()
        .unwrap_or_default()
        .to_string_lossy();
    data.notes.push(format!(
        "Plot3D solution {name}: {}{}; Mach number {}, angle of attack {}, Reynolds number {}, time {}",
        layout.encoding.describe(),
        trailing(source, &layout),
        conditions[0],
        conditions[1],
        conditions[2],
        conditions[3]
    ));
    let mut q: [Vec<f64>; 5] = Default::default();
    for block in &layout.blocks {
        let n = points(block.dimensions) as usize;
        let values = layout.encoding.floats(source, block.values, 5 * n);
        for (q, values) in q.iter_mut().zip(values.chunks_exact(n)) {
            q.extend_from_slice(values);
        }
    }
    derive(q, data);
    Ok(())
}

/// Adds Q1…Q5 and what follows from them.
fn derive(q: [Vec<f64>; 5], data: &mut MeshData) {
    let n = q[0].len();
    let momentum = |p: usize| DVec3::new(q[1][p], q[2][p], q[3][p]);
    // Not a number where there is no density.
    let velocity = |p: usize| {
        if q[0][p] == 0.0 {
            DVec3::NAN
        } else {
            momentum(p) / q[0][p]
        }
    };
    let each = |f: &dyn Fn(usize) -> f64| -> Vec<f64> { (0..n).map(f).collect() };
    let mut derived = vec![
        ("momentum-magnitude", each(&|p| momentum(p).length())),
        ("velocity-magnitude", each(&|p| velocity(p).length())),
        ("velocity-x", each(&|p| velocity(p).x)),
        ("velocity-y", each(&|p| velocity(p).y)),
        ("velocity-z", each(&|p| velocity(p).z)),
    ];

    // Internal energy per volume; negative where Q5 is not a gas's energy.
    let internal = each(&|p| q[4][p] - 0.5 * momentum(p).dot(velocity(p)));
    let is_gas = |e: f64| e > 0.0;
    let gas = internal.iter().filter(|&&e| is_gas(e)).count();
    let varies = q[0].iter().any(|&density| density != q[0][0]);
    if varies && gas * 100 >= n * 99 {
        let pressure = |p: usize| {
            if is_gas(internal[p]) {
                (GAMMA - 1.0) * internal[p]
            } else {
                f64::NAN
            }
        };
        let temperature = |p: usize| pressure(p) / q[0][p];
        derived.push(("pressure", each(&pressure)));
        derived.push(("temperature", each(&temperature)));
        derived.push((
            "mach",
            each(&|p| velocity(p).length() / (GAMMA * temperature(p)).sqrt()),
        ));
        data.notes.push(format!(
            "pressure, temperature and mach assume a ratio of specific heats of {GAMMA} and a gas constant of 1"
        ));
        if gas < n {
            data.notes.push(format!(
                "pressure, temperature and mach are not numbers at {} with no internal energy",
                count((n - gas) as u64, "point")
            ));
        }
    } else {
        let reason = if q[4].iter().all(|&e| e == 0.0) {
            "the energy is 0 everywhere"
        } else if !varies {
            "the density is the same everywhere (incompressible flow)"
        } else {
            "the energy is less than the kinetic energy at more than 1 % of the points"
        };
        data.notes.push(format!(
            "pressure, temperature and mach are not derived: {reason}"
        ));
    }
    let [density, x, y, z, energy] = q;
    let mut fields = vec![
        ("density", density),
        ("energy", energy),
        ("momentum-x", x),
        ("momentum-y", y),
        ("momentum-z", z),
    ];
    fields.append(&mut derived);
    data.fields = fields
        .into_iter()
        .map(|(name, values)| Scalars {
            name: name.into(),
            association: Association::Point,
            values,
        })
        .collect();
}

/// ", 484 trailing bytes ignored".
fn trailing(source: &Source, layout: &Layout) -> String {
    match source.bytes.len() as u64 - layout.size {
        0 => String::new(),
        rest => format!(", {} ignored", count(rest, "trailing byte")),
    }
}

fn extension(path: &Path) -> String {
    path.extension()
        .map(|e| e.to_string_lossy().to_ascii_lowercase())
        .unwrap_or_default()
}

/// The names that the solution of the grid `path` may have.
fn candidates(path: &Path) -> Vec<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let mut found = Vec::new();
    if GRID_EXTENSIONS.contains(&extension(path).as_str()) {
        found.extend([path.with_extension("q"), path.with_extension("Q")]);
    } else if let Some(end) = path.extension()
        && let Some((head, tail)) = split_end(&stem, 3)
        && tail.eq_ignore_ascii_case("xyz")
    {
        let end = end.to_string_lossy();
        for q in ["q", "Q"] {
            found.push(path.with_file_name(format!("{head}{q}.{end}")));
        }
    }
    found
}

/// The grid that exists and whose solution is `path` by name.
fn grid_of(path: &Path) -> Option<PathBuf> {
    let stem = path.file_stem()?.to_string_lossy().into_owned();
    let end = path.extension()?.to_string_lossy().into_owned();
    let mut found = Vec::new();
    if end.eq_ignore_ascii_case("q") {
        for grid in GRID_EXTENSIONS {
            found.push(path.with_extension(grid));
            found.push(path.with_extension(grid.to_ascii_uppercase()));
        }
    } else if let Some((head, tail)) = split_end(&stem, 1)
        && tail.eq_ignore_ascii_case("q")
    {
        for xyz in ["xyz", "XYZ"] {
            found.push(path.with_file_name(format!("{head}{xyz}.{end}")));
        }
    }
    found.into_iter().find(|p| p.is_file())
}

/// `text` cut before its last `length` bytes.
fn split_end(text: &str, length: usize) -> Option<(&str, &str)> {
    text.split_at_checked(text.len().checked_sub(length)?)
}

#[cfg(test)]
mod tests;
