//! Data sets of the literature, where they are: `../shared/data` beside the
//! repository, or the folder that `TETRASCOPE_DATA` names.

use tetrascope_core::Bounds;
use tetrascope_core::glam::DVec3;
use tetrascope_io::MeshData;
use tetrascope_testing::mesh_data;

/// The mesh in a file, or `None` with a word about it when the file is absent.
fn read(name: &str) -> Option<MeshData> {
    mesh_data("real meshes", name)
}

fn values(data: &MeshData, name: &str) -> Vec<f64> {
    data.field(Some(name))
        .unwrap_or_else(|e| panic!("{e}"))
        .values
}

/// Published to five or more digits, of values that are f32 in the file: half a
/// unit of the fifth digit.
fn assert_close(value: f64, published: f64) {
    assert!(
        (value - published).abs() <= 5e-5 * published.abs().max(1e-3),
        "{value} is not {published}"
    );
}

fn assert_range(values: &[f64], low: f64, high: f64) {
    assert_close(values.iter().copied().fold(f64::INFINITY, f64::min), low);
    assert_close(
        values.iter().copied().fold(f64::NEG_INFINITY, f64::max),
        high,
    );
}

/// The volume inside the cells, each cut into tetrahedra around its first
/// point; exact where opposite sides agree on their diagonals, near it elsewhere.
fn volume(data: &MeshData) -> f64 {
    let split: &[[usize; 4]] = match data.cells.types[0] {
        10 => &[[0, 1, 2, 3]],
        // Around the diagonal from 0 to 6: the same in every cell of a block.
        12 => &[
            [0, 1, 2, 6],
            [0, 2, 3, 6],
            [0, 3, 7, 6],
            [0, 7, 4, 6],
            [0, 4, 5, 6],
            [0, 5, 1, 6],
        ],
        other => panic!("cells of type {other}"),
    };
    let corners = data.cells.offsets[1] as usize;
    data.cells
        .connectivity
        .chunks_exact(corners)
        .flat_map(|cell| {
            split
                .iter()
                .map(move |t| t.map(|c| data.points[cell[c] as usize]))
        })
        .map(|[a, b, c, d]| (b - a).dot((c - a).cross(d - a)).abs() / 6.0)
        .sum()
}

#[test]
fn bluntfin() {
    let Some(data) = read("bluntfinxyz.bin") else {
        return;
    };
    assert_eq!(
        (data.points.len(), data.cells.types.len()),
        (40_960, 37_479)
    );
    let p = 6_820;
    for (value, published) in
        data.points[p]
            .to_array()
            .into_iter()
            .zip([0.42984095, 0.5721181, 0.018365353])
    {
        assert_close(value, published);
    }
    for (name, published) in [
        ("density", 1.2735),
        ("momentum-x", 2.1173),
        ("momentum-y", 0.35898),
        ("momentum-z", -0.11533),
        ("energy", 6.8446),
    ] {
        assert_close(values(&data, name)[p], published);
    }
    assert_close(values(&data, "momentum-z")[40_959], 0.024707999);
    assert_range(&values(&data, "density"), 0.1926, 4.9775);
    assert_range(&values(&data, "momentum-x"), -2.1835, 5.7903);
    assert_range(&values(&data, "energy"), 0.768957, 25.160999);
    let bounds = Bounds::of(data.points.iter().copied());
    assert!(
        bounds
            .min
            .abs_diff_eq(DVec3::new(-7.8157473, 0.0, 0.0), 1e-6)
    );
    assert!(
        bounds
            .max
            .abs_diff_eq(DVec3::new(14.362204, 8.3275585, 5.7242513), 1e-6)
    );
    assert_close(volume(&data), 931.1627);
    assert_eq!(data.field(None).expect("it has fields").name, "density");
    assert!(
        data.notes
            .iter()
            .any(|n| n.contains("484 trailing bytes ignored")),
        "{:?}",
        data.notes
    );
    // The free stream flows at Mach 2.95, and the fastest point is near it.
    let fastest = values(&data, "mach").iter().copied().fold(0.0, f64::max);
    assert!((2.9..4.5).contains(&fastest), "{fastest}");
}

#[test]
fn comb() {
    let Some(data) = read("combxyz.bin") else {
        return;
    };
    assert_eq!(
        (data.points.len(), data.cells.types.len()),
        (47_025, 43_008)
    );
    assert_close(data.points[13_462].x, 4.56471);
    assert_close(data.points[13_462].z, 26.727411);
    assert_close(values(&data, "density")[13_462], 0.2213392);
    assert_close(values(&data, "momentum-z")[13_462], 41.733456);
    assert_range(&values(&data, "density"), 0.19781309, 0.71041924);
    assert_close(volume(&data), 1061.697);
    assert!(data.field(Some("pressure")).is_err());
    assert_eq!(data.field(None).expect("it has fields").name, "density");
}

#[test]
fn post() {
    let Some(data) = read("postxyz.bin") else {
        return;
    };
    assert_eq!(
        (data.points.len(), data.cells.types.len()),
        (109_744, 102_675)
    );
    assert_close(data.points[20_416].y, 0.21499555);
    assert_close(values(&data, "momentum-y")[20_416], 0.0084706647);
    assert_range(&values(&data, "velocity-x"), -0.215, 1.3618);
    assert_range(&values(&data, "energy"), -0.541506, 4.395837);
    assert_close(volume(&data), 3399.662);
    // The density is 1 everywhere, and Q5 is no gas's energy.
    assert_eq!(data.field(None).expect("it has fields").name, "energy");
    assert!(data.field(Some("mach")).is_err());
}

fn volume_of(data: MeshData, field: &str) -> f64 {
    data.into_mesh(Some(field))
        .unwrap_or_else(|e| panic!("{e}"))
        .volume()
}

#[test]
fn spx() {
    let Some(data) = read("spx.vtu") else { return };
    assert_eq!(
        (data.points.len(), data.cells.types.len()),
        (20_108, 12_936)
    );
    let scalar = values(&data, "scalar");
    assert_range(&scalar, 0.0, 3.186);
    let list = data.field_list();
    // The points that cells use have less.
    assert!(list[0].starts_with("scalar [0, 2.25"), "{list:?}");
    assert_close(volume_of(data, "scalar"), 118.3818);
}

#[test]
fn seamount() {
    let Some(data) = read("seamount.vtu") else {
        return;
    };
    assert_eq!(
        (data.points.len(), data.cells.types.len()),
        (20_004, 100_450)
    );
    assert_range(&values(&data, "Temperature"), -0.99571, -0.00413918);
    assert_range(&values(&data, "Pressure"), -0.61099, 0.788205);
    assert_range(&values(&data, "Velocity-magnitude"), 0.00455783, 1.27143);
    assert_close(volume_of(data, "Temperature"), 82.372);
}

#[test]
fn chimney() {
    let Some(data) = read("chimney_66.vtu") else {
        return;
    };
    assert_eq!((data.points.len(), data.cells.types.len()), (687, 1_703));
    assert_range(&values(&data, "Concentration"), -0.7503, 1.31337);
    // A box of 1.4 × 0.8 × 0.4.
    assert_close(volume_of(data, "Concentration"), 0.448);
}

#[test]
fn notch_stress() {
    let Some(data) = read("notch_stress_fixed.vtk") else {
        return;
    };
    assert_eq!((data.points.len(), data.cells.types.len()), (3_537, 2_192));
    assert_eq!(data.cell_counts(), [(12, 2_188), (13, 4)]);
    assert_range(&values(&data, "Nodal Stress-normed"), 3_206.6, 8_109_795.9);
    assert_eq!(
        data.fields
            .iter()
            .filter(|f| f.name.starts_with("Nodal Stress-"))
            .count(),
        8
    );
}

#[test]
fn angular_sector() {
    let Some(data) = read("AngularSector.vtk") else {
        return;
    };
    assert_eq!(data.points.len(), 10_141);
    assert_eq!(data.cell_counts(), [(12, 7_632), (14, 144)]);
    assert_range(&values(&data, "PointId"), 0.0, 9_126.0);
}

#[test]
fn tetrahedra_of_the_scenes() {
    for (name, points, cells, volume) in [
        ("bluntfin_tets.vtu", 40_960, 187_395, 931.1627),
        ("comb_tets.vtu", 47_025, 215_040, 1061.697),
    ] {
        let Some(data) = read(name) else { continue };
        assert_eq!((data.points.len(), data.cells.types.len()), (points, cells));
        assert_eq!(data.field(None).expect("it has fields").name, "density");
        assert_close(volume_of(data, "density"), volume);
    }
}
