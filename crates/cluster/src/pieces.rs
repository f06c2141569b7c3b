//! The pieces of a mesh in files, of which each rank reads its own.
//!
//! 1. All ranks read the list of pieces, which is short, and know whose each piece is ([`partition`](crate::partition)).
//! 2. Each looks at its pieces, and all choose the field by what all pieces offer.
//! 3. Each makes meshes of its pieces, and all learn of all pieces what is known of clusters without reading
//!    them: box, range, counts and some values.
//!
//! From then on a piece is a cluster. Its mesh stays in memory as far as there is room, and is read again elsewhere.

mod told;

use std::collections::HashMap;
use std::ops::Range;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use tetrascope_core::clusters::{Cluster, ClusterSource, MeshClusters};
use tetrascope_core::mesh::{Association, volume_corners};
use tetrascope_core::{Error, Scalars, TetMesh};
use tetrascope_io::lists::{
    PieceField, Pieces, choose_field, list_pieces, piece_fields, read_piece,
};
use tetrascope_io::{MeshData, StepChoice, open_tsc};

use crate::collective::{agree, all_gather, gather};
use crate::part::spread;
use crate::partition::by_bytes;
use crate::{Communicator, Failure, Share};
use told::{Facts, all_fields, numbers};

/// The part of a mesh to read, and the memory for it.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The field, as `MeshData::choose` finds it; `None` for the first that varies.
    pub field: Option<String>,
    /// The time step of a `.pvd` file; `None` for the first.
    pub step: Option<StepChoice>,
    /// Bytes for the meshes of pieces that stay in memory at a rank, beside what its renderer takes.
    pub memory: u64,
}

/// A mesh of which each rank has a share.
#[derive(Clone, Debug)]
pub struct Opened {
    /// All pieces or clusters, the same at every rank. Those of other ranks are not to be read.
    pub whole: MeshClusters,
    /// This rank's.
    pub share: Share,
    /// How many pieces or clusters there are, those without cells too.
    pub pieces: usize,
    /// Findings, repairs and omissions, one sentence each; at rank 0 those of all ranks.
    pub notes: Vec<String>,
}

/// Opens a cluster file (`.tsc`), or the pieces that another file lists (`list_pieces`). All ranks call it together.
///
/// # Errors
/// At every rank, that of the first rank that failed: those of reading; [`Error::Invalid`] for pieces with curved cells, which
/// cannot be cut alike piece by piece, and for a mesh without cells.
pub fn open(ranks: &impl Communicator, path: &Path, wanted: &Wanted) -> Result<Opened, Failure> {
    let extension = path.extension().unwrap_or_default();
    match extension.eq_ignore_ascii_case("tsc") {
        true => open_clusters(ranks, path, wanted),
        false => open_pieces(ranks, path, wanted),
    }
}

fn open_clusters(
    ranks: &impl Communicator,
    path: &Path,
    wanted: &Wanted,
) -> Result<Opened, Failure> {
    let open = || {
        let whole = open_tsc(path)?;
        let (name, _) = whole.source().field();
        if let Some(other) = wanted.field.as_ref().filter(|field| *field != name) {
            return Err(Error::NoSuchField {
                name: other.clone(),
                available: vec![name.to_owned()],
            });
        }
        if wanted.step.is_some() {
            return Err(Error::Invalid {
                what: format!("{} holds no time steps", path.display()),
                help: Some("leave out `step` and `time`".into()),
            });
        }
        let share = Share::by_bytes(&whole, ranks.rank(), ranks.size())?;
        Ok((whole, share))
    };
    let (whole, share) = agree(ranks, open())?;
    Ok(Opened {
        pieces: whole.source().clusters().len(),
        notes: idle(&spread(&whole, ranks.size())).into_iter().collect(),
        whole,
        share,
    })
}

fn open_pieces(ranks: &impl Communicator, path: &Path, wanted: &Wanted) -> Result<Opened, Failure> {
    let (rank, size) = (ranks.rank(), ranks.size());
    let listed = agree(ranks, list_pieces(path, wanted.step))?;
    let bytes: Vec<u64> = listed.files.iter().map(|file| file.bytes).collect();
    let spread = by_bytes(&bytes, size);
    let own = spread[rank].clone();
    let mut notes = Notes::default();

    // Half for the data of pieces, and half for the meshes that are made of them.
    let mut room = wanted.memory / 2;
    let looked = own
        .clone()
        .map(|piece| look(&listed, piece, &mut room, &mut notes));
    let looked: Vec<Looked> = agree(ranks, looked.collect())?;
    let offered = looked.iter().map(|looked| looked.fields.clone());
    let offered = all_fields(ranks, offered.collect())?;
    let chosen = choose_field(&offered, listed.all_fields, wanted.field.as_deref());
    let (field, note) = agree(ranks, chosen)?;

    let mut source = PieceSource {
        pieces: listed.clone(),
        field,
        numbers: Vec::new(),
        clusters: Vec::new(),
        picked: Vec::new(),
        kept: Mutex::new(HashMap::new()),
    };
    let made = make(&source, &own, looked, wanted.memory / 2, &mut notes);
    let made = agree(ranks, made)?;
    let facts = made.iter().flat_map(|made| made.facts.encode());
    let facts = all_gather(ranks, facts.collect())?;
    let facts: Vec<Facts> = facts
        .iter()
        .flat_map(|bytes| Facts::decode_all(bytes))
        .collect();
    let values: u64 = facts.iter().map(|facts| facts.values).sum();
    let step = (values / PICKED).max(1) as usize;
    let picked = made.iter().flat_map(|made| {
        let values = made.some.iter().step_by((step / made.every).max(1));
        values.flat_map(|value| value.to_le_bytes())
    });
    let picked = all_gather(ranks, picked.collect())?;
    source.picked = picked.iter().flat_map(|bytes| numbers(bytes)).collect();
    source.numbers = facts.iter().map(|facts| facts.piece).collect();
    source.clusters = facts.iter().map(|facts| facts.cluster).collect();
    source.kept = Mutex::new(
        made.into_iter()
            .filter_map(|made| Some((made.facts.piece, made.mesh?)))
            .collect(),
    );
    let own = (0..facts.len()).filter(|&cluster| own.contains(&facts[cluster].piece));
    let own: Vec<usize> = own.collect();
    let whole = || {
        if source.clusters.is_empty() {
            return Err(Error::Format {
                path: path.to_owned(),
                at: "its pieces".into(),
                what: "no piece has cells with a volume".into(),
                help: None,
            });
        }
        let whole = MeshClusters::new(Arc::new(source))?;
        let share = Share::of(&whole, own)?;
        Ok((whole, share))
    };
    let (whole, share) = agree(ranks, whole())?;
    let mut all = Vec::new();
    all.extend(listed.notes);
    all.extend(idle(&spread));
    all.extend(note);
    for bytes in gather(ranks, notes.0.join("\n").into_bytes())?.unwrap_or_default() {
        let text = String::from_utf8_lossy(&bytes).into_owned();
        all.extend(text.lines().map(String::from));
    }
    Ok(Opened {
        pieces: listed.files.len(),
        whole,
        share,
        notes: all,
    })
}

/// A note of ranks that have nothing to draw.
fn idle(spread: &[Range<usize>]) -> Option<String> {
    let count = spread.iter().filter(|pieces| pieces.is_empty()).count();
    let of = spread.len();
    (count > 0)
        .then(|| format!("{count} of {of} ranks have nothing to draw: there are too few pieces"))
}

/// About so many values of all pieces are picked, so that a look can be chosen by them: as many as in a cluster file.
const PICKED: u64 = 1 << 16;

/// Notes about pieces, one line each.
#[derive(Default)]
struct Notes(Vec<String>);

impl Notes {
    fn add(&mut self, pieces: &Pieces, piece: usize, notes: &[String]) {
        let path = &pieces.files[piece].path;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let line = |note: &String| format!("{name}: {}", note.replace('\n', " "));
        self.0.extend(notes.iter().map(line));
    }
}

/// A piece that was read for the first time.
struct Looked {
    /// `None` for a piece without cells.
    fields: Option<Vec<PieceField>>,
    /// Its data, if there was room to keep it.
    data: Option<MeshData>,
}

/// VTK's linear volume cells, which are cut by where their corners lie.
const STRAIGHT: std::ops::RangeInclusive<u8> = 10..=16;

fn look(pieces: &Pieces, piece: usize, room: &mut u64, notes: &mut Notes) -> Result<Looked, Error> {
    let file = &pieces.files[piece];
    let data = read_piece(&file.path)?;
    notes.add(pieces, piece, &data.notes);
    let types = &data.cells.types;
    let is_volume = |kind: &&u8| volume_corners(**kind).is_some();
    if let Some(kind) = types
        .iter()
        .filter(is_volume)
        .find(|kind| !STRAIGHT.contains(kind))
    {
        return Err(Error::Format {
            path: file.path.clone(),
            at: "the cells".into(),
            what: format!(
                "a piece with curved cells (VTK type {kind}), which pieces do not cut alike"
            ),
            help: Some("pack the whole mesh with `tetrascope pack`, and draw the .tsc file".into()),
        });
    }
    if !types.iter().any(|kind| is_volume(&kind)) {
        notes.add(
            pieces,
            piece,
            &["left out: it has no cells with a volume".into()],
        );
        return Ok(Looked {
            fields: None,
            data: None,
        });
    }
    // Fields are decoded from the file's bytes when they are asked for.
    let bytes = file.bytes
        + 24 * data.points.len() as u64
        + 9 * types.len() as u64
        + 8 * data.cells.connectivity.len() as u64;
    let fields = Some(piece_fields(&data));
    let fits = bytes <= *room;
    if fits {
        *room -= bytes;
    }
    Ok(Looked {
        fields,
        data: fits.then_some(data),
    })
}

/// The mesh of a piece with the chosen field; NaN in a block without it.
fn mesh_of(data: MeshData, field: &PieceField) -> Result<TetMesh, Error> {
    let is_it = |other: &tetrascope_io::MeshField| {
        (&other.name, other.association) == (&field.name, field.association)
    };
    let scalars = match data.fields.iter().position(is_it) {
        Some(number) => data.scalars(number)?,
        None => Scalars {
            name: field.name.clone(),
            association: field.association,
            values: vec![
                f64::NAN;
                match field.association {
                    Association::Point => data.points.len(),
                    Association::Cell => data.cells.types.len(),
                }
            ],
        },
    };
    let MeshData { points, cells, .. } = data;
    match cells.types.iter().all(|kind| *kind == *STRAIGHT.start()) {
        true => TetMesh::from_cells(points, cells, scalars),
        false => TetMesh::new(points, &cells, scalars),
    }
}

/// A piece of this rank.
struct Made {
    facts: Facts,
    /// Some of its values, of which some are picked: one of so many.
    some: Vec<f64>,
    every: usize,
    /// The mesh, if there is room to keep it.
    mesh: Option<TetMesh>,
}

/// Bytes of a mesh in memory, at most: its tetrahedra and their neighbors, its points and values.
fn mesh_bytes(cluster: &Cluster) -> u64 {
    60 * u64::from(cluster.cells) + 40 * u64::from(cluster.points)
}

fn make(
    source: &PieceSource,
    own: &Range<usize>,
    looked: Vec<Looked>,
    memory: u64,
    notes: &mut Notes,
) -> Result<Vec<Made>, Error> {
    let mut room = memory;
    let mut all = Vec::new();
    for (piece, looked) in own.clone().zip(looked) {
        if looked.fields.is_none() {
            continue;
        }
        let mesh = source.mesh(piece, looked.data)?;
        notes.add(&source.pieces, piece, &mesh.report().notes());
        if mesh.cell_count() == 0 {
            continue;
        }
        let cluster = Cluster {
            cells: mesh.cell_count() as u32,
            points: mesh.points().len() as u32,
            bounds: mesh.bounds(),
            scalar_range: mesh.scalar_range(),
        };
        let bytes = mesh_bytes(&cluster);
        let fits = bytes <= room;
        if fits {
            room -= bytes;
        }
        let values = &mesh.scalars().values;
        let every = (values.len() / PICKED as usize).max(1);
        all.push(Made {
            facts: Facts {
                piece,
                cluster,
                values: values.len() as u64,
            },
            some: values.iter().step_by(every).copied().collect(),
            every,
            mesh: fits.then_some(mesh),
        });
    }
    Ok(all)
}

/// Pieces as clusters.
#[derive(Debug)]
struct PieceSource {
    pieces: Pieces,
    field: PieceField,
    /// The piece of each cluster.
    numbers: Vec<usize>,
    clusters: Vec<Cluster>,
    picked: Vec<f64>,
    /// Meshes in memory, by piece.
    kept: Mutex<HashMap<usize, TetMesh>>,
}

impl PieceSource {
    /// The mesh of a piece, of its data if that is at hand.
    fn mesh(&self, piece: usize, data: Option<MeshData>) -> Result<TetMesh, Error> {
        let path = &self.pieces.files[piece].path;
        let data = match data {
            Some(data) => data,
            None => read_piece(path)?,
        };
        mesh_of(data, &self.field).map_err(|error| match error {
            Error::Invalid { what, help } => Error::Format {
                path: path.clone(),
                at: "the piece".into(),
                what,
                help,
            },
            other => other,
        })
    }
}

impl ClusterSource for PieceSource {
    fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    fn field(&self) -> (&str, Association) {
        (&self.field.name, self.field.association)
    }

    fn picked(&self) -> &[f64] {
        &self.picked
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        let piece = self.numbers[cluster];
        let kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(mesh) = kept.get(&piece) {
            return Ok(mesh.clone());
        }
        drop(kept);
        self.mesh(piece, None)
    }
}
