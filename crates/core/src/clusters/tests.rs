use glam::DVec3;

use super::*;

/// A cube of n³ cubes, six tetrahedra each, with uneven spacing, so that cells are dense at the origin.
fn mesh(n: u32, association: Association) -> TetMesh {
    let at = |i: u32| f64::from(i * i) / f64::from(n * n);
    let side = n + 1;
    let grid =
        (0..side).flat_map(|z| (0..side).flat_map(move |y| (0..side).map(move |x| [x, y, z])));
    let points: Vec<DVec3> = grid
        .map(|[x, y, z]| DVec3::new(at(x), at(y), at(z)))
        .collect();
    let mut cells = Vec::new();
    for z in 0..n {
        for y in 0..n {
            for x in 0..n {
                let corner =
                    |c: u32| x + (c & 1) + side * (y + (c >> 1 & 1) + side * (z + (c >> 2)));
                for path in [[1, 3], [2, 6], [4, 5], [5, 1], [3, 2], [6, 4]] {
                    cells.push([corner(0), corner(path[0]), corner(path[1]), corner(7)]);
                }
            }
        }
    }
    let count = match association {
        Association::Point => points.len(),
        Association::Cell => cells.len(),
    };
    let scalars = Scalars {
        name: "f".into(),
        association,
        values: (0..count).map(|i| (i as f64).sin()).collect(),
    };
    TetMesh::from_tetrahedra(points, cells, scalars).expect("valid")
}

/// The corners and values of a mesh's cells, in any order.
fn cells(mesh: &TetMesh) -> Vec<Vec<[u64; 4]>> {
    let cell = |cell: usize| {
        let points = mesh.cell_points(cell);
        let scalars = mesh.cell_scalars(cell);
        let corner = |i: usize| {
            let [x, y, z] = points[i].to_array();
            [x, y, z, scalars[i]].map(f64::to_bits)
        };
        let mut corners: Vec<[u64; 4]> = (0..4).map(corner).collect();
        corners.sort_unstable();
        corners
    };
    (0..mesh.cell_count()).map(cell).collect()
}

#[test]
fn clusters_have_each_cell_once_and_no_more_than_asked() {
    for association in [Association::Point, Association::Cell] {
        let mesh = mesh(6, association);
        let mut whole = cells(&mesh);
        whole.sort_unstable();
        for most in [1, 7, 100, 1295, 1296, u32::MAX] {
            let clusters = MeshClusters::of(&mesh, most).expect("cut");
            let source = clusters.source();
            let mut found = Vec::new();
            for (i, cluster) in source.clusters().iter().enumerate() {
                let part = source.read(i).expect("in memory");
                assert!(cluster.cells <= most && cluster.cells > 0);
                assert_eq!(cluster.cells as usize, part.cell_count());
                assert_eq!(cluster.points as usize, part.points().len());
                assert_eq!(cluster.bounds, part.bounds());
                assert_eq!(cluster.scalar_range, part.scalar_range());
                found.extend(cells(&part));
            }
            found.sort_unstable();
            assert_eq!(found, whole, "{most}");
            let least = (mesh.cell_count() as u64).div_ceil(most.into());
            assert_eq!(source.clusters().len() as u64, least);
            assert_eq!(clusters.bounds(), mesh.bounds());
            assert_eq!(clusters.scalar_range(), mesh.scalar_range());
            assert_eq!(clusters.cell_count(), mesh.cell_count());
        }
    }
}

#[test]
fn little_memory_gives_the_same_cells_in_the_same_order() {
    let mesh = mesh(8, Association::Point);
    let along = |memory: u64| {
        let limits = Cut {
            most_cells: 10,
            memory,
            ..Cut::default()
        };
        let mut all = Vec::new();
        let mut parts = 0;
        cut(&mesh, &limits, &mut |part| {
            assert!(part.tetrahedra.len() <= 10);
            parts += 1;
            all.extend(cells(&part.into_mesh("f".into())?));
            Ok(())
        })
        .expect("cut");
        (all, parts)
    };
    let (whole, parts) = along(1 << 30);
    assert_eq!(parts, whole.len().div_ceil(10));
    // Room for 40 cells of 3072.
    let (little, more) = along(40 * 16);
    assert_eq!(little, whole);
    assert!(more < 2 * parts, "{more} of {parts}");
}

#[test]
fn cells_at_one_place_are_cut_all_the_same() {
    let points = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::ONE];
    let four = [[0, 1, 2, 3], [0, 1, 2, 4], [0, 1, 3, 4], [1, 2, 3, 4]];
    // All within a millionth of a box that one far point stretches.
    let mut positions: Vec<DVec3> = points.iter().map(|p| *p * 1e-7).collect();
    positions.extend([
        DVec3::splat(0.9),
        DVec3::splat(0.9) + DVec3::X,
        DVec3::splat(1.0),
        DVec3::splat(2.0),
    ]);
    let mut tetrahedra = four.to_vec();
    tetrahedra.push([5, 6, 7, 8]);
    let scalars = Scalars {
        name: "f".into(),
        association: Association::Point,
        values: vec![f64::NAN; 9],
    };
    let mesh = TetMesh::from_tetrahedra(positions, tetrahedra, scalars).expect("valid");
    let limits = Cut {
        most_cells: 1,
        memory: 0,
        ..Cut::default()
    };
    let mut sizes = Vec::new();
    cut(&mesh, &limits, &mut |part| {
        assert_eq!(part.cluster().scalar_range, None);
        sizes.push(part.tetrahedra.len());
        Ok(())
    })
    .expect("cut");
    assert_eq!(sizes, [1; 5]);
}

#[test]
fn clusters_are_the_same_every_time() {
    let mesh = mesh(12, Association::Point);
    let clusters = MeshClusters::of(&mesh, 400).expect("cut");
    let source = clusters.source();
    let again = MeshClusters::of(&mesh, 400).expect("cut");
    assert_eq!(again.source().clusters(), source.clusters());
    assert_eq!(again.source().picked(), source.picked());
}

#[test]
fn hopeless_cuts_are_refused_and_a_stop_is_heard() {
    let mesh = mesh(2, Association::Cell);
    assert!(MeshClusters::of(&mesh, 0).is_err());
    let limits = Cut::default();
    limits.stop.set();
    let cut = cut(&mesh, &limits, &mut |_| Ok(()));
    assert!(matches!(cut, Err(Error::Stopped)));
}
