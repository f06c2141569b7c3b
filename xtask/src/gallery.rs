//! The gallery of the guides: pictures of real data, from scene files in the repository.
//!
//! [`PICTURES`] names each scene (`docs/gallery/NAME.toml`), the data file that it shows and where
//! that comes from. `cargo xtask gallery` draws them and writes `docs/gallery.md`.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use tetrascope::core::{Error, VolumeRenderer as _};
use tetrascope::scene::{SceneFile, VolumeSource, nearest};
use tetrascope::{Context, Settings, algorithm, volumes};
use tetrascope_testing::data_path;

use crate::machine;
use crate::output::{print, write};
use crate::picture::{shown, small_png};

/// Options of the gallery.
#[derive(clap::Args)]
pub struct Options {
    /// The pictures to draw, by the names of their scene files [default: all]
    names: Vec<String>,
    /// The folder with the data files [default: TETRASCOPE_DATA]
    #[arg(long, value_name = "FOLDER")]
    data: Option<PathBuf>,
    /// The algorithm
    #[arg(short, long, value_name = "NAME", default_value = "raycast-cpu")]
    algorithm: String,
    /// Where to write the pictures [default: docs/gallery, and the page beside it]
    #[arg(short, long, value_name = "FOLDER")]
    output: Option<PathBuf>,
}

/// A picture of the gallery.
#[derive(Clone, Copy)]
pub struct Picture {
    /// The scene's file, without `.toml`.
    pub name: &'static str,
    /// The data file.
    pub file: &'static str,
    /// A sentence about it.
    pub about: &'static str,
    /// The repository on GitHub and the path in it.
    pub origin: &'static str,
}

/// Every picture, in the order of the page.
pub const PICTURES: [Picture; 12] = [
    Picture {
        name: "blunt-fin",
        file: "bluntfinxyz.bin",
        about: "Air at Mach 2.95 flows around a blunt fin on a plate: its density behind the shock.",
        origin: "pyvista/vtk-data, Data/bluntfinxyz.bin and Data/bluntfinq.bin",
    },
    Picture {
        name: "combustor",
        file: "combxyz.bin",
        about: "The density in a combustion chamber: where it is low, the gas is hot.",
        origin: "pyvista/vtk-data, Data/combxyz.bin and Data/combq.bin",
    },
    Picture {
        name: "oxygen-post",
        file: "postxyz.bin",
        about: "Liquid oxygen flows around a post: slow in its wake, fast beside it.",
        origin: "pyvista/vtk-data, Data/postxyz.bin and Data/postq.bin",
    },
    Picture {
        name: "super-phoenix",
        file: "spx.vtu",
        about: "A part of the reactor Super Phoenix.",
        origin: "recheliu/recheliu-mylib, data/spx.vtu",
    },
    Picture {
        name: "notched-plate",
        file: "notch_stress_fixed.vtk",
        about: "The stress in a notched plate, from a finite element program.",
        origin: "pyvista/vtk-data, Data/notch_stress_fixed.vtk",
    },
    Picture {
        name: "seamount",
        file: "seamount.vtu",
        about: "The speed of sea water that flows over a seamount.",
        origin: "FluidityProject/fluidity, tests/data/seamount.vtu",
    },
    Picture {
        name: "aneurysm",
        file: "aneurism.vti",
        about: "Arteries with an aneurysm, by rotational X-ray angiography.",
        origin: "Kitware/vtk-js-datasets, data/vti/aneurism.vti",
    },
    Picture {
        name: "head-angiography",
        file: "CT_AVM.nii.gz",
        about: "Vessels of a head with a malformation, by computed tomography.",
        origin: "niivue/niivue-demo-images, CT_AVM.nii.gz",
    },
    Picture {
        name: "aorta",
        file: "aorta.mha",
        about: "An abdominal aorta with contrast agent, in slices 1.5 mm apart.",
        origin: "vmtk/vmtk-test-data, input/aorta.mha",
    },
    Picture {
        name: "engine",
        file: "engine.vti",
        about: "Two cylinders of an engine block, by computed tomography.",
        origin: "Kitware/vtk-js-datasets, data/vti/engine.vti",
    },
    Picture {
        name: "tooth",
        file: "tooth.nrrd",
        about: "A tooth: enamel around dentin.",
        origin: "Kitware/vtk-js-datasets, data/nrrd/tooth.nrrd",
    },
    Picture {
        name: "iron-protein",
        file: "ironProt.vtk",
        about: "An isosurface of the electron density of an iron protein, lit from two sides.",
        origin: "pyvista/vtk-data, Data/ironProt.vtk",
    },
];

/// Frames of each picture that are timed.
const FRAMES: usize = 5;

/// A picture that was drawn.
struct Drawn {
    picture: &'static Picture,
    /// Its volume, in words.
    volume: String,
    /// From the call until pixels are in memory.
    time: Duration,
}

/// Draws pictures, and the page where all of them were drawn.
///
/// # Errors
/// An unknown name, a data file that is not there, or what loading, drawing and writing refuse.
pub fn run(options: &Options) -> Result<(), Error> {
    let chosen = chosen(&options.names)?;
    let data = |name: &str| match &options.data {
        Some(folder) => folder.join(name),
        None => data_path(name),
    };
    // Say all that is missing before the work, not one after the other.
    let missing: Vec<&str> = chosen
        .iter()
        .filter(|picture| !data(picture.file).is_file())
        .map(|picture| picture.file)
        .collect();
    if let Some(first) = missing.first() {
        let folder = data(first);
        let folder = folder.parent().unwrap_or(Path::new(".")).display();
        return Err(Error::Usage {
            what: format!("no {} in {folder}", missing.join(", ")),
            help: Some(
                "name the folder with --data or TETRASCOPE_DATA; docs/gallery.md says where each \
                 file comes from"
                    .into(),
            ),
        });
    }
    let scenes = machine::root().join("docs/gallery");
    let output = options.output.as_ref().unwrap_or(&scenes);
    let mut drawn = Vec::new();
    for picture in chosen {
        let file = data(picture.file);
        let one = draw(picture, &scenes, file, &options.algorithm, output)?;
        let time = milliseconds(one.time);
        print(&format!("{}: {}, {time}\n", picture.name, one.volume))?;
        drawn.push(one);
    }
    if options.output.is_none() && drawn.len() == PICTURES.len() {
        write(&scenes.with_extension("md"), page(&drawn))?;
    }
    Ok(())
}

fn chosen(names: &[String]) -> Result<Vec<&'static Picture>, Error> {
    if names.is_empty() {
        return Ok(PICTURES.iter().collect());
    }
    let find = |name: &String| {
        let found = PICTURES.iter().find(|picture| picture.name == name);
        found.ok_or_else(|| {
            let known = PICTURES.map(|picture| picture.name);
            let near = nearest(name, &known).map(|near| format!("did you mean '{near}'?"));
            let all = || format!("there are {}", known.join(", "));
            Error::Usage {
                what: format!("no picture is called '{name}'"),
                help: Some(near.unwrap_or_else(all)),
            }
        })
    };
    names.iter().map(find).collect()
}

fn draw(
    picture: &'static Picture,
    scenes: &Path,
    data: PathBuf,
    name: &str,
    output: &Path,
) -> Result<Drawn, Error> {
    let mut file = SceneFile::read(&scenes.join(picture.name).with_extension("toml"))?;
    file.volume = VolumeSource {
        file: Some(data),
        field: file.volume.field,
        ..VolumeSource::default()
    };
    let loaded = volumes::load(&file.volume)?;
    let scene = file.resolve(&loaded.volume)?;
    let algorithm = algorithm(name)?;
    let settings = Settings::defaults(algorithm);
    (algorithm.supports)(&loaded.volume, &scene.appearance, &scene.view, &settings)?;
    let context = Context::new();
    let renderer = (algorithm.build)(&context, &loaded.volume, &scene.appearance, &settings)?;
    // What else the machine does only adds to a time, so the least counts.
    let mut time = Duration::MAX;
    let mut frame = None;
    for _ in 0..FRAMES {
        let start = Instant::now();
        frame = Some(renderer.render(&scene.view)?);
        time = time.min(start.elapsed());
    }
    let frame = frame.expect("several were drawn");
    let path = output.join(picture.name).with_extension("png");
    write(&path, small_png(&shown(&frame)))?;
    Ok(Drawn {
        picture,
        volume: loaded.description,
        time,
    })
}

/// The page, in Markdown.
fn page(drawn: &[Drawn]) -> String {
    let mut page = String::from(
        "# Gallery\n\n\
         Real data in 1024×768, drawn by `raycast-cpu`, exact to the rounding of 32-bit floats. \
         Scene files are in [gallery](gallery); each says colors, opacities, camera and background, \
         and may be used for data of your own. `cargo xtask gallery` draws all of them again and \
         writes this page.\n\n\
         Times are the least of five frames on two CPU cores, once the volume is loaded. The data files \
         are public, in the repositories on GitHub that are named; put them into one folder and set \
         `TETRASCOPE_DATA` to it.\n",
    );
    for one in drawn {
        let Picture {
            name,
            file,
            about,
            origin,
        } = one.picture;
        let (volume, time) = (&one.volume, milliseconds(one.time));
        write!(
            page,
            "\n## {about}\n\n\
             ![{about}](gallery/{name}.png)\n\n    \
             tetrascope render $TETRASCOPE_DATA/{file} --scene docs/gallery/{name}.toml -o {name}.png\n\n\
             {volume}; {time}. Data: {origin}.\n"
        )
        .expect("a string takes any text");
    }
    page
}

/// As whole milliseconds of two digits.
fn milliseconds(time: Duration) -> String {
    let ms = time.as_secs_f64() * 1e3;
    let digit = 10_f64.powf(ms.log10().floor() - 1.0).max(1.0);
    format!("{:.0} ms", (ms / digit).round() * digit)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_scene_is_there_and_every_scene_file_is_drawn() {
        let folder = machine::root().join("docs/gallery");
        for picture in &PICTURES {
            let path = folder.join(picture.name).with_extension("toml");
            let scene = SceneFile::read(&path).expect("a scene file");
            assert_eq!(scene.volume.file, None, "the data's folder is the user's");
            assert_eq!(
                (scene.image.width, scene.image.height),
                (Some(1024), Some(768))
            );
            assert!(folder.join(picture.name).with_extension("png").is_file());
        }
        let files = std::fs::read_dir(folder).expect("the folder of scenes");
        let scenes = files.filter(|file| {
            let path = file.as_ref().expect("an entry").path();
            path.extension()
                .is_some_and(|extension| extension == "toml")
        });
        assert_eq!(scenes.count(), PICTURES.len());
    }

    #[test]
    fn an_unknown_picture_is_refused_with_the_nearest_name() {
        let error = chosen(&["blunt-fn".into()]).err().expect("no such picture");
        let Error::Usage { help, .. } = error else {
            panic!("{error}");
        };
        assert_eq!(help.as_deref(), Some("did you mean 'blunt-fin'?"));
        assert_eq!(chosen(&[]).expect("all").len(), PICTURES.len());
    }

    #[test]
    fn times_have_two_digits() {
        assert_eq!(milliseconds(Duration::from_micros(123_456)), "120 ms");
        assert_eq!(milliseconds(Duration::from_micros(7_400)), "7 ms");
        assert_eq!(milliseconds(Duration::from_micros(87_400)), "87 ms");
    }
}
