//! Pictures as bytes and as files.

use std::path::{Path, PathBuf};

use numpy::{PyArray1, PyArrayMethods as _, PyReadonlyArray3, PyUntypedArrayMethods as _};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use tetrascope::core::{Error, Frame, FrameStats};
use tetrascope::io;

use crate::errors::exception;
use crate::work::run;

/// Keys and texts, which image files hold.
type Metadata = Vec<(String, String)>;

/// The frame of an array with the axes row, column and channel.
fn frame(py: Python<'_>, pixels: &PyReadonlyArray3<'_, f32>) -> PyResult<Frame> {
    let [height, width, channels] = [0, 1, 2].map(|axis| pixels.shape()[axis]);
    let sides = (u32::try_from(width), u32::try_from(height));
    let (Ok(width), Ok(height), 4, true) = (sides.0, sides.1, channels, pixels.is_c_contiguous())
    else {
        let error = Error::Invalid {
            what: format!("an array of {height}×{width}×{channels} is not a picture"),
            help: Some("a picture is rows of pixels of four channels".into()),
        };
        return Err(exception(py, &error));
    };
    let (pixels, _) = pixels.as_slice()?.as_chunks::<4>();
    Ok(Frame::new(
        (width, height),
        pixels.to_vec(),
        FrameStats::default(),
    ))
}

/// A picture as a PNG file.
#[pyfunction]
pub(crate) fn encode_png<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray3<'py, f32>,
    metadata: Metadata,
) -> PyResult<Bound<'py, PyBytes>> {
    let frame = frame(py, &pixels)?;
    let file = run(py, move || io::encode_png(&frame, &metadata))?;
    Ok(PyBytes::new(py, &file))
}

/// Writes a picture in the format that the extension names.
#[pyfunction]
pub(crate) fn write_image(
    py: Python<'_>,
    path: PathBuf,
    pixels: PyReadonlyArray3<'_, f32>,
    metadata: Metadata,
) -> PyResult<()> {
    let frame = frame(py, &pixels)?;
    run(py, move || {
        io::image::check_path(&path)?;
        io::write_image(Path::new(&path), &frame, &metadata)
    })
}

/// A picture's pixels in 8-bit sRGB with straight alpha, as PNG files have them.
#[pyfunction]
pub(crate) fn to_srgb8<'py>(
    py: Python<'py>,
    pixels: PyReadonlyArray3<'py, f32>,
) -> PyResult<Bound<'py, PyAny>> {
    let frame = frame(py, &pixels)?;
    let (height, width) = (frame.height as usize, frame.width as usize);
    let texels = py.detach(move || io::image::straight_srgb8(&frame));
    let flat = PyArray1::from_vec(py, texels.into_flattened());
    Ok(flat.reshape([height, width, 4])?.into_any())
}
