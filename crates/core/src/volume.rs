//! A mesh or a grid, and the box around it.

use glam::DVec3;

use crate::clusters::MeshClusters;
use crate::grid::GridStream;
use crate::{Grid, TetMesh};

/// Whether a scalar is a value: finite, also where it is kept as f32.
///
/// One that is not (NaN, an infinity, a double beyond f32 such as a fill value of 1e300) is not a
/// value: a cell with such a scalar at a corner is transparent, in every renderer.
#[inline]
pub fn is_value(scalar: f64) -> bool {
    (scalar as f32).is_finite()
}

/// The volume that is drawn: a tetrahedral mesh or a regular grid.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum Volume {
    /// An unstructured mesh, all of it tetrahedra.
    Mesh(TetMesh),
    /// A regular grid of samples.
    Grid(Grid),
    /// A regular grid that is read in parts, as it may not fit in memory.
    Stream(GridStream),
    /// A tetrahedral mesh that is read in clusters, as it may not fit in memory.
    Clusters(MeshClusters),
}

/// The kinds of volume that settings may be for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum VolumeKind {
    /// Meshes in memory.
    Mesh,
    /// Regular grids, in memory or not.
    Grid,
    /// Meshes that are read in clusters.
    Clusters,
}

impl VolumeKind {
    /// "meshes in memory", "regular grids", "meshes in clusters".
    pub fn name(self) -> &'static str {
        match self {
            VolumeKind::Mesh => "meshes in memory",
            VolumeKind::Grid => "regular grids",
            VolumeKind::Clusters => "meshes in clusters",
        }
    }
}

impl Volume {
    /// Which kind it is of.
    pub fn kind(&self) -> VolumeKind {
        match self {
            Volume::Mesh(_) => VolumeKind::Mesh,
            Volume::Grid(_) | Volume::Stream(_) => VolumeKind::Grid,
            Volume::Clusters(_) => VolumeKind::Clusters,
        }
    }

    /// The smallest axis-aligned box around everything that can be drawn.
    pub fn bounds(&self) -> Bounds {
        match self {
            Volume::Mesh(mesh) => mesh.bounds(),
            Volume::Grid(grid) => grid.bounds(),
            Volume::Stream(stream) => stream.source().lattice().bounds(),
            Volume::Clusters(clusters) => clusters.bounds(),
        }
    }

    /// The least and greatest finite scalar, if there is any.
    pub fn scalar_range(&self) -> Option<(f64, f64)> {
        match self {
            Volume::Mesh(mesh) => mesh.scalar_range(),
            Volume::Grid(grid) => grid.scalar_range(),
            Volume::Stream(stream) => stream.scalar_range(),
            Volume::Clusters(clusters) => clusters.scalar_range(),
        }
    }

    /// Points whose convex hull is that of the volume; around a mesh that is read in clusters, that of the
    /// clusters' boxes.
    pub fn outline(&self) -> Box<dyn Iterator<Item = DVec3> + '_> {
        match self {
            Volume::Mesh(mesh) => {
                // A cell's first, to which cameras are relative, then each once.
                let first = mesh.tetrahedra().first().map(|cell| cell[0]);
                let points = first.into_iter().chain(mesh.points_in_use());
                Box::new(points.map(|point| mesh.points()[point as usize]))
            }
            Volume::Grid(grid) => Box::new(grid.lattice().corners().into_iter()),
            Volume::Stream(stream) => Box::new(stream.source().lattice().corners().into_iter()),
            Volume::Clusters(clusters) => {
                let boxes = clusters.source().clusters().iter().map(|c| c.bounds);
                let boxes = boxes.filter(|bounds| !bounds.is_empty());
                Box::new(boxes.flat_map(|bounds| bounds.corners()))
            }
        }
    }

    /// Three edges of the box around the volume, world units: a mesh's box has the world's
    /// axes, a grid's its own.
    pub fn box_axes(&self) -> [DVec3; 3] {
        let lattice = match self {
            Volume::Mesh(_) | Volume::Clusters(_) => {
                let size = self.bounds().size();
                return [DVec3::X * size.x, DVec3::Y * size.y, DVec3::Z * size.z];
            }
            Volume::Grid(grid) => *grid.lattice(),
            Volume::Stream(stream) => stream.source().lattice(),
        };
        let [origin, x, y, _, z, ..] = lattice.corners();
        [x, y, z].map(|corner| corner - origin)
    }

    /// How many cells (tetrahedra or voxel cells) there are.
    pub fn cell_count(&self) -> usize {
        match self {
            Volume::Mesh(mesh) => mesh.cell_count(),
            Volume::Grid(grid) => grid.cell_count(),
            Volume::Stream(stream) => stream.source().lattice().cells().iter().product(),
            Volume::Clusters(clusters) => clusters.cell_count(),
        }
    }
}

/// An axis-aligned box in world space. Empty when `min > max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The least corner.
    pub min: DVec3,
    /// The greatest corner.
    pub max: DVec3,
}

impl Bounds {
    /// The box that contains nothing.
    pub const EMPTY: Bounds = Bounds {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
    };

    /// The smallest box around `points`.
    pub fn of(points: impl IntoIterator<Item = DVec3>) -> Bounds {
        points.into_iter().fold(Bounds::EMPTY, |bounds, p| Bounds {
            min: bounds.min.min(p),
            max: bounds.max.max(p),
        })
    }

    /// The eight corners, x fastest.
    pub fn corners(&self) -> [DVec3; 8] {
        std::array::from_fn(|i| {
            let pick = |axis: usize| match i >> axis & 1 {
                0 => self.min[axis],
                _ => self.max[axis],
            };
            DVec3::new(pick(0), pick(1), pick(2))
        })
    }

    /// Whether the box contains no point.
    pub fn is_empty(&self) -> bool {
        !self.min.cmple(self.max).all()
    }

    /// The middle; the origin for an empty box.
    pub fn center(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            // Halves first: the sum of two huge corners could overflow.
            self.min * 0.5 + self.max * 0.5
        }
    }

    /// The edge lengths; zero for an empty box.
    pub fn size(&self) -> DVec3 {
        if self.is_empty() {
            DVec3::ZERO
        } else {
            self.max - self.min
        }
    }

    /// The length of the diagonal.
    pub fn diagonal(&self) -> f64 {
        self.size().length()
    }
}
