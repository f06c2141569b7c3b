//! Axes that are not space, and where samples stand in files.

use super::*;

fn names(data: &GridData) -> Vec<&str> {
    data.fields
        .iter()
        .map(|field| field.name.as_str())
        .collect()
}

/// An NRRD of bytes 0, 1, 2 … with these sizes.
fn bytes_of(sizes: &[usize], more: &str) -> Vec<u8> {
    let words: Vec<String> = sizes.iter().map(usize::to_string).collect();
    let head = format!(
        "NRRD0005\ntype: UINT8\ndimension: {}\nsizes: {}\nencoding: raw\n{more}\n",
        sizes.len(),
        words.join(" ")
    );
    let count: usize = sizes.iter().product();
    let bytes: Vec<u8> = (0..count).map(|i| i as u8).collect();
    join(&[head.as_bytes(), &bytes])
}

fn read_bytes(sizes: &[usize], more: &str) -> Result<GridData, Error> {
    read(&[("a.nrrd", &bytes_of(sizes, more))])
}

#[test]
fn only_domain_and_space_are_space() {
    for kinds in [
        "RGB-color domain domain",
        "domain domain time",
        "space list space",
        "vector space space",
    ] {
        let error = read_bytes(&[3, 4, 5], &format!("kinds: {kinds}\n"));
        let error = error.expect_err("a picture").to_string();
        assert!(error.contains("two spatial axes"), "{kinds}: {error}");
    }
    // First, last and between: sample (1, 0, 0) of entry 2.
    let cases: [(&[usize], &str, &[&str], f64); 5] = [
        (
            &[3, 2, 2, 2],
            "list domain domain domain",
            &["scalars-0", "scalars-1", "scalars-2"],
            5.0,
        ),
        (
            &[2, 2, 2, 3],
            "domain domain domain time",
            &["scalars-0", "scalars-1", "scalars-2"],
            17.0,
        ),
        (
            &[2, 2, 3, 2],
            "space space list space",
            &["scalars-0", "scalars-1", "scalars-2"],
            9.0,
        ),
        (
            &[2, 2, 2, 3],
            "domain domain domain vector",
            &["scalars-magnitude", "scalars-0", "scalars-1", "scalars-2"],
            17.0,
        ),
        (
            &[3, 2, 2, 2],
            "RGB-color domain domain domain",
            &["scalars-0", "scalars-1", "scalars-2"],
            5.0,
        ),
    ];
    for (sizes, kinds, expected, value) in cases {
        let data = read_bytes(sizes, &format!("kinds: {kinds}\n"));
        let data = data.unwrap_or_else(|error| panic!("{kinds}: {error}"));
        assert_eq!(names(&data), expected);
        let (lattice, last) = loaded(&data, expected.len() - 1);
        assert_eq!((lattice.dims, last.get(1)), ([2; 3], value), "{kinds}");
        let colors = data.notes.iter().any(|note| note.contains("colors"));
        assert_eq!(colors, kinds.contains("color"), "{:?}", data.notes);
    }
    let data = read_bytes(
        &[2, 2, 2, 2, 3],
        "kinds: vector domain domain domain time\n",
    );
    let data = data.expect("vectors in time");
    assert_eq!(
        names(&data)[..4],
        [
            "scalars-0-magnitude",
            "scalars-0-0",
            "scalars-0-1",
            "scalars-1-magnitude"
        ]
    );
    let (_, magnitude) = loaded(&data, 3);
    assert_eq!(magnitude.get(0), f64::hypot(16.0, 17.0) as f32 as f64);
}

// As SimpleITK writes four dimensions.
#[test]
fn four_dimensions_are_frames() {
    let nrrd = "space dimension: 4\nkinds: domain domain domain domain\n\
        space directions: (1,0,0,0) (0,2,0,0) (0,0,3,0) (0,0,0,4)\nspace origin: (5,6,7,8)\n";
    let nrrd = bytes_of(&[2, 2, 2, 3], nrrd);
    let bytes: Vec<u8> = (0..24).collect();
    let mha = "NDims = 4\nDimSize = 2 2 2 3\nElementType = MET_UCHAR\nOffset = 5 6 7 8\n\
        ElementSpacing = 1 2 3 4\nTransformMatrix = 1 0 0 0 0 1 0 0 0 0 1 0 0 0 0 1\n\
        ElementDataFile = LOCAL\n";
    let mha = join(&[mha.as_bytes(), &bytes]);
    let nii = nifti(|h| {
        for (i, size) in [4_i16, 2, 2, 2, 3].into_iter().enumerate() {
            h[40 + 2 * i..42 + 2 * i].copy_from_slice(&size.to_le_bytes());
        }
        h[70] = 2;
    });
    let nii = join(&[&nii, &bytes]);
    for (name, file) in [("a.nrrd", nrrd), ("a.mha", mha), ("a.nii", nii)] {
        let data = read(&[(name, &file)]).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(names(&data), ["scalars-0", "scalars-1", "scalars-2"]);
        for frame in 0..3_u8 {
            let expected: Vec<u8> = (8 * frame..8 * frame + 8).collect();
            let (lattice, samples) = loaded(&data, frame.into());
            assert_eq!(samples, Samples::U8(expected), "{name}");
            if name != "a.nii" {
                assert_eq!(lattice.origin, DVec3::new(5.0, 6.0, 7.0));
                assert_eq!(lattice.spacing, DVec3::new(1.0, 2.0, 3.0));
            }
        }
        // Large ones stay in the file, each frame where it stands.
        let folder = folder(&[(name, &file)]);
        let options = ReadOptions {
            stream_above: 20,
            ..ReadOptions::default()
        };
        let data = read_with(&folder.path().join(name), &options).expect("streamed");
        let FieldSamples::Streamed(stream) = &data.fields[2].samples else {
            panic!("24 bytes are too many");
        };
        assert_eq!(stream.scalar_range(), Some((16.0, 23.0)), "{name}");
    }
    let turned = "space dimension: 4\nkinds: domain domain domain domain\n\
        space directions: (1,0,0,1) (0,2,0,0) (0,0,3,0) (0,0,0,4)\n";
    assert!(read_bytes(&[2, 2, 2, 3], turned).is_err());
}

#[test]
fn niftis_have_vectors_and_colors() {
    let vectors = nifti(|h| {
        for (i, size) in [5_i16, 2, 2, 2, 1, 3].into_iter().enumerate() {
            h[40 + 2 * i..42 + 2 * i].copy_from_slice(&size.to_le_bytes());
        }
        h[68..70].copy_from_slice(&1007_i16.to_le_bytes());
        h[70] = 2;
    });
    let bytes: Vec<u8> = (0..24).collect();
    let data = read(&[("a.nii", &join(&[&vectors, &bytes]))]).expect("vectors");
    assert_eq!(
        names(&data),
        ["scalars-magnitude", "scalars-0", "scalars-1", "scalars-2"]
    );
    assert_eq!(loaded(&data, 2).1.get(0), 8.0);
    let colors = nifti(|h| {
        for (i, size) in [3_i16, 2, 2, 2].into_iter().enumerate() {
            h[40 + 2 * i..42 + 2 * i].copy_from_slice(&size.to_le_bytes());
        }
        h[70..72].copy_from_slice(&128_i16.to_le_bytes());
    });
    let data = read(&[("a.nii", &join(&[&colors, &bytes]))]).expect("colors");
    assert_eq!(names(&data), ["scalars-0", "scalars-1", "scalars-2"]);
    assert_eq!(loaded(&data, 1).1.get(1), 4.0);
}

#[test]
fn lines_and_bytes_before_samples_are_passed_over() {
    let (bytes, samples) = shorts();
    let head = |encoding: &str, more: &str| {
        format!(
            "NRRD0004\ntype: INT16\ndimension: 3\nsizes: 2 3 4\nendian: Little\n\
             encoding: {encoding}\n{more}"
        )
    };
    let lines = b"one line\r\nanother\n".as_slice();
    let detached = head("raw", "line skip: 2\nbyte skip: 3\ndata file: d\n");
    let packed = head("gzip", "line skip: 2\nbyte skip: 3\ndata file: d\n");
    let tail = head("gzip", "byte skip: -1\ndata file: d\n");
    let attached = head("raw", "line skip: 2\n\n");
    let cases: [&[(&str, &[u8])]; 4] = [
        &[
            ("a.nhdr", detached.as_bytes()),
            ("d", &join(&[lines, b"abc", &bytes])),
        ],
        &[
            ("a.nhdr", packed.as_bytes()),
            ("d", &join(&[lines, &gzip(&join(&[b"abc", &bytes]))])),
        ],
        &[
            ("a.nhdr", tail.as_bytes()),
            ("d", &gzip(&join(&[b"abcde", &bytes]))),
        ],
        &[("a.nrrd", &join(&[attached.as_bytes(), lines, &bytes]))],
    ];
    for files in cases {
        assert_eq!(first(files).1, samples);
    }
    let many = head("raw", "line skip: 9\ndata file: d\n");
    let error = read(&[("a.nhdr", many.as_bytes()), ("d", lines)]).expect_err("two lines");
    assert!(error.to_string().contains("after 2 of 9 lines"), "{error}");
}

#[test]
fn niftis_without_an_offset_and_packed_under_another_name() {
    let (bytes, samples) = shorts();
    let header = nifti(|h| h[108..112].fill(0));
    let file = join(&[&header, &bytes]);
    assert_eq!(first(&[("a.nii", &file)]).1, samples);
    assert_eq!(first(&[("a.nii", &gzip(&file))]).1, samples);
}

#[test]
fn meta_images_in_slices() {
    let (bytes, samples) = shorts();
    let slices: Vec<&[u8]> = bytes.chunks(12).collect();
    for list in [
        "LIST 2D\ns1\ns2\ns3\ns4\n",
        "LIST\ns1\ns2\ns3\ns4\n",
        "s%d 1 4 1\n",
    ] {
        let head = format!("{MHD}ElementDataFile = {list}");
        let files: [(&str, &[u8]); 5] = [
            ("a.mhd", head.as_bytes()),
            ("s1", slices[0]),
            ("s2", slices[1]),
            ("s3", slices[2]),
            ("s4", slices[3]),
        ];
        assert_eq!(first(&files).1, samples, "{list}");
    }
    let none = format!("{MHD}ElementDataFile = LIST\n");
    assert!(read(&[("a.mhd", none.as_bytes())]).is_err());
    // A number of axes is not a number of bytes.
    let many = "NDims = 9999999\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = x\n";
    assert!(read(&[("a.mhd", many.as_bytes())]).is_err());
    let axes = "2 ".repeat(5000);
    let many = format!("DimSize = {axes}\nElementType = MET_UCHAR\nElementDataFile = x\n");
    assert!(read(&[("a.mhd", many.as_bytes())]).is_err());
}

#[test]
fn what_varies_in_whole_numbers_of_text_is_kept() {
    let text: String = (0..8)
        .map(|i| format!("{}\n", 864_691_135_000_000_001_i64 + i))
        .collect();
    let head = "NRRD0004\ntype: int64\ndimension: 3\nsizes: 2 2 2\nencoding: text\n\n";
    let data = read(&[("a.nrrd", &join(&[head.as_bytes(), text.as_bytes()]))]).expect("fine");
    let field = &data.fields[0];
    let (_, samples) = loaded(&data, 0);
    for i in 0..8 {
        let id = samples.get(i) as i64 + field.offset as i64;
        assert_eq!(id, 864_691_135_000_000_001 + i as i64);
    }
    assert!(data.notes[0].contains("is drawn less"), "{:?}", data.notes);
}

// The first array is a constant, so the second is what to look at.
#[test]
fn the_first_field_that_varies_is_the_default() {
    let head = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET STRUCTURED_POINTS\n\
        DIMENSIONS 2 2 2\nPOINT_DATA 8\nFIELD f 2\nk 1 8 float\n5 5 5 5 5 5 5 5\n\
        rho 1 8 float\n1 2 3 4 5 6 7 8\n";
    let data = read(&[("a.vtk", head.as_bytes())]).expect("fine");
    assert_eq!(data.clone().into_volume(None).expect("varies").1, "rho");
    assert_eq!(data.into_volume(Some("k")).expect("there").1, "k");
}
