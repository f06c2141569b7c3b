//! From a file to what draws it: `loading/lattice/150k cells/read, zlib`, `…/mesh`, `…/neighbors`,
//! `…/pack raycast-cpu`.
//!
//! The mesh is a lattice of cubes, six tetrahedra each, whose inner points are moved by a fixed
//! seed. `read` is a `.vtu` file as VTK writes it, appended in blocks of 32 KiB that zlib has
//! compressed, appended as it is, and in words; `mesh` makes tetrahedra of what was read,
//! `neighbors` finds faces and boundary, and `pack` is a renderer made from both.

use std::fmt::Write as _;
use std::hint::black_box;
use std::io::Write as _;

use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use tetrascope::core::glam::DVec3;
use tetrascope::core::{TetMesh, Volume};
use tetrascope::io::{FileData, MeshData, ReadOptions, read_file};
use tetrascope::{Context, Settings};
use tetrascope_testing::ramp;

/// Cubes along each axis.
const CUBES: usize = 29;

/// Points and cells of the lattice.
struct Lattice {
    points: Vec<DVec3>,
    cells: Vec<[usize; 4]>,
}

fn lattice() -> Lattice {
    let side = CUBES + 1;
    // Knuth's multiplicative generator (MMIX), upper bits.
    let mut seed = 1_u64;
    let mut random = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 40) as f64 / (1 << 24) as f64 - 0.5
    };
    let mut points = Vec::new();
    let mut cells = Vec::new();
    for place in 0..side.pow(3) {
        let at = [place % side, place / side % side, place / side / side];
        let moved = at.map(|i| match i > 0 && i < CUBES {
            true => i as f64 + 0.4 * random(),
            false => i as f64,
        });
        points.push(DVec3::from_array(moved) / CUBES as f64);
        if at.contains(&CUBES) {
            continue;
        }
        // Along the edges from one corner to the opposite one, in each order of the axes.
        let [x, y, z] = [1, side, side * side];
        for [a, b, c] in [
            [x, y, z],
            [y, z, x],
            [z, x, y],
            [y, x, z],
            [x, z, y],
            [z, y, x],
        ] {
            cells.push([place, place + a, place + a + b, place + a + b + c]);
        }
    }
    Lattice { points, cells }
}

/// How arrays are written.
#[derive(Clone, Copy)]
enum Way {
    Zlib,
    Raw,
    Text,
}

impl Way {
    fn write(self, bytes: &[u8], data: &mut Vec<u8>) {
        const BLOCK: usize = 32 << 10;
        let word = |n: usize| (n as u32).to_le_bytes();
        if !matches!(self, Way::Zlib) {
            data.extend(word(bytes.len()));
            data.extend(bytes);
            return;
        }
        let compressed = bytes.chunks(BLOCK).map(|block| {
            let level = flate2::Compression::default();
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), level);
            encoder.write_all(block).expect("in memory");
            encoder.finish().expect("in memory")
        });
        let blocks: Vec<Vec<u8>> = compressed.collect();
        data.extend(
            [blocks.len(), BLOCK, bytes.len() % BLOCK]
                .map(word)
                .concat(),
        );
        data.extend(blocks.iter().flat_map(|block| word(block.len())));
        data.extend(blocks.concat());
    }

    /// A `.vtu` file.
    fn file(self, lattice: &Lattice) -> Vec<u8> {
        let points = lattice.points.iter().map(|p| p.as_vec3());
        let positions: Vec<f32> = points.clone().flat_map(|p| p.to_array()).collect();
        let scalars: Vec<f32> = points.map(|p| (9.0 * p.x).sin() + p.y * p.z).collect();
        let indices: Vec<i64> = lattice.cells.iter().flatten().map(|&p| p as i64).collect();
        let ends: Vec<i64> = (1..=lattice.cells.len() as i64)
            .map(|cell| 4 * cell)
            .collect();
        let types = vec![10_u8; lattice.cells.len()];
        let mut data = Vec::new();
        let mut element = |name: &str,
                           kind: &str,
                           components: usize,
                           bytes: Vec<u8>,
                           words: String| {
            let (place, text) = match self {
                Way::Text => ("ascii".into(), words),
                _ => (format!("appended\" offset=\"{}", data.len()), String::new()),
            };
            if !matches!(self, Way::Text) {
                self.write(&bytes, &mut data);
            }
            format!(
                r#"<DataArray type="{kind}" Name="{name}" NumberOfComponents="{components}" format="{place}">{text}</DataArray>"#
            )
        };
        let floats =
            |values: &[f32]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
        let longs =
            |values: &[i64]| -> Vec<u8> { values.iter().flat_map(|v| v.to_le_bytes()).collect() };
        let field = element("t", "Float32", 1, floats(&scalars), words(&scalars));
        let place = element(
            "Points",
            "Float32",
            3,
            floats(&positions),
            words(&positions),
        );
        let indices = element("connectivity", "Int64", 1, longs(&indices), words(&indices));
        let ends = element("offsets", "Int64", 1, longs(&ends), words(&ends));
        let types = element("types", "UInt8", 1, types.clone(), words(&types));
        let compressor = match self {
            Way::Zlib => r#" compressor="vtkZLibDataCompressor""#,
            _ => "",
        };
        let (point_count, cell_count) = (lattice.points.len(), lattice.cells.len());
        let head = format!(
            r#"<VTKFile type="UnstructuredGrid" byte_order="LittleEndian"{compressor}><UnstructuredGrid>
<Piece NumberOfPoints="{point_count}" NumberOfCells="{cell_count}"><PointData>{field}</PointData>
<Points>{place}</Points><Cells>{indices}{ends}{types}</Cells></Piece></UnstructuredGrid>
<AppendedData encoding="raw">_"#
        );
        let mut file = head.into_bytes();
        file.extend(data);
        file
    }
}

fn words<T: std::fmt::Display>(numbers: &[T]) -> String {
    let mut text = String::new();
    for number in numbers {
        write!(text, "{number} ").expect("in memory");
    }
    text
}

fn mesh_of(data: MeshData) -> TetMesh {
    data.into_mesh(None).expect("it has a field")
}

fn loading(criterion: &mut Criterion) {
    let lattice = lattice();
    let thousands = (lattice.cells.len() + 500) / 1000;
    let mut group = criterion.benchmark_group(format!("loading/lattice/{thousands}k cells"));
    group.sample_size(20);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("lattice.vtu");
    let read = || match read_file(&path, &ReadOptions::default()) {
        Ok(FileData::Mesh(data)) => data,
        _ => panic!("the file is a mesh"),
    };
    for (name, way) in [("text", Way::Text), ("raw", Way::Raw), ("zlib", Way::Zlib)] {
        std::fs::write(&path, way.file(&lattice)).expect("there is room");
        group.bench_function(format!("read, {name}"), |b| b.iter(|| black_box(read())));
    }
    group.bench_function("mesh", |b| {
        b.iter_batched(read, |data| black_box(mesh_of(data)), BatchSize::LargeInput);
    });
    group.bench_function("neighbors", |b| {
        let find = |mesh: TetMesh| black_box(mesh.neighbors().len());
        b.iter_batched(|| mesh_of(read()), find, BatchSize::LargeInput);
    });
    let volume = Volume::Mesh(mesh_of(read()));
    let look = ramp(&volume);
    let algorithm = tetrascope::algorithm("raycast-cpu").expect("it is built in");
    let settings = Settings::parse(algorithm, []).expect("the default is valid");
    let context = Context::new();
    group.bench_function("pack raycast-cpu", |b| {
        b.iter(|| (algorithm.build)(&context, &volume, &look, &settings).expect("it draws this"));
    });
    group.finish();
}

criterion_group!(benches, loading);
criterion_main!(benches);
