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

/// A sum of light loses up to 2⁻²⁵ of itself, to either side: in 128 blocks of 1024 sums, each of a 128th of the
/// light, 6e-8 together where that is random (2⁻²⁵ · 0.7 / 128 · √1024 · √128). Sixteen times that is left for
/// those that lean to one side. Cells that are summed one by one are 3.2e-6 off.
const MOST: f64 = 1e-6;

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
