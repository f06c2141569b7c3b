//! Where files say that their samples lie.

use super::*;
use tetrascope_core::Unit as _;

/// A lattice as NRRD writes it, for its samples as shorts.
fn nrrd(space: &str, axes: [DVec3; 3], origin: DVec3) -> Vec<u8> {
    let vector = |v: DVec3| format!("({},{},{})", v.x, v.y, v.z);
    let head = format!(
        "NRRD0004\ntype: short\ndimension: 3\nsizes: 2 3 4\nendian: little\nencoding: raw\n{space}\
         space directions: {} {} {}\nspace origin: {}\n\n",
        vector(axes[0]),
        vector(axes[1]),
        vector(axes[2]),
        vector(origin)
    );
    join(&[head.as_bytes(), &shorts().0])
}

/// Axes of lengths 1, 2 and 3 that are turned about all directions.
fn oblique() -> [DVec3; 3] {
    let turn = DMat3::from_cols_array(&[2., -1., 2., 2., 2., -1., -1., 2., 2.]) * (1.0 / 3.0);
    [turn.x_axis, turn.y_axis * 2.0, turn.z_axis * 3.0]
}

/// The header with an sform of these columns.
fn with_sform(header: &mut [u8], columns: [DVec3; 4]) {
    header[254] = 1;
    for (i, column) in columns.into_iter().enumerate() {
        for (row, value) in column.to_array().into_iter().enumerate() {
            let at = 280 + 16 * row + 4 * i;
            header[at..at + 4].copy_from_slice(&(value as f32).to_le_bytes());
        }
    }
}

fn assert_alike(a: &Lattice, b: &Lattice, off: f64) {
    assert_eq!(a.dims, b.dims);
    let (x, y) = (a.linear().to_cols_array(), b.linear().to_cols_array());
    assert!(
        x.iter().zip(y).all(|(x, y)| (x - y).abs() < off),
        "{a:?} {b:?}"
    );
    assert!(
        (a.origin - b.origin).abs().max_element() < off,
        "{a:?} {b:?}"
    );
}

// x to the left, y to the back, z to the head, whatever the file counts in.
#[test]
fn one_volume_lies_at_one_place_in_every_format() {
    let (bytes, samples) = shorts();
    let (axes, origin) = (oblique(), DVec3::new(10.0, -20.0, 30.0));
    let truth = Lattice::from_axes([2, 3, 4], origin, axes, Interpolation::Linear);
    let truth = truth.expect("perpendicular");
    let (las, ras) = (DVec3::new(1.0, -1.0, 1.0), DVec3::new(-1.0, -1.0, 1.0));
    let of = |space: &str, signs: DVec3| {
        let space = format!("space: {space}\n");
        nrrd(&space, axes.map(|axis| axis * signs), origin * signs)
    };
    let [x, y, z] = axes.map(|axis| axis.unit());
    let numbers = [x, y, z]
        .map(|v| format!("{} {} {}", v.x, v.y, v.z))
        .join(" ");
    let mha = format!(
        "NDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\nElementSpacing = 1 2 3\n\
         TransformMatrix = {numbers}\nOffset = 10 -20 30\nElementDataFile = LOCAL\n"
    );
    let nii = nifti(|h| {
        let [x, y, z] = axes.map(|axis| axis * ras);
        with_sform(h, [x, y, z, origin * ras]);
    });
    let files = [
        ("a.nrrd", of("left-posterior-superior", DVec3::ONE)),
        ("a.nrrd", of("LAS", las)),
        ("a.nrrd", of("right-anterior-superior", ras)),
        ("a.mha", join(&[mha.as_bytes(), &bytes])),
        ("a.nii", join(&[&nii, &bytes])),
    ];
    for (i, (name, bytes)) in files.iter().enumerate() {
        let data = read(&[(name, bytes)]).unwrap_or_else(|error| panic!("{error}"));
        let (lattice, found) = loaded(&data, 0);
        assert_eq!(found, samples);
        assert_eq!(data.space, Some("LPS"));
        // NIfTI has 32-bit floats: 30 is off by 2e-6 at most.
        assert_alike(&lattice, &truth, 2e-6);
        let handed = data.notes.iter().any(|note| note.contains("left-handed"));
        assert_eq!(handed, i == 1, "{:?}", data.notes);
    }
    // Not a body's directions: the frame is the file's, but nothing is mirrored.
    let data = read(&[("a.nrrd", &of("3D-left-handed", las))]).expect("fine");
    assert_eq!(data.space, None);
    assert_alike(&data.fields[0].lattice, &truth, 1e-12);
    assert!(data.notes[0].contains("left-handed"), "{:?}", data.notes);
    // A file that does not say.
    let data = read(&[("a.nrrd", &nrrd("", axes, origin))]).expect("fine");
    assert_eq!((data.space, data.notes.len()), (None, 0));
    assert_alike(&data.fields[0].lattice, &truth, 1e-12);
}

#[test]
fn rotations_of_few_decimals_are_read_as_the_nearest() {
    let truth = Lattice::from_axes([2, 3, 4], DVec3::ZERO, oblique(), Interpolation::Linear);
    let truth = truth.expect("perpendicular");
    for unit in [1e3, 1e4] {
        let axes = oblique().map(|axis| (axis * unit).round() / unit);
        let data = read(&[("a.nrrd", &nrrd("space: LPS\n", axes, DVec3::ZERO))]);
        let data = data.unwrap_or_else(|error| panic!("{error}"));
        assert_alike(&data.fields[0].lattice, &truth, 2.0 / unit);
        assert!(data.notes[0].contains("rounding"), "{:?}", data.notes);
    }
    let (bytes, _) = shorts();
    let mha = "NDims = 3\nDimSize = 2 3 4\nElementType = MET_SHORT\nElementSpacing = 1 2 3\n\
        TransformMatrix = 0.667 -0.333 0.667 0.667 0.667 -0.333 -0.333 0.667 0.667\n\
        ElementDataFile = LOCAL\n";
    let (lattice, _) = first(&[("a.mha", &join(&[mha.as_bytes(), &bytes]))]);
    assert_alike(&lattice, &truth, 3e-3);
}

#[test]
fn an_sform_with_shear_is_mended_or_refused_and_never_forgotten() {
    let (bytes, _) = shorts();
    let origin = DVec3::new(10.0, -20.0, 30.0);
    let sheared = |by: f64, qform: bool| {
        let header = nifti(|h| {
            let [x, y, z] = oblique();
            with_sform(h, [x, y, z + by * y, origin]);
            h[252] = qform.into();
        });
        read(&[("a.nii", &join(&[&header, &bytes]))])
    };
    let ras = DVec3::new(-1.0, -1.0, 1.0);
    let near = oblique().map(|axis| axis * ras);
    let near = Lattice::from_axes([2, 3, 4], origin * ras, near, Interpolation::Linear);
    let near = near.expect("perpendicular");
    let data = sheared(1e-4, false).expect("a little");
    // The shear moves an axis of length 3 by 1e-4 of one of length 2, and both share that.
    assert_alike(&data.fields[0].lattice, &near, 3e-4);
    assert!(
        data.notes.iter().any(|n| n.contains("shear of")),
        "{:?}",
        data.notes
    );
    assert!(
        !data.notes.iter().any(|n| n.contains("qform")),
        "{:?}",
        data.notes
    );
    let error = sheared(0.5, false).expect_err("too much").to_string();
    assert!(error.contains("shear") && !error.contains('\n'), "{error}");
    // Only what the file has is used in its place.
    let data = sheared(0.5, true).expect("the qform");
    assert!(
        data.notes[0].contains("its qform is used"),
        "{:?}",
        data.notes
    );
}

#[test]
fn a_quaternion_that_is_too_long_stretches_nothing() {
    let (bytes, _) = shorts();
    let header = nifti(|h| {
        h[252] = 1;
        h[264..268].copy_from_slice(&1.25_f32.to_le_bytes());
    });
    let data = read(&[("a.nii", &join(&[&header, &bytes]))]).expect("fine");
    let lattice = data.fields[0].lattice;
    assert_eq!(lattice.spacing, DVec3::new(0.5, 2.0, 3.0));
    // Half a turn about z, which is no more than from RAS to LPS.
    assert_eq!(lattice.direction, DMat3::IDENTITY);
    assert!(data.notes[0].contains("1.25"), "{:?}", data.notes);
}

#[test]
fn a_file_without_a_place_says_so() {
    let (bytes, _) = shorts();
    let data = read(&[("a.nii", &join(&[&nifti(|_| {}), &bytes]))]).expect("fine");
    assert_eq!(
        (data.space, data.fields[0].lattice.direction),
        (None, DMat3::IDENTITY)
    );
    assert!(data.notes[0].contains("does not say"), "{:?}", data.notes);
    let zeros = format!("{MHD}ElementDataFile = LOCAL\n")
        .replace("0 1 0 -1 0 0 0 0 1", "0 0 0 0 0 0 0 0 0");
    let data = read(&[("a.mha", &join(&[zeros.as_bytes(), &bytes]))]).expect("fine");
    assert_eq!(data.fields[0].lattice.direction, DMat3::IDENTITY);
    assert!(data.notes[0].contains("zeros"), "{:?}", data.notes);
}
