//! The variables of a netCDF file, classic or in HDF5.

use std::collections::HashMap;
use std::path::PathBuf;

use netcdf_reader::classic::ClassicFile;
use netcdf_reader::{NcFormat, NcSliceInfo, NcSliceInfoElem, NcType};
use tetrascope_core::Error;

#[cfg(feature = "hdf5")]
use crate::hdf5;
use crate::source::{Source, format_error};

/// A netCDF file: in memory, if it is classic.
pub(super) struct File {
    pub(super) path: PathBuf,
    /// The length of the file, bytes.
    pub(super) length: u64,
    /// The most bytes that its cells, or one of its variables at a time, may take.
    pub(super) most_bytes: u64,
    backend: Backend,
    /// Those that can be read, by name.
    variables: HashMap<String, Variable>,
}

enum Backend {
    Classic(ClassicFile),
    /// The datasets of the variables.
    #[cfg(feature = "hdf5")]
    Hdf5(HashMap<String, hdf5::Dataset>),
}

pub(super) struct Variable {
    /// At least one dimension.
    pub(super) shape: Vec<u64>,
    is_text: bool,
    /// The name of its elements' type, such as "HEX8".
    pub(super) element_type: String,
}

impl File {
    /// Opens a classic file.
    pub(super) fn classic(source: Source) -> Result<File, Error> {
        let Source { path, bytes } = source;
        let length = bytes.len() as u64;
        let format = match bytes.get(3) {
            Some(1) => NcFormat::Classic,
            Some(2) => NcFormat::Offset64,
            _ => NcFormat::Cdf5,
        };
        // Not by its path, for which the crate maps the file: a file that becomes shorter
        // would then end the program.
        let file = ClassicFile::from_vec(bytes, format);
        let file = file.map_err(|error| Error::Format {
            path: path.clone(),
            at: "the netCDF header".into(),
            what: one_line(&error),
            help: Some("the file is truncated or damaged; copy or write it again".into()),
        })?;
        let mut variables = HashMap::new();
        for variable in &file.root_group().variables {
            let shape = variable.shape();
            let bytes: u64 = match variable.dtype() {
                NcType::Byte | NcType::UByte | NcType::Char => 1,
                NcType::Short | NcType::UShort => 2,
                NcType::Int | NcType::UInt | NcType::Float => 4,
                NcType::Double | NcType::Int64 | NcType::UInt64 => 8,
                _ => continue,
            };
            let needed = shape.iter().try_fold(bytes, |n, &d| n.checked_mul(d));
            if needed.is_none_or(|needed| needed > length) {
                return Err(Error::Format {
                    path,
                    at: format!("variable '{}'", variable.name()),
                    what: format!("{shape:?} values cannot be in a file of {length} bytes"),
                    help: Some("the file is truncated or damaged; copy or write it again".into()),
                });
            }
            if !shape.is_empty() {
                let is_text = matches!(variable.dtype(), NcType::Char);
                let element_type = variable.attribute("elem_type");
                let element_type = element_type.and_then(|kind| kind.value.as_string());
                let element_type = element_type.unwrap_or_default();
                let known = Variable {
                    shape,
                    is_text,
                    element_type: element_type.trim_matches(['\0', ' ']).to_owned(),
                };
                variables.insert(variable.name().to_owned(), known);
            }
        }
        Ok(File {
            path,
            length,
            most_bytes: length,
            backend: Backend::Classic(file),
            variables,
        })
    }

    /// Takes the variables of an HDF5 file. Dimensions are datasets there, too.
    #[cfg(feature = "hdf5")]
    pub(super) fn hdf5(root: &hdf5::Group) -> Result<File, Error> {
        let (_, names) = root.members()?;
        let (mut datasets, mut variables) = (HashMap::new(), HashMap::new());
        for name in names {
            let Some(dataset) = root.dataset(&name)? else {
                continue;
            };
            let is_text = dataset.is_text();
            if dataset.shape().is_empty() || !(is_text || dataset.number().is_some()) {
                continue;
            }
            let variable = Variable {
                shape: dataset.shape().to_vec(),
                is_text,
                element_type: dataset.attribute_text("elem_type").unwrap_or_default(),
            };
            variables.insert(name.clone(), variable);
            datasets.insert(name, dataset);
        }
        Ok(File {
            path: root.file.path.clone(),
            length: root.file.length,
            // As points and cells of other packed meshes.
            most_bytes: (32 << 20) + 32 * root.file.length,
            backend: Backend::Hdf5(datasets),
            variables,
        })
    }

    /// The size of a dimension; 0 if it is not there.
    pub(super) fn dimension(&self, name: &str) -> u64 {
        match &self.backend {
            Backend::Classic(file) => {
                let mut dimensions = file.root_group().dimensions.iter();
                dimensions.find(|d| d.name == name).map_or(0, |d| d.size)
            }
            #[cfg(feature = "hdf5")]
            Backend::Hdf5(_) => self
                .variable(name)
                .map_or(0, |dimension| dimension.shape[0]),
        }
    }

    pub(super) fn variable(&self, name: &str) -> Option<&Variable> {
        self.variables.get(name)
    }

    pub(super) fn error(&self, at: impl Into<String>, what: impl Into<String>) -> Error {
        format_error(&self.path, at, what)
    }

    /// The numbers of a variable at the given places of its first dimensions.
    pub(super) fn floats(&self, name: &str, places: &[u64]) -> Result<Vec<f64>, Error> {
        let wrong = |what: String| self.error(format!("variable '{name}'"), what);
        let variable = self
            .variable(name)
            .ok_or_else(|| wrong("the file does not have it".into()))?;
        if variable.is_text {
            return Err(wrong("it is text where numbers are needed".into()));
        }
        let shape = &variable.shape;
        if places.len() >= shape.len() || places.iter().zip(shape).any(|(at, size)| at >= size) {
            return Err(wrong(format!("its shape is {shape:?}")));
        }
        match &self.backend {
            Backend::Classic(file) => {
                let mut selection = NcSliceInfo::all(shape.len());
                for (part, &place) in selection.selections.iter_mut().zip(places) {
                    *part = NcSliceInfoElem::Index(place);
                }
                let values = file.read_variable_slice_as_f64(name, &selection);
                let values = values.map_err(|error| wrong(one_line(&error)))?;
                Ok(values.into_raw_vec_and_offset().0)
            }
            #[cfg(feature = "hdf5")]
            Backend::Hdf5(datasets) => {
                let rest = &shape[places.len()..];
                let bytes = rest.iter().fold(8, |n: u64, d| n.saturating_mul(*d));
                if bytes > self.most_bytes {
                    let length = self.length;
                    let what = "so many different ones cannot be in";
                    return Err(wrong(format!("{bytes} bytes: {what} {length} bytes")));
                }
                let rows = 0..shape.get(places.len()).copied().unwrap_or(0);
                datasets[name].view(places, rows)?.floats()
            }
        }
    }

    /// The texts of a variable; none if it is not there.
    pub(super) fn texts(&self, name: &str) -> Result<Vec<String>, Error> {
        let Some(variable) = self.variable(name) else {
            return Ok(Vec::new());
        };
        let at = || format!("variable '{name}'");
        if !variable.is_text {
            return Err(self.error(at(), "it is not text, which names are"));
        }
        match &self.backend {
            Backend::Classic(file) => {
                let texts = file.read_variable_as_strings(name);
                texts.map_err(|error| self.error(at(), one_line(&error)))
            }
            #[cfg(feature = "hdf5")]
            Backend::Hdf5(datasets) => datasets[name].texts(self.most_bytes),
        }
    }
}

fn one_line(error: &netcdf_reader::Error) -> String {
    error.to_string().replace(['\n', '\r'], " ")
}
