//! A finned block that cools: steady heat conduction, solved by finite elements.
//!
//! Weiler, Kraus and Ertl 2002, figure 13 (right) and tables 1 to 3, draw "a
//! finite-element mesh (heat-sink)" of 121 668 cells; Westermann 2001 has one
//! too. Neither gives its shape: seven fins on a plate are ours.
//!
//! In the block −∇·(k ∇T) = 0; the plate's underside is held at 80 °C, and every
//! other face loses h (T − 20 °C) per area. Linear elements on Kuhn's cut of a
//! lattice couple only points along its axes (gradients of the others are
//! orthogonal), so the matrix has seven entries a row, none positive off the
//! diagonal: the discrete maximum principle holds, and temperatures lie between
//! 20 and 80 °C. The loss is lumped at the points, which keeps that. Conjugate
//! gradients solve it (J. Shewchuk, "An Introduction to the Conjugate Gradient
//! Method Without the Agonizing Pain", 1994, appendix B3).

use tetrascope_core::mesh::Association;
use tetrascope_core::{CameraFit, Error, Scalars, TetMesh};

use crate::lattice::{Lattice, Split};
use crate::{Dataset, Look, Make, knot};

pub(crate) const DATASET: Dataset = Dataset {
    name: "heat-sink",
    about: "a plate with seven fins, non-convex, and its temperature in steady conduction; mm, °C",
    paper: "Weiler, Kraus, Ertl 2002, figure 13; Westermann 2001, figure 6 (the shape is a reconstruction)",
    default_cells: 121_668,
    // The solver's time grows as the power 4/3 of the cells.
    max_cells: 20_000_000,
    seeded: false,
    make: Make::Mesh(make),
    cells: None,
    look,
};

/// Fins, and the widths in mm of a fin and of the gap between two.
const FINS: usize = 7;
const FIN: f64 = 2.0;
const GAP: f64 = 3.0;
/// Heights of the plate and of the fins on it, and the length of both, mm.
const PLATE: f64 = 4.0;
const HEIGHT: f64 = 21.0;
const LENGTH: f64 = 48.0;

/// k, aluminium: W/(mm K).
const CONDUCTIVITY: f64 = 0.2;
/// h, in a stream of water: W/(mm² K).
const TRANSFER: f64 = 6e-4;
/// °C.
const AMBIENT: f64 = 20.0;
const BASE: f64 = 80.0;

/// How many lattice cells there are across each part.
struct Parts {
    fin: usize,
    gap: usize,
    plate: usize,
    height: usize,
    length: usize,
}

impl Parts {
    /// Cells of about 1 mm for the default, with the length making up for the
    /// rounding of the rest.
    fn new(cells: u64) -> Parts {
        let scale = (cells as f64 / 121_668.0).cbrt();
        let part = |size: f64| (size * scale).round().max(1.0) as usize;
        let mut parts = Parts {
            fin: part(FIN),
            gap: part(GAP),
            plate: part(PLATE),
            height: part(HEIGHT),
            length: 1,
        };
        let section = parts.section();
        parts.length = (cells as f64 / (6 * section) as f64).round().max(1.0) as usize;
        parts
    }

    /// Squares in the cross section.
    fn section(&self) -> usize {
        let width = FINS * self.fin + (FINS - 1) * self.gap;
        width * self.plate + FINS * self.fin * self.height
    }

    fn lattice(&self) -> Lattice {
        // `count` steps that end at `to` exactly.
        let steps = |axis: &mut Vec<f64>, to: f64, count: usize| {
            let from = *axis.last().expect("it starts somewhere");
            axis.extend((1..=count).map(|i| from + (to - from) * (i as f64 / count as f64)));
        };
        let (mut x, mut y, mut z) = (vec![0.0], vec![0.0], vec![0.0]);
        for fin in 0..FINS {
            let start = fin as f64 * (FIN + GAP);
            if fin > 0 {
                steps(&mut x, start, self.gap);
            }
            steps(&mut x, start + FIN, self.fin);
        }
        steps(&mut y, LENGTH, self.length);
        steps(&mut z, PLATE, self.plate);
        steps(&mut z, PLATE + HEIGHT, self.height);
        Lattice { axes: [x, y, z] }
    }

    /// Whether cube (i, j, k) of the lattice is metal.
    fn metal(&self, [i, _, k]: [usize; 3]) -> bool {
        k < self.plate || i % (self.fin + self.gap) < self.fin
    }
}

fn make(cells: u64, _seed: u64) -> Result<TetMesh, Error> {
    build(&Parts::new(cells))
}

fn build(parts: &Parts) -> Result<TetMesh, Error> {
    let lattice = parts.lattice();
    let temperatures = Conduction::new(&lattice, parts).solve()?;
    let mut tetrahedra = lattice.tetrahedra_where(Split::Six, |cube| parts.metal(cube));
    let used = lattice.used(tetrahedra.as_flattened_mut());
    let points = lattice.points();
    let scalars = Scalars {
        name: "temperature".into(),
        association: Association::Point,
        values: used.iter().map(|&p| temperatures[p as usize]).collect(),
    };
    let points = used.iter().map(|&p| points[p as usize]).collect();
    TetMesh::from_tetrahedra(points, tetrahedra, scalars)
}

/// The stiffness matrix of linear elements on Kuhn's cut, with the lumped loss.
struct Conduction {
    strides: [usize; 3],
    /// For each axis, what couples a point with the next one along it, W/K.
    couplings: [Vec<f64>; 3],
    /// The diagonal, W/K; 0 at points outside the metal.
    diagonal: Vec<f64>,
    /// Points below this index are on the underside, at a given temperature.
    held: usize,
}

impl Conduction {
    fn new(lattice: &Lattice, parts: &Parts) -> Conduction {
        let cubes = lattice.cubes();
        let strides = lattice.strides();
        let count = lattice.axes.iter().map(Vec::len).product();
        let mut couplings = [0, 1, 2].map(|_| vec![0.0; count]);
        let mut diagonal = vec![0.0; count];
        for k in 0..cubes[2] {
            for j in 0..cubes[1] {
                for i in (0..cubes[0]).filter(|&i| parts.metal([i, j, k])) {
                    let cube = [i, j, k];
                    let first = i + j * strides[1] + k * strides[2];
                    let size =
                        [0, 1, 2].map(|a| lattice.axes[a][cube[a] + 1] - lattice.axes[a][cube[a]]);
                    let volume: f64 = size.iter().product::<f64>() / 6.0;
                    for a in 0..3 {
                        let (b, c) = ((a + 1) % 3, (a + 2) % 3);
                        // A tetrahedron walks along each axis once. It goes along a
                        // first or last in two orders each, in the middle in one.
                        for (side_b, side_c, orders) in
                            [(0, 0, 2.0), (1, 0, 1.0), (0, 1, 1.0), (1, 1, 2.0)]
                        {
                            let p = first + side_b * strides[b] + side_c * strides[c];
                            let coupling = CONDUCTIVITY * orders * volume / (size[a] * size[a]);
                            couplings[a][p] += coupling;
                            diagonal[p] += coupling;
                            diagonal[p + strides[a]] += coupling;
                        }
                        // A face without metal behind it loses heat: a third of each
                        // triangle's to each of its corners, and the diagonal, from
                        // corner (0, 0) to (1, 1), belongs to both triangles.
                        for side in [0, 1] {
                            let mut behind = cube;
                            behind[a] = (cube[a] + 2 * side).wrapping_sub(1);
                            let open = behind[a] >= cubes[a] || !parts.metal(behind);
                            let underside = a == 2 && side == 0 && k == 0;
                            if !open || underside {
                                continue;
                            }
                            for (side_b, side_c, triangles) in
                                [(0, 0, 2.0), (1, 0, 1.0), (0, 1, 1.0), (1, 1, 2.0)]
                            {
                                let p = first
                                    + side * strides[a]
                                    + side_b * strides[b]
                                    + side_c * strides[c];
                                diagonal[p] += TRANSFER * size[b] * size[c] / 6.0 * triangles;
                            }
                        }
                    }
                }
            }
        }
        Conduction {
            strides,
            couplings,
            diagonal,
            held: strides[2],
        }
    }

    /// The matrix times `x`, at the points that are not held.
    fn apply(&self, x: &[f64], y: &mut [f64]) {
        for p in self.held..x.len() {
            let mut sum = self.diagonal[p] * x[p];
            for (stride, coupling) in self.strides.iter().zip(&self.couplings) {
                // The last points couple with nothing, so nothing wraps around.
                sum -= coupling[p - stride] * x[p - stride];
                if let Some(next) = x.get(p + stride) {
                    sum -= coupling[p] * next;
                }
            }
            y[p] = sum;
        }
    }

    /// The temperature at each lattice point, °C; ambient outside the metal.
    fn solve(&self) -> Result<Vec<f64>, Error> {
        // Above ambient the loss is proportional, so the right-hand side is zero
        // and the held points drive the rest. The first guess is the base's.
        let count = self.diagonal.len();
        let metal = |p: usize| self.diagonal[p] > 0.0;
        let mut x: Vec<f64> = (0..count)
            .map(|p| if metal(p) { BASE - AMBIENT } else { 0.0 })
            .collect();
        let inverse: Vec<f64> = (0..count)
            .map(|p| {
                if p >= self.held && metal(p) {
                    1.0 / self.diagonal[p]
                } else {
                    0.0
                }
            })
            .collect();
        let mut product = vec![0.0; count];
        self.apply(&x, &mut product);
        let mut residual: Vec<f64> = product.iter().map(|v| -v).collect();
        let mut direction: Vec<f64> = residual.iter().zip(&inverse).map(|(r, m)| r * m).collect();
        let mut energy = dot(&residual, &direction);
        // Twelve digits of the residual leave ten of the temperature.
        let goal = energy * 1e-24;
        // Steps grow with the length of the lattice, a few times the number of
        // points along it; ten thousand is far more than 20 million cells take.
        for _ in 0..10_000 {
            if energy <= goal {
                x.iter_mut().for_each(|t| *t += AMBIENT);
                return Ok(x);
            }
            self.apply(&direction, &mut product);
            let step = energy / dot(&direction, &product);
            for p in self.held..count {
                x[p] += step * direction[p];
                residual[p] -= step * product[p];
            }
            let before = energy;
            energy = residual.iter().zip(&inverse).map(|(r, m)| r * r * m).sum();
            let turn = energy / before;
            for p in self.held..count {
                direction[p] = residual[p] * inverse[p] + turn * direction[p];
            }
        }
        Err(Error::Invalid {
            what: format!(
                "the heat sink's temperature did not converge in 10000 steps on {count} points"
            ),
            help: Some("ask for fewer cells".into()),
        })
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Cool blue tips to a hot plate; a fin of 2 mm lets light through.
fn look() -> Look {
    Look {
        fit: CameraFit::PlusIso,
        knots: vec![
            knot(48.0, [0.05, 0.15, 0.75], 0.10),
            knot(55.0, [0.05, 0.60, 0.80], 0.10),
            knot(63.0, [0.35, 0.80, 0.25], 0.15),
            knot(72.0, [1.0, 0.60, 0.05], 0.35),
            knot(80.0, [1.0, 0.10, 0.03], 1.0),
        ],
    }
}

#[cfg(test)]
mod tests {
    use tetrascope_core::glam::DVec3;

    use super::*;
    use crate::{Options, checks};

    fn mesh(cells: Option<u64>) -> TetMesh {
        DATASET.mesh(&Options { cells, seed: None }).expect("valid")
    }

    #[test]
    fn the_block_is_whole_and_its_size_near_the_papers() {
        let block = mesh(None);
        // Half a slice of the section more or less: 121 536.
        assert!(block.cell_count().abs_diff(121_668) <= 3 * Parts::new(121_668).section());
        for mesh in [block, mesh(Some(2000)), mesh(Some(30_000))] {
            checks::conforms(&mesh);
            checks::positive(&mesh);
            let exact = (7.0 * 2.0 + 6.0 * 3.0) * 4.0 * 48.0 + 7.0 * 2.0 * 21.0 * 48.0;
            // One rounding error a cell.
            let rounding = mesh.cell_count() as f64 * f64::EPSILON * exact;
            assert!((checks::volume(&mesh) - exact).abs() < rounding);
        }
    }

    /// Assembles the equations again, cell by cell from the gradients of the general
    /// linear element, and returns (residual at free points, heat through the
    /// underside, heat lost), all W.
    fn balance(mesh: &TetMesh) -> (Vec<f64>, f64, f64) {
        let t = &mesh.scalars().values;
        let mut flow = vec![0.0; t.len()];
        for (cell, corners) in mesh.tetrahedra().iter().enumerate() {
            let p = mesh.cell_points(cell);
            let six_volumes = (p[1] - p[0]).dot((p[2] - p[0]).cross(p[3] - p[0]));
            let g1 = (p[2] - p[0]).cross(p[3] - p[0]) / six_volumes;
            let g2 = (p[3] - p[0]).cross(p[1] - p[0]) / six_volumes;
            let g3 = (p[1] - p[0]).cross(p[2] - p[0]) / six_volumes;
            let gradients = [-(g1 + g2 + g3), g1, g2, g3];
            let slope: DVec3 = (0..4).map(|i| gradients[i] * t[corners[i] as usize]).sum();
            for (gradient, &p) in gradients.iter().zip(corners) {
                flow[p as usize] += CONDUCTIVITY * six_volumes / 6.0 * gradient.dot(slope);
            }
        }
        let mut lost = 0.0;
        for face in checks::boundary(mesh) {
            let [a, b, c] = face.map(|p| mesh.points()[p as usize]);
            if a.z == 0.0 && b.z == 0.0 && c.z == 0.0 {
                continue;
            }
            let area = (b - a).cross(c - a).length() / 2.0;
            for p in face {
                let loss = TRANSFER * area / 3.0 * (t[p as usize] - AMBIENT);
                flow[p as usize] += loss;
                lost += loss;
            }
        }
        let held = |p: usize| mesh.points()[p].z == 0.0;
        let gained = (0..t.len()).filter(|&p| held(p)).map(|p| flow[p]).sum();
        let free = (0..t.len()).filter(|&p| !held(p)).map(|p| flow[p]);
        (free.collect(), gained, lost)
    }

    #[test]
    fn the_discrete_heat_equation_holds_and_heat_is_conserved() {
        for cells in [2000, 121_668] {
            let (residual, gained, lost) = balance(&mesh(Some(cells)));
            // The solver stops when the residual, weighted by the inverse diagonal, is
            // 1e-12 of the first, which is the loss at the base's temperature; twice
            // that, as the diagonal varies fourfold. Rounding is far below.
            let area = 2.0 * (32.0 + 48.0) * PLATE // the plate's rim
                + 32.0 * LENGTH // what faces up, on the plate or on the fins
                + 2.0 * 7.0 * (FIN + LENGTH) * HEIGHT;
            let tolerance = 2e-12 * TRANSFER * area * (BASE - AMBIENT);
            let worst = residual.iter().fold(0.0f64, |m, r| m.max(r.abs()));
            assert!(worst < tolerance, "{worst} W, {tolerance} W");
            // The residuals add up, one per point.
            assert!((gained - lost).abs() < tolerance * residual.len() as f64);
            assert!(lost > 100.0, "{lost} W");
        }
    }

    #[test]
    fn the_maximum_principle_holds() {
        let mesh = mesh(None);
        for (p, &t) in mesh.points().iter().zip(&mesh.scalars().values) {
            if p.z == 0.0 {
                assert_eq!(t, BASE);
            } else {
                assert!(t > AMBIENT && t < BASE, "{t} at {p}");
            }
        }
        // It is coldest at the tips of the outer fins' corners.
        let values = &mesh.scalars().values;
        let coldest = (0..values.len()).min_by(|&a, &b| values[a].total_cmp(&values[b]));
        let p = mesh.points()[coldest.expect("points")];
        assert!(
            p.z == 25.0 && (p.x == 0.0 || p.x == 32.0) && (p.y == 0.0 || p.y == 48.0),
            "{p}"
        );
    }

    // The textbook's fin (Incropera, "Fundamentals of Heat and Mass Transfer", §3.6):
    // with m² = h·perimeter/(k·section) and the tip losing heat too,
    // θ(z)/θ(root) = [cosh m(H − z) + n sinh m(H − z)] / [cosh mH + n sinh mH], n = h/(mk).
    #[test]
    fn a_fin_cools_as_the_textbook_says() {
        let mesh = mesh(None);
        // The mean over the section of the middle fin, 15 ≤ x ≤ 17, at height z.
        let theta = |z: f64| {
            let near = |p: &DVec3| p.z == z && p.x == 16.0;
            let ys = mesh.points().iter().zip(&mesh.scalars().values);
            let all: Vec<f64> = ys
                .filter(|(p, _)| near(p))
                .map(|(_, t)| t - AMBIENT)
                .collect();
            all.iter().sum::<f64>() / all.len() as f64
        };
        let m = (TRANSFER * 2.0 * (LENGTH + FIN) / (CONDUCTIVITY * LENGTH * FIN)).sqrt();
        let n = TRANSFER / (m * CONDUCTIVITY);
        let shape = |z: f64| (m * (HEIGHT - z)).cosh() + n * (m * (HEIGHT - z)).sinh();
        for z in [7.0, 14.0, 21.0] {
            let (ours, theirs) = (theta(PLATE + z) / theta(PLATE), shape(z) / shape(0.0));
            // The textbook ignores differences across a fin, of the order of the Biot
            // numbers h·1 mm/k = 0.003 across it and h·24 mm/k/3 = 0.024 along it.
            assert!(
                (ours / theirs - 1.0).abs() < 0.025,
                "{z} mm: {ours}, {theirs}"
            );
        }
    }

    // Halving all cells again and again: the steps shrink. Heat flows around the
    // edges between plate and fins, of 270°, where the error of the heat falls as h^(4/3).
    #[test]
    fn the_heat_converges() {
        let lost = |n| {
            let parts = Parts {
                fin: n,
                gap: n,
                plate: 2 * n,
                height: 10 * n,
                length: 4 * n,
            };
            balance(&build(&parts).expect("converges")).2
        };
        let watts = [1, 2, 4].map(lost);
        let ratio = (watts[1] - watts[0]) / (watts[2] - watts[1]);
        // 1.85 here, as two cells across a fin are not yet the limit; above 2 from
        // 2, 4 and 8, whose million cells take a test too long. At most h².
        assert!((1.7..4.0).contains(&ratio), "{watts:?}");
        let change = (watts[2] - watts[1]).abs() / watts[2];
        assert!(change < 0.01, "{watts:?}");
    }
}
