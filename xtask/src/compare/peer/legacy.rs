//! Meshes as VTK reads them.

use std::fmt::Write as _;

use tetrascope::core::TetMesh;

/// A mesh as a legacy VTK file, binary, which is big-endian.
pub(super) fn legacy(mesh: &TetMesh) -> Vec<u8> {
    let mut head =
        String::from("# vtk DataFile Version 3.0\ntetrahedra\nBINARY\nDATASET UNSTRUCTURED_GRID\n");
    let (points, cells) = (mesh.points(), mesh.tetrahedra());
    _ = writeln!(head, "POINTS {} double", points.len());
    let mut file = head.into_bytes();
    for coordinate in points.iter().flat_map(|point| point.to_array()) {
        file.extend(coordinate.to_be_bytes());
    }
    file.extend(format!("\nCELLS {} {}\n", cells.len(), 5 * cells.len()).bytes());
    for cell in cells {
        file.extend(4_i32.to_be_bytes());
        file.extend(cell.iter().flat_map(|point| point.to_be_bytes()));
    }
    file.extend(format!("\nCELL_TYPES {}\n", cells.len()).bytes());
    for _ in cells {
        file.extend(10_i32.to_be_bytes());
    }
    let head = format!(
        "\nPOINT_DATA {}\nSCALARS scalar double 1\nLOOKUP_TABLE default\n",
        points.len()
    );
    file.extend(head.bytes());
    for value in &mesh.scalars().values {
        file.extend(value.to_be_bytes());
    }
    file
}

#[cfg(test)]
mod tests {
    use super::super::tests::sphere;
    use super::*;
    use tetrascope::core::Volume;
    use tetrascope::io::{FileData, ReadOptions, read_file};

    #[test]
    fn what_vtk_is_given_is_the_mesh() {
        let (volume, _) = sphere();
        let Volume::Mesh(mesh) = &volume else {
            panic!("it is a mesh");
        };
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("volume.vtk");
        std::fs::write(&path, legacy(mesh)).expect("written");
        let FileData::Mesh(read) =
            read_file(&path, &ReadOptions::default()).expect("our reader takes it")
        else {
            panic!("it is a mesh");
        };
        let read = read.into_mesh(None).expect("tetrahedra");
        assert_eq!(read.points(), mesh.points());
        assert_eq!(read.tetrahedra(), mesh.tetrahedra());
        assert_eq!(read.scalars().values, mesh.scalars().values);
    }
}
