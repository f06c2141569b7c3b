//! All samples against f64, cell by cell, and how often each is written.

use tetrascope_core::Unit as _;
use tetrascope_core::glam::{DMat3, DVec3};
use tetrascope_core::grid::Interpolation;
use tetrascope_core::mesh::Association;
use tetrascope_core::{Scalars, Volume};
use tetrascope_testing::{
    data_set, gpu, jumping, kuhn, mesh, mismatched, point_scalars, split, stacked_plates,
    tetrahedra_of,
};

use super::*;

mod textured;

/// A lattice of `dims` samples whose first is at `low` and whose last is at `high`.
fn lattice(dims: [usize; 3], low: DVec3, high: DVec3) -> Lattice {
    let cells = DVec3::from_array(dims.map(|d| (d - 1) as f64));
    Lattice {
        dims,
        origin: low,
        spacing: (high - low) / cells,
        direction: DMat3::IDENTITY,
        interpolation: Interpolation::Linear,
    }
}

/// A lattice around a mesh, a little larger than it.
fn around(mesh: &TetMesh, dims: [usize; 3]) -> Lattice {
    let bounds = mesh.bounds();
    let margin = 0.03 * bounds.size();
    lattice(dims, bounds.min - margin, bounds.max + margin)
}

/// The same samples on axes that are turned about their center.
fn turned(lattice: Lattice, direction: DMat3) -> Lattice {
    let cells = DVec3::from_array(lattice.dims.map(|d| (d - 1) as f64));
    let center = lattice.point(0.5 * cells);
    let origin = center - direction * (lattice.spacing * (0.5 * cells));
    Lattice {
        origin,
        direction,
        ..lattice
    }
}

/// A rotation by no round angle about no axis.
fn rotation() -> DMat3 {
    DMat3::from_axis_angle(DVec3::new(1.0, -2.0, 0.5).unit(), 0.7)
}

fn tuning(gpu: &Gpu) -> Tuning {
    Tuning {
        counted: true,
        ..Tuning::new(gpu)
    }
}

fn resampler(gpu: &Gpu, mesh: &TetMesh, lattice: &Lattice, tuning: Tuning) -> Resampler {
    let options = ResamplerOptions::default();
    let made = Resampler::tuned(gpu, mesh, lattice, &options, tuning).expect("it fits");
    made.resample().expect("it runs");
    made
}

/// Scalars, coverage and writes of each sample.
fn taken(made: &Resampler) -> (Vec<[f32; 2]>, Vec<u32>) {
    let gpu = &made.gpu;
    let mut encoder = gpu.device().create_command_encoder(&Default::default());
    let Way::Direct(direct) = &made.way else {
        panic!("only these are counted");
    };
    let writes = direct.writes();
    let texels = read_back(gpu, &mut encoder, Source::Texture(made.grid.texture()));
    let writes = read_back(gpu, &mut encoder, Source::Buffer(writes, writes.size()));
    gpu.finish(encoder).expect("a copy");
    let texels: Vec<[f32; 2]> = texels.expect("a copy").read().expect("readable");
    let writes: Vec<u32> = writes.expect("a copy").read().expect("readable");
    for (texel, count) in texels.iter().zip(&writes) {
        let expected = if *count > 0 { 1.0 } else { 0.0 };
        assert_eq!(
            texel[1], expected,
            "coverage of what was written {count} times"
        );
    }
    (texels, writes)
}

/// A cell that may contain a sample.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    /// How deep the sample is in the cell, in samples; negative outside.
    depth: f64,
    /// The linear interpolant there, between the corners' least and greatest.
    scalar: f64,
    /// How much rounding may move a face of the cell, in samples.
    reach: f64,
    /// How much that changes the scalar.
    slack: f64,
    /// The difference of the corners' least and greatest.
    range: f64,
}

/// A vertex moves by what its distance from a column is rounded by, 2⁻²⁴ of it. A face's crossing
/// errs by some four times that across and along, so a sample's depth by at most 2⁻²⁰ of the
/// cell's extent.
const ROUNDING: f64 = 1.0 / (1u64 << 20) as f64;

/// For each sample the cells in which it is, or beside which it is by no more than rounding and
/// `beside` samples.
fn candidates(mesh: &TetMesh, lattice: &Lattice, beside: f64) -> Vec<Vec<Candidate>> {
    let [nx, ny, nz] = lattice.dims;
    let mut found = vec![Vec::new(); nx * ny * nz];
    let from_world = lattice.linear().inverse();
    for cell in 0..mesh.cell_count() {
        let p = mesh
            .cell_points(cell)
            .map(|p| from_world * (p - lattice.origin));
        let s = mesh.cell_scalars(cell);
        let edges = DMat3::from_cols(p[1] - p[0], p[2] - p[0], p[3] - p[0]);
        if edges.determinant() == 0.0 || s.iter().any(|s| !s.is_finite()) {
            continue;
        }
        // Rows are the gradients of the shares of corners 1 to 3.
        let shares = edges.inverse();
        let rows = shares.transpose();
        let gradients = [
            -(rows.x_axis + rows.y_axis + rows.z_axis),
            rows.x_axis,
            rows.y_axis,
            rows.z_axis,
        ];
        let slope = (0..4).fold(DVec3::ZERO, |sum, i| sum + s[i] * gradients[i]);
        let low = p[0].min(p[1]).min(p[2]).min(p[3]);
        let high = p[0].max(p[1]).max(p[2]).max(p[3]);
        let reach = beside + ROUNDING * (high - low).max_element();
        let range = |axis: usize, count: usize| {
            let first = (low[axis] - reach).ceil().max(0.0) as usize;
            let end = ((high[axis] + reach).floor() + 1.0).clamp(0.0, count as f64) as usize;
            first..end
        };
        for z in range(2, nz) {
            for y in range(1, ny) {
                for x in range(0, nx) {
                    let place = DVec3::new(x as f64, y as f64, z as f64);
                    let of_rest = shares * (place - p[0]);
                    let w = [1.0 - of_rest.element_sum(), of_rest.x, of_rest.y, of_rest.z];
                    let depth = (0..4).map(|i| w[i] / gradients[i].length());
                    let depth = depth.fold(f64::INFINITY, f64::min);
                    if depth < -reach {
                        continue;
                    }
                    let scalar = (0..4).map(|i| w[i] * s[i]).sum::<f64>();
                    let least = s.iter().copied().fold(f64::INFINITY, f64::min);
                    let greatest = s.iter().copied().fold(f64::NEG_INFINITY, f64::max);
                    found[x + nx * (y + ny * z)].push(Candidate {
                        depth,
                        scalar: scalar.clamp(least, greatest),
                        reach,
                        slack: reach * slope.length() + 1e-30,
                        range: greatest - least,
                    });
                }
            }
        }
    }
    found
}

/// Plates in which the field has all of its range within 2⁻¹¹ of their width: turned, what
/// rounding explains is more than 10⁻⁵ of the range.
const STEEP: &str = "turned plates";

/// Facts about all samples of a mesh.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    inside: usize,
    outside: usize,
    /// Within rounding of the surface.
    between: usize,
    /// Written more than once.
    twice: usize,
    /// The greatest difference from the interpolant, as a share of the range.
    error: f64,
    /// The same as a share of what rounding explains: of a cell's corners and of the scalar.
    explained: f64,
}

/// Holds all samples to the interpolant in f64 of a cell in which they are.
fn judge(name: &str, made: &Resampler, mesh: &TetMesh) -> Judged {
    let lattice = made.grid().lattice();
    let range = mesh.scalar_range().expect("values");
    let width = (range.1 - range.0).max(f64::MIN_POSITIVE);
    // A scalar is rounded at each corner, on faces and between them.
    let rounding = 4.0 * f64::from(f32::EPSILON) * range.0.abs().max(range.1.abs());
    let mut judged = Judged::default();
    let (texels, writes) = taken(made);
    for (i, found) in candidates(mesh, lattice, 0.0).iter().enumerate() {
        let place = [
            i % lattice.dims[0],
            i / lattice.dims[0] % lattice.dims[1],
            i / (lattice.dims[0] * lattice.dims[1]),
        ];
        let [scalar, coverage] = texels[i];
        judged.twice += usize::from(writes[i] > 1);
        // A sample on the surface may be left out, and one on a face is deep in neither cell.
        let deep = found.iter().any(|c| c.depth > c.reach);
        if found.is_empty() {
            judged.outside += 1;
            assert_eq!(coverage, 0.0, "{name}: {place:?} is outside");
            continue;
        }
        if coverage == 0.0 {
            assert!(!deep, "{name}: {place:?} is inside: {found:?}");
            judged.between += 1;
            continue;
        }
        judged.inside += 1;
        let off = |c: &Candidate| (f64::from(scalar) - c.scalar).abs();
        let error = found.iter().map(off).fold(f64::INFINITY, f64::min) / width;
        let explained = found.iter().map(|c| off(c) / (c.slack + rounding));
        judged.error = judged.error.max(error);
        judged.explained = judged
            .explained
            .max(explained.fold(f64::INFINITY, f64::min));
        assert!(
            error <= 1e-5 || judged.explained <= 1.0 && name == STEEP,
            "{name}: {scalar} at {place:?}, {error:e} from {found:?}"
        );
    }
    eprintln!("{name}: {judged:?}");
    judged
}

/// Every sample is written at most once, and what errors there are rounding explains.
fn is_whole(judged: Judged) {
    assert!(judged.inside > 0 && judged.twice == 0, "{judged:?}");
    assert!(judged.explained <= 1.0, "{judged:?}");
}

fn wavy(p: DVec3) -> f64 {
    (3.0 * p.x).sin() + (2.0 * p.y + 1.0).cos() + p.z * p.x
}

/// A number in [0, 1) for each i, without pattern.
fn random(i: usize) -> f64 {
    let mut h = (i as u64 + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((h ^ (h >> 31)) >> 11) as f64 / (1u64 << 53) as f64
}

/// n³ cubes of six cells in [0, 1]³, from large ones to those 10⁵ times smaller at one corner,
/// their inner points moved by up to `jitter` of their distance.
fn graded(n: usize, jitter: f64) -> TetMesh {
    let (mut points, cells) = kuhn(n, DVec3::ZERO, DVec3::ONE, |_| true);
    let place = |share: f64| 1e-5f64.powf(1.0 - share) * (1.0 - (1.0 - share).powi(40));
    for (i, point) in points.iter_mut().enumerate() {
        let inner =
            point.cmpgt(DVec3::splat(1e-9)).all() && point.cmplt(DVec3::splat(1.0 - 1e-9)).all();
        if inner {
            let by = DVec3::new(random(3 * i), random(3 * i + 1), random(3 * i + 2)) - 0.5;
            *point += 2.0 * jitter / n as f64 * by;
        }
        *point = DVec3::new(place(point.x), place(point.y), place(point.z));
    }
    mesh((points, cells), wavy)
}

/// Cells a thousand times wider than thick, as in boundary layers, and others 10⁵ times.
fn layers(thin: f64) -> TetMesh {
    let (mut points, cells) = kuhn(6, DVec3::ZERO, DVec3::ONE, |_| true);
    for point in &mut points {
        let share = (6.0 * point.z).round();
        // Every second layer is thin.
        let below = (share / 2.0).floor() / 3.0;
        point.z = below + if share % 2.0 == 1.0 { thin } else { 0.0 };
        point.x += 0.01 * (5.0 * point.y).sin();
        point.z += 0.1 * point.x * point.y;
    }
    mesh((points, cells), wavy)
}

#[test]
fn every_sample_in_a_mesh_is_its_interpolant() {
    let Some(gpu) = gpu("every_sample_in_a_mesh_is_its_interpolant") else {
        return;
    };
    let meshes = [
        ("sphere", data_set("sphere", Some(20_000))),
        ("graded", graded(9, 0.3)),
        ("layers of 1e-3", layers(1e-3)),
        ("layers of 1e-5", layers(1e-5)),
    ];
    for (name, mesh) in meshes {
        for dims in [[48, 40, 33], [20, 21, 50], [17, 64, 30]] {
            let around = around(&mesh, dims);
            let made = resampler(&gpu, &mesh, &around, tuning(&gpu));
            is_whole(judge(name, &made, &mesh));
        }
    }
}

#[test]
fn lattices_may_be_turned_mirrored_and_partly_outside() {
    let Some(gpu) = gpu("lattices_may_be_turned_mirrored_and_partly_outside") else {
        return;
    };
    let mesh = data_set("sphere", Some(8_000));
    let straight = around(&mesh, [40, 33, 27]);
    let mirror = DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0));
    for direction in [rotation(), mirror, rotation() * mirror] {
        let lattice = turned(straight, direction);
        let made = resampler(&gpu, &mesh, &lattice, tuning(&gpu));
        is_whole(judge("turned", &made, &mesh));
    }
    // A corner of the mesh, much finer than its cells.
    let bounds = mesh.bounds();
    let corner = lattice(
        [30, 40, 50],
        bounds.min - 0.01 * bounds.size(),
        bounds.min + 0.13 * bounds.size(),
    );
    let made = resampler(&gpu, &mesh, &corner, tuning(&gpu));
    is_whole(judge("a corner", &made, &mesh));
}

#[test]
fn a_linear_field_is_reproduced_to_rounding() {
    let Some(gpu) = gpu("a_linear_field_is_reproduced_to_rounding") else {
        return;
    };
    let linear = |p: DVec3| 0.3 * p.x - 0.7 * p.y + 0.2 * p.z + 0.1;
    let with = |mesh: &TetMesh| {
        let values = mesh.points().iter().map(|p| linear(*p)).collect();
        mesh.with_scalars(point_scalars(values)).expect("as many")
    };
    let meshes = [
        with(&data_set("sphere", Some(8_000))),
        with(&graded(9, 0.3)),
        with(&layers(1e-5)),
        with(&slivers()),
    ];
    for mesh in meshes {
        let around = around(&mesh, [40, 36, 34]);
        let made = resampler(&gpu, &mesh, &around, tuning(&gpu));
        let (low, high) = mesh.scalar_range().expect("values");
        let (texels, _) = taken(&made);
        let mut greatest = 0.0_f64;
        let mut inside = 0;
        for (i, [scalar, coverage]) in texels.iter().enumerate() {
            if *coverage == 1.0 {
                let place = [i % 40, i / 40 % 36, i / (40 * 36)].map(|i| i as f64);
                let truth = linear(around.point(place.into()));
                greatest = greatest.max((f64::from(*scalar) - truth).abs());
                inside += 1;
            }
        }
        eprintln!(
            "{inside} samples, {:e} of the range",
            greatest / (high - low)
        );
        // Rounded are a vertex's scalar, and its places by at most 2⁻²⁴ of the mesh's extent,
        // over which the field has its range; some eight times on the way.
        assert!(inside > 1000 && greatest <= 2.0f64.powi(-21) * (high - low));
    }
}

/// Cells whose four corners are almost in one plane, the worst there are: a square whose
/// diagonals pass each other 10⁻⁴ apart, among others that fill the space around it.
fn slivers() -> TetMesh {
    let n = 6;
    let (mut points, cells) = kuhn(n, DVec3::ZERO, DVec3::ONE, |_| true);
    for (i, point) in points.iter_mut().enumerate() {
        let cube = (*point * n as f64).round();
        // Every second plane of points almost touches the one before.
        for axis in 0..3 {
            if cube[axis] % 2.0 == 1.0 {
                point[axis] -= (1.0 - 1e-4 * (1.0 + random(3 * i + axis))) / n as f64;
            }
        }
    }
    mesh((points, cells), wavy)
}

#[test]
fn slivers_lose_no_sample_and_explain_their_errors() {
    let Some(gpu) = gpu("slivers_lose_no_sample_and_explain_their_errors") else {
        return;
    };
    let mesh = slivers();
    for direction in [DMat3::IDENTITY, rotation()] {
        let lattice = turned(around(&mesh, [50, 41, 36]), direction);
        let made = resampler(&gpu, &mesh, &lattice, tuning(&gpu));
        is_whole(judge("slivers", &made, &mesh));
    }
}

/// Samples on faces, edges and vertices: the worst case. A sample on the surface belongs to the
/// mesh on one side of each axis, so as many as intervals along it.
#[test]
fn a_sample_on_a_lattice_of_cells_is_written_once() {
    let Some(gpu) = gpu("a_sample_on_a_lattice_of_cells_is_written_once") else {
        return;
    };
    // Cubes of 1, 2, 3, 5 and 7 samples per side, of a third and a seventh of one, and others that
    // no float has.
    for (n, samples) in [(6, 1), (6, 2), (4, 3), (3, 5), (2, 7), (12, 0), (21, 0)] {
        let count = if samples == 0 {
            n / [3, 7][usize::from(n == 21)]
        } else {
            n * samples
        };
        for (scale, shift) in [(1.0, 0.0), (0.1, 0.7), (1.0 / 3.0, -5.1)] {
            for direction in [DMat3::IDENTITY, rotation()] {
                let side = count as f64 * scale;
                let cells = kuhn(n, DVec3::ZERO, DVec3::splat(side), |_| true);
                let place = |p: DVec3| direction * (p + shift);
                let cells = (cells.0.into_iter().map(place).collect(), cells.1);
                let mesh = mesh(cells, |p| p.x - p.y);
                // One sample farther on each side.
                let dims = [count + 3, count + 4, count + 5];
                let lattice = Lattice {
                    dims,
                    origin: place(DVec3::splat(-scale)),
                    spacing: DVec3::splat(scale),
                    direction,
                    interpolation: Interpolation::Linear,
                };
                let made = resampler(&gpu, &mesh, &lattice, tuning(&gpu));
                let (_, writes) = taken(&made);
                let what = format!("{n} cubes, {count} samples, {scale}, {shift}, {direction}");
                let mut twice = 0;
                for (i, &times) in writes.iter().enumerate() {
                    let at = [i % dims[0], i / dims[0] % dims[1], i / (dims[0] * dims[1])];
                    let inner = at.iter().all(|&i| i > 1 && i < count + 1);
                    let outer = at.iter().any(|&i| i < 1 || i > count + 1);
                    assert!(
                        times <= 1 || direction == rotation(),
                        "{what}: {at:?} {times} times"
                    );
                    twice += usize::from(times > 1);
                    assert!(!inner || times >= 1, "{what}: {at:?} not written");
                    assert!(!outer || times == 0, "{what}: {at:?} is outside");
                }
                // Turned points are off their samples by rounding of f64, so that columns pass
                // vertical edges by as little: then rounding may swap the faces of a cell.
                assert!(
                    twice <= 1 + count * count * count / 100,
                    "{what}: {twice} twice"
                );
                let all = writes.iter().sum::<u32>() as usize;
                // A turned mesh is not exactly on the samples: its surface may be on either side.
                if direction == DMat3::IDENTITY && scale == 1.0 && shift == 0.0 {
                    assert_eq!(all, count * count * count, "{what}");
                }
            }
        }
    }
}

#[test]
fn adversarial_meshes_are_sampled_where_they_are() {
    let Some(gpu) = gpu("adversarial_meshes_are_sampled_where_they_are") else {
        return;
    };
    let sphere = data_set("sphere", Some(4_000));
    let volumes: [(&str, Volume); 4] = [
        ("plates", stacked_plates(40)),
        ("mismatched", mismatched(5)),
        ("split", split(&sphere)),
        ("jumping", jumping(&sphere)),
    ];
    for (name, volume) in volumes {
        let mesh = tetrahedra_of(&volume);
        let lattice = around(mesh, [31, 30, 71]);
        let made = resampler(&gpu, mesh, &lattice, tuning(&gpu));
        is_whole(judge(name, &made, mesh));
        let lattice = turned(lattice, rotation());
        let made = resampler(&gpu, mesh, &lattice, tuning(&gpu));
        let name = if name == "plates" { STEEP } else { name };
        is_whole(judge(name, &made, mesh));
    }
}

/// A sphere whose cells have scalars of their own, but for one that has none.
fn with_cell_scalars() -> TetMesh {
    let mesh = data_set("sphere", Some(4_000));
    let mut values: Vec<f64> = (0..mesh.cell_count())
        .map(|c| (c * 7 % 101) as f64)
        .collect();
    values[17] = f64::NAN;
    let scalars = Scalars {
        name: "c".into(),
        association: Association::Cell,
        values,
    };
    mesh.with_scalars(scalars).expect("as many")
}

#[test]
fn fields_of_cells_are_constant_in_each() {
    let Some(gpu) = gpu("fields_of_cells_are_constant_in_each") else {
        return;
    };
    let mesh = with_cell_scalars();
    let made = resampler(&gpu, &mesh, &around(&mesh, [37, 30, 41]), tuning(&gpu));
    is_whole(judge("cells", &made, &mesh));
    let (texels, _) = taken(&made);
    assert!(texels.iter().all(|t| t[0].fract() == 0.0));
}

/// Cells of more samples than one invocation, workgroup and 64 workgroups take, and grids of
/// several parts: the same samples.
#[test]
fn samples_do_not_depend_on_how_work_is_divided() {
    let Some(gpu) = gpu("samples_do_not_depend_on_how_work_is_divided") else {
        return;
    };
    let one = |dims: [usize; 3], n: usize, tuning: Tuning| {
        let cells = kuhn(n, DVec3::ZERO, DVec3::ONE, |_| true);
        let mesh = mesh(cells, wavy);
        let made = resampler(&gpu, &mesh, &around(&mesh, dims), tuning);
        let (texels, writes) = taken(&made);
        assert!(writes.iter().all(|times| *times <= 1));
        texels
    };
    let usual = tuning(&gpu);
    let parts = Tuning { side: 13, ..usual };
    let none = Tuning { small: 0, ..usual };
    for (dims, n) in [([40, 35, 50], 2), ([90, 80, 70], 1)] {
        let expected = one(dims, n, usual);
        assert!(expected.iter().filter(|t| t[1] == 1.0).count() > 10_000);
        assert!(one(dims, n, parts) == expected, "in parts");
        assert!(one(dims, n, none) == expected, "by workgroups");
    }
    // 262² columns are more than 64 workgroups take.
    let dims = [262, 262, 263];
    let texels = one(dims, 1, usual);
    let lattice = lattice(dims, DVec3::splat(-0.03), DVec3::splat(1.03));
    for (i, [_, coverage]) in texels.iter().enumerate() {
        let place = [i % 262, i / 262 % 262, i / (262 * 262)].map(|i| i as f64);
        let p = lattice.point(place.into());
        let inside = p.cmpgt(DVec3::ZERO).all() && p.cmplt(DVec3::ONE).all();
        assert_eq!(*coverage, f32::from(u8::from(inside)), "{p}");
    }
}

#[test]
fn reloading_leaves_nothing_of_the_old_mesh() {
    let Some(gpu) = gpu("reloading_leaves_nothing_of_the_old_mesh") else {
        return;
    };
    let meshes = [
        data_set("sphere", Some(4_000)),
        graded(5, 0.2),
        layers(1e-3),
        data_set("sphere", Some(6_000)),
    ];
    let lattice = lattice([33, 30, 35], DVec3::splat(-1.1), DVec3::splat(1.1));
    let mut made = resampler(&gpu, &meshes[0], &lattice, tuning(&gpu));
    let mut sizes = Vec::new();
    for round in 0..2 {
        for mesh in &meshes {
            made.reload(mesh).expect("it fits");
            made.resample().expect("it runs");
            let fresh = resampler(&gpu, mesh, &lattice, tuning(&gpu));
            assert!(taken(&made) == taken(&fresh), "round {round}");
            assert_eq!(made.grid().scalar_range(), fresh.grid().scalar_range());
        }
        sizes.push(made.bytes());
    }
    assert_eq!(
        sizes[0], sizes[1],
        "sizes that were seen need no other buffers"
    );
    // Moved away: an empty grid.
    let far = |p: DVec3| p + DVec3::splat(50.0);
    let points = meshes[0].points().iter().map(|p| far(*p)).collect();
    let cells = meshes[0].tetrahedra().to_vec();
    let moved = TetMesh::from_tetrahedra(points, cells, meshes[0].scalars().clone());
    made.reload(&moved.expect("a mesh")).expect("it fits");
    made.resample().expect("it runs");
    assert!(taken(&made).0.iter().all(|texel| *texel == [0.0; 2]));
    let grid = made.read_back(Outside::Nan).expect("read");
    assert_eq!(grid.samples().missing(), 33 * 30 * 35);
    let grid = made.read_back(Outside::Uncovered).expect("read");
    assert!(grid.coverage().expect("it has").iter().all(|c| *c == 0.0));
}

#[test]
fn what_cannot_be_sampled_is_refused_in_words() {
    let Some(gpu) = gpu("what_cannot_be_sampled_is_refused_in_words") else {
        return;
    };
    let sphere = data_set("sphere", Some(500));
    let usual = around(&sphere, [9; 3]);
    let flat = {
        let (mut points, cells) = kuhn(2, DVec3::ZERO, DVec3::ONE, |_| true);
        points.iter_mut().for_each(|p| p.z = 0.5);
        mesh((points, cells), wavy)
    };
    let of_dims = |dims| Lattice { dims, ..usual };
    let far = Lattice {
        origin: DVec3::splat(1e12),
        ..usual
    };
    let cases = [
        (&sphere, of_dims([0, 4, 4]), "at least 2 samples"),
        (&sphere, of_dims([4, 1 << 20, 4]), "texels a side"),
        (&flat, usual, "without volume"),
        (&sphere, far, "samples from the grid"),
    ];
    for (mesh, lattice, words) in cases {
        let made = Resampler::new(&gpu, mesh, &lattice, &ResamplerOptions::default());
        let error = made.expect_err(words).to_string();
        assert!(error.contains(words) && !error.contains('\n'), "{error}");
    }
    let mut made = resampler(&gpu, &sphere, &usual, tuning(&gpu));
    let before = taken(&made);
    assert!(made.reload(&flat).is_err());
    made.resample().expect("the mesh before stays");
    assert!(taken(&made) == before);
}
