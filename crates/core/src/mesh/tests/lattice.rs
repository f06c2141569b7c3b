//! Properties of splits, on lattices of mixed cells with shuffled points.

use proptest::prelude::*;

use super::*;

/// Cells per axis.
const SIZE: [usize; 3] = [3, 2, 3];

/// How a column of cubes, or one cube, becomes cells.
#[derive(Clone, Copy, Debug)]
enum Fill {
    Hexahedron,
    Voxel,
    Pyramids,
}

#[derive(Clone, Debug)]
struct Lattice {
    /// A number for each lattice point, and then for each cube's center.
    numbers: Vec<u64>,
    positions: Vec<DVec3>,
    fills: Vec<Fill>,
    /// For each column along z: none, or wedges cut along one of two diagonals.
    wedges: Vec<Option<bool>>,
    /// For each cube one of the 48 symmetries of its own numbering.
    symmetries: Vec<usize>,
}

fn lattice_point([i, j, k]: [usize; 3]) -> usize {
    i + (SIZE[0] + 1) * (j + (SIZE[1] + 1) * k)
}

fn lattice_points() -> impl Iterator<Item = [usize; 3]> {
    (0..=SIZE[2])
        .flat_map(|k| (0..=SIZE[1]).flat_map(move |j| (0..=SIZE[0]).map(move |i| [i, j, k])))
}

fn cubes() -> impl Iterator<Item = [usize; 3]> {
    (0..SIZE[2]).flat_map(|k| (0..SIZE[1]).flat_map(move |j| (0..SIZE[0]).map(move |i| [i, j, k])))
}

const CUBE_COUNT: usize = SIZE[0] * SIZE[1] * SIZE[2];
const POINT_COUNT: usize = (SIZE[0] + 1) * (SIZE[1] + 1) * (SIZE[2] + 1);

/// One of the 48 ways to turn or mirror a corner's offset.
fn turned(corner: [usize; 3], symmetry: usize) -> [usize; 3] {
    const ORDERS: [[usize; 3]; 6] = [
        [0, 1, 2],
        [1, 2, 0],
        [2, 0, 1],
        [0, 2, 1],
        [2, 1, 0],
        [1, 0, 2],
    ];
    let order = ORDERS[symmetry / 8];
    std::array::from_fn(|axis| corner[order[axis]] ^ (symmetry >> axis & 1))
}

impl Lattice {
    /// `moved` shifts points that are inside the box by up to 0.08 per axis, so that faces
    /// are not flat.
    fn strategy(with_wedges: bool, moved: bool) -> impl Strategy<Value = Lattice> {
        let numbers: Vec<u64> = (0..(POINT_COUNT + CUBE_COUNT) as u64).collect();
        let fill = prop_oneof![
            Just(Fill::Hexahedron),
            Just(Fill::Voxel),
            Just(Fill::Pyramids)
        ];
        let wedge = prop_oneof![Just(None), Just(Some(false)), Just(Some(true))];
        let shift = if moved { 0.08 } else { 0.0 };
        (
            Just(numbers).prop_shuffle(),
            prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), POINT_COUNT),
            prop::collection::vec(fill, CUBE_COUNT),
            prop::collection::vec(wedge, SIZE[0] * SIZE[1]),
            prop::collection::vec(0..48_usize, CUBE_COUNT),
        )
            .prop_map(move |(numbers, shifts, fills, wedges, symmetries)| {
                let mut positions: Vec<DVec3> = lattice_points()
                    .zip(shifts)
                    .map(|(at, by)| {
                        DVec3::from_array(std::array::from_fn(|axis| {
                            let inside = at[axis] != 0 && at[axis] != SIZE[axis];
                            at[axis] as f64 + if inside { shift * by[axis] } else { 0.0 }
                        }))
                    })
                    .collect();
                positions.extend(
                    cubes().map(|c| DVec3::from_array(c.map(|i| i as f64)) + DVec3::splat(0.5)),
                );
                Lattice {
                    numbers,
                    positions,
                    fills,
                    wedges: if with_wedges {
                        wedges
                    } else {
                        vec![None; SIZE[0] * SIZE[1]]
                    },
                    symmetries,
                }
            })
    }

    /// The cells of cubes that `keep` accepts, by lattice point (not by number).
    fn cells(&self, keep: impl Fn([usize; 3]) -> bool) -> Cells {
        let mut list: Vec<(u8, Vec<u64>)> = Vec::new();
        for (index, cube) in cubes().enumerate().filter(|(_, cube)| keep(*cube)) {
            let corner = |offset: [usize; 3]| {
                lattice_point(std::array::from_fn(|axis| cube[axis] + offset[axis])) as u64
            };
            let symmetry = self.symmetries[index];
            if let Some(diagonal) = self.wedges[cube[0] + SIZE[0] * cube[1]] {
                let halves = if diagonal {
                    [[0, 1, 2], [0, 2, 3]]
                } else {
                    [[1, 2, 3], [1, 3, 0]]
                };
                for half in halves {
                    let bottom = half.map(|i| corner(CUBE[i].map(usize::from)));
                    let top = half.map(|i| corner(CUBE[i + 4].map(usize::from)));
                    let wedge = if symmetry < 24 {
                        [bottom, top]
                    } else {
                        [top, bottom]
                    };
                    list.push((13, wedge.concat()));
                }
                continue;
            }
            match self.fills[index] {
                Fill::Hexahedron => {
                    list.push((
                        12,
                        CUBE.map(|c| corner(turned(c.map(usize::from), symmetry)))
                            .to_vec(),
                    ));
                }
                Fill::Voxel => {
                    let row = |i: usize| corner(turned([i & 1, i >> 1 & 1, i >> 2], symmetry));
                    list.push((11, (0..8).map(row).collect()));
                }
                Fill::Pyramids => {
                    for face in cell_type::HEXAHEDRON.faces {
                        let mut pyramid: Vec<u64> = face
                            .iter()
                            .map(|&i| corner(CUBE[i].map(usize::from)))
                            .collect();
                        pyramid.rotate_left(symmetry % 4);
                        if symmetry % 8 >= 4 {
                            pyramid.reverse();
                        }
                        pyramid.push((POINT_COUNT + index) as u64);
                        list.push((14, pyramid));
                    }
                }
            }
        }
        let list: Vec<(u8, &[u64])> = list.iter().map(|(t, c)| (*t, c.as_slice())).collect();
        super::cells(&list)
    }

    /// Points and cells by number.
    fn renumbered(&self, mut cells: Cells) -> (Vec<DVec3>, Cells) {
        let mut points = vec![DVec3::ZERO; self.numbers.len()];
        for (&number, &position) in self.numbers.iter().zip(&self.positions) {
            points[number as usize] = position;
        }
        for point in &mut cells.connectivity {
            *point = self.numbers[*point as usize];
        }
        (points, cells)
    }

    fn mesh(&self, cells: Cells, split: Split) -> TetMesh {
        let (points, cells) = self.renumbered(cells);
        let count = points.len();
        TetMesh::with_split(points, &cells, scalars(count), split).expect("valid")
    }
}

/// The volume of the undivided box.
const BOX_VOLUME: f64 = CUBE_COUNT as f64;

/// A few hundred volumes of up to 1, each of a few roundings.
const VOLUME_TOLERANCE: f64 = 1e3 * f64::EPSILON * BOX_VOLUME;

/// Every face has two cells or lies in a side of the box: cuts agree, and none is missing.
fn assert_fills_the_box(mesh: &TetMesh) -> Result<(), TestCaseError> {
    prop_assert!((mesh.volume() - BOX_VOLUME).abs() < VOLUME_TOLERANCE);
    let report = mesh.report();
    prop_assert_eq!(report.crowded_faces, 0);
    prop_assert_eq!(report.folded, 0);
    prop_assert_eq!(report.degenerate, 0);
    for &(cell, opposite) in mesh.boundary_faces() {
        let corners = mesh.cell_points(cell as usize);
        let face = FACES[usize::from(opposite)].map(|i| corners[i]);
        let in_a_side = (0..3).any(|axis| {
            [0.0, SIZE[axis] as f64]
                .iter()
                .any(|side| face.iter().all(|p| p[axis] == *side))
        });
        prop_assert!(in_a_side, "{face:?} is inside the box and has one cell");
    }
    let boundary = mesh.boundary_statistics();
    prop_assert!(boundary.closed);
    prop_assert_eq!(boundary.components, 1);
    prop_assert_eq!(boundary.euler_characteristic, 2);
    prop_assert!(boundary.convex);
    Ok(())
}

/// Moves the points (i, 0, 0) to (i, 1, 0), as in the Blunt Fin: the cubes at that edge
/// become wedges, which halves their volume.
fn collapse_edges_in_space(lattice: &mut Lattice) -> f64 {
    for i in 0..=SIZE[0] {
        lattice.positions[lattice_point([i, 0, 0])] = lattice.positions[lattice_point([i, 1, 0])];
    }
    BOX_VOLUME - 0.5 * SIZE[0] as f64
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn splits_agree_for_any_mixture_and_numbering(lattice in Lattice::strategy(true, true)) {
        let mesh = lattice.mesh(lattice.cells(|_| true), Split::SmallestIndex);
        assert_fills_the_box(&mesh)?;
    }

    #[test]
    fn five_alternating_agrees_for_hexahedra_and_pyramids(lattice in Lattice::strategy(false, true)) {
        let mesh = lattice.mesh(lattice.cells(|_| true), Split::FiveAlternating);
        assert_fills_the_box(&mesh)?;
        let report = mesh.report();
        let count = |t: u8| report.cells_by_type.get(&t).copied().unwrap_or(0);
        prop_assert_eq!(mesh.cell_count(), 5 * (count(11) + count(12)) + 2 * count(14));
    }

    /// Two blocks that share no points cut the faces where they touch alike.
    #[test]
    fn blocks_that_touch_agree(
        lattice in prop_oneof![Lattice::strategy(true, true), Lattice::strategy(false, true)]
    ) {
        let mut cells = lattice.cells(|cube| cube[0] == 0);
        let mut other = lattice.cells(|cube| cube[0] != 0);
        let mut lattice = lattice;
        // The second block has its own copies of all points, numbered the other way around.
        let count = lattice.numbers.len() as u64;
        lattice.numbers.extend(lattice.numbers.clone().iter().map(|n| 2 * count - 1 - n));
        lattice.positions.extend(lattice.positions.clone());
        let end = cells.connectivity.len() as u64;
        cells.types.append(&mut other.types);
        cells.offsets.extend(other.offsets[1..].iter().map(|o| o + end));
        cells.connectivity.extend(other.connectivity.iter().map(|p| p + count));
        let mesh = lattice.mesh(cells.clone(), Split::SmallestIndex);
        assert_fills_the_box(&mesh)?;
        prop_assert_eq!(mesh.report().joined_faces, 2 * SIZE[1] * SIZE[2]);
        if lattice.wedges.iter().all(Option::is_none) {
            let mesh = lattice.mesh(cells, Split::FiveAlternating);
            assert_fills_the_box(&mesh)?;
            prop_assert_eq!(mesh.report().joined_faces, 2 * SIZE[1] * SIZE[2]);
        }
    }

    #[test]
    fn edges_collapsed_in_space_invert_nothing(mut lattice in Lattice::strategy(false, false)) {
        lattice.fills.fill(Fill::Hexahedron);
        let volume = collapse_edges_in_space(&mut lattice);
        for split in [Split::SmallestIndex, Split::FiveAlternating] {
            let mesh = lattice.mesh(lattice.cells(|_| true), split);
            prop_assert!((mesh.volume() - volume).abs() < VOLUME_TOLERANCE);
            let report = mesh.report();
            prop_assert_eq!(report.folded, 0);
            prop_assert_eq!(report.crowded_faces, 0);
            prop_assert!(report.collapsed > 0);
            prop_assert_eq!(report.degenerate, 0);
            prop_assert_eq!(mesh.boundary_statistics().euler_characteristic, 2);
            prop_assert!(mesh.boundary_statistics().closed);
        }
    }

    /// The same shape, but the cells name one point twice.
    #[test]
    fn edges_collapsed_by_index_leave_no_gap(mut lattice in Lattice::strategy(false, false)) {
        lattice.fills.fill(Fill::Hexahedron);
        let volume = collapse_edges_in_space(&mut lattice);
        let mut cells = lattice.cells(|_| true);
        for i in 0..=SIZE[0] {
            let (gone, kept) = (lattice_point([i, 0, 0]), lattice_point([i, 1, 0]));
            for point in &mut cells.connectivity {
                if *point == gone as u64 {
                    *point = kept as u64;
                }
            }
        }
        for split in [Split::SmallestIndex, Split::FiveAlternating] {
            let mesh = lattice.mesh(cells.clone(), split);
            prop_assert!((mesh.volume() - volume).abs() < VOLUME_TOLERANCE);
            let report = mesh.report();
            prop_assert!(report.collapsed > 0);
            prop_assert_eq!((report.folded, report.crowded_faces, report.degenerate), (0, 0, 0));
            let boundary = mesh.boundary_statistics();
            prop_assert!(boundary.closed);
            prop_assert_eq!(boundary.euler_characteristic, 2);
        }
    }

    /// Faces found by comparing all pairs.
    #[test]
    fn neighbors_are_those_of_brute_force(
        tetrahedra in prop::collection::vec(prop::array::uniform4(0..7_u32), 0..24)
    ) {
        let points: Vec<DVec3> = (0..7).map(|i| {
            let t = f64::from(i);
            DVec3::new(t, t * t, t * t * t)
        }).collect();
        let mesh = TetMesh::from_tetrahedra(points, tetrahedra, scalars(7)).expect("valid");
        let face = |cell: usize, opposite: usize| {
            let mut face = FACES[opposite].map(|i| mesh.tetrahedra()[cell][i]);
            face.sort_unstable();
            face
        };
        for cell in 0..mesh.cell_count() {
            for opposite in 0..4 {
                let others: Vec<u32> = (0..mesh.cell_count())
                    .filter(|&other| other != cell)
                    .filter(|&other| (0..4).any(|o| face(other, o) == face(cell, opposite)))
                    .map(|other| other as u32)
                    .collect();
                let expected = if let [one] = others[..] { one } else { NO_NEIGHBOR };
                prop_assert_eq!(mesh.neighbors()[cell][opposite], expected);
                let is_boundary = mesh.boundary_faces().contains(&(cell as u32, opposite as u8));
                prop_assert_eq!(is_boundary, expected == NO_NEIGHBOR);
            }
        }
    }
}

#[test]
fn an_odd_ring_cannot_be_colored() {
    // Three hexahedra around an axis, each a third of a ring.
    let points: Vec<DVec3> = (0..3)
        .flat_map(|third| {
            let direction = glam::DVec2::from_angle(f64::from(third) * std::f64::consts::TAU / 3.0);
            [(1.0, 0.0), (2.0, 0.0), (1.0, 1.0), (2.0, 1.0)]
                .map(|(radius, z)| DVec3::from((direction * radius, z)))
        })
        .collect();
    let ring: Vec<Vec<u64>> = (0..3)
        .map(|third| {
            let (here, next) = (4 * third, 4 * ((third + 1) % 3));
            vec![
                here,
                here + 1,
                next + 1,
                next,
                here + 2,
                here + 3,
                next + 3,
                next + 2,
            ]
        })
        .collect();
    let list: Vec<(u8, &[u64])> = ring.iter().map(|c| (12, c.as_slice())).collect();
    let cells = super::cells(&list);
    let error = TetMesh::with_split(points.clone(), &cells, scalars(12), Split::FiveAlternating)
        .expect_err("three is odd");
    assert!(error.to_string().contains("odd number of steps"), "{error}");

    let mesh = TetMesh::new(points, &cells, scalars(12)).expect("valid");
    let boundary = mesh.boundary_statistics();
    assert!(boundary.closed && !boundary.convex);
    assert_eq!(boundary.euler_characteristic, 0);
}
