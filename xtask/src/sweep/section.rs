//! A sweep for people.

use minijinja::Environment;
use serde::Serialize;
use tetrascope::voxel_hw::machine::Merge;

use super::charts::{self, RateLine, WIDTHS, is_moved, rates, tornado};
use super::plan::GENERATORS;
use super::result::{Row, Sweep, SweptMesh, Weight};
use crate::page::{self, html};
use crate::report::{bytes, thousands};

/// The part of a page on a sweep, ready to be written.
#[derive(Debug, Serialize)]
pub struct Section {
    sweep: Sweep,
    answer: Vec<String>,
    meshes: Vec<MeshSection>,
    generators: [u32; 3],
    widths: [u32; 3],
    colors: [&'static str; 5],
}

/// The part on one mesh.
#[derive(Debug, Serialize)]
struct MeshSection {
    mesh: SweptMesh,
    panels: Vec<Panel>,
    lines: Vec<Line>,
    /// Voxels of the sensitivities.
    dims: [usize; 3],
    tornado: Option<String>,
    /// Names of numbers that move nothing.
    unmoved: Vec<String>,
}

/// A chart of one number of samples.
#[derive(Debug, Serialize)]
struct Panel {
    samples: u32,
    chart: String,
}

/// A line of the table: a machine and a volume, with both merges.
#[derive(Debug, Serialize)]
struct Line {
    samples: u32,
    dims: [usize; 3],
    generators: u32,
    merges: Vec<Cell>,
    texture_bytes: u64,
    texture_fits: bool,
    is_standard: bool,
}

/// One configuration in the table.
#[derive(Debug, Serialize)]
struct Cell {
    rate: String,
    bound: String,
    bytes: u64,
}

impl Section {
    /// The section of a sweep.
    pub fn new(sweep: Sweep) -> Section {
        let meshes = sweep.meshes.iter().map(|mesh| of_mesh(&sweep, mesh));
        Section {
            answer: answer(&sweep),
            meshes: meshes.collect(),
            generators: GENERATORS,
            widths: WIDTHS,
            colors: crate::plot::COLORS,
            sweep,
        }
    }

    /// The bound of the machine and its volumes per second, in sentences.
    pub fn answer(&self) -> &[String] {
        &self.answer
    }

    /// A page of its own that needs no other file.
    pub fn to_html(&self) -> String {
        #[derive(Serialize)]
        struct Page<'a> {
            machine: &'a Section,
        }
        html(include_str!("page.html"), &Page { machine: self }, add_to)
    }
}

/// Adds the templates that pages with a section include, and their filters.
pub(crate) fn add_to(environment: &mut Environment<'static>) {
    environment.add_filter("bytes", bytes);
    environment.add_filter("thousands", thousands);
    page::add(environment, "machine.html", include_str!("section.html"));
}

/// "128 × 49 × 34".
fn times([x, y, z]: [usize; 3]) -> String {
    format!("{x} × {y} × {z}")
}

/// Three digits.
fn rate(rate: f64) -> String {
    let decimals = (2.0 - rate.log10().floor()).clamp(0.0, 9.0);
    format!("{rate:.*}", decimals as usize)
}

fn answer(sweep: &Sweep) -> Vec<String> {
    // The mesh with the most cells first.
    let mut meshes: Vec<&SweptMesh> = sweep.meshes.iter().collect();
    meshes.sort_by_key(|mesh| std::cmp::Reverse(mesh.cells));
    let parts = meshes.into_iter().filter_map(|mesh| {
        let row = sweep.standard(&mesh.name)?;
        let (most, dims) = (rate(row.volumes_per_second[1]), times(row.dims));
        Some((
            row.bound.clone(),
            format!(
                "{most} volumes per second of {} ({} tetrahedra, {dims} voxels)",
                mesh.name,
                thousands(mesh.cells as u64),
            ),
        ))
    });
    let parts = parts.enumerate().map(|(index, (bound, made))| match index {
        0 => format!("Bound by the {bound}, the machine makes at most {made}"),
        _ => format!("bound by the {bound}, {made}"),
    });
    let parts: Vec<String> = parts.collect();
    let mut bounds: Vec<(&str, usize)> = Vec::new();
    for row in &sweep.rows {
        match bounds.iter_mut().find(|(name, _)| *name == row.bound) {
            Some((_, count)) => *count += 1,
            None => bounds.push((&row.bound, 1)),
        }
    }
    bounds.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    let bounds = bounds.iter().map(|(name, count)| format!("{name} {count}"));
    vec![
        format!("{}.", parts.join("; ")),
        format!(
            "That is with {} fragment generators, one sample per voxel, {} bits per voxel and the \
             merge by broadcast.",
            sweep.standard_generators, sweep.bits_per_voxel
        ),
        format!(
            "What bounds all {} configurations: {}.",
            sweep.rows.len(),
            bounds.collect::<Vec<_>>().join(", ")
        ),
    ]
}

fn of_mesh(sweep: &Sweep, mesh: &SweptMesh) -> MeshSection {
    let rows: Vec<&Row> = sweep.rows.iter().filter(|r| r.mesh == mesh.name).collect();
    let mut samples: Vec<u32> = rows.iter().map(|row| row.samples).collect();
    samples.dedup();
    let highest_rates = || rows.iter().map(|row| row.volumes_per_second[1]);
    let least = highest_rates().fold(f64::INFINITY, f64::min);
    let most = highest_rates().fold(0.0, f64::max);
    let panels = samples.into_iter().map(|samples| Panel {
        samples,
        chart: rates(&rate_lines(&rows, samples), (least, most), (430, 370)),
    });
    let found = sweep.sensitivity.iter().find(|s| s.mesh == mesh.name);
    let weights = found.map_or(&[][..], |found| &found.weights);
    let is_strong = |weight: &&Weight| weight.ratios.iter().any(|ratio| is_moved(*ratio));
    let (strong, weak): (Vec<&Weight>, Vec<&Weight>) = weights.iter().partition(is_strong);
    MeshSection {
        mesh: mesh.clone(),
        panels: panels.collect(),
        lines: lines(sweep, &rows),
        dims: found.map_or([0; 3], |found| found.dims),
        tornado: (!strong.is_empty()).then(|| tornado(&strong, 860)),
        unmoved: weak.iter().map(|w| w.name.replace('_', " ")).collect(),
    }
}

fn rate_lines(rows: &[&Row], samples: u32) -> Vec<RateLine> {
    let mut lines = Vec::new();
    for (machine, generators) in GENERATORS.into_iter().enumerate() {
        for (merge, which) in Merge::ALL {
            let of = |row: &&&Row| {
                (row.samples, row.generators, row.merge.as_str()) == (samples, generators, merge)
            };
            let points = rows.iter().filter(of);
            lines.push(charts::RateLine {
                machine,
                is_readback: which == Merge::Readback,
                points: points.map(|r| (r.side, r.volumes_per_second[1])).collect(),
            });
        }
    }
    lines
}

fn lines(sweep: &Sweep, rows: &[&Row]) -> Vec<Line> {
    let is_same =
        |a: &&Row, b: &&Row| (a.samples, a.side, a.generators) == (b.samples, b.side, b.generators);
    let line = |rows: &[&Row]| {
        let row = rows[0];
        let cell = |row: &&Row| {
            let [least, most] = row.volumes_per_second.map(rate);
            Cell {
                rate: match least == most {
                    true => most,
                    false => format!("{least} to {most}"),
                },
                bound: row.bound.clone(),
                bytes: row.bytes.merged(),
            }
        };
        Line {
            samples: row.samples,
            dims: row.dims,
            generators: row.generators,
            merges: rows.iter().map(cell).collect(),
            texture_bytes: row.texture_bytes,
            texture_fits: row.texture_fits,
            is_standard: sweep.standard(&row.mesh) == Some(row),
        }
    };
    rows.chunk_by(is_same).map(line).collect()
}

#[cfg(test)]
mod tests {
    use minijinja::HtmlEscape;

    use super::*;
    use crate::sweep::tests::small;

    #[test]
    fn the_page_has_every_configuration_and_needs_no_other_file() {
        let sweep = small();
        let section = Section::new(sweep.clone());
        let page = section.to_html();
        for mesh in &sweep.meshes {
            let lines = section
                .meshes
                .iter()
                .find(|m| m.mesh == *mesh)
                .expect("a mesh");
            let of_mesh = sweep.rows.iter().filter(|row| row.mesh == mesh.name);
            let count: usize = lines.lines.iter().map(|line| line.merges.len()).sum();
            assert_eq!(count, of_mesh.count());
        }
        // A row of the table for each pair of merges, two charts for each mesh, and a tornado.
        assert_eq!(
            page.matches("<tr class=\"machine").count(),
            sweep.rows.len() / 2
        );
        assert_eq!(page.matches("<tr class=\"machine standard").count(), 2);
        assert_eq!(page.matches("class=\"panel\"").count(), 4);
        assert_eq!(page.matches("class=\"tornado\"").count(), 2);
        for row in &sweep.rows {
            assert!(page.contains(&rate(row.volumes_per_second[1])), "{row:?}");
        }
        for number in &sweep.machine {
            let about = HtmlEscape(&number.about).to_string();
            assert!(page.contains(&about), "{about}");
        }
        assert!(page.contains("many &amp; small") && page.contains("a &lt;note&gt;"));
        for outside in ["src=\"", "href=\"http", "@import", "url(", "<script"] {
            assert!(!page.contains(outside), "the page needs {outside}");
        }
    }

    #[test]
    fn the_answer_names_what_bounds_the_machine() {
        let sweep = small();
        let row = sweep.standard("Staircase").expect("it is there").clone();
        let answer = Section::new(sweep).answer().join(" ");
        assert!(
            answer.contains(&format!("ound by the {}, ", row.bound)),
            "{answer}"
        );
        assert!(
            answer.contains("16 voxels") && answer.contains("all 48"),
            "{answer}"
        );
    }

    #[test]
    fn rates_have_three_digits() {
        for (value, text) in [
            (1234.5, "1234"),
            (12.34, "12.3"),
            (1.0, "1.00"),
            (0.012345, "0.0123"),
        ] {
            assert_eq!(rate(value), text);
        }
    }
}
