//! `resample`: a mesh to a file of samples on a regular grid.

use serde_json::json;
use tetrascope::core::grid::{Lattice, Samples};
use tetrascope::core::{Error, number};
use tetrascope::io::vti::check_path as check_vti_path;
use tetrascope::io::{Compression, write_vti};
use tetrascope::resample::ResamplerOptions;
use tetrascope::resampling::Sampled;
use tetrascope::volumes::LoadedFields;
use tetrascope::{Context, help};

use crate::args::ResampleArgs;
use crate::mesh::{load, named};
use crate::output::{Output, Stop};

/// The name that VTK's filter gives the array that is 1 inside of the mesh and 0 outside.
pub(crate) const INSIDE: &str = "vtkValidPointMask";

pub(crate) fn run(args: &ResampleArgs, output: &Output) -> Result<(), Stop> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => named(&args.mesh, ".vti"),
    };
    check_vti_path(&path)?;
    let names = (!args.all_fields).then_some(&args.field[..]);
    let (loaded, load) = load(&args.mesh, names, output)?;
    let bounds = args.region.unwrap_or(loaded.mesh.bounds());
    let lattice = Lattice::over(&bounds, args.dims.over(&bounds, &loaded.mesh))?;
    let options = ResamplerOptions {
        passes: args.passes,
        weights: args.weights,
        slabs: args.slabs,
    };
    let (sampled, seconds) = sample(&loaded, &lattice, &options, args.outside, output)?;
    let inside = sampled.count_inside();
    let warning = (inside == 0).then(|| nothing_inside(&loaded));

    let mask = Samples::U8(
        sampled
            .inside
            .iter()
            .map(|is_in| u8::from(*is_in))
            .collect(),
    );
    let mut arrays: Vec<(&str, &Samples)> = Vec::new();
    arrays.extend(sampled.fields.iter().map(|(name, s)| (name.as_str(), s)));
    arrays.push((INSIDE, &mask));
    let compression = match args.compress {
        true => Compression::Zlib,
        false => Compression::None,
    };
    let ((), write) = output.timed(&format!("writing {}", path.display()), || {
        write_vti(&path, &lattice, &arrays, compression)
    })?;
    if let Some(warning) = &warning {
        output.warning(warning);
    }
    if !output.json() {
        return output.written(&path);
    }
    let fields = sampled
        .fields
        .iter()
        .map(|(name, samples)| json!({"name": name, "range": samples.range()}));
    let warnings = warning.iter();
    let warnings = warnings.map(|w| json!({"message": w.to_string(), "help": help(w)}));
    output.json_result(&json!({
        "output": path.to_string_lossy(),
        "dims": lattice.dims,
        "origin": lattice.origin.to_array(),
        "spacing": lattice.spacing.to_array(),
        "fields": fields.collect::<Vec<_>>(),
        "samples_inside": inside,
        "seconds": {"load": load, "resample": seconds, "write": write},
        "warnings": warnings.collect::<Vec<_>>(),
    }))
}

/// Takes the samples; prints how many are inside. Gives the seconds too.
pub(crate) fn sample(
    loaded: &LoadedFields,
    lattice: &Lattice,
    options: &ResamplerOptions,
    outside: f32,
    output: &Output,
) -> Result<(Sampled, f64), Error> {
    let [nx, ny, nz] = lattice.dims;
    let context = Context::new();
    let gpu = context.gpu()?;
    let progress = output.progress();
    let done = |share: f64| {
        if let Some(progress) = &progress {
            progress(share);
        }
    };
    let what = format!("taking {nx}x{ny}x{nz} samples");
    let taken = || Sampled::new(gpu, loaded, lattice, options, outside, done);
    let timed = output.timed(&what, taken)?;
    if let Some(adapter) = context.adapter() {
        output.note(format_args!("  {adapter}"));
    }
    let (inside, all) = (timed.0.count_inside(), nx * ny * nz);
    let percent = number::rounded(100.0 * inside as f64 / all as f64);
    output.note(format_args!(
        "  {inside} samples are in the mesh, {percent} %"
    ));
    Ok(timed)
}

/// That no sample is in the mesh, which is worth a word.
pub(crate) fn nothing_inside(loaded: &LoadedFields) -> Error {
    let bounds = loaded.mesh.bounds();
    Error::Invalid {
        what: "no sample is in the mesh".into(),
        help: Some(format!(
            "the mesh reaches from {} to {}",
            number::vector(bounds.min),
            number::vector(bounds.max)
        )),
    }
}
