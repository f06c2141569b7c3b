//! Tetrahedral meshes that need not fit in memory: they are read cluster by cluster.
//!
//! A cluster is a run of cells along a Hilbert curve through the mesh's box: near each other, and about
//! as many as in any other cluster. It is a mesh of its own with the points that its cells use; two clusters
//! have the points of the faces between them in common, to the last bit.
//!
//! 1. [`hilbert`] is the curve.
//! 2. [`cut`] cuts cells that can be listed again and again ([`CellSource`]) into clusters, in
//!    bounded memory.
//! 3. A [`ClusterSource`] says what is known of each cluster and reads it; [`MeshClusters`] is a volume
//!    of them.

pub mod cut;
pub mod hilbert;

use std::fmt::Debug;
use std::sync::Arc;

use crate::mesh::Association;
use crate::{Bounds, Error, Scalars, TetMesh, is_value};

pub use cut::{CellSource, Cut, Part, cut};

/// The facts about a cluster that are known without reading it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cluster {
    /// How many tetrahedra it has.
    pub cells: u32,
    /// How many points its cells use.
    pub points: u32,
    /// The box around these points, world space.
    pub bounds: Bounds,
    /// The least and greatest finite scalar of its cells, if there is any.
    pub scalar_range: Option<(f64, f64)>,
}

/// A mesh that is read cluster by cluster.
pub trait ClusterSource: Debug + Send + Sync {
    /// All clusters, along the curve; never changes.
    fn clusters(&self) -> &[Cluster];

    /// The name of the field, and where its values are.
    fn field(&self) -> (&str, Association);

    /// Some of the values, evenly spread: at points or in cells.
    fn picked(&self) -> &[f64];

    /// A checksum that stands for all clusters, if there is one.
    fn checksum(&self) -> Option<u32> {
        None
    }

    /// The cluster with this number, which exists.
    ///
    /// # Errors
    /// Those of reading, and of making a mesh of what was read.
    fn read(&self, cluster: usize) -> Result<TetMesh, Error>;
}

/// A mesh that stays where it is, in a file as a rule, and is read in clusters.
///
/// Cheap to clone: clones share the source.
#[derive(Clone, Debug)]
pub struct MeshClusters {
    source: Arc<dyn ClusterSource>,
    bounds: Bounds,
    scalar_range: Option<(f64, f64)>,
    cells: u64,
}

impl MeshClusters {
    /// The clusters of a source, none of which is read.
    ///
    /// # Errors
    /// [`Error::Invalid`] for more cells than this machine counts.
    pub fn new(source: Arc<dyn ClusterSource>) -> Result<MeshClusters, Error> {
        let clusters = source.clusters();
        let boxes = clusters.iter().map(|cluster| cluster.bounds);
        let boxes = boxes.filter(|bounds| !bounds.is_empty());
        let bounds = Bounds::of(boxes.flat_map(|bounds| [bounds.min, bounds.max]));
        let ranges = clusters.iter().filter_map(|cluster| cluster.scalar_range);
        let join = |a: (f64, f64), b: (f64, f64)| (a.0.min(b.0), a.1.max(b.1));
        let scalar_range = ranges.reduce(join);
        let cells = clusters
            .iter()
            .map(|cluster| u64::from(cluster.cells))
            .sum();
        if usize::try_from(cells).is_err() {
            return Err(Error::invalid(format!("a mesh of {cells} cells")));
        }
        Ok(MeshClusters {
            source,
            bounds,
            scalar_range,
            cells,
        })
    }

    /// A mesh in memory, cut into clusters of at most `most_cells` each, 1 or more.
    ///
    /// # Errors
    /// Those of [`cut`].
    pub fn of(mesh: &TetMesh, most_cells: u32) -> Result<MeshClusters, Error> {
        let mut parts = InMemory {
            meshes: Vec::new(),
            clusters: Vec::new(),
            picked: Vec::new(),
            name: mesh.scalars().name.clone(),
            association: mesh.scalars().association,
        };
        let limits = Cut {
            most_cells,
            ..Cut::default()
        };
        cut(mesh, &limits, &mut |part| {
            parts.clusters.push(part.cluster());
            parts.picked.extend(part.values.iter().step_by(PICKED));
            parts.meshes.push(part.into_mesh(parts.name.clone())?);
            Ok(())
        })?;
        MeshClusters::new(Arc::new(parts))
    }

    /// Where the clusters come from.
    pub fn source(&self) -> &Arc<dyn ClusterSource> {
        &self.source
    }

    /// The box around all clusters.
    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    /// The least and greatest finite scalar, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        self.scalar_range
    }

    /// How many tetrahedra all clusters have.
    pub fn cell_count(&self) -> usize {
        self.cells as usize
    }
}

/// One value of so many is picked of a mesh in memory.
const PICKED: usize = 64;

/// Clusters that are in memory already.
#[derive(Debug)]
struct InMemory {
    meshes: Vec<TetMesh>,
    clusters: Vec<Cluster>,
    picked: Vec<f64>,
    name: String,
    association: Association,
}

impl ClusterSource for InMemory {
    fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    fn field(&self) -> (&str, Association) {
        (&self.name, self.association)
    }

    fn picked(&self) -> &[f64] {
        &self.picked
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        Ok(self.meshes[cluster].clone())
    }
}

impl Part {
    /// The facts about this part.
    pub fn cluster(&self) -> Cluster {
        let finite = self.values.iter().copied().filter(|v| is_value(*v));
        let range = finite.fold(None, |range: Option<(f64, f64)>, v| match range {
            None => Some((v, v)),
            Some((low, high)) => Some((low.min(v), high.max(v))),
        });
        Cluster {
            cells: self.tetrahedra.len() as u32,
            points: self.points.len() as u32,
            bounds: Bounds::of(self.points.iter().copied()),
            scalar_range: range,
        }
    }

    /// The part as a mesh.
    ///
    /// # Errors
    /// Those of [`TetMesh::from_tetrahedra`].
    pub fn into_mesh(self, name: String) -> Result<TetMesh, Error> {
        let scalars = Scalars {
            name,
            association: self.association,
            values: self.values,
        };
        TetMesh::from_tetrahedra(self.points, self.tetrahedra, scalars)
    }
}

#[cfg(test)]
mod tests;
