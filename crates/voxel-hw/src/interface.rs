//! The interface that the paper proposes to add to OpenGL (section 5.5), for programs that have
//! no mesh but corners, one after the other.

use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::{Interpolation, Lattice};
use tetrascope_core::{Bounds, Error, is_value, number};

use crate::cell::Buffers;
use crate::face::Number;
use crate::options::{Arithmetic, VoxelizerOptions, voxel_count};
use crate::source::{Polyhedron, ToVoxels, tetrahedron};
use crate::space::Space;
use crate::volume::VoxelVolume;
use crate::voxelizer::{AccumulationBuffer, Voxelizer};

/// Cubic voxels over `bounds`, as small as a buffer of `prefsize` voxels allows: no more along each
/// axis than that, and no more than the box needs.
///
/// "For example the user space is ⟨100, 20, 60⟩ and the volume buffer specified is
/// ⟨100, 100, 100⟩, then the actual volume buffer is ⟨100, 20, 60⟩."
///
/// # Errors
/// A box without volume, and numbers of voxels that are refused.
pub fn voxels_over(bounds: &Bounds, prefsize: [usize; 3]) -> Result<Lattice, Error> {
    let size = bounds.size();
    if !(size.is_finite() && size.cmpgt(DVec3::ZERO).all()) {
        return Err(Error::Invalid {
            what: format!(
                "the user space from {} to {} has no volume",
                number::vector(bounds.min),
                number::vector(bounds.max)
            ),
            help: Some("its first corner is less than its second along each axis".into()),
        });
    }
    // What fits along each axis may be more than fits in all: that is for the actual voxels.
    for n in prefsize {
        voxel_count([n, 1, 1])?;
    }
    let sides = size / DVec3::from_array(prefsize.map(|n| n as f64));
    let side = sides.max_element();
    let dims = [0, 1, 2].map(|axis| {
        // A whole number may have been rounded up.
        let voxels = size[axis] / side * (1.0 - 4.0 * f64::EPSILON);
        (voxels.ceil() as usize).clamp(1, prefsize[axis])
    });
    voxel_count(dims)?;
    let lattice = Lattice {
        dims,
        origin: bounds.min + 0.5 * side,
        spacing: DVec3::splat(side),
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Nearest,
    };
    lattice.validate()?;
    Ok(lattice)
}

/// The same voxels and a layer more on each side, for a mesh to fade into, `interpolation` between them.
///
/// # Errors
/// More voxels than there may be.
pub fn with_border(lattice: &Lattice, interpolation: Interpolation) -> Result<Lattice, Error> {
    let bordered = Lattice {
        dims: lattice.dims.map(|voxels| voxels + 2),
        origin: lattice.origin - lattice.linear() * DVec3::ONE,
        interpolation,
        ..*lattice
    };
    voxel_count(bordered.dims)?;
    bordered.validate()?;
    Ok(bordered)
}

/// A context of voxelization, in the manner of OpenGL.
///
/// | the paper's routine | here |
/// |---|---|
/// | `vox_prefsize()` | [`prefsize`](VoxelContext::prefsize) |
/// | `vox_ortho()` | [`ortho`](VoxelContext::ortho) |
/// | `vox_bgntetra()` | [`begin_tetra`](VoxelContext::begin_tetra) |
/// | `v3f()` and the like | [`vertex`](VoxelContext::vertex) |
/// | `vox_endtetra()` | [`end_tetra`](VoxelContext::end_tetra) |
///
/// [`scalar_range`](VoxelContext::scalar_range) is ours: voxels are scaled to it while they are
/// written. A call that fails changes nothing.
///
/// ```
/// use tetrascope_core::glam::DVec3;
/// use tetrascope_voxel_hw::{VoxelContext, VoxelizerOptions};
///
/// let mut context = VoxelContext::new(VoxelizerOptions::default())?;
/// context.prefsize([100, 100, 100])?;
/// context.ortho(DVec3::ZERO, DVec3::new(100.0, 20.0, 60.0))?;
/// context.scalar_range(0.0, 1.0)?;
/// context.begin_tetra()?;
/// context.vertex(DVec3::ZERO, 0.0)?;
/// context.vertex(DVec3::X * 100.0, 1.0)?;
/// context.vertex(DVec3::Y * 20.0, 0.0)?;
/// context.vertex(DVec3::Z * 60.0, 0.0)?;
/// context.end_tetra()?;
/// assert_eq!(context.finish()?.dims(), [100, 20, 60]);
/// # Ok::<(), tetrascope_core::Error>(())
/// ```
#[derive(Debug)]
pub struct VoxelContext {
    voxelizer: Voxelizer,
    prefsize: Option<[usize; 3]>,
    user_space: Option<Bounds>,
    scalar_range: Option<(f64, f64)>,
    /// From the first cell on.
    target: Option<Filling>,
    /// The corners of the cell that was begun.
    open: Option<Vec<(DVec3, f64)>>,
}

#[derive(Debug)]
struct Filling {
    buffer: AccumulationBuffer,
    to_voxels: ToVoxels,
    numbers: Numbers,
    cells: usize,
}

#[derive(Debug)]
enum Numbers {
    Fixed(Buffers<i32>),
    Float(Buffers<f64>),
}

/// An error of a program that uses the context, with what to do instead.
fn misuse(what: impl Into<String>, help: &str) -> Error {
    Error::Usage {
        what: what.into(),
        help: Some(help.into()),
    }
}

impl VoxelContext {
    /// A context in which nothing is known yet; of the options, `cells` does not matter.
    ///
    /// # Errors
    /// Those of [`Voxelizer::new`].
    pub fn new(options: VoxelizerOptions) -> Result<VoxelContext, Error> {
        Ok(VoxelContext {
            scalar_range: options.scalar_range,
            voxelizer: Voxelizer::new(options)?,
            prefsize: None,
            user_space: None,
            target: None,
            open: None,
        })
    }

    /// The most voxels along each axis (`vox_prefsize`).
    ///
    /// # Errors
    /// No voxels or too many, and a call after the first cell.
    pub fn prefsize(&mut self, voxels: [usize; 3]) -> Result<(), Error> {
        self.check_empty("the size of the volume buffer")?;
        for n in voxels {
            voxel_count([n, 1, 1])?;
        }
        self.prefsize = Some(voxels);
        Ok(())
    }

    /// The user space, which the voxels cover (`vox_ortho`).
    ///
    /// # Errors
    /// A box without volume, and a call after the first cell.
    pub fn ortho(&mut self, low: DVec3, high: DVec3) -> Result<(), Error> {
        self.check_empty("the user space")?;
        let bounds = Bounds {
            min: low,
            max: high,
        };
        voxels_over(&bounds, [1; 3])?;
        self.user_space = Some(bounds);
        Ok(())
    }

    /// The scalars between which voxels lie; others become the nearer one.
    ///
    /// # Errors
    /// Numbers that are not finite or in the wrong order, and a call after the first cell.
    pub fn scalar_range(&mut self, low: f64, high: f64) -> Result<(), Error> {
        self.check_empty("the scalar range")?;
        if !(is_value(low) && is_value(high) && low <= high) {
            return Err(misuse(
                format!("a scalar range of {}", number::range((low, high))),
                "give two numbers, the lower one first",
            ));
        }
        self.scalar_range = Some((low, high));
        Ok(())
    }

    fn check_empty(&self, what: &str) -> Result<(), Error> {
        if self.open.is_none() && self.target.is_none() {
            return Ok(());
        }
        Err(misuse(
            format!("{what} cannot change once there is a tetrahedron"),
            "set it before the first begin_tetra, or begin a new context",
        ))
    }

    /// Begins a tetrahedron (`vox_bgntetra`).
    ///
    /// # Errors
    /// A tetrahedron that has not ended; no size, user space or scalar range; no memory for so
    /// many voxels.
    pub fn begin_tetra(&mut self) -> Result<(), Error> {
        if self.open.is_some() {
            return Err(misuse(
                "a tetrahedron begins within another one",
                "call end_tetra before the next begin_tetra",
            ));
        }
        if self.target.is_none() {
            self.target = Some(self.filling()?);
        }
        self.open = Some(Vec::new());
        Ok(())
    }

    fn filling(&self) -> Result<Filling, Error> {
        let missing = |what: &str, call: &str| {
            misuse(
                format!("there is no {what} yet"),
                &format!("call {call} before the first begin_tetra"),
            )
        };
        let prefsize = self.prefsize;
        let prefsize = prefsize.ok_or_else(|| missing("size of the volume buffer", "prefsize"))?;
        let user_space = self.user_space.as_ref();
        let user_space = user_space.ok_or_else(|| missing("user space", "ortho"))?;
        let range = self.scalar_range;
        let range = range.ok_or_else(|| missing("scalar range", "scalar_range"))?;
        let lattice = voxels_over(user_space, prefsize)?;
        let space = Space::new(&lattice, self.voxelizer.options().columns);
        Ok(Filling {
            buffer: AccumulationBuffer::new(space, range)?,
            to_voxels: ToVoxels::new(&space.turned()),
            numbers: match self.voxelizer.options().arithmetic {
                Arithmetic::FixedPoint => Numbers::Fixed(Buffers::default()),
                Arithmetic::Float => Numbers::Float(Buffers::default()),
            },
            cells: 0,
        })
    }

    /// A corner in user space and its scalar; a cell with a scalar that is not a value is left out.
    ///
    /// # Errors
    /// A corner outside of begin and end, a fifth one, and a place that is not finite.
    pub fn vertex(&mut self, position: DVec3, scalar: f64) -> Result<(), Error> {
        let Some(corners) = &mut self.open else {
            return Err(misuse(
                "a vertex that belongs to no tetrahedron",
                "call begin_tetra first",
            ));
        };
        if !position.is_finite() {
            return Err(misuse(
                format!("a vertex at {}", number::vector(position)),
                "give finite coordinates",
            ));
        }
        if corners.len() == 4 {
            return Err(misuse(
                "a tetrahedron of more than four vertices",
                "call end_tetra, then begin_tetra for the next one",
            ));
        }
        corners.push((position, scalar));
        Ok(())
    }

    /// Ends a tetrahedron and voxelizes it (`vox_endtetra`). Both orientations are accepted.
    ///
    /// # Errors
    /// No tetrahedron was begun, fewer than four vertices, and a cell that is wider than fixed-point
    /// numbers hold.
    pub fn end_tetra(&mut self) -> Result<(), Error> {
        let (Some(corners), Some(filling)) = (&self.open, &mut self.target) else {
            return Err(misuse(
                "a tetrahedron ends that did not begin",
                "call begin_tetra and give four vertices first",
            ));
        };
        if corners.len() < 4 {
            return Err(misuse(
                format!("a tetrahedron ends after {} vertices", corners.len()),
                "give four",
            ));
        }
        let places = corners.iter().map(|(p, _)| filling.to_voxels.place(*p));
        let mut cell = Polyhedron {
            corners: places.collect(),
            scalars: corners.iter().map(|(_, scalar)| *scalar).collect(),
            faces: tetrahedron().to_vec(),
            orientation: 0,
        };
        let exact: Vec<_> = cell.corners.iter().map(|p| f64::corner(*p, 0.0)).collect();
        cell.orientation = f64::volume_sign(&exact, &cell.faces);
        let buffer = &mut filling.buffer;
        match &mut filling.numbers {
            Numbers::Fixed(buffers) => {
                self.voxelizer
                    .add_cell(filling.cells, &cell, buffers, buffer)?;
            }
            Numbers::Float(buffers) => {
                self.voxelizer
                    .add_cell(filling.cells, &cell, buffers, buffer)?;
            }
        }
        filling.cells += 1;
        self.open = None;
        Ok(())
    }

    /// The voxels of all tetrahedra.
    ///
    /// # Errors
    /// A tetrahedron that has not ended, no tetrahedra at all, and no memory.
    pub fn finish(self) -> Result<VoxelVolume, Error> {
        if self.open.is_some() {
            return Err(misuse(
                "the last tetrahedron did not end",
                "call end_tetra first",
            ));
        }
        let Some(filling) = self.target else {
            return Err(misuse(
                "there are no tetrahedra to voxelize",
                "call begin_tetra, vertex four times, and end_tetra for each",
            ));
        };
        filling.buffer.finish(&self.voxelizer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn over(size: [f64; 3], prefsize: [usize; 3]) -> Result<Lattice, Error> {
        let bounds = Bounds {
            min: DVec3::ONE,
            max: DVec3::ONE + DVec3::from(size),
        };
        voxels_over(&bounds, prefsize)
    }

    #[test]
    fn voxels_are_cubes_and_fit_in_the_buffer() {
        let cases = [
            ([100.0, 20.0, 60.0], [100, 100, 100], [100, 20, 60]),
            ([1.0, 0.2, 0.6], [100, 100, 100], [100, 20, 60]),
            ([100.0, 20.0, 60.0], [50, 100, 100], [50, 10, 30]),
            ([100.0, 20.0, 60.0], [100, 10, 100], [50, 10, 30]),
            ([3.0, 1.0, 1e-9], [10, 10, 10], [10, 4, 1]),
            ([0.3, 0.1, 0.1], [3, 3, 3], [3, 1, 1]),
        ];
        for (size, prefsize, dims) in cases {
            let lattice = over(size, prefsize).expect("valid");
            assert_eq!(lattice.dims, dims, "{size:?} in {prefsize:?}");
            let covered = lattice.bounds().size();
            assert!((covered - DVec3::from(size)).min_element() > -1e-12);
        }
    }

    #[test]
    fn sizes_of_nothing_are_refused() {
        for (size, prefsize) in [
            ([1.0, 1.0, 0.0], [4, 4, 4]),
            ([1.0, -1.0, 1.0], [4, 4, 4]),
            ([f64::NAN, 1.0, 1.0], [4, 4, 4]),
            ([f64::INFINITY, 1.0, 1.0], [4, 4, 4]),
            ([1.0, 1.0, 1.0], [4, 0, 4]),
            ([1.0, 1.0, 1.0], [4, 4, 1025]),
            ([1.0, 1.0, 1.0], [1024, 1024, 1024]),
            ([1.0, 1.0, 1.0], [usize::MAX; 3]),
        ] {
            let error = over(size, prefsize).expect_err("refused");
            assert!(error.help().is_some(), "{error}");
        }
    }

    fn context() -> VoxelContext {
        let mut context = VoxelContext::new(VoxelizerOptions::default()).expect("valid");
        context.prefsize([8; 3]).expect("valid");
        context
            .ortho(DVec3::ZERO, DVec3::splat(4.0))
            .expect("valid");
        context.scalar_range(0.0, 4.0).expect("valid");
        context
    }

    fn tetrahedron(context: &mut VoxelContext, corners: [DVec3; 4]) {
        context.begin_tetra().expect("begins");
        for corner in corners {
            context.vertex(corner, corner.x).expect("a corner");
        }
        context.end_tetra().expect("ends");
    }

    #[test]
    fn misuse_is_refused_in_words_and_changes_nothing() {
        let mut context = VoxelContext::new(VoxelizerOptions::default()).expect("valid");
        let refused = |result: Result<(), Error>, word: &str| {
            let error = result.expect_err("misuse");
            assert!(error.to_string().contains(word), "{error}");
            assert!(error.help().is_some(), "{error}");
        };
        refused(context.begin_tetra(), "size");
        refused(context.vertex(DVec3::ZERO, 0.0), "no tetrahedron");
        refused(context.end_tetra(), "did not begin");
        refused(context.prefsize([0, 8, 8]), "0 × 1 × 1");
        context.prefsize([8; 3]).expect("valid");
        refused(context.begin_tetra(), "user space");
        refused(context.ortho(DVec3::ZERO, DVec3::X), "no volume");
        context
            .ortho(DVec3::ZERO, DVec3::splat(4.0))
            .expect("valid");
        refused(context.begin_tetra(), "scalar range");
        refused(context.scalar_range(1.0, 0.0), "range");
        context.scalar_range(0.0, 4.0).expect("valid");

        context.begin_tetra().expect("all is set");
        refused(context.begin_tetra(), "within another");
        refused(context.prefsize([8; 3]), "cannot change");
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|c| 4.0 * c);
        for corner in &corners[..3] {
            context.vertex(*corner, corner.x).expect("a corner");
        }
        refused(context.end_tetra(), "after 3 vertices");
        refused(context.vertex(DVec3::NAN, 0.0), "NaN");
        context.vertex(corners[3], 0.0).expect("the fourth");
        refused(context.vertex(DVec3::ZERO, 0.0), "more than four");
        context.end_tetra().expect("four corners");
        refused(context.end_tetra(), "did not begin");
        refused(context.ortho(DVec3::ZERO, DVec3::ONE), "cannot change");
        let misused = context.finish().expect("voxels");

        let mut plain = self::context();
        tetrahedron(&mut plain, corners);
        assert!(misused == plain.finish().expect("voxels"));
    }

    #[test]
    fn nothing_and_a_part_are_refused() {
        assert!(context().finish().is_err());
        let mut part = context();
        part.begin_tetra().expect("begins");
        assert!(part.finish().is_err());
    }

    #[test]
    fn both_orientations_are_the_same_cell() {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z].map(|c| 3.9 * c);
        let [mut one, mut other] = [(); 2].map(|()| context());
        tetrahedron(&mut one, corners);
        let [a, b, c, d] = corners;
        tetrahedron(&mut other, [b, a, c, d]);
        let volume = one.finish().expect("voxels");
        assert!(volume == other.finish().expect("voxels"));
        assert!(volume.counts().writes > 50);
    }
}
