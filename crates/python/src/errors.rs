//! Errors of the library as exceptions of Python.
//!
//! `tetrascope/_errors.py` says which class each kind is; the words are the library's.

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use tetrascope::core::Error;
use tetrascope::scene::nearest;

/// The exception for an error.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    match made(py, error) {
        Ok(exception) | Err(exception) => exception,
    }
}

fn made(py: Python<'_>, error: &Error) -> PyResult<PyErr> {
    let (code, path) = match error {
        Error::Io { path, source, .. } => (source.raw_os_error().or(code(source)), Some(path)),
        _ => (None, None),
    };
    let make = py.import("tetrascope._errors")?.getattr("make")?;
    let made = make.call1((kind(error), error.to_string(), help(error), code, path))?;
    Ok(PyErr::from_value(made))
}

/// The code of an error that has lost it on its way, by its kind; Python's classes follow it.
fn code(error: &std::io::Error) -> Option<i32> {
    use std::io::ErrorKind;
    Some(match error.kind() {
        ErrorKind::NotFound => 2,
        ErrorKind::PermissionDenied => 13,
        ErrorKind::NotADirectory => 20,
        ErrorKind::IsADirectory => 21,
        _ => return None,
    })
}

/// The exception for a panic, which is a fault of ours.
pub(crate) fn fault(payload: &(dyn std::any::Any + Send)) -> PyErr {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    let text = text.or(payload.downcast_ref::<&str>().copied());
    let text = text.unwrap_or("without a reason");
    PyRuntimeError::new_err(format!(
        "a fault in tetrascope, not of yours; please report it: {text}"
    ))
}

fn kind(error: &Error) -> &'static str {
    match error {
        Error::Io { .. } => "file",
        Error::NoMemory { .. } => "memory",
        Error::NoAdapter { .. }
        | Error::TooLarge { .. }
        | Error::OutOfMemory { .. }
        | Error::Device { .. } => "device",
        _ => "input",
    }
}

/// How to help; a misspelt name is corrected.
fn help(error: &Error) -> Option<String> {
    let meant = match error {
        Error::Unknown { name, valid, .. } => nearest(name, valid).map(String::from),
        Error::NoSuchField { name, available } => {
            // Each is followed by its range, "density [0, 1] (point)".
            let bare = available.iter();
            let bare: Vec<&str> = bare.filter_map(|f| f.split(" [").next()).collect();
            nearest(name, &bare).map(String::from)
        }
        _ => None,
    };
    match meant {
        Some(meant) => Some(format!("did you mean '{meant}'?")),
        None => error.help(),
    }
}
