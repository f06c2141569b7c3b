//! Every algorithm's picture of every scene under every optical model, beside the reviewed one.
//!
//! `cargo xtask snapshots bless` accepts what the last run left in `target/snapshots`. Only the
//! ground truth, which is the same everywhere, and Mesa's llvmpipe, which everybody
//! can run, may bless.

use xtask::picture::shown;
use xtask::snapshots::compare::Store;
use xtask::snapshots::pictures::scenes;
use xtask::testing::{Failures, algorithms, draw, drawn_by};

/// Steps of 255 that may differ. Where pictures are blessed: one, for a mathematical library, or
/// a compiler of the driver, that rounds the other way at the border of two steps. On other
/// adapters: another driver's f32, and cells with equal keys in another order, make two more.
fn steps(may_bless: bool) -> u8 {
    if may_bless { 1 } else { 3 }
}

#[test]
fn pictures_are_as_reviewed() {
    let store = Store::here();
    let mut failures = Failures::default();
    let drawing: Vec<(&str, String)> = algorithms("snapshots")
        .into_iter()
        .map(|algorithm| (algorithm.name, drawn_by(algorithm)))
        .collect();
    for scene in scenes().expect("data sets are made") {
        for picture in scene.pictures().expect("scenes are complete") {
            let algorithm = picture.algorithm;
            let Some((_, adapter)) = drawing.iter().find(|d| d.0 == algorithm.name) else {
                continue; // said to be skipped above
            };
            let may_bless = !algorithm.needs_gpu || adapter.contains("llvmpipe");
            let frame = draw(
                algorithm,
                picture.setting,
                &scene.volume,
                &picture.appearance,
                &picture.view,
            );
            let frame = frame.expect("what is not drawn is not listed");
            let (name, image) = (&picture.name, shown(&frame));
            if let Err(why) = store.check(name, &image, steps(may_bless), may_bless) {
                failures.push(format!("{why} (drawn by {adapter})"));
            }
        }
    }
    failures.finish();
}
