//! The part of a mesh that a rank has.

use std::ops::Range;
use std::sync::Arc;

use tetrascope_core::clusters::{Cluster, ClusterSource, MeshClusters};
use tetrascope_core::mesh::Association;
use tetrascope_core::{Error, TetMesh};
use tetrascope_f32::Domain;

use crate::partition::by_bytes;

/// Some clusters of a mesh, and what all ranks know of the whole.
#[derive(Clone, Debug)]
pub struct Share {
    /// The clusters of this rank; perhaps none.
    pub own: MeshClusters,
    /// The box and range of the whole mesh, the same at every rank.
    pub domain: Domain,
}

impl Share {
    /// Those of a mesh's clusters whose numbers are in `numbers`.
    ///
    /// # Errors
    /// Those of [`MeshClusters::new`].
    ///
    /// # Panics
    /// If there is no such cluster.
    pub fn of(
        whole: &MeshClusters,
        numbers: impl IntoIterator<Item = usize>,
    ) -> Result<Share, Error> {
        let source = whole.source().clone();
        let numbers: Vec<usize> = numbers.into_iter().collect();
        let clusters = numbers.iter().map(|&number| source.clusters()[number]);
        Ok(Share {
            own: MeshClusters::new(Arc::new(Chosen {
                clusters: clusters.collect(),
                numbers,
                source,
            }))?,
            domain: Domain {
                bounds: whole.bounds(),
                scalar_range: whole.scalar_range(),
            },
        })
    }

    /// The clusters of one of so many ranks, by their bytes.
    ///
    /// # Errors
    /// As [`Share::of`].
    pub fn by_bytes(whole: &MeshClusters, rank: usize, ranks: usize) -> Result<Share, Error> {
        Share::of(whole, spread(whole, ranks)[rank].clone())
    }
}

/// The clusters of each of so many ranks, by their bytes.
pub(crate) fn spread(whole: &MeshClusters, ranks: usize) -> Vec<Range<usize>> {
    // As they are stored: 16 bytes for a tetrahedron, and 16 for a point with its value.
    let bytes = |cluster: &Cluster| 16 * (u64::from(cluster.cells) + u64::from(cluster.points));
    let bytes: Vec<u64> = whole.source().clusters().iter().map(bytes).collect();
    by_bytes(&bytes, ranks)
}

/// Some clusters of a source.
#[derive(Debug)]
struct Chosen {
    source: Arc<dyn ClusterSource>,
    numbers: Vec<usize>,
    clusters: Vec<Cluster>,
}

impl ClusterSource for Chosen {
    fn clusters(&self) -> &[Cluster] {
        &self.clusters
    }

    fn field(&self) -> (&str, Association) {
        self.source.field()
    }

    fn picked(&self) -> &[f64] {
        self.source.picked()
    }

    fn read(&self, cluster: usize) -> Result<TetMesh, Error> {
        self.source.read(self.numbers[cluster])
    }
}
