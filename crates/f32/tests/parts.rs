//! Parts of one mesh with the whole's domain: every number in f32 is the whole's.

use std::collections::HashMap;

use tetrascope_core::glam::{DAffine3, DVec3};
use tetrascope_core::{
    Appearance, Bounds, Camera, CameraFit, DepthCue, Knot, OpticalModel, Scalars, TetMesh,
    TransferFunction, View,
};
use tetrascope_f32::look::look;
use tetrascope_f32::{Domain, Normalization, ScalarMap};
use tetrascope_testing::{data_set, quarters};

/// Bits of positions and scalars of all corners of all cells, and of the depth cue.
fn numbers(mesh: &TetMesh, domain: &Domain) -> (Vec<u32>, Vec<u32>, Vec<u32>) {
    let knot = Knot {
        scalar: 0.0,
        color: DVec3::ONE,
        extinction: 1.0,
    };
    let function = TransferFunction::new(vec![knot]).expect("one knot");
    let mut appearance = Appearance::new(function, OpticalModel::Isosurfaces);
    appearance.depth_cue = Some(DepthCue { strength: 0.7 });
    let map = ScalarMap::of_appearance(&appearance, domain.scalar_range);
    let normalization = Normalization::of(&domain.bounds);
    let view = View {
        // One camera for all parts.
        camera: Camera::fit(
            &Bounds::of([DVec3::NEG_ONE, DVec3::ONE]),
            CameraFit::PlusIso,
            false,
            1.0,
        ),
        width: 8,
        height: 8,
        background: [0.0; 4],
    };
    let identity = DAffine3::IDENTITY;
    let (uniform, _) = look(
        &appearance,
        &view,
        &domain.bounds,
        &normalization,
        &map,
        &identity,
    );
    let cells = 0..mesh.cell_count();
    let positions = cells.clone().flat_map(|cell| {
        let points = mesh.cell_points(cell);
        points.map(|point| normalization.position(point).to_array().map(f32::to_bits))
    });
    let scalars = cells.flat_map(|cell| mesh.cell_scalars(cell).map(|s| map.scalar(s).to_bits()));
    (
        positions.flatten().collect(),
        scalars.collect(),
        bytemuck::cast_slice(&[uniform]).to_vec(),
    )
}

#[test]
fn parts_of_a_mesh_have_the_numbers_of_the_whole() {
    let mesh = data_set("torus", Some(3000));
    // Each quadrant has a range of its own.
    let values = mesh.points().iter().map(|p| p.x + 2.0 * p.y + p.z);
    let scalars = Scalars {
        values: values.collect(),
        ..mesh.scalars().clone()
    };
    let mesh = mesh.with_scalars(scalars).expect("one per point");
    let whole = Domain::of(&mesh);
    let quadrants = quarters(&mesh);
    let cells: usize = quadrants.iter().map(TetMesh::cell_count).sum();
    assert_eq!(cells, mesh.cell_count());
    let all = numbers(&mesh, &whole);
    for (quarter, part) in quadrants.iter().enumerate() {
        let domain = Domain::of(part).within(Some(whole)).expect("inside");
        let (positions, scalars, cue) = numbers(part, &domain);
        let of_whole: HashMap<&[u32], &[u32]> = all.0.chunks(12).zip(all.1.chunks(4)).collect();
        for (position, scalar) in positions.chunks(12).zip(scalars.chunks(4)) {
            assert_eq!(of_whole.get(position), Some(&scalar), "quarter {quarter}");
        }
        assert_eq!(cue, all.2, "quarter {quarter}");

        let own = numbers(part, &Domain::of(part));
        assert_ne!(own.0, positions, "quarter {quarter}");
        assert_ne!(own.1, scalars, "quarter {quarter}");
        assert_ne!(own.2, cue, "quarter {quarter}");
    }
}
