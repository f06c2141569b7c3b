//! Clusters in memory: those that are drawn, and those that stay for the next frame.

use std::sync::Arc;

use tetrascope_core::clusters::{Cluster, MeshClusters};
use tetrascope_core::{Appearance, Error};

use crate::mesh::Caster;

/// A packed cluster.
pub(super) type Part = Arc<Caster>;

/// Bytes of a cluster while it is read and packed, for each cell and point: what it is read from, its mesh
/// with the adjacency, and what of them `mesh::packed` makes.
///
/// These bounds and those below are upper ones: 16 clusters of 250 000 cells, all of them kept and four read at
/// once, took 380 MB with the picture and the program, and 660 MB by these numbers.
const BYTES_PER_CELL: u64 = 160;
const BYTES_PER_POINT: u64 = 160;

/// Bytes of a packed cluster and its mesh that stay.
const KEPT_PER_CELL: u64 = 100;
const KEPT_PER_POINT: u64 = 80;

/// Clusters that stay in memory, as many as there is room for: those that are drawn first.
#[derive(Debug)]
pub(super) struct Kept {
    parts: Vec<Option<Part>>,
    sizes: Vec<u64>,
    bytes: u64,
    /// Bytes of the largest while it is read.
    largest: u64,
    /// Bytes that may be used.
    memory: u64,
}

impl Kept {
    /// Nothing yet.
    pub(super) fn new(clusters: &MeshClusters, memory: u64) -> Result<Kept, Error> {
        let all = clusters.source().clusters();
        let size = |cluster: &Cluster, per_cell: u64, per_point: u64| {
            u64::from(cluster.cells) * per_cell + u64::from(cluster.points) * per_point
        };
        let working = all.iter().map(|c| size(c, BYTES_PER_CELL, BYTES_PER_POINT));
        let largest = working.max().unwrap_or(0);
        // An eighth is for runs (`room_of_runs`), and what is left for the picture.
        if largest > memory / 2 {
            let mb = |bytes: u64| bytes.div_ceil(1_000_000);
            return Err(Error::Invalid {
                what: format!(
                    "the largest cluster takes {} MB while it is read, more than half of the {} MB that may be used",
                    mb(largest),
                    mb(memory)
                ),
                help: Some("allow more `memory`, or cut the mesh into smaller clusters".into()),
            });
        }
        Ok(Kept {
            parts: vec![None; all.len()],
            sizes: all
                .iter()
                .map(|c| size(c, KEPT_PER_CELL, KEPT_PER_POINT))
                .collect(),
            bytes: 0,
            largest,
            memory,
        })
    }

    /// How many clusters are drawn at once: `most`, or as many as half of the memory holds.
    pub(super) fn batch(&self, most: usize) -> usize {
        let fit = (self.memory / 2) / self.largest.max(1);
        (fit as usize).clamp(1, most)
    }

    /// A cluster, if it is here.
    pub(super) fn get(&self, cluster: usize) -> Option<Part> {
        self.parts[cluster].clone()
    }

    /// Keeps a cluster if there is room in a quarter of the memory.
    pub(super) fn keep(&mut self, cluster: usize, part: Part) {
        if self.parts[cluster].is_none() && self.bytes + self.sizes[cluster] <= self.memory / 4 {
            self.bytes += self.sizes[cluster];
            self.parts[cluster] = Some(part);
        }
    }

    /// Shows what is kept in another look.
    pub(super) fn restyle(&mut self, appearance: &Appearance) {
        for part in self.parts.iter_mut().flatten() {
            *part = Arc::new(part.restyled(appearance));
        }
    }

    /// Forgets all.
    pub(super) fn clear(&mut self) {
        self.parts.iter_mut().for_each(|part| *part = None);
        self.bytes = 0;
    }

    /// Bytes of what is kept.
    pub(super) fn bytes(&self) -> u64 {
        self.bytes
    }
}
