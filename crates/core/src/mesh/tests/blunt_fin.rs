//! The Blunt Fin of the literature, where its files are at hand.

use std::path::PathBuf;

use super::*;

/// The points of a big-endian Plot3D grid of floats, and its size.
fn read_grid(name: &str) -> Option<(Vec<DVec3>, [usize; 3])> {
    let folder = std::env::var_os("TETRASCOPE_DATA").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data"),
        PathBuf::from,
    );
    let bytes = std::fs::read(folder.join(name)).ok()?;
    let word = |i: usize| -> [u8; 4] { bytes[4 * i..4 * i + 4].try_into().expect("four bytes") };
    let size = [0, 1, 2].map(|i| u32::from_be_bytes(word(i)) as usize);
    let count: usize = size.iter().product();
    let float = |i: usize| f64::from(f32::from_be_bytes(word(3 + i)));
    let point = |i| DVec3::new(float(i), float(count + i), float(2 * count + i));
    Some(((0..count).map(point).collect(), size))
}

/// One hexahedron between each eight points.
fn hexahedra([ni, nj, nk]: [usize; 3]) -> Cells {
    let mut cells = Cells {
        offsets: vec![0],
        ..Cells::default()
    };
    for k in 0..nk - 1 {
        for j in 0..nj - 1 {
            for i in 0..ni - 1 {
                for [di, dj, dk] in CUBE.map(|corner| corner.map(usize::from)) {
                    let point = i + di + ni * (j + dj + nj * (k + dk));
                    cells.connectivity.push(point as u64);
                }
                cells.types.push(12);
                cells.offsets.push(cells.connectivity.len() as u64);
            }
        }
    }
    cells
}

#[test]
fn the_blunt_fin_has_the_counts_of_the_papers() {
    let Some((points, size)) = read_grid("bluntfinxyz.bin") else {
        println!("skipped: bluntfinxyz.bin is not in ../shared/data or $TETRASCOPE_DATA");
        return;
    };
    let cells = hexahedra(size);
    // Split, tetrahedra (Bernardon 2004; Weiler 2002), those of them with two corners at one
    // place: an edge of the grid is collapsed.
    for (split, tetrahedra, collapsed) in [
        (Split::FiveAlternating, 187_395, 77),
        (Split::SmallestIndex, 224_874, 115),
    ] {
        let mesh = TetMesh::with_split(points.clone(), &cells, scalars(points.len()), split)
            .expect("valid");
        let report = mesh.report();
        assert_eq!(report.tetrahedra + report.collapsed, tetrahedra);
        assert_eq!(report.collapsed, collapsed, "{split:?}");
        assert_eq!(report.degenerate, 0, "{split:?}");
        let mistakes = (
            report.folded,
            report.flipped,
            report.crowded_faces,
            report.duplicates,
        );
        assert_eq!(mistakes, (0, 0, 0, 0), "{split:?}");
        // Known to seven digits.
        assert!((mesh.volume() - 931.1627).abs() < 5e-5, "{}", mesh.volume());
        let boundary = mesh.boundary_statistics();
        // Of 13 516 triangles 78 have no area, with two corners at one place.
        assert_eq!(boundary.faces, 13_516 - 78);
        assert_eq!((boundary.components, boundary.euler_characteristic), (1, 2));
        assert!(boundary.closed && !boundary.convex);
    }
}
