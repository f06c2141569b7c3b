//! So many cells on one ray that sums in f32 lose digits, cell by cell.

use tetrascope_testing::{apart, say};
use xtask::stability::{Expected, row};
use xtask::testing::{Failures, algorithms, draw};

/// Cells on the ray.
const CELLS: usize = 1 << 17;

/// Those that add up as many sums as there are cells, each with a setting that is exact.
const EXACT: [(&str, &str); 3] = [
    ("raycast-cpu", ""),
    ("raycast-peel", ""),
    ("projection", "order=per-pixel"),
];

/// Sums alone would be off by 1e-4 and more. Of the light of each cell rounding takes 2⁻²⁴ a few times, and where
/// it leads to one side that is the picture's error: 1e-6. Lengths are differences of z, which add up
/// to the whole, but for the color by which each counts.
const MOST: f64 = 1e-5;

#[test]
fn a_hundred_thousand_cells_on_a_ray_add_up() {
    let case = row("a row", CELLS, 1);
    let shot = &case.shots[0];
    let Expected::Light(light) = &case.expected else {
        panic!("a row has a closed form");
    };
    let want = light(&shot.view.ray(0, 0));
    let mut failures = Failures::default();
    for algorithm in algorithms("row") {
        let Some((_, setting)) = EXACT.iter().find(|(name, _)| *name == algorithm.name) else {
            continue;
        };
        let (volume, view) = (&shot.volume, &shot.view);
        let frame = draw(algorithm, setting, volume, &shot.appearance, view).expect("it is drawn");
        let got = frame.pixels[0].map(f64::from);
        let worst = (0..4).map(|c| apart(got[c], want[c])).fold(0.0, f64::max);
        let name = algorithm.name;
        say(&format!("{name} {setting}: {worst:.1e}"));
        if worst > MOST {
            failures.push(format!(
                "{name} {setting}: {worst:.1e} off: {got:?}, not {want:?}"
            ));
        }
    }
    failures.finish();
}
