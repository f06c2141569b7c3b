//! Samples of a mesh's field at the points of a regular lattice.

use numpy::PyArray1;
use pyo3::prelude::*;
use tetrascope::core::grid::{Lattice, Samples};
use tetrascope::core::{self, Bounds, Error};
use tetrascope::resample::ResamplerOptions;
use tetrascope::resampling::{Dims, Sampled};
use tetrascope::volumes::LoadedFields;

use crate::context;
use crate::errors::exception;
use crate::volume::Volume;
use crate::work::run;

/// Samples x fastest, which of them are in the mesh, how many there are along each axis, the
/// first one's place, and their distances.
type Taken<'py> = (
    Bound<'py, PyArray1<f32>>,
    Bound<'py, PyArray1<bool>>,
    [usize; 3],
    [f64; 3],
    [f64; 3],
);

/// Takes samples over `bounds`, or the mesh's own.
#[pyfunction]
#[pyo3(signature = (volume, longest, dims, bounds, outside))]
pub(crate) fn resample<'py>(
    py: Python<'py>,
    volume: &Volume,
    longest: Option<usize>,
    dims: Option<[usize; 3]>,
    bounds: Option<[f64; 6]>,
    outside: f32,
) -> PyResult<Taken<'py>> {
    let core::Volume::Mesh(mesh) = &volume.volume else {
        let error = Error::Invalid {
            what: "samples are taken of meshes, and this is a regular grid already".into(),
            help: Some("draw it as it is".into()),
        };
        return Err(exception(py, &error));
    };
    let dims = match (dims, longest) {
        (Some(dims), _) => Dims::Each(dims),
        (None, Some(longest)) => Dims::Longest(longest),
        (None, None) => Dims::Auto,
    };
    let mesh = mesh.clone();
    let sampled = run(py, move || {
        let bounds = match bounds {
            None => mesh.bounds(),
            Some([x0, x1, y0, y1, z0, z1]) => Bounds {
                min: [x0, y0, z0].into(),
                max: [x1, y1, z1].into(),
            },
        };
        let lattice = Lattice::over(&bounds, dims.over(&bounds, &mesh))?;
        let loaded = LoadedFields {
            fields: vec![mesh.scalars().clone()],
            mesh,
            notes: Vec::new(),
            files: Vec::new(),
        };
        let options = ResamplerOptions::default();
        Sampled::new(
            context().gpu()?,
            &loaded,
            &lattice,
            &options,
            outside,
            |_| (),
        )
    })?;
    let Sampled {
        lattice,
        mut fields,
        inside,
    } = sampled;
    let values = match fields.pop() {
        Some((_, Samples::F32(values))) => values,
        _ => Vec::new(),
    };
    Ok((
        PyArray1::from_vec(py, values),
        PyArray1::from_vec(py, inside),
        lattice.dims,
        lattice.origin.to_array(),
        lattice.spacing.to_array(),
    ))
}
