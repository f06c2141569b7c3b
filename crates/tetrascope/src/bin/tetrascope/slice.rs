//! `slice`: the section of a mesh by a plane, as a picture or as numbers.

use serde_json::json;
use tetrascope::core::colormap::Colormap;
use tetrascope::core::glam::DVec3;
use tetrascope::core::grid::{Lattice, Samples};
use tetrascope::core::{ClipPlane, Frame, FrameStats, number};
use tetrascope::help;
use tetrascope::io::image::{check_path, write_image, write_npy};
use tetrascope::io::vti::check_path as check_vti_path;
use tetrascope::io::{Compression, write_vti};
use tetrascope::resample::ResamplerOptions;
use tetrascope::resampling::Sampled;

use crate::args::SliceArgs;
use crate::mesh::{load, named};
use crate::output::{Output, Stop};
use crate::resample::{INSIDE, nothing_inside, sample};

/// The format of a section.
enum Format {
    /// Colors.
    Picture,
    /// The field's numbers, NaN outside.
    Npy,
    Vti,
}

pub(crate) fn run(args: &SliceArgs, output: &Output) -> Result<(), Stop> {
    let path = match &args.output {
        Some(path) => path.clone(),
        None => named(&args.mesh, "-slice.png"),
    };
    let extension = path.extension().map(|e| e.to_ascii_lowercase());
    let format = match extension.as_ref().and_then(|e| e.to_str()) {
        Some("vti") => Format::Vti,
        Some("npy") => Format::Npy,
        _ => Format::Picture,
    };
    match format {
        Format::Vti => check_vti_path(&path)?,
        _ => check_path(&path)?,
    }
    let names: Vec<String> = args.field.iter().cloned().collect();
    let (loaded, load) = load(&args.mesh, Some(&names), output)?;
    let bounds = loaded.mesh.bounds();
    let plane = args.plane.unwrap_or(ClipPlane {
        point: bounds.center(),
        normal: DVec3::Z,
    });
    let lattice = Lattice::on_plane(&bounds, plane.point, plane.normal, args.size as usize)?;
    let (sampled, seconds) = sample(
        &loaded,
        &lattice,
        &ResamplerOptions::default(),
        f32::NAN,
        output,
    )?;
    let warning = (sampled.count_inside() == 0).then(|| nothing_inside(&loaded));

    let (field, samples) = &sampled.fields[0];
    let Samples::F32(numbers) = samples else {
        unreachable!("samples are 32-bit floats");
    };
    let [width, height, _] = lattice.dims;
    let range = match args.range {
        Some([low, high]) => (low, high),
        None => samples.range().unwrap_or((0.0, 1.0)),
    };
    let metadata = [
        ("Title", format!("{field} on a plane")),
        (
            "Software",
            format!("tetrascope {}", env!("CARGO_PKG_VERSION")),
        ),
        ("plane point", number::vector(plane.point)),
        ("plane normal", number::vector(plane.normal)),
        ("range", number::range(range)),
    ];
    let metadata = metadata.map(|(key, text)| (key.to_owned(), text));
    // Rows go down in pictures and up in grids.
    let rows = || numbers.chunks(width).rev().flatten().copied();
    let ((), write) = output.timed(&format!("writing {}", path.display()), || match format {
        Format::Picture => {
            let pixels = rows().map(|s| color(s, args.colormap, range, args.background));
            let size = (width as u32, height as u32);
            let frame = Frame::new(size, pixels.collect(), FrameStats::default());
            write_image(&path, &frame, &metadata)
        }
        Format::Npy => write_npy(&path, width, &rows().collect::<Vec<f32>>(), &metadata),
        Format::Vti => {
            let mask = mask(&sampled);
            let arrays = [(field.as_str(), samples), (INSIDE, &mask)];
            write_vti(&path, &lattice, &arrays, Compression::None)
        }
    })?;
    if matches!(format, Format::Picture) {
        output.note(format_args!("  colors from {}", number::range(range)));
    }
    if let Some(warning) = &warning {
        output.warning(warning);
    }
    if !output.json() {
        return output.written(&path);
    }
    let warnings = warning.iter();
    let warnings = warnings.map(|w| json!({"message": w.to_string(), "help": help(w)}));
    output.json_result(&json!({
        "output": path.to_string_lossy(),
        "size": [width, height],
        "field": field,
        "range": samples.range(),
        "pixels_inside": sampled.count_inside(),
        "seconds": {"load": load, "resample": seconds, "write": write},
        "warnings": warnings.collect::<Vec<_>>(),
    }))
}

fn mask(sampled: &Sampled) -> Samples {
    Samples::U8(
        sampled
            .inside
            .iter()
            .map(|is_in| u8::from(*is_in))
            .collect(),
    )
}

/// The color of a scalar, premultiplied linear RGBA; the background's where there is none.
fn color(scalar: f32, map: Colormap, (low, high): (f64, f64), background: [f32; 4]) -> [f32; 4] {
    if scalar.is_nan() {
        let [r, g, b, a] = background;
        return [r * a, g * a, b * a, a];
    }
    let width = high - low;
    let share = if width > 0.0 {
        (f64::from(scalar) - low) / width
    } else {
        0.5
    };
    let [r, g, b] = map.linear_rgb(share.clamp(0.0, 1.0)).as_vec3().to_array();
    [r, g, b, 1.0]
}
