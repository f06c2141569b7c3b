use tetrascope_scene::Scene;

use super::*;
use crate::volumes;

/// A data set as its look has it, a square picture.
pub(crate) fn scene(dataset: &str, cells: u64, side: u32) -> (Volume, Scene) {
    let dataset = tetrascope_datasets::find(dataset).expect("a data set");
    let mut file = volumes::scene(dataset);
    file.volume.cells = Some(cells);
    (file.image.width, file.image.height) = (Some(side), Some(side));
    let volume = volumes::load(&file.volume).expect("it is made").volume;
    let scene = file.resolve(&volume).expect("it is complete");
    (volume, scene)
}

#[test]
fn a_need_that_no_picture_keeps_is_refused() {
    let nothing = Need::default();
    let error = |error| Need {
        error: Some(error),
        ..Need::default()
    };
    let late = Need {
        budget: Some(Duration::ZERO),
        ..Need::default()
    };
    let small = Need {
        memory: Some(0),
        ..Need::default()
    };
    for need in [
        nothing,
        error(0.0),
        error(-1.0),
        error(f64::NAN),
        error(f64::INFINITY),
        late,
        small,
    ] {
        let refused = need.validate().expect_err("it makes no sense");
        assert!(
            matches!(refused, Error::Usage { help: Some(_), .. }),
            "{need:?}"
        );
    }
    error(1e-3).validate().expect("it makes sense");
}
