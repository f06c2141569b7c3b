//! Files that list the pieces of a mesh, for who reads each piece by itself: processes that have some pieces each.
//!
//! [`list_pieces`] says which files there are and how large they are, and reads none; [`read_piece`] reads one.
//! Pieces agree about what is between them: points where they lie, to the last bit, and faces with four
//! corners and more, which are cut by where their corners lie ([`read_piece`]). [`choose_field`] chooses a field that
//! all mean.

use std::path::{Path, PathBuf};

use tetrascope_core::Error;
use tetrascope_core::mesh::Association;

use crate::collection::parts_of_step;
use crate::image::extension;
use crate::mesh_data::MeshField;
use crate::source::{Source, open_file};
use crate::steps::{StepChoice, without_steps};
use crate::vtu::{self, Listed};
use crate::{MeshData, is_collection};

/// The pieces of a mesh.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Pieces {
    /// Their files.
    pub files: Vec<PieceFile>,
    /// Whether a field may be absent in some of them, and is then NaN there; otherwise it has to be in all of them.
    pub all_fields: bool,
    /// Omissions and choices, one sentence each.
    pub notes: Vec<String>,
}

/// A piece's file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PieceFile {
    /// Where it is.
    pub path: PathBuf,
    /// How many bytes it has.
    pub bytes: u64,
}

/// A field that a piece offers.
#[derive(Clone, Debug, PartialEq)]
pub struct PieceField {
    /// Its name in the file.
    pub name: String,
    /// Where its values are.
    pub association: Association,
    /// The least and greatest finite value that volume cells of the piece use, if there is any.
    pub range: Option<(f64, f64)>,
}

/// The pieces that a `.pvtu` or `.vtm` file lists, or a `.pvd` file for one time, the first unless `step` chooses
/// another; a `.vtu`, `.vts` or `.vtr` file is one piece.
///
/// # Errors
/// [`Error::Io`] when a file cannot be read, [`Error::Format`] when the list makes no sense or is of another format,
/// [`Error::Invalid`] for a time step that there is not.
pub fn list_pieces(path: &Path, step: Option<StepChoice>) -> Result<Pieces, Error> {
    let mut found = Pieces {
        files: Vec::new(),
        all_fields: false,
        notes: Vec::new(),
    };
    if !is_collection(path) {
        if step.is_some() {
            return Err(without_steps(path));
        }
        found.add(path.to_owned())?;
        return Ok(found);
    }
    if extension(path) != "pvd" {
        return Err(Error::Format {
            path: path.to_owned(),
            at: "its name".into(),
            what: "a list of a series does not list pieces".into(),
            help: Some("give the file of one step".into()),
        });
    }
    let (files, times, number) = parts_of_step(path, step)?;
    if times.len() > 1 {
        let (count, time) = (times.len(), times[number]);
        let which = match step {
            None => "the first is drawn",
            Some(_) => "one is drawn",
        };
        found.notes.push(format!(
            "the file lists {count} time steps: {which}, at {time}"
        ));
    }
    files.into_iter().try_for_each(|file| found.add(file))?;
    Ok(found)
}

impl Pieces {
    /// Adds a file, or the files that it lists.
    fn add(&mut self, path: PathBuf) -> Result<(), Error> {
        const LISTS: [&str; 3] = ["pvtu", "vtm", "vtmb"];
        let mut files = vec![path.clone()];
        if LISTS.contains(&&*extension(&path)) {
            let listed = Listed::of(Source::open(&path)?)?.ok_or_else(|| Error::Format {
                path: path.clone(),
                at: "byte 0".into(),
                what: "the file does not list the pieces of an unstructured mesh or blocks".into(),
                help: Some("give a .pvtu, .vtm or .pvd file".into()),
            })?;
            self.all_fields |= listed.all_fields;
            self.notes.extend(listed.notes);
            files = listed.files;
        }
        for path in files {
            let (_, bytes) = open_file(&path)?;
            self.files.push(PieceFile { path, bytes });
        }
        Ok(())
    }
}

/// Reads a piece of a mesh, with all its fields and without ghosts. It may have no cells, or none with a volume.
///
/// Where cells are not all tetrahedra, points are in the order of their places, by which
/// [`TetMesh`](tetrascope_core::TetMesh) and polyhedra cut faces: two pieces cut the faces between them alike.
///
/// # Errors
/// As [`read_mesh`](crate::read_mesh).
pub fn read_piece(path: &Path) -> Result<MeshData, Error> {
    vtu::read_part(Source::open(path)?)
}

/// The fields that a piece offers.
pub fn piece_fields(data: &MeshData) -> Vec<PieceField> {
    let fields = data.fields.iter();
    fields
        .map(|field| PieceField {
            name: field.name.clone(),
            association: field.association,
            range: field.range,
        })
        .collect()
}

/// Chooses a field of a mesh by the fields of its pieces, each a list as [`piece_fields`] gives it, as
/// [`MeshData::choose`] does: the field, with the range of all pieces, and what is to be said about the choice.
///
/// # Errors
/// As [`MeshData::choose`].
pub fn choose_field(
    pieces: &[Vec<PieceField>],
    all_fields: bool,
    name: Option<&str>,
) -> Result<(PieceField, Option<String>), Error> {
    let mut together: Vec<(PieceField, usize)> = Vec::new();
    for field in pieces.iter().flatten() {
        let is_it = |(known, _): &&mut (PieceField, usize)| {
            (&known.name, known.association) == (&field.name, field.association)
        };
        match together.iter_mut().find(is_it) {
            Some((known, count)) => {
                *count += 1;
                known.range = match (known.range, field.range) {
                    (Some((a, b)), Some((c, d))) => Some((a.min(c), b.max(d))),
                    (one, other) => one.or(other),
                };
            }
            None => together.push((field.clone(), 1)),
        }
    }
    together.retain(|(_, count)| all_fields || *count == pieces.len());
    let fields = together
        .iter()
        .map(|(field, _)| MeshField::described(field));
    let described = MeshData {
        fields: fields.collect(),
        ..MeshData::default()
    };
    let (index, note) = described.choose(name)?;
    Ok((together.swap_remove(index).0, note))
}
