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
use std::sync::Arc;

use glam::DVec3;
use tetrascope_core::Error;
use tetrascope_core::glam;
use tetrascope_core::mesh::Association;

use self::layout::{Dimensions, Kind, Layout, describe_blocks, points};
use crate::MeshData;
use crate::fields::{Array, Numbers};
use crate::mesh_data::add_hexahedra;
use crate::read::check;
use crate::source::{Source, count, room};

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
    let arrays = match solution {
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
            Vec::new()
        }
    };
    check(&grid.path, &data, &arrays)?;
    data.add_fields(arrays)?;
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
            "give the grid's file first and this one with `solution`",
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
    let all: u64 = dimensions.iter().map(|&d| points(d)).sum();
    data.points = room(all as usize)?; // the file holds them
    let mut keep = Vec::new();
    let mut flat_blocks = 0;
    for block in &layout.blocks {
        let n = points(block.dimensions) as usize;
        let base = data.points.len() as u64;
        let each = |i| layout.encoding.float(source, block.values, i);
        data.points
            .extend((0..n).map(|p| DVec3::new(each(p), each(n + p), each(2 * n + p))));
        if block.dimensions.contains(&1) {
            flat_blocks += 1;
            continue;
        }
        let first = data.cells.types.len();
        add_hexahedra(&mut data.cells, block.dimensions.map(u64::from), base)?;
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
) -> Result<Vec<Array>, Error> {
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
            "give the solution that belongs to this grid with `solution`",
        ));
    }
    let conditions: Vec<f64> = layout
        .encoding
        .floats(source, layout.blocks[0].conditions, 4)
        .collect();
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
    let all: u64 = dimensions.iter().map(|&d| points(d)).sum();
    let mut q = Solution::default();
    for values in &mut q.0 {
        *values = room(all as usize)?; // the file holds them
    }
    for block in &layout.blocks {
        let n = points(block.dimensions) as usize;
        let values = layout.encoding.floats(source, block.values, 5 * n);
        for (i, value) in values.enumerate() {
            q.0[i / n].push(value);
        }
    }
    Ok(derive(q, data))
}

/// Q1…Q5 at all points.
#[derive(Debug, Default)]
struct Solution([Vec<f64>; 5]);

impl Solution {
    fn count(&self) -> usize {
        self.0[0].len()
    }

    fn density(&self, p: usize) -> f64 {
        self.0[0][p]
    }

    fn momentum(&self, p: usize) -> DVec3 {
        DVec3::new(self.0[1][p], self.0[2][p], self.0[3][p])
    }

    /// Not a number where there is no density.
    fn velocity(&self, p: usize) -> DVec3 {
        if self.density(p) == 0.0 {
            DVec3::NAN
        } else {
            self.momentum(p) / self.density(p)
        }
    }

    fn energy(&self, p: usize) -> f64 {
        self.0[4][p]
    }

    /// Internal energy per volume; not above 0 where Q5 is not a gas's energy.
    fn internal(&self, p: usize) -> f64 {
        self.energy(p) - 0.5 * self.momentum(p).dot(self.velocity(p))
    }

    fn is_gas(&self, p: usize) -> bool {
        self.internal(p) > 0.0
    }

    fn pressure(&self, p: usize) -> f64 {
        if self.is_gas(p) {
            (GAMMA - 1.0) * self.internal(p)
        } else {
            f64::NAN
        }
    }

    fn temperature(&self, p: usize) -> f64 {
        self.pressure(p) / self.density(p)
    }

    fn mach(&self, p: usize) -> f64 {
        self.velocity(p).length() / (GAMMA * self.temperature(p)).sqrt()
    }
}

/// The value of a field at a point.
type At = fn(&Solution, usize) -> f64;

/// A field that follows from a solution.
#[derive(Debug)]
struct Derived {
    solution: Arc<Solution>,
    at: At,
}

impl Numbers for Derived {
    fn each(&self, each: &mut dyn FnMut(f64)) -> Result<(), Error> {
        (0..self.solution.count()).for_each(|p| each((self.at)(&self.solution, p)));
        Ok(())
    }
}

/// Q1…Q5 and what follows from them.
fn derive(solution: Solution, data: &mut MeshData) -> Vec<Array> {
    let q = Arc::new(solution);
    let n = q.count();
    let mut fields: Vec<(&str, At)> = vec![
        ("density", |q, p| q.density(p)),
        ("energy", |q, p| q.energy(p)),
        ("momentum-x", |q, p| q.momentum(p).x),
        ("momentum-y", |q, p| q.momentum(p).y),
        ("momentum-z", |q, p| q.momentum(p).z),
        ("momentum-magnitude", |q, p| q.momentum(p).length()),
        ("velocity-magnitude", |q, p| q.velocity(p).length()),
        ("velocity-x", |q, p| q.velocity(p).x),
        ("velocity-y", |q, p| q.velocity(p).y),
        ("velocity-z", |q, p| q.velocity(p).z),
    ];
    let gas = (0..n).filter(|&p| q.is_gas(p)).count();
    let varies = (0..n).any(|p| q.density(p) != q.density(0));
    if varies && gas * 100 >= n * 99 {
        fields.push(("pressure", |q, p| q.pressure(p)));
        fields.push(("temperature", |q, p| q.temperature(p)));
        fields.push(("mach", |q, p| q.mach(p)));
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
        let reason = if (0..n).all(|p| q.energy(p) == 0.0) {
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
    let array = |(name, at): (&str, At)| Array {
        name: name.into(),
        association: Association::Point,
        components: 1,
        component_names: Vec::new(),
        tuples: n,
        numbers: Arc::new(Derived {
            solution: q.clone(),
            at,
        }),
        active: false,
        colors: false,
    };
    fields.into_iter().map(array).collect()
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
