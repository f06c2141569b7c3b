use proptest::prelude::*;
use tetrascope_core::Volume;
use tetrascope_core::glam::{DMat3, DQuat};
use tetrascope_core::mesh::Association;

use super::*;
use crate::{FieldSamples, FileData, GridData, ReadOptions, read_file};

fn lattice(dims: [usize; 3], interpolation: Interpolation) -> Lattice {
    Lattice {
        dims,
        origin: DVec3::new(-0.1, 1e-30, 7e20),
        spacing: DVec3::new(0.3, 1.0 / 3.0, 2e18),
        direction: DMat3::IDENTITY,
        interpolation,
    }
}

fn read(path: &Path, options: &ReadOptions) -> GridData {
    match read_file(path, options) {
        Ok(FileData::Grid(grid)) => grid,
        Ok(FileData::Mesh(_) | FileData::Clusters(_)) => panic!("an image is not a mesh"),
        Err(error) => panic!("{error}"),
    }
}

/// Writes and reads arrays, which must come back the same to the last bit.
fn round_trip(lattice: &Lattice, arrays: &[(&str, &Samples)], compression: Compression) -> Lattice {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vti");
    write_vti(&path, lattice, arrays, compression).expect("it is writable");
    let data = read(&path, &ReadOptions::default());
    assert_eq!(data.fields.len(), arrays.len());
    for (field, (name, samples)) in data.fields.iter().zip(arrays) {
        assert_eq!(field.name, *name);
        assert_eq!(field.lattice.dims, lattice.dims);
        match (&field.samples, samples) {
            // NaN is not equal to itself.
            (FieldSamples::Loaded(Samples::F32(found)), Samples::F32(written)) => {
                let bits = |v: &[f32]| v.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                assert!(bits(found) == bits(written), "{name}");
            }
            (FieldSamples::Loaded(found), written) => assert!(found == *written, "{name}"),
            _ => panic!("small grids are read"),
        }
    }
    data.fields[0].lattice
}

/// Numbers that look random.
fn noise(count: usize) -> impl Iterator<Item = u32> {
    (0..count as u32).map(|i| (i ^ 0x9e37).wrapping_mul(0x85eb_ca6b).rotate_left(13))
}

#[test]
fn every_type_reads_back_bit_by_bit() {
    let lattice = lattice([5, 3, 4], Interpolation::Linear);
    let bytes = Samples::U8(noise(60).map(|x| x as u8).collect());
    let words = Samples::U16(noise(60).map(|x| x as u16).collect());
    let signed = Samples::I16(noise(60).map(|x| x as i16).collect());
    let mut floats: Vec<f32> = noise(60).map(|x| x as f32 * 1e-3 - 7e5).collect();
    floats[7] = f32::NAN;
    floats[8] = -0.0;
    floats[9] = f32::MIN_POSITIVE / 8.0;
    let floats = Samples::F32(floats);
    let arrays = [
        ("Temperature <at> \"noon\" & °C", &floats),
        ("bytes", &bytes),
        ("words", &words),
        ("coverage", &signed),
    ];
    for compression in [Compression::None, Compression::Zlib] {
        assert_eq!(round_trip(&lattice, &arrays, compression), lattice);
    }
}

// Several blocks, the last one short, full and alone.
#[test]
fn arrays_of_many_blocks_read_back() {
    for [nx, ny, nz] in [
        [64, 64, 64],
        [64, 64, 65],
        [64, 64, 63],
        [61, 67, 71],
        [2, 2, 2],
    ] {
        let count = nx * ny * nz;
        let floats = Samples::F32(noise(count).map(|x| (x % 100) as f32).collect());
        let bytes = Samples::U8(noise(count).map(|x| (x % 7) as u8).collect());
        let arrays = [("a", &floats), ("b", &bytes)];
        let lattice = lattice([nx, ny, nz], Interpolation::Linear);
        for compression in [Compression::None, Compression::Zlib] {
            round_trip(&lattice, &arrays, compression);
        }
    }
}

#[test]
fn zlib_makes_files_smaller() {
    let folder = tempfile::tempdir().expect("a folder");
    let samples = Samples::F32((0..64 * 64 * 64).map(|i| (i / 64) as f32).collect());
    let sizes = [Compression::None, Compression::Zlib].map(|compression| {
        let path = folder.path().join("a.vti");
        let lattice = lattice([64; 3], Interpolation::Linear);
        write_vti(&path, &lattice, &[("a", &samples)], compression).expect("it is writable");
        std::fs::metadata(&path).expect("it is there").len()
    });
    assert!(
        sizes[0] > samples.bytes() && sizes[1] * 8 < sizes[0],
        "{sizes:?}"
    );
}

// Files of more bytes than are to be kept in memory are read where they are.
#[test]
fn plain_files_can_be_streamed() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vti");
    let samples = Samples::U16(noise(1000).map(|x| x as u16).collect());
    let lattice = lattice([10; 3], Interpolation::Linear);
    write_vti(&path, &lattice, &[("a", &samples)], Compression::None).expect("it is writable");
    let options = ReadOptions {
        stream_above: 100,
        ..ReadOptions::default()
    };
    let data = read(&path, &options);
    let FieldSamples::Streamed(stream) = &data.fields[0].samples else {
        panic!("2000 bytes are more than 100");
    };
    assert_eq!(stream.scalar_range(), samples.range());
}

#[test]
fn samples_that_fill_cells_are_cell_data() {
    let lattice = Lattice {
        origin: DVec3::new(1.5, 2.0, 0.25),
        spacing: DVec3::new(1.0, 2.0, 0.5),
        ..lattice([4, 3, 1], Interpolation::Nearest)
    };
    let samples = Samples::U8((0..12).collect());
    // All of these numbers are sums of few powers of two, so nothing is rounded.
    let found = round_trip(&lattice, &[("labels", &samples)], Compression::Zlib);
    assert_eq!(found, lattice);
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vti");
    write_vti(&path, &lattice, &[("labels", &samples)], Compression::None).expect("writable");
    let data = read(&path, &ReadOptions::default());
    assert_eq!(data.fields[0].association, Association::Cell);
}

#[test]
fn coverage_goes_with_its_grid() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vti");
    let lattice = lattice([3, 4, 5], Interpolation::Linear);
    let samples = Samples::F32(noise(60).map(|x| x as f32).collect());
    let shares: Vec<f32> = noise(60).map(|x| (x % 1001) as f32 / 1000.0).collect();
    let plain = Grid::on(lattice, samples).expect("valid");
    let grid = plain.clone().covered(shares).expect("shares");
    for compression in [Compression::None, Compression::Zlib] {
        write_grid(&path, &grid, "T", compression).expect("it is writable");
        let data = read(&path, &ReadOptions::default());
        let (volume, name) = data
            .into_covered_volume(None, COVERAGE)
            .expect("both are there");
        let Volume::Grid(found) = volume else {
            panic!("small grids are read");
        };
        assert_eq!((name.as_str(), found.lattice()), ("T", grid.lattice()));
        assert_eq!(found.samples(), grid.samples());
        assert_eq!(found.coverage(), grid.coverage());
    }
    assert!(write_grid(&path, &grid, COVERAGE, Compression::None).is_err());
    // Without one there is one array, and nothing that is taken for one.
    write_grid(&path, &plain, "T", Compression::None).expect("it is writable");
    let data = read(&path, &ReadOptions::default());
    assert_eq!(data.fields.len(), 1);
    let error = data.into_covered_volume(None, COVERAGE).expect_err("none");
    assert!(matches!(error, Error::NoSuchField { .. }), "{error}");
    // Numbers that are not shares are refused.
    let samples = plain.samples();
    write_vti(
        &path,
        &lattice,
        &[("T", samples), (COVERAGE, samples)],
        Compression::None,
    )
    .expect("it is writable");
    let data = read(&path, &ReadOptions::default());
    let error = data
        .into_covered_volume(Some("T"), COVERAGE)
        .expect_err("too much");
    assert!(error.to_string().contains("the coverage"), "{error}");
}

proptest! {
    // Directions are read as lengths and unit vectors. The columns of a rotation are as long as 1
    // to 8 roundings, a product with the spacing, a length and a quotient add 8 of them: 16 of 2⁻⁵³.
    #[test]
    fn turned_lattices_read_back(
        x in -10.0..10.0f64, y in -10.0..10.0f64, z in -10.0..10.0f64, flip: bool,
    ) {
        let flip = DMat3::from_diagonal(DVec3::new(1.0, if flip { -1.0 } else { 1.0 }, 1.0));
        let turn = DMat3::from_quat(DQuat::from_scaled_axis(DVec3::new(x, y, z)));
        let lattice = Lattice {
            direction: turn * flip,
            ..lattice([2, 3, 4], Interpolation::Linear)
        };
        let samples = Samples::U8((0..24).collect());
        let found = round_trip(&lattice, &[("a", &samples)], Compression::None);
        prop_assert_eq!(found.origin, lattice.origin);
        let rounding = 16.0 * f64::EPSILON / 2.0;
        prop_assert!(found.direction.abs_diff_eq(lattice.direction, rounding));
        let share = (found.spacing / lattice.spacing - 1.0).abs().max_element();
        prop_assert!(share <= rounding, "{}", share);
    }
}

#[test]
fn nothing_is_written_of_what_is_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("a.vti");
    std::fs::write(&path, "precious").expect("it is writable");
    let lattice = lattice([2; 3], Interpolation::Linear);
    let (eight, seven) = (Samples::U8(vec![0; 8]), Samples::U8(vec![0; 7]));
    let flat = Lattice {
        dims: [2, 2, 1],
        ..lattice
    };
    type Case<'a> = (&'a Lattice, &'a [(&'a str, &'a Samples)], &'a str);
    let cases: [Case; 6] = [
        (&lattice, &[], "without an array"),
        (
            &lattice,
            &[("a", &eight), ("b", &seven)],
            "'b' has 7 samples",
        ),
        (&lattice, &[("", &eight)], "array 0 needs a name"),
        (
            &lattice,
            &[("a", &eight), ("b\n", &eight)],
            "array 1 needs a name",
        ),
        (&lattice, &[("a", &eight), ("a", &eight)], "two arrays"),
        (&flat, &[("a", &eight)], "at least 2 samples"),
    ];
    for (lattice, arrays, words) in cases {
        let error = write_vti(&path, lattice, arrays, Compression::None).expect_err(words);
        assert!(error.to_string().contains(words), "{error}");
    }
    let nowhere = folder.path().join("no folder/a.vti");
    let error = write_vti(&nowhere, &lattice, &[("a", &eight)], Compression::None);
    assert!(matches!(error, Err(Error::Io { .. })));
    assert_eq!(std::fs::read(&path).expect("it is there"), b"precious");
    let names = std::fs::read_dir(folder.path()).expect("it is readable");
    assert_eq!(names.count(), 1, "no temporary file is left");
}
