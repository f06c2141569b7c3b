//! NumPy's arrays, as Python has prepared them: one axis, contiguous, native byte order.

use std::sync::atomic::{AtomicBool, Ordering};

use numpy::{Element, PyArray1, PyArrayMethods as _, PyReadonlyArray1, PyUntypedArrayMethods as _};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use rayon::prelude::*;
use tetrascope::core::Error;
use tetrascope::core::glam::DVec3;
use tetrascope::core::grid::Samples;

/// Numbers are converted in pieces of this length, on all cores.
const PIECE: usize = 1 << 16;

/// A borrowed array of numbers of type `T`, if it is one.
fn view<'py, T: Element>(array: &Bound<'py, PyAny>) -> Option<PyReadonlyArray1<'py, T>> {
    let array = array.cast::<PyArray1<T>>().ok()?;
    // A slice of what is in another order would be read in that.
    array.is_c_contiguous().then(|| array.readonly())
}

fn unprepared(what: &str) -> PyErr {
    PyTypeError::new_err(format!(
        "{what} must be a contiguous array with one axis, of a number type that is read as it is"
    ))
}

/// `f64` of an array of 32- or 64-bit floats.
pub(crate) fn reals(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<f64>> {
    if let Some(view) = view::<f64>(array) {
        return Ok(view.as_slice()?.to_vec());
    }
    if let Some(view) = view::<f32>(array) {
        return Ok(view.as_slice()?.iter().map(|&x| x.into()).collect());
    }
    Err(unprepared(what))
}

/// Points of an array of three 32- or 64-bit floats for each.
pub(crate) fn points(array: &Bound<'_, PyAny>) -> PyResult<Vec<DVec3>> {
    fn of<T: Copy + Sync + Into<f64>>(numbers: &[T]) -> Vec<DVec3> {
        let (points, _) = numbers.as_chunks::<3>();
        let points = points.par_iter().with_min_len(PIECE);
        points
            .map(|&[x, y, z]| DVec3::new(x.into(), y.into(), z.into()))
            .collect()
    }
    if let Some(view) = view::<f64>(array) {
        return Ok(of(view.as_slice()?));
    }
    if let Some(view) = view::<f32>(array) {
        return Ok(of(view.as_slice()?));
    }
    Err(unprepared("points"))
}

/// Samples of a grid, in their own type where grids have it.
pub(crate) fn samples(array: &Bound<'_, PyAny>) -> PyResult<Samples> {
    if let Some(view) = view::<f32>(array) {
        return Ok(Samples::F32(view.as_slice()?.to_vec()));
    }
    if let Some(view) = view::<u8>(array) {
        return Ok(Samples::U8(view.as_slice()?.to_vec()));
    }
    if let Some(view) = view::<u16>(array) {
        return Ok(Samples::U16(view.as_slice()?.to_vec()));
    }
    if let Some(view) = view::<i16>(array) {
        return Ok(Samples::I16(view.as_slice()?.to_vec()));
    }
    Err(unprepared("samples"))
}

/// Bytes, such as types of cells.
pub(crate) fn bytes(array: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<u8>> {
    let view = view::<u8>(array).ok_or_else(|| unprepared(what))?;
    Ok(view.as_slice()?.to_vec())
}

/// A borrowed array of 32- or 64-bit integers.
pub(crate) enum Indices<'py> {
    Wide(PyReadonlyArray1<'py, i64>),
    Narrow(PyReadonlyArray1<'py, i32>),
}

impl<'py> Indices<'py> {
    pub(crate) fn of(array: &Bound<'py, PyAny>, what: &str) -> PyResult<Indices<'py>> {
        if let Some(view) = view(array) {
            return Ok(Indices::Wide(view));
        }
        view(array)
            .map(Indices::Narrow)
            .ok_or_else(|| unprepared(what))
    }

    pub(crate) fn len(&self) -> usize {
        match self {
            Indices::Wide(view) => view.len(),
            Indices::Narrow(view) => view.len(),
        }
    }

    pub(crate) fn read<T>(&self, reader: impl IndexReader<T>) -> PyResult<T> {
        Ok(match self {
            Indices::Wide(view) => reader.read(view.as_slice()?),
            Indices::Narrow(view) => reader.read(view.as_slice()?),
        })
    }
}

/// An integer of an array.
pub(crate) trait Index: Copy + Send + Sync + Into<i64> {}
impl Index for i64 {}
impl Index for i32 {}

/// Something that is read from integers of either width.
pub(crate) trait IndexReader<T> {
    fn read<I: Index>(self, indices: &[I]) -> T;
}

/// Tetrahedra that follow each other in `WIDTH` numbers each: four corners, or 4 and these.
pub(crate) struct Tetrahedra<const WIDTH: usize>;

impl<const WIDTH: usize> IndexReader<Result<Option<Vec<[u32; 4]>>, Error>> for Tetrahedra<WIDTH> {
    /// `None` where something else stands between.
    fn read<I: Index>(self, indices: &[I]) -> Result<Option<Vec<[u32; 4]>>, Error> {
        let (cells, rest) = indices.as_chunks::<WIDTH>();
        if !rest.is_empty() {
            return Ok(None);
        }
        // One pass: the numbers may be more than caches hold.
        let (is_mixed, is_beyond) = (AtomicBool::new(false), AtomicBool::new(false));
        // (`array::map` is a call for each number, which is not always inlined.)
        let corners = |cell: &[I; WIDTH]| -> [i64; 4] {
            let corner = |i: usize| cell[WIDTH - 4 + i].into();
            [corner(0), corner(1), corner(2), corner(3)]
        };
        let read = |cell: &[I; WIDTH]| {
            let count: i64 = cell[0].into();
            if WIDTH > 4 && count != 4 {
                is_mixed.store(true, Ordering::Relaxed);
            }
            let [a, b, c, d] = corners(cell);
            // Negative numbers have all of the upper bits.
            if (a | b | c | d) >> 32 != 0 {
                is_beyond.store(true, Ordering::Relaxed);
            }
            [a as u32, b as u32, c as u32, d as u32]
        };
        let tetrahedra = cells.par_iter().with_min_len(PIECE).map(read).collect();
        if is_mixed.into_inner() {
            return Ok(None);
        }
        if !is_beyond.into_inner() {
            return Ok(Some(tetrahedra));
        }
        let wrong = cells.iter().enumerate().find_map(|(cell, numbers)| {
            let wrong = corners(numbers)
                .into_iter()
                .find(|corner| corner >> 32 != 0)?;
            Some(no_point(cell, wrong))
        });
        Err(wrong.expect("one was found above"))
    }
}

/// Indices and numbers of corners in turn, as VTK's legacy layout has them: offsets and
/// connectivity of so many cells.
pub(crate) struct Padded {
    pub(crate) cells: usize,
}

impl IndexReader<Result<(Vec<u64>, Vec<u64>), Error>> for Padded {
    fn read<I: Index>(self, indices: &[I]) -> Result<(Vec<u64>, Vec<u64>), Error> {
        let mut offsets = Vec::with_capacity(self.cells + 1);
        let mut connectivity = Vec::with_capacity(indices.len().saturating_sub(self.cells));
        offsets.push(0);
        let mut rest = indices;
        while let Some((&count, after)) = rest.split_first() {
            let cell = offsets.len() - 1;
            let count: i64 = count.into();
            let corners = usize::try_from(count).ok().and_then(|n| after.get(..n));
            let Some(corners) = corners else {
                return Err(Error::Invalid {
                    what: format!(
                        "cell {cell} says that {count} points follow, and {} do",
                        after.len()
                    ),
                    help: Some(
                        "`cells` is the number of a cell's points and these, for one cell after \
                         the other; give `offsets` for connectivity alone"
                            .into(),
                    ),
                });
            };
            for &corner in corners {
                connectivity.push(point(cell, corner.into())?);
            }
            offsets.push(connectivity.len() as u64);
            rest = &after[corners.len()..];
        }
        match offsets.len() - 1 {
            found if found == self.cells => Ok((offsets, connectivity)),
            found => Err(Error::Invalid {
                what: format!("{found} cells have {} types", self.cells),
                help: Some("give one type for each cell".into()),
            }),
        }
    }
}

/// Numbers that are not negative.
pub(crate) struct Counts {
    pub(crate) what: &'static str,
}

impl IndexReader<Result<Vec<u64>, Error>> for Counts {
    fn read<I: Index>(self, indices: &[I]) -> Result<Vec<u64>, Error> {
        let numbers = indices.iter().enumerate().map(|(at, &index)| {
            let index: i64 = index.into();
            u64::try_from(index)
                .map_err(|_| Error::invalid(format!("{} {at} is {index}", self.what)))
        });
        numbers.collect()
    }
}

/// Whether offsets are those of cells that have this many points each.
pub(crate) struct Even {
    pub(crate) points: i64,
}

impl IndexReader<bool> for Even {
    fn read<I: Index>(self, indices: &[I]) -> bool {
        let offsets = indices.par_iter().with_min_len(PIECE).enumerate();
        offsets.all(|(cell, &offset)| {
            let offset: i64 = offset.into();
            (cell as i64).checked_mul(self.points) == Some(offset)
        })
    }
}

/// The index of a cell's point.
fn point(cell: usize, index: i64) -> Result<u64, Error> {
    u64::try_from(index).map_err(|_| no_point(cell, index))
}

fn no_point(cell: usize, index: i64) -> Error {
    Error::Invalid {
        what: format!("cell {cell} uses point {index}"),
        help: Some("points are counted from 0".into()),
    }
}
