//! The targets of libFuzzer: each takes bytes and answers in some hundred microseconds.
//!
//! A target makes one input of the bytes that it is given: a file, several files, a scene, a
//! mesh, or a file that it packs itself, so that what changes lies behind checksums. Files lie
//! in one folder, in memory where the system has such a place.

mod archive;
mod mesh;
mod packed;

use std::cell::RefCell;
use std::collections::HashMap;
use std::fs::{self, File};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::grid::{ByteOrder, Interpolation, Lattice, RawLayout, RawNumber, Region};
use tetrascope::core::mesh::Association;
use tetrascope::core::{Error, Grid, Scalars, TetMesh, Volume};
use tetrascope::io::{FileData, GridData, MeshData, ReadOptions, read_collection, read_file};
use tetrascope::scene::SceneFile;

use crate::pack::{Part, Wrap, pack};
use crate::reader::check_message;
use crate::seeds::{self, Kind, Seed};
use crate::{PeakAlloc, allowed};

/// One way to use bytes.
pub struct Target {
    /// Its name, which is also that of its corpus.
    pub name: &'static str,
    /// More bytes than this are no better.
    pub longest: usize,
    /// The kind of files of which it has the words, and the seeds where it makes none.
    kind: Option<&'static str>,
    read: fn(&Bench, &[u8]) -> Result<(), Error>,
    seeds: fn(&[Seed]) -> Vec<Vec<u8>>,
}

impl Target {
    const fn of(
        name: &'static str,
        kind: &'static str,
        read: fn(&Bench, &[u8]) -> Result<(), Error>,
    ) -> Target {
        Target {
            name,
            longest: 2048,
            kind: Some(kind),
            read,
            seeds: first_files,
        }
    }
}

/// Every target.
pub const TARGETS: [Target; 31] = [
    Target::of("vtu", "vtu", |bench, bytes| bench.file("mesh.vtu", bytes)),
    Target::of("vtk", "vtk", |bench, bytes| bench.file("mesh.vtk", bytes)),
    Target::of("vts", "vts", |bench, bytes| bench.file("grid.vts", bytes)),
    Target::of("vtr", "vtr", |bench, bytes| bench.file("grid.vtr", bytes)),
    Target {
        seeds: two_files,
        ..Target::of("pvtu", "pvtu", |bench, bytes| {
            bench.listed(["mesh.pvtu", "a.vtu"], bytes)
        })
    },
    Target {
        seeds: two_files,
        ..Target::of("vtm", "vtm", |bench, bytes| {
            bench.listed(["mesh.vtm", "a.vtu"], bytes)
        })
    },
    Target {
        seeds: two_files,
        ..Target::of("pvti", "pvti", |bench, bytes| {
            bench.listed(["grid.pvti", "a.vti"], bytes)
        })
    },
    Target::of("gmsh", "gmsh", |bench, bytes| bench.file("mesh.msh", bytes)),
    Target {
        longest: 4096,
        ..Target::of("exodus", "exodus", |bench, bytes| {
            bench.file("mesh.e", bytes)
        })
    },
    Target::of("vti", "vti", |bench, bytes| bench.file("grid.vti", bytes)),
    Target {
        seeds: two_files,
        ..Target::of("plot3d", "plot3d", plot3d)
    },
    Target::of("metaimage", "metaimage", |bench, bytes| {
        bench.file("grid.mha", bytes)
    }),
    Target::of("nrrd", "nrrd", |bench, bytes| {
        bench.file("grid.nrrd", bytes)
    }),
    Target {
        longest: 1024,
        ..Target::of("nifti", "nifti", |bench, bytes| {
            bench.file("grid.nii", bytes)
        })
    },
    Target {
        longest: 1024,
        seeds: two_files,
        ..Target::of("nifti-pair", "nifti-pair", pair)
    },
    Target {
        longest: 512,
        ..Target::of("npy", "npy", |bench, bytes| bench.file("grid.npy", bytes))
    },
    Target {
        longest: 1024,
        ..Target::of("npz", "npz", |bench, bytes| bench.file("grid.npz", bytes))
    },
    Target::of("mrc", "mrc", |bench, bytes| bench.file("grid.mrc", bytes)),
    Target {
        longest: 4096,
        ..Target::of("tiff", "tiff", |bench, bytes| bench.file("grid.tif", bytes))
    },
    Target {
        longest: 4096,
        ..Target::of("dicom", "dicom", |bench, bytes| {
            bench.file("grid.dcm", bytes)
        })
    },
    Target {
        longest: 512,
        seeds: raw_seeds,
        ..Target::of("raw", "raw", raw)
    },
    Target {
        seeds: stream_seeds,
        ..Target::of("streams", "vti", streams)
    },
    Target::of("scene-toml", "scene", |bench, bytes| {
        bench.scene("scene.toml", bytes)
    }),
    Target::of("scene-json", "scene", |bench, bytes| {
        bench.scene("scene.json", bytes)
    }),
    Target {
        longest: 1024,
        ..Target::of("pvd", "pvd", |bench, bytes| {
            bench.collection("steps.pvd", bytes)
        })
    },
    Target {
        longest: 1024,
        ..Target::of("series", "series", |bench, bytes| {
            bench.collection("steps.vtu.series", bytes)
        })
    },
    Target {
        name: "mesh",
        longest: 1024,
        kind: None,
        read: |_, bytes| mesh::build(bytes),
        seeds: |_| mesh::seeds(),
    },
    Target {
        seeds: |_| packed::mesh_seeds(),
        ..Target::of("packed-vtu", "vtu", packed::mesh)
    },
    Target {
        seeds: |_| packed::mesh_seeds(),
        ..Target::of("packed-vti", "vti", packed::image)
    },
    Target {
        seeds: packed::grid_seeds,
        ..Target::of("packed-grid", "nrrd", packed::grid)
    },
    Target {
        longest: 1024,
        seeds: |_| archive::seeds(),
        ..Target::of("packed-npz", "npy", archive::read)
    },
];

/// The target called `name`.
pub fn find(name: &str) -> Option<&'static Target> {
    TARGETS.iter().find(|target| target.name == name)
}

/// Where targets read, and with what.
pub struct Bench {
    folder: tempfile::TempDir,
    /// Files that are written again and again: opening them takes as long as reading one.
    files: RefCell<HashMap<&'static str, File>>,
    mesh: Volume,
    grid: Volume,
}

/// Where files are written to memory, if there is such a place.
const IN_MEMORY: &str = "/dev/shm";

impl Bench {
    /// Also makes this thread the one that does all work: parallel loops over nothing would
    /// wait for each other.
    ///
    /// # Errors
    /// No folder can be made.
    pub fn new() -> io::Result<Bench> {
        let alone = rayon::ThreadPoolBuilder::new()
            .num_threads(1)
            .use_current_thread();
        // Where there are threads already, they are as good.
        let _ = alone.build_global();
        let folder = match std::env::var_os("TMPDIR") {
            None if Path::new(IN_MEMORY).is_dir() => tempfile::tempdir_in(IN_MEMORY)?,
            _ => tempfile::tempdir()?,
        };
        // The files that headers and collections of the seeds name.
        let samples: Vec<u8> = (0..72).collect();
        for name in ["grid.raw", "s1.raw", "s2.raw"] {
            fs::write(folder.path().join(name), &samples)?;
        }
        for name in ["a.vtu", "b.vtu"] {
            fs::write(folder.path().join(name), seeds::listed_mesh())?;
        }
        for (name, piece) in seeds::listed_extents() {
            fs::write(folder.path().join(name), piece)?;
        }
        Ok(Bench {
            folder,
            files: RefCell::default(),
            mesh: small_mesh(),
            grid: small_grid(),
        })
    }

    /// Uses `bytes` as `target` does: whether they were read, or refused.
    ///
    /// # Errors
    /// The fault of the answer: a message that is not one printable line, or more memory
    /// than [`allowed`], if the process counts it by [`PeakAlloc`].
    ///
    /// # Panics
    /// Where a reader does, which is the finding.
    pub fn run(&self, target: &Target, bytes: &[u8]) -> Result<bool, String> {
        PeakAlloc.reset_peak_usage();
        let before = PeakAlloc.current_usage();
        let answer = (target.read)(self, bytes);
        let memory = PeakAlloc.peak_usage().saturating_sub(before) as u64;
        if memory > allowed(bytes.len()) {
            return Err(format!("{memory} bytes of memory for {}", bytes.len()));
        }
        match answer {
            Ok(()) => Ok(true),
            Err(error) => check_message(&error).map(|()| false),
        }
    }

    /// Writes a file that is to be read.
    fn put(&self, name: &'static str, bytes: &[u8]) -> PathBuf {
        let path = self.folder.path().join(name);
        let mut files = self.files.borrow_mut();
        let create = || File::create(&path).expect("the folder is ours");
        let file = files.entry(name).or_insert_with(create);
        let written = (|| {
            file.seek(SeekFrom::Start(0))?;
            file.write_all(bytes)?;
            file.set_len(bytes.len() as u64)
        })();
        written.expect("the file is ours");
        path
    }

    fn file(&self, name: &'static str, bytes: &[u8]) -> Result<(), Error> {
        let path = self.put(name, bytes);
        take(read_file(&path, &ReadOptions::default())?)
    }

    /// A list, then the first of the two files that it may name, which are called so.
    fn listed(&self, [name, listed]: [&'static str; 2], bytes: &[u8]) -> Result<(), Error> {
        let (list, first) = cut(bytes);
        self.put(listed, first);
        self.file(name, list)
    }

    fn collection(&self, name: &'static str, bytes: &[u8]) -> Result<(), Error> {
        let path = self.put(name, bytes);
        read_collection(&path).map(drop)
    }

    /// Parses and completes a scene; what a complete scene prints is a scene again.
    fn scene(&self, name: &str, bytes: &[u8]) -> Result<(), Error> {
        let Ok(text) = std::str::from_utf8(bytes) else {
            return Ok(()); // refused before it comes to this
        };
        let file = SceneFile::parse(text, Path::new(name))?;
        file.volume.raw_layout()?;
        let volume = match bytes.len() % 2 {
            0 => &self.mesh,
            _ => &self.grid,
        };
        let scene = file.resolve(volume)?;
        let printed = SceneFile::parse(&scene.to_toml(), Path::new("scene.toml"));
        let again = printed.expect("a complete scene is a scene");
        let again = again.resolve(volume).expect("it is complete");
        assert_eq!(again.to_toml(), scene.to_toml(), "printed twice");
        Ok(())
    }
}

/// All that a person may ask of what was read.
fn take(data: FileData) -> Result<(), Error> {
    /// So many fields of a file are read: others are read by the same code.
    const FIELDS: usize = 4;
    match data {
        FileData::Mesh(mesh) => take_mesh(mesh, FIELDS),
        FileData::Grid(grid) => take_grid(grid, FIELDS),
        FileData::Clusters(clusters) => {
            let source = clusters.source();
            let mut all = 0..source.clusters().len();
            all.try_for_each(|cluster| source.read(cluster).map(drop))
        }
    }
}

fn take_mesh(data: MeshData, fields: usize) -> Result<(), Error> {
    data.field_list();
    for field in data.fields.iter().take(fields) {
        data.field(Some(&field.name)).map(drop).or_else(no_field)?;
    }
    let mesh = data.into_mesh(None)?;
    mesh.report().notes();
    mesh.scalar_range();
    Ok(())
}

/// Names that stand for several fields are refused, which is right.
fn no_field(error: Error) -> Result<(), Error> {
    match error {
        Error::NoSuchField { .. } => Ok(()),
        other => Err(other),
    }
}

fn take_grid(data: GridData, fields: usize) -> Result<(), Error> {
    for field in data.fields.iter().take(fields) {
        field.samples.range();
        field.samples.missing();
    }
    match data.into_volume(None)?.0 {
        Volume::Stream(stream) => {
            let source = stream.source();
            let corner = Region {
                low: source.lattice().dims.map(|n| n - 1),
                size: [1; 3],
            };
            source.read(corner).map(drop)
        }
        _ => Ok(()),
    }
}

/// A grid file, then the solution.
fn plot3d(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let (grid, solution) = cut(bytes);
    bench.put("meshq.bin", solution);
    bench.file("meshxyz.bin", grid)
}

/// The header of a pair, then its samples.
fn pair(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let (header, samples) = cut(bytes);
    bench.put("grid.img", samples);
    bench.file("grid.hdr", header)
}

/// Two files of bytes that begin with the length of the first, in two.
fn cut(bytes: &[u8]) -> (&[u8], &[u8]) {
    let [low, high, rest @ ..] = bytes else {
        return (bytes, &[]);
    };
    let length = usize::from(u16::from_le_bytes([*low, *high]));
    rest.split_at(length.min(rest.len()))
}

/// Six bytes of layout, then the file.
fn raw(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let [kind, x, y, z, offset, options, rest @ ..] = bytes else {
        return Ok(());
    };
    let size = |byte: &u8| match usize::from(*byte) {
        small @ 0..192 => small,
        large => 1 << (large - 192),
    };
    const SPACINGS: [f64; 8] = [1.0, -1.0, 0.0, 1e-310, 1e300, f64::NAN, f64::INFINITY, 2.5];
    let spacing = SPACINGS[usize::from(options >> 5)];
    let layout = RawLayout {
        lattice: Lattice {
            dims: [size(x), size(y), size(z)],
            origin: DVec3::ZERO,
            spacing: DVec3::new(1.0, spacing, 1.0),
            direction: DMat3::IDENTITY,
            interpolation: match options & 1 {
                0 => Interpolation::Linear,
                _ => Interpolation::Nearest,
            },
        },
        number: RawNumber::ALL[usize::from(*kind) % RawNumber::ALL.len()],
        offset: size(offset) as u64,
        byte_order: match options & 2 {
            0 => ByteOrder::Little,
            _ => ByteOrder::Big,
        },
    };
    let path = bench.put("grid.raw", rest);
    let options = ReadOptions {
        raw: Some(layout),
        stream_above: if options & 4 == 0 { u64::MAX } else { 0 },
        ..ReadOptions::default()
    };
    take(read_file(&path, &options)?)
}

/// The names and kinds of files that [`streams`] reads; an input's first byte chooses.
const STREAMED: [(&str, &str); 8] = [
    ("grid.vti", "vti"),
    ("grid.vtk", "vtk"),
    ("grid.mha", "metaimage"),
    ("grid.nrrd", "nrrd"),
    ("grid.nii", "nifti"),
    ("grid.npy", "npy"),
    ("grid.mrc", "mrc"),
    ("grid.tif", "tiff"),
];

/// Grids that are left in their file as far as that can be.
fn streams(bench: &Bench, bytes: &[u8]) -> Result<(), Error> {
    let [which, rest @ ..] = bytes else {
        return Ok(());
    };
    let (name, _) = STREAMED[usize::from(*which) % STREAMED.len()];
    let path = bench.put(name, rest);
    let options = ReadOptions {
        stream_above: 0,
        ..ReadOptions::default()
    };
    take(read_file(&path, &options)?)
}

fn small_mesh() -> Volume {
    let points = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
    let scalars = Scalars {
        name: "s".into(),
        association: Association::Point,
        values: vec![0.0, 1.0, 2.0, 3.0, f64::NAN],
    };
    let mesh = TetMesh::from_tetrahedra(points, vec![[0, 1, 2, 3], [1, 2, 3, 4]], scalars);
    Volume::Mesh(mesh.expect("two tetrahedra"))
}

fn small_grid() -> Volume {
    let samples = tetrascope::core::grid::Samples::U8((0..24).map(|i| i * 7).collect());
    let grid = Grid::new(
        [2, 3, 4],
        DVec3::ZERO,
        DVec3::new(1.0, 1.0, 2.0),
        DMat3::IDENTITY,
        samples,
    );
    Volume::Grid(grid.expect("a small grid"))
}

/// Writes the seeds of each target to a folder of its name in `folder`, its words to a file
/// `NAME.dict`, and the bytes of its longest input to `NAME.len`.
///
/// # Errors
/// A fixture cannot be read, or `folder` not be written to.
pub fn write_seeds(folder: &Path) -> io::Result<()> {
    let kinds = seeds::kinds()?;
    for target in &TARGETS {
        let kind = kinds.iter().find(|kind| Some(kind.name) == target.kind);
        let own = folder.join(target.name);
        fs::create_dir_all(&own)?;
        let all = match target.name {
            "streams" => of_streams(&kinds),
            _ => (target.seeds)(kind.map_or(&[], |kind| &kind.seeds)),
        };
        for (i, seed) in all.iter().enumerate() {
            fs::write(own.join(format!("seed-{i}")), seed)?;
        }
        let words = kind.map_or(&[][..], |kind| kind.words);
        let words = words.iter().map(|word| quoted(word));
        let words: String = words.collect();
        fs::write(folder.join(format!("{}.dict", target.name)), words)?;
        let longest = target.longest.to_string();
        fs::write(folder.join(format!("{}.len", target.name)), longest)?;
    }
    Ok(())
}

/// A line of a dictionary.
fn quoted(word: &str) -> String {
    let bytes = word.bytes().map(|byte| match byte {
        b'"' | b'\\' => format!("\\{}", char::from(byte)),
        b' '..=b'~' => char::from(byte).to_string(),
        _ => format!("\\x{byte:02x}"),
    });
    format!("\"{}\"\n", bytes.collect::<String>())
}

/// The first file of each seed, as it is.
fn first_files(seeds: &[Seed]) -> Vec<Vec<u8>> {
    let mut files: Vec<Vec<u8>> = seeds.iter().map(|seed| pack(&seed.files[0].1)).collect();
    // Short ones are read faster.
    files.sort_by_key(Vec::len);
    files
}

/// As [`cut`] takes them apart.
fn two_files(seeds: &[Seed]) -> Vec<Vec<u8>> {
    let join = |seed: &Seed| {
        let grid = pack(&seed.files[0].1);
        let length = (grid.len() as u16).to_le_bytes();
        let solution = seed.files.get(1).map(|(_, parts)| pack(parts));
        [length.to_vec(), grid, solution.unwrap_or_default()].concat()
    };
    seeds.iter().map(join).collect()
}

fn raw_seeds(_: &[Seed]) -> Vec<Vec<u8>> {
    let number = |kind: u8| {
        let head = [kind, 2, 2, 2, kind % 3, kind % 8];
        [&head[..], &[kind * 17; 70]].concat()
    };
    (0..RawNumber::ALL.len() as u8).map(number).collect()
}

fn stream_seeds(_: &[Seed]) -> Vec<Vec<u8>> {
    Vec::new() // of several kinds: see `of_streams`
}

fn of_streams(kinds: &[Kind]) -> Vec<Vec<u8>> {
    let mut all = Vec::new();
    for (which, (_, name)) in (0u8..).zip(STREAMED) {
        for kind in kinds.iter().filter(|kind| kind.name == name) {
            let files = first_files(&kind.seeds).into_iter();
            all.extend(files.map(|file| [vec![which], file].concat()));
        }
    }
    all
}

/// A file in parts, without what packs them.
fn unpacked(parts: &[Part]) -> Vec<u8> {
    let plain = parts.iter().map(|part| Part {
        wrap: Wrap::Plain,
        ..part.clone()
    });
    pack(&plain.collect::<Vec<_>>())
}
