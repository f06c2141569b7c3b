//! Resamples and voxelizes a mesh each time that a line comes in and prints the seconds of both, so
//! that another program can have its turn in between: `benches/peers/vtk_resample.py` does.
//!
//! Arguments: a data set's name or a file, and dims. A turn has the upload of the whole mesh in it,
//! as of one that has changed, and the wait for the samples; not their way back, as `slicing` draws
//! them where they are.

use std::io::{BufRead as _, Write as _};
use std::time::Instant;

use tetrascope::core::grid::Lattice;
use tetrascope::core::{Error, TetMesh, Volume};
use tetrascope::resample::{Resampler, ResamplerOptions};
use tetrascope::scene::VolumeSource;
use tetrascope::voxel_hw::{Columns, DeviceVoxelizer, Voxelizer, VoxelizerOptions};
use tetrascope::{Context, volumes};

fn mesh(name: &str) -> Result<TetMesh, Error> {
    let is_dataset = tetrascope::datasets::find(name).is_ok();
    let source = VolumeSource {
        dataset: is_dataset.then(|| name.into()),
        file: (!is_dataset).then(|| name.into()),
        ..VolumeSource::default()
    };
    match volumes::load(&source)?.volume {
        Volume::Mesh(mesh) => Ok(mesh),
        _ => Err(Error::invalid("a mesh is resampled, not a grid")),
    }
}

fn main() -> Result<(), Error> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [name, dims] = &arguments[..] else {
        return Err(Error::invalid(
            "give a mesh and dims, such as sphere 128x128x128",
        ));
    };
    let dims: Option<Vec<usize>> = dims.split('x').map(|d| d.parse().ok()).collect();
    let dims = dims.and_then(|dims| dims.try_into().ok());
    let dims: [usize; 3] = dims.ok_or_else(|| Error::invalid("dims are three numbers"))?;
    let mesh = mesh(name)?;
    let lattice = Lattice::over(&mesh.bounds(), dims)?;
    let context = Context::new();
    let mut resampler = Resampler::new(
        context.gpu()?,
        &mesh,
        &lattice,
        &ResamplerOptions::default(),
    )?;
    resampler.resample()?;
    let voxelizer = Voxelizer::new(VoxelizerOptions {
        columns: Columns::Longest,
        ..VoxelizerOptions::default()
    })?;
    let mut voxelizer = DeviceVoxelizer::new(context.gpu()?, &voxelizer, &mesh, &lattice)?;
    voxelizer.voxelize()?;
    let adapter = context.adapter().unwrap_or_default();
    println!("{} cells, {adapter}", mesh.cell_count());
    for _ in std::io::stdin().lock().lines().map_while(Result::ok) {
        let start = Instant::now();
        resampler.reload(&mesh)?;
        resampler.resample()?;
        let resampled = start.elapsed();
        let start = Instant::now();
        voxelizer.reload(&mesh)?;
        voxelizer.voxelize()?;
        let voxelized = start.elapsed();
        println!("{} {}", resampled.as_secs_f64(), voxelized.as_secs_f64());
        // Nobody who waits for it is there if it fails.
        let _ = std::io::stdout().flush();
    }
    Ok(())
}
