//! Neighbors and duplicates of meshes at random, against what a table of all faces says.

use std::collections::HashMap;

use super::*;

/// A sequence that looks random: Steele, Lea and Flood's SplitMix64, 2014.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) % limit
    }
}

/// Cells between points at random: with few points, most of them repeat each other or share
/// faces with several others. Some points coincide, and some cells are flat.
fn tangle(seed: u64, points: u64, cells: usize) -> (Vec<DVec3>, Vec<[u32; 4]>) {
    let mut random = Random(seed);
    let mut places = Vec::new();
    for point in 0..points {
        let place = match random.below(4) {
            0 if point > 0 => places[random.below(point) as usize],
            _ => DVec3::from_array([0; 3].map(|_| random.below(6) as f64)),
        };
        places.push(place);
    }
    let cells = (0..cells).map(|_| [0; 4].map(|_| random.below(points) as u32));
    (places, cells.collect())
}

fn in_order<const N: usize>(mut numbers: [u32; N]) -> [u32; N] {
    numbers.sort_unstable();
    numbers
}

/// A mesh with its neighbors, made by so many threads.
fn made(points: &[DVec3], cells: &[[u32; 4]], threads: usize) -> (TetMesh, MeshReport) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().expect("threads").install(|| {
        let mesh = TetMesh::from_tetrahedra(points.to_vec(), cells.to_vec(), scalars(points.len()));
        let mesh = mesh.expect("all points exist");
        let report = mesh.report();
        (mesh, report)
    })
}

#[test]
fn neighbors_are_those_of_a_table_of_faces() {
    for (seed, points, cells) in [(1, 6, 40), (2, 30, 600), (3, 400, 3000), (4, 4, 9)] {
        let (points, cells) = tangle(seed, points, cells);
        let (mesh, report) = made(&points, &cells, 3);
        let places = mesh.places();
        let mut faces: HashMap<[u32; 3], Vec<(usize, usize)>> = HashMap::new();
        for (cell, places) in places.iter().enumerate() {
            for (opposite, face) in FACES.iter().enumerate() {
                let face = in_order(face.map(|corner| places[corner]));
                faces.entry(face).or_default().push((cell, opposite));
            }
        }
        let mut neighbors = vec![[NO_NEIGHBOR; 4]; places.len()];
        let mut joined = 0;
        for pair in faces.values().filter(|same| same.len() == 2) {
            let [(a, a_opposite), (b, b_opposite)] = [pair[0], pair[1]];
            neighbors[a][a_opposite] = b as u32;
            neighbors[b][b_opposite] = a as u32;
            let points = |cell: usize, opposite: usize| {
                in_order(FACES[opposite].map(|corner| mesh.tetrahedra()[cell][corner]))
            };
            joined += usize::from(points(a, a_opposite) != points(b, b_opposite));
        }
        let crowded = faces.values().filter(|same| same.len() > 2).count();
        assert_eq!(mesh.neighbors(), neighbors);
        assert_eq!(
            (report.crowded_faces, report.joined_faces),
            (crowded, joined)
        );
        let open = |&(cell, opposite): &(u32, u8)| {
            neighbors[cell as usize][usize::from(opposite)] == NO_NEIGHBOR
        };
        assert!(mesh.boundary_faces().iter().all(open));
        assert!(mesh.boundary_faces().is_sorted());
        let count = neighbors.iter().flatten().filter(|n| **n == NO_NEIGHBOR);
        assert_eq!(mesh.boundary_faces().len(), count.count());
    }
}

#[test]
fn the_first_of_equal_cells_is_kept() {
    let (points, cells) = tangle(5, 9, 500);
    let (mesh, report) = made(&points, &cells, 3);
    // The place of a point: the first that lies there.
    let place = |point: u32| {
        let there = |p: &DVec3| *p == points[point as usize];
        points.iter().position(there).expect("itself") as u32
    };
    let mut known = std::collections::HashSet::new();
    let mut kept = Vec::new();
    let mut duplicates = 0;
    for (source, cell) in cells.iter().enumerate() {
        let places = in_order(cell.map(place));
        if places.windows(2).any(|pair| pair[0] == pair[1]) {
            continue;
        }
        match known.insert(places) {
            true => kept.push(source),
            false => duplicates += 1,
        }
    }
    assert!(duplicates > 100);
    assert_eq!(report.duplicates, duplicates);
    let sources: Vec<usize> = (0..mesh.cell_count())
        .map(|c| mesh.source_cell(c))
        .collect();
    assert_eq!(sources, kept);
}

#[test]
fn threads_do_not_change_a_mesh() {
    let (points, cells) = tangle(6, 200, 20_000);
    let (one, one_report) = made(&points, &cells, 1);
    for threads in [2, 3, 11] {
        let (other, report) = made(&points, &cells, threads);
        assert_eq!(report, one_report);
        assert_eq!(other.tetrahedra(), one.tetrahedra());
        assert_eq!(other.places(), one.places());
        assert_eq!(other.neighbors(), one.neighbors());
        assert_eq!(other.boundary_faces(), one.boundary_faces());
    }
}

#[test]
fn plain_tetrahedra_are_made_as_any_cells() {
    for (seed, points, count) in [(7, 9, 500), (8, 300, 9000)] {
        let (points, tetrahedra) = tangle(seed, points, count);
        let cells = Cells {
            types: vec![10; count],
            offsets: (0..=count as u64).map(|cell| 4 * cell).collect(),
            connectivity: tetrahedra.iter().flatten().map(|&p| p.into()).collect(),
        };
        let scalars = scalars(points.len());
        let cut = TetMesh::new(points.clone(), &cells, scalars.clone()).expect("valid");
        let plain = TetMesh::from_cells(points.clone(), cells.clone(), scalars.clone());
        let plain = plain.expect("valid");
        assert_eq!(plain.tetrahedra(), cut.tetrahedra());
        assert_eq!(plain.places(), cut.places());
        assert_eq!(plain.report(), cut.report());
        assert!(cut.report().flipped > 0 && cut.report().degenerate > 0);
        // What is wrong is said in the same words.
        let mut wrong = cells;
        wrong.connectivity[77] = 4000;
        let mut far = points.clone();
        far[5].y = f64::INFINITY;
        for (points, cells) in [(points, &wrong), (far, &wrong)] {
            let line = |result: Result<TetMesh, Error>| result.expect_err("wrong").to_string();
            let cut = line(TetMesh::new(points.clone(), cells, scalars.clone()));
            let plain = line(TetMesh::from_cells(points, cells.clone(), scalars.clone()));
            assert_eq!(plain, cut);
        }
    }
}
