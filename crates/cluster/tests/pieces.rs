//! Pieces of a mesh in files, read by ranks that are threads here.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use tetrascope_cluster::pieces::{Opened, Wanted, open};
use tetrascope_cluster::{Communicator as _, Exchange, Failure, RankRenderer, threads};
use tetrascope_core::{Camera, CameraFit, Frame, Volume};
use tetrascope_io::StepChoice;
use tetrascope_raycast_cpu::RaycastCpuOptions;
use tetrascope_raycast_cpu::counters::{LOST_RAYS, UNPAIRED_FACES};
use tetrascope_testing::{exactly, ramp, scale, view};

/// Hexahedra along each axis.
const SIZE: [usize; 3] = [6, 3, 3];

/// Points of a lattice, moved so that no face is planar.
fn point([x, y, z]: [usize; 3]) -> [f64; 3] {
    let wave = |a: usize, b: usize, c: usize| {
        0.2 * (3.1 * a as f64 + 1.7 * b as f64 + 2.3 * c as f64).sin()
    };
    [
        x as f64 + wave(x, y, z),
        y as f64 + wave(y, z, x),
        z as f64 + wave(z, x, y),
    ]
}

/// A piece: hexahedra between two places along x, of which those before or behind others are ghosts.
#[derive(Clone, Copy)]
struct Slab {
    cells: [usize; 2],
    /// Those that are not ghosts.
    own: [usize; 2],
    /// Whether its points are numbered with y the other way around, so that another corner of each face comes first, and
    /// not the one across.
    mirrored: bool,
    field: &'static str,
}

impl Slab {
    fn new(first: usize, end: usize) -> Slab {
        Slab {
            cells: [first, end],
            own: [first, end],
            mirrored: false,
            field: "height",
        }
    }

    fn text(&self) -> String {
        let [first, end] = self.cells;
        let [_, ny, nz] = SIZE;
        let mut places = Vec::new();
        for z in 0..=nz {
            for y in 0..=ny {
                places.extend((first..=end).map(|x| [x, y, z]));
            }
        }
        if self.mirrored {
            places.sort_by_key(|[x, y, z]| (*z, ny - y, *x));
        }
        let number = |place: [usize; 3]| {
            places
                .iter()
                .position(|other| *other == place)
                .expect("a point")
        };
        let (mut cells, mut ghosts) = (Vec::new(), Vec::new());
        for x in first..end {
            for y in 0..ny {
                for z in 0..nz {
                    let corner = |dx: usize, dy: usize, dz: usize| number([x + dx, y + dy, z + dz]);
                    let bottom = [
                        corner(0, 0, 0),
                        corner(1, 0, 0),
                        corner(1, 1, 0),
                        corner(0, 1, 0),
                    ];
                    let top = [
                        corner(0, 0, 1),
                        corner(1, 0, 1),
                        corner(1, 1, 1),
                        corner(0, 1, 1),
                    ];
                    cells.push([bottom, top].concat());
                    ghosts.push(u8::from(!(self.own[0]..self.own[1]).contains(&x)));
                }
            }
        }
        let mut text = String::from(
            "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\">\n<UnstructuredGrid>\n",
        );
        let join =
            |numbers: &mut dyn Iterator<Item = String>| numbers.collect::<Vec<_>>().join(" ");
        let points = places
            .iter()
            .flat_map(|place| point(*place))
            .map(|x| format!("{x:?}"));
        let values = places
            .iter()
            .map(|[x, y, z]| format!("{}", x + 2 * y + 3 * z));
        let connectivity = cells.iter().flatten().map(ToString::to_string);
        let offsets = (1..=cells.len()).map(|cell| (8 * cell).to_string());
        let types = cells.iter().map(|_| "12".to_owned());
        write!(
            text,
            "<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n\
             <PointData><DataArray type=\"Float64\" Name=\"{}\" format=\"ascii\">{}</DataArray></PointData>\n\
             <CellData><DataArray type=\"UInt8\" Name=\"vtkGhostType\" format=\"ascii\">{}</DataArray></CellData>\n\
             <Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{}</DataArray></Points>\n\
             <Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">{}</DataArray>\n\
             <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">{}</DataArray>\n\
             <DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">{}</DataArray></Cells>\n\
             </Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
            places.len(),
            cells.len(),
            self.field,
            join(&mut { values }),
            join(&mut ghosts.iter().map(ToString::to_string)),
            join(&mut { points }),
            join(&mut { connectivity }),
            join(&mut { offsets }),
            join(&mut { types }),
        )
        .expect("text");
        text
    }
}

/// A folder with pieces and their list.
struct Files(tempfile::TempDir);

impl Files {
    fn new(slabs: &[Slab]) -> Files {
        let files = Files(tempfile::tempdir().expect("a folder"));
        let mut list = String::new();
        for (number, slab) in slabs.iter().enumerate() {
            files.write(&format!("{number}.vtu"), &slab.text());
            list += &format!("<Piece Source=\"{number}.vtu\"/>\n");
        }
        files.write(
            "mesh.pvtu",
            &format!("<VTKFile type=\"PUnstructuredGrid\">\n<PUnstructuredGrid>\n{list}</PUnstructuredGrid>\n</VTKFile>\n"),
        );
        files
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn write(&self, name: &str, text: &str) {
        std::fs::write(self.path(name), text).expect("written");
    }
}

fn wanted() -> Wanted {
    Wanted {
        field: None,
        step: None,
        memory: 1_000_000_000,
    }
}

/// The picture of so many ranks, and what rank 0 opened.
fn draw(ranks: usize, path: &Path, wanted: &Wanted) -> Result<(Frame, Opened), Failure> {
    let mut found = threads::run(ranks, |ranks| {
        let opened = open(&ranks, path, wanted)?;
        let whole = Volume::Clusters(opened.whole.clone());
        // By the box and the range of the whole, which are the same however it is cut.
        let look = ramp(&whole);
        let view = view(
            Camera::fit(&whole.bounds(), CameraFit::PlusIso, false, 1.0),
            48,
        );
        let exchange = Exchange::direct(ranks.size());
        let options = RaycastCpuOptions::default();
        let renderer = RankRenderer::new(&ranks, &opened.share, &look, &options, exchange)?;
        let picture = renderer.render(&ranks, &view)?;
        Ok((picture.frame, opened))
    });
    let (frame, opened) = found.swap_remove(0)?;
    let frame = frame.expect("rank 0 has it");
    assert_eq!(frame.stats.get(LOST_RAYS), Some(0));
    assert_eq!(frame.stats.get(UNPAIRED_FACES), Some(0));
    Ok((frame, opened))
}

/// Rays cross from piece to piece at other faces than within one: the bound of `raycast-cpu`'s clusters.
const MOST: f64 = 2e-6;

fn assert_same(a: &Frame, b: &Frame, what: &str) {
    let most = MOST * scale(&exactly(a));
    let pairs = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let worst = pairs.fold(0.0, |w: f64, (a, b)| w.max(f64::from((a - b).abs())));
    assert!(worst <= most, "{what}: {worst:e} of {most:e}");
}

/// The faces between pieces are not planar, and pieces number their points as they like: all the same they cut
/// these faces alike. With ghosts, the picture is that without.
#[test]
fn warped_hexahedra_meet_without_seams_and_ghosts_are_left_out() {
    let whole = Files::new(&[Slab::new(0, 6)]);
    let (one, opened) = draw(1, &whole.path("mesh.pvtu"), &wanted()).expect("a picture");
    let cells = opened.whole.cell_count();
    // Five or six of each hexahedron.
    assert!((5 * 54..=6 * 54).contains(&cells), "{cells}");
    let mirrored = |slab: Slab| Slab {
        mirrored: true,
        ..slab
    };
    let with_ghosts = |slab: Slab| Slab {
        cells: [
            slab.own[0].saturating_sub(1),
            (slab.own[1] + 1).min(SIZE[0]),
        ],
        ..slab
    };
    let slabs = [Slab::new(0, 2), mirrored(Slab::new(2, 3)), Slab::new(3, 6)];
    for (name, slabs) in [("slabs", slabs), ("ghosts", slabs.map(with_ghosts))] {
        let files = Files::new(&slabs);
        for ranks in [1, 2, 3, 5] {
            let (found, opened) =
                draw(ranks, &files.path("mesh.pvtu"), &wanted()).expect("a picture");
            assert_same(&one, &found, &format!("{name}, {ranks} ranks"));
            assert_eq!((opened.pieces, opened.whole.cell_count()), (3, cells));
            let noted = opened
                .notes
                .iter()
                .any(|note| note.contains("they are ghosts"));
            assert_eq!(noted, name == "ghosts", "{:?}", opened.notes);
            let idle = opened
                .notes
                .iter()
                .any(|note| note.contains("ranks have nothing to draw"));
            assert_eq!(idle, ranks > 3, "{:?}", opened.notes);
        }
    }
    // A single file is one piece, and what does not fit in memory is read again.
    let (alone, _) = draw(2, &whole.path("0.vtu"), &wanted()).expect("a picture");
    assert_same(&one, &alone, "one file");
    let files = Files::new(&slabs);
    let little = Wanted {
        memory: 0,
        ..wanted()
    };
    let (again, _) = draw(2, &files.path("mesh.pvtu"), &little).expect("a picture");
    assert_same(&one, &again, "read again");
}

#[test]
fn pieces_without_cells_are_left_out_and_a_mesh_without_any_is_an_error() {
    let ghosts = Slab {
        own: [9, 9],
        ..Slab::new(0, 1)
    };
    let one = Files::new(&[Slab::new(0, 6)]);
    let (one, _) = draw(1, &one.path("mesh.pvtu"), &wanted()).expect("a picture");
    let files = Files::new(&[ghosts, Slab::new(0, 6), ghosts]);
    let (found, opened) = draw(3, &files.path("mesh.pvtu"), &wanted()).expect("a picture");
    assert_same(&one, &found, "with ghosts alone");
    let left_out = |note: &&String| note.contains("left out: it has no cells with a volume");
    assert_eq!(
        opened.notes.iter().filter(left_out).count(),
        2,
        "{:?}",
        opened.notes
    );
    let files = Files::new(&[ghosts, ghosts]);
    let failure = draw(2, &files.path("mesh.pvtu"), &wanted()).expect_err("no cells");
    assert!(failure.everywhere, "{failure}");
}

#[test]
fn a_field_is_in_all_pieces_and_may_be_absent_in_blocks() {
    let other = Slab {
        field: "other",
        ..Slab::new(3, 6)
    };
    let files = Files::new(&[Slab::new(0, 3), other]);
    let height = Wanted {
        field: Some("height".into()),
        ..wanted()
    };
    let failure = draw(2, &files.path("mesh.pvtu"), &height).expect_err("not in all");
    assert!(
        failure.everywhere && failure.to_string().contains("no scalar field"),
        "{failure}"
    );
    files.write(
        "mesh.vtm",
        "<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet><Block><DataSet file=\"0.vtu\"/>\
         <DataSet file=\"1.vtu\"/></Block></vtkMultiBlockDataSet></VTKFile>",
    );
    for ranks in [1, 2] {
        let (_, opened) = draw(ranks, &files.path("mesh.vtm"), &height).expect("a picture");
        let ranges = opened
            .whole
            .source()
            .clusters()
            .iter()
            .map(|c| c.scalar_range);
        let ranges: Vec<_> = ranges.collect();
        assert!(ranges[0].is_some() && ranges[1].is_none(), "{ranges:?}");
    }
}

#[test]
fn a_pvd_file_lists_the_pieces_of_a_time() {
    let files = Files::new(&[Slab::new(0, 2), Slab::new(2, 6), Slab::new(0, 6)]);
    files.write(
        "time.pvd",
        "<VTKFile type=\"Collection\"><Collection>\
         <DataSet timestep=\"1.5\" part=\"0\" file=\"2.vtu\"/>\
         <DataSet timestep=\"0.5\" part=\"0\" file=\"0.vtu\"/>\
         <DataSet timestep=\"0.5\" part=\"1\" file=\"1.vtu\"/>\
         </Collection></VTKFile>",
    );
    let path = files.path("time.pvd");
    let (first, opened) = draw(2, &path, &wanted()).expect("a picture");
    assert_eq!(opened.pieces, 2);
    assert!(
        opened.notes[0].contains("2 time steps"),
        "{:?}",
        opened.notes
    );
    let second = Wanted {
        step: Some(StepChoice::Time(1.5)),
        ..wanted()
    };
    let (second, opened) = draw(2, &path, &second).expect("a picture");
    assert_eq!(opened.pieces, 1);
    assert_same(&first, &second, "the same lattice at both times");
    let none = Wanted {
        step: Some(StepChoice::Number(2)),
        ..wanted()
    };
    let failure = draw(2, &path, &none).expect_err("no such step");
    assert!(
        failure.everywhere && failure.to_string().contains("time step 2"),
        "{failure}"
    );
}

#[test]
fn a_bad_piece_is_named_with_its_rank() {
    let files = Files::new(&[Slab::new(0, 2), Slab::new(2, 4), Slab::new(4, 6)]);
    let text = Slab::new(2, 4).text();
    files.write("1.vtu", &text[..text.len() / 2]);
    let failure = draw(3, &files.path("mesh.pvtu"), &wanted()).expect_err("a bad piece");
    assert_eq!(failure.rank, 1, "{failure}");
    assert!(failure.to_string().contains("1.vtu"), "{failure}");
}
