//! Grids that mean harm: NumPy arrays and archives, MRC maps, TIFF stacks, NIfTI, lists of pieces.

use std::io::Write as _;

use flate2::Compression;
use flate2::write::{GzEncoder, ZlibEncoder};
use tetrascope_fuzz::zip::{Entry, Member, zip};

use super::*;

/// Checks that `files` are read, at once and in the memory that is allowed for them.
fn accepted(files: &Files, words: &str) {
    let (answer, length, memory) = measured(files);
    answer.expect(words);
    assert!(memory <= allowed(length), "{words}: {memory} bytes");
}

/// The header of a NumPy array.
fn npy_header(kind: &str, shape: &str) -> Vec<u8> {
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({shape}), }}\n");
    let length = (text.len() as u16).to_le_bytes();
    [&b"\x93NUMPY\x01\0"[..], &length, text.as_bytes()].concat()
}

/// An archive of one array, which is deflated, with what the directory says of it.
fn npz(array: &[u8], lie: impl FnMut(usize, &mut Entry)) -> Files<'static> {
    let member = Member {
        name: "a.npy",
        bytes: array,
        is_deflated: true,
    };
    vec![("a.npz", zip(&[member], lie))]
}

#[test]
fn arrays_whose_shapes_cannot_be_true_are_refused() {
    let whole = [npy_header("<f4", "2, 2, 2"), vec![0; 32]].concat();
    accepted(&vec![("a.npy", whole.clone())], "eight numbers");
    accepted(&npz(&whole, |_, _| {}), "eight packed numbers");
    for wrong in [
        HUGE[0],
        HUGE[1],
        HUGE[2],
        HUGE[3],
        "-1",
        "nan",
        "1e9",
        "99999999999999999999",
    ] {
        for shape in [format!("{wrong}, 2, 2"), format!("2, 2, {wrong}")] {
            for kind in ["<f4", "<c16", "|u1"] {
                let array = [npy_header(kind, &shape), vec![0; 99]].concat();
                refused(&vec![("a.npy", array.clone())], "a.npy at ");
                refused(&npz(&array, |_, _| {}), "a.npz at ");
            }
        }
    }
    refused(&vec![("a.npy", npy_header("<f4", "0, 0, 0"))], "a.npy at ");
    refused(
        &vec![("a.npy", npy_header("|O", "2, 2, 2"))],
        "Python objects",
    );
    let mut many = String::from("2, ");
    many = many.repeat(9000);
    refused(&vec![("a.npy", npy_header("<f4", &many))], "a.npy at ");
    for version in [2, 3] {
        let file = [&b"\x93NUMPY"[..], &[version, 0], &u32::MAX.to_le_bytes()].concat();
        refused(&vec![("a.npy", file)], "a.npy at ");
    }
    for length in 0..whole.len() {
        if length > 0 {
            refused(&vec![("a.npy", whole[..length].to_vec())], "a.npy");
        }
    }
}

#[test]
fn archives_whose_directories_lie_are_refused() {
    let array = [npy_header("<f4", "2, 2, 2"), vec![0; 32]].concat();
    for number in [u32::MAX, 1 << 31, 100_000] {
        refused(&npz(&array, |_, entry| entry.start = number), "a.npz at ");
        refused(&npz(&array, |_, entry| entry.packed = number), "a.npz at ");
    }
    refused(&npz(&array, |_, entry| entry.unpacked = 0), "a.npz at ");
    refused(&npz(&array, |_, entry| entry.packed = 0), "a.npz at ");
    refused(&npz(&array, |_, entry| entry.method = 14), "is packed by");
    // It says less than it unpacks to.
    refused(&npz(&array, |_, entry| entry.unpacked -= 1), "a.npz at ");
    // Names are those of fields, and no file is written; messages are lines all the same.
    let names = ["../a.npy", "/etc/passwd.npy", "a\n\u{1b}[31m.npy", "\0.npy"];
    for name in names {
        let member = |bytes| Member {
            name,
            bytes,
            is_deflated: false,
        };
        accepted(
            &vec![("a.npz", zip(&[member(&array)], |_, _| {}))],
            "a name",
        );
        let broken = zip(&[member(&array[..50])], |_, _| {});
        refused(&vec![("a.npz", broken)], "a.npz at ");
    }
}

// Each of 900 arrays is the same million bytes.
#[test]
fn arrays_of_an_archive_that_share_their_bytes_are_refused() {
    let array = [npy_header("|u1", "100, 100, 100"), vec![7; 1_000_000]].concat();
    let member = |bytes| Member {
        name: "a.npy",
        bytes,
        is_deflated: false,
    };
    let mut members: Vec<Member> = (0..900).map(|_| member(&[])).collect();
    members[0] = member(&array);
    let length = array.len() as u32;
    let shared = zip(&members, |_, entry| {
        (entry.start, entry.packed, entry.unpacked) = (0, length, length);
    });
    refused(&vec![("a.npz", shared)], "overlaps");
    let apart = [member(&array), member(&array)];
    accepted(&vec![("a.npz", zip(&apart, |_, _| {}))], "two arrays");
}

#[test]
fn arrays_that_would_unpack_to_very_much_are_refused() {
    // The header alone is there; what the directory says comes to 2 GB, 1 GB and 1 TB.
    for (shape, words) in [
        ("1250, 1250, 1250", "which is refused"),
        ("1000, 1000, 1000", "a.npz at "),
        ("10000, 10000, 10000", "a.npz at "),
    ] {
        let header = npy_header("|u1", shape);
        refused(&npz(&header, |_, entry| entry.unpacked = u32::MAX), words);
    }
    let much = npy_header("|u1", "4, 4, 4");
    let much = [much, vec![0; 100 << 20]].concat();
    accepted(&npz(&much, |_, _| {}), "64 of 100 million bytes");
}

/// A map of 2 × 2 × 2 floats, of which `change` may be anything.
fn mrc(change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut map = vec![0; 1024];
    let mut put = |at: usize, bytes: &[u8]| map[at..at + bytes.len()].copy_from_slice(bytes);
    for at in [0, 4, 8, 12, 28, 32, 36] {
        put(at, &2i32.to_le_bytes());
    }
    for at in [40, 44, 48] {
        put(at, &2f32.to_le_bytes());
        put(at + 12, &90f32.to_le_bytes());
    }
    for (at, axis) in [(64, 1i32), (68, 2), (72, 3), (88, 1)] {
        put(at, &axis.to_le_bytes());
    }
    put(208, b"MAP DD\0\0");
    change(&mut map);
    map.extend([0; 32]);
    map
}

/// Four bytes of a header become a number.
fn at(place: usize, number: i32) -> impl Fn(&mut [u8]) {
    move |header| header[place..place + 4].copy_from_slice(&number.to_le_bytes())
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(bytes).and_then(|()| encoder.finish());
    written.expect("memory can be written")
}

#[test]
fn maps_whose_headers_cannot_be_true_are_refused() {
    accepted(&vec![("a.mrc", mrc(|_| {}))], "a map");
    accepted(&vec![("a.mrc", gzip(&mrc(|_| {})))], "a packed map");
    let nan = f32::NAN.to_bits() as i32;
    let infinite = f32::INFINITY.to_bits() as i32;
    for number in [i32::MAX, i32::MIN, -1, 0, 1 << 20] {
        for place in [0, 4, 8] {
            refused(&vec![("a.mrc", mrc(at(place, number)))], "a.mrc at ");
            refused(&vec![("a.mrc", gzip(&mrc(at(place, number))))], "a.mrc at ");
        }
    }
    for number in [i32::MAX, i32::MIN, -1, 1 << 20] {
        refused(&vec![("a.mrc", mrc(at(92, number)))], "a.mrc at ");
    }
    let all = |number: i32| move |header: &mut [u8]| (0..3).for_each(|i| at(4 * i, number)(header));
    refused(&vec![("a.mrc", mrc(all(i32::MAX)))], "a.mrc at ");
    for number in [nan, infinite] {
        for place in [52, 56, 60] {
            refused(&vec![("a.mrc", mrc(at(place, number)))], "a.mrc at ");
        }
        // A cell that is none has distances of 1, and no place: ORIGIN is not used.
        for place in [40, 44, 48, 196, 200, 204] {
            accepted(&vec![("a.mrc", mrc(at(place, number)))], "NaN");
        }
    }
    // Volumes of no sections, and of more than there are.
    for number in [0, -1, 3, i32::MAX] {
        let stack = mrc(|header| {
            at(88, 401)(header);
            at(36, number)(header);
        });
        refused(&vec![("a.mrc", stack)], "a.mrc at ");
    }
    let whole = mrc(|_| {});
    for length in (1..whole.len()).step_by(7) {
        refused(&vec![("a.mrc", whole[..length].to_vec())], "a.mrc");
    }
}

/// A header of NIfTI-2 and 8 floats, in one file or (`ni2`) without them.
fn nifti_two(magic: &[u8; 3], change: impl Fn(&mut [u8])) -> Vec<u8> {
    let mut file = vec![0; 544];
    let mut put = |at: usize, bytes: &[u8]| file[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &540i32.to_le_bytes());
    put(4, magic);
    put(7, b"\0\r\n\x1a\n");
    put(12, &16i16.to_le_bytes());
    put(14, &32i16.to_le_bytes());
    for (i, size) in [3i64, 2, 2, 2, 1, 1, 1, 1].into_iter().enumerate() {
        put(16 + 8 * i, &size.to_le_bytes());
        put(104 + 8 * i, &1f64.to_le_bytes());
    }
    if magic == b"n+2" {
        put(168, &544i64.to_le_bytes());
    }
    change(&mut file);
    match magic {
        b"n+2" => [file, vec![0; 32]].concat(),
        _ => file,
    }
}

fn wide(place: usize, number: i64) -> impl Fn(&mut [u8]) {
    move |header| header[place..place + 8].copy_from_slice(&number.to_le_bytes())
}

#[test]
fn niftis_of_64_bits_and_pairs_whose_headers_cannot_be_true_are_refused() {
    let pair = |header: Vec<u8>| vec![("a.hdr", header), ("a.img", vec![0; 32])];
    accepted(&vec![("a.nii", nifti_two(b"n+2", |_| {}))], "one file");
    accepted(&pair(nifti_two(b"ni2", |_| {})), "a pair");
    for number in [i64::MAX, i64::MIN, -1, 1 << 62, 1 << 32] {
        for place in [16, 24, 32, 40, 168] {
            let one = nifti_two(b"n+2", wide(place, number));
            refused(&vec![("a.nii", one)], "a.nii at ");
            // What is wrong with the samples' place is said of their file.
            refused(&pair(nifti_two(b"ni2", wide(place, number))), " at ");
        }
    }
    let frames = nifti_two(b"n+2", |header| {
        wide(16, 7)(header);
        (3..8).for_each(|i| wide(16 + 8 * i, 1 << 16)(header));
    });
    refused(&vec![("a.nii", frames)], "a.nii at ");
    for number in [f64::NAN, f64::INFINITY, 1e308] {
        let bits = number.to_bits() as i64;
        // Sizes of voxels that are none are 1; a scale that is none is not used.
        for place in [104, 112, 176] {
            let _ = measured(&vec![("a.nii", nifti_two(b"n+2", wide(place, bits)))]);
        }
        // Of sform and qform alike.
        for place in [400, 424, 352, 368] {
            let file = nifti_two(b"n+2", |header| {
                at(if place < 400 { 344 } else { 348 }, 1)(header);
                wide(place, bits)(header);
            });
            refused(&vec![("a.nii", file)], "a.nii at ");
        }
    }
    // The samples of the pair are not there, and are nothing.
    refused(
        &vec![("a.hdr", nifti_two(b"ni2", |_| {}))],
        "which is not there",
    );
    refused(
        &vec![("a.hdr", nifti_two(b"ni2", |_| {})), ("a.img", vec![0; 31])],
        "a.img at ",
    );
    // Analyze: 16-bit sizes of which all are the greatest, and an offset that is NaN.
    let mut analyze = vec![0; 348];
    analyze[..4].copy_from_slice(&348i32.to_le_bytes());
    for (i, size) in [7, i16::MAX, i16::MAX, i16::MAX, 9999, 9999, 9999, 9999]
        .iter()
        .enumerate()
    {
        analyze[40 + 2 * i..][..2].copy_from_slice(&size.to_le_bytes());
    }
    analyze[70] = 64;
    refused(&pair(analyze.clone()), " at ");
    analyze[40..48].copy_from_slice(&[3, 0, 2, 0, 2, 0, 2, 0]);
    for offset in [f32::NAN, f32::INFINITY, -1.0, 0.5, f32::MAX, 1e9] {
        analyze[108..112].copy_from_slice(&offset.to_le_bytes());
        refused(&pair(analyze.clone()), " at ");
    }
}

#[test]
fn packed_maps_and_pairs_that_would_unpack_to_very_much_are_refused() {
    let large = mrc(|header| {
        at(12, 0)(header);
        (0..3).for_each(|i| at(4 * i, 1250)(header));
    });
    refused(&vec![("a.mrc", packed(gzip(&large)))], "which is refused");
    let header = nifti_two(b"ni2", |header| {
        header[12] = 2;
        (1..4).for_each(|i| wide(16 + 8 * i, 1250)(header));
    });
    let files = vec![("a.hdr", header), ("a.img", packed(gzip(&[0; 99])))];
    refused(&files, "which is refused");
}

/// A TIFF file that grows, little-endian.
struct Tiff {
    file: Vec<u8>,
    /// Where the offset of the next directory is to stand.
    next: usize,
}

const SHORT: u16 = 3;
const LONG: u16 = 4;

// Tags, by their numbers in the specification.
const WIDTH: u16 = 256;
const HEIGHT: u16 = 257;
const BITS: u16 = 258;
const COMPRESSION: u16 = 259;
const PHOTOMETRIC: u16 = 262;
const DESCRIPTION: u16 = 270;
const OFFSETS: u16 = 273;
const ROWS: u16 = 278;
const COUNTS: u16 = 279;

type Tag = (u16, u16, u32, u32);

impl Tiff {
    fn new() -> Tiff {
        Tiff {
            file: b"II*\0\0\0\0\0".to_vec(),
            next: 4,
        }
    }

    /// Where `bytes` then are.
    fn put(&mut self, bytes: &[u8]) -> u32 {
        let place = self.file.len() as u32;
        self.file.extend(bytes);
        place
    }

    /// A directory that the last one points to.
    fn page(&mut self, tags: &[Tag]) {
        let place = self.file.len() as u32;
        self.point(place);
        self.file.extend((tags.len() as u16).to_le_bytes());
        for (tag, kind, count, value) in tags {
            self.file
                .extend([tag.to_le_bytes(), kind.to_le_bytes()].concat());
            self.file
                .extend([count.to_le_bytes(), value.to_le_bytes()].concat());
        }
        self.next = self.file.len();
        self.file.extend([0; 4]);
    }

    /// Makes the last directory point to `place`.
    fn point(&mut self, place: u32) {
        self.file[self.next..self.next + 4].copy_from_slice(&place.to_le_bytes());
    }

    fn files(self) -> Files<'static> {
        vec![("a.tif", self.file)]
    }
}

/// A page of bytes in one strip of `length` bytes at `place`.
fn strip(size: [u32; 2], compression: u32, place: u32, length: u32) -> Vec<Tag> {
    vec![
        (WIDTH, LONG, 1, size[0]),
        (HEIGHT, LONG, 1, size[1]),
        (BITS, SHORT, 1, 8),
        (COMPRESSION, SHORT, 1, compression),
        (PHOTOMETRIC, SHORT, 1, 1),
        (OFFSETS, LONG, 1, place),
        (ROWS, LONG, 1, size[1]),
        (COUNTS, LONG, 1, length),
    ]
}

/// Two pages of 4 × 4 bytes, of which the first may be another.
fn stack(change: impl Fn(&mut Vec<Tag>)) -> Tiff {
    let mut tiff = Tiff::new();
    for first in [true, false] {
        let place = tiff.put(&[7; 16]);
        let mut tags = strip([4, 4], 1, place, 16);
        if first {
            change(&mut tags);
        }
        tiff.page(&tags);
    }
    tiff
}

fn set(tag: u16, value: u32) -> impl Fn(&mut Vec<Tag>) {
    move |tags| {
        let entry = tags.iter_mut().find(|entry| entry.0 == tag);
        entry.expect("every page has it").3 = value;
    }
}

#[test]
fn stacks_whose_tags_cannot_be_true_are_refused() {
    accepted(&stack(|_| {}).files(), "two pages");
    for tag in [WIDTH, HEIGHT, OFFSETS, COUNTS, BITS] {
        for number in [u32::MAX, 1 << 31, 0] {
            if (tag, number) != (OFFSETS, 0) {
                refused(&stack(set(tag, number)).files(), "a.tif at ");
            }
        }
    }
    let both = |tags: &mut Vec<Tag>| {
        [WIDTH, HEIGHT, ROWS]
            .map(|tag| set(tag, u32::MAX)(tags))
            .len()
    };
    let all = stack(|tags| assert_eq!(both(tags), 3));
    refused(&all.files(), "a.tif at ");
    // Counts of values: more than there are bytes.
    for tag in [WIDTH, BITS, OFFSETS, COUNTS] {
        let many = stack(|tags| {
            let entry = tags.iter_mut().find(|entry| entry.0 == tag);
            entry.expect("every page has it").2 = u32::MAX;
        });
        refused(&many.files(), "a.tif at ");
    }
    // The first directory is not there.
    for place in [u32::MAX, 1 << 31, 3] {
        let mut tiff = stack(|_| {});
        tiff.next = 4;
        tiff.point(place);
        refused(&tiff.files(), "a.tif at ");
    }
    // The third is not.
    for place in [u32::MAX, 1 << 31] {
        let mut tiff = stack(|_| {});
        tiff.point(place);
        refused(&tiff.files(), "a.tif at ");
    }
}

#[test]
fn directories_in_a_circle_are_refused() {
    let first = 8 + 16; // behind the header and the first page's samples
    for last in [first, first + 2 + 8 * 12 + 4 + 16] {
        let mut tiff = stack(|_| {});
        tiff.point(last);
        refused(&tiff.files(), "a.tif at ");
    }
}

#[test]
fn strips_that_overlap_are_refused() {
    // 16384 strips of 32 KiB at one place, twice: 1 GiB of 230 kB.
    let mut tiff = Tiff::new();
    let rows = 1 << 14;
    let place = tiff.put(&[7; 1 << 15]);
    let offsets = tiff.put(&place.to_le_bytes().repeat(rows));
    let counts = tiff.put(&(1u32 << 15).to_le_bytes().repeat(rows));
    for _ in 0..2 {
        let mut tags = strip([1 << 15, rows as u32], 1, 0, 0);
        tags[5] = (OFFSETS, LONG, rows as u32, offsets);
        tags[6] = (ROWS, LONG, 1, 1);
        tags[7] = (COUNTS, LONG, rows as u32, counts);
        tiff.page(&tags);
    }
    refused(&tiff.files(), "overlap");
    // One strip that is 600 pages.
    let mut tiff = Tiff::new();
    let place = tiff.put(&vec![7; 1_000_000]);
    for _ in 0..600 {
        tiff.page(&strip([1000, 1000], 1, place, 1_000_000));
    }
    refused(&tiff.files(), "overlap");
}

#[test]
fn stacks_that_would_unpack_to_very_much_are_refused() {
    // LZW, deflate and PackBits: 512 MB, 8 GB and more in 16 bytes.
    for compression in [5, 8, 32946, 32773] {
        for side in [1 << 14, 1 << 16, 1 << 20, 1 << 30] {
            let mut tiff = Tiff::new();
            for _ in 0..2 {
                let place = tiff.put(&[0; 16]);
                tiff.page(&strip([side, side], compression, place, 16));
            }
            refused(&tiff.files(), "a.tif at ");
        }
    }
    // Strips of 16 samples that go on for 100 MB.
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::fast());
    let written = encoder.write_all(&vec![0; 100 << 20]);
    let deflated = written.and_then(|()| encoder.finish()).expect("memory");
    let runs = [129, 0].repeat(100_000);
    for (compression, bytes) in [(8, deflated), (32773, runs)] {
        let mut tiff = Tiff::new();
        let length = bytes.len() as u32;
        for _ in 0..2 {
            let place = tiff.put(&bytes);
            tiff.page(&strip([4, 4], compression, place, length));
        }
        let (_, length, memory) = measured(&tiff.files());
        assert!(memory <= allowed(length), "{compression}: {memory} bytes");
    }
}

// Directories of 65535 entries that begin 6 bytes apart, so that each has its own offset of the
// next: 10⁹ entries in 0.9 MB.
#[test]
fn directories_that_overlap_are_refused_before_they_take_long() {
    let count = 16_000;
    let entries = 12 * 0xffff;
    let mut tiff = Tiff::new();
    let place = tiff.put(&[7; 16]);
    let first = tiff.file.len();
    tiff.point(first as u32);
    tiff.file.resize(first + 6 * count + 2 + entries + 6, 0);
    for i in 0..count {
        let begin = first + 6 * i;
        tiff.file[begin..begin + 2].copy_from_slice(&[0xff; 2]);
        let next = (begin as u32 + 6).to_le_bytes();
        tiff.file[begin + 2 + entries..][..4].copy_from_slice(&next);
    }
    refused(&tiff.files(), "a.tif at ");
    // Pages that are right, before the same.
    let mut tiff = Tiff::new();
    let bytes = tiff.put(&[7; 16]);
    assert_eq!(bytes, place);
    let strips = 100_000;
    let offsets = tiff.put(&place.to_le_bytes().repeat(strips));
    let counts = tiff.put(&1u32.to_le_bytes().repeat(strips));
    for _ in 0..5000 {
        let mut tags = strip([1, strips as u32], 1, 0, 0);
        tags[5] = (OFFSETS, LONG, strips as u32, offsets);
        tags[6] = (ROWS, LONG, 1, 1);
        tags[7] = (COUNTS, LONG, strips as u32, counts);
        tiff.page(&tags);
    }
    refused(&tiff.files(), "a.tif at ");
}

/// Pages of one byte with a description of the first.
fn described(pages: usize, text: &str) -> Files<'static> {
    let mut tiff = Tiff::new();
    let words = tiff.put(text.as_bytes());
    for page in 0..pages {
        let place = tiff.put(&[7; 4]);
        let mut tags = strip([2, 2], 1, place, 4);
        if page == 0 {
            tags.insert(5, (DESCRIPTION, 2, text.len() as u32, words));
        }
        tiff.page(&tags);
    }
    tiff.files()
}

#[test]
fn descriptions_of_stacks_that_cannot_be_true_are_refused_or_not_used() {
    for huge in HUGE {
        for text in [
            format!("ImageJ=1\nimages={huge}\nslices={huge}\n"),
            format!("ImageJ=1\nchannels={huge}\nslices={huge}\nframes={huge}\n"),
            format!("{{\"shape\": [{huge}, {huge}, 2, 2]}}"),
        ] {
            accepted(&described(2, &text), "pages are slices");
        }
        // All samples would follow those of the only page.
        let text = format!("ImageJ=1\nimages={huge}\nslices={huge}\n");
        refused(&described(1, &text), "a.tif at ");
        let size = |x: &str, y: &str| {
            format!(
                "<OME><Pixels DimensionOrder=\"XYZCT\" SizeZ=\"{x}\" SizeC=\"{y}\" SizeT=\"1\"/></OME>"
            )
        };
        refused(&described(2, &size(huge, "1")), "a.tif at ");
        refused(&described(2, &size(huge, huge)), "a.tif at ");
    }
    // Every plane is named by each of 20000 elements: 4 · 10⁸ times.
    let pixels = "<Pixels DimensionOrder=\"XYZCT\" SizeZ=\"20000\" SizeC=\"1\" SizeT=\"1\">";
    let elements = "<TiffData PlaneCount=\"20000\"/>".repeat(20_000);
    let text = format!("<OME>{pixels}{elements}</Pixels></OME>");
    refused(&described(20_000, &text), "again and again");
    let entity = "<!DOCTYPE a [<!ENTITY b \"c\">]><OME/>";
    refused(&described(2, &format!("<?xml?>{entity}")), "a.tif at ");
}

/// A list of pieces of a grid of `kind` with `extent`.
fn pieces(kind: &str, extent: &str, pieces: &[(&str, &str)]) -> Vec<u8> {
    let entry =
        |(extent, name): &(&str, &str)| format!("<Piece Extent=\"{extent}\" Source=\"{name}\"/>");
    let pieces: String = pieces.iter().map(entry).collect();
    format!(
        "<VTKFile type=\"P{kind}\"><P{kind} WholeExtent=\"{extent}\">{pieces}</P{kind}></VTKFile>"
    )
    .into_bytes()
}

#[test]
fn extents_of_listed_pieces_that_cannot_be_true_are_refused() {
    let image = |extent: &str| {
        format!(
            "<VTKFile type=\"ImageData\"><ImageData WholeExtent=\"{extent}\"><Piece Extent=\
             \"{extent}\"><PointData><DataArray type=\"UInt8\" Name=\"s\">1 2 3 4 5 6 7 8\
             </DataArray></PointData></Piece></ImageData></VTKFile>"
        )
        .into_bytes()
    };
    let small = "0 1 0 1 0 1";
    let good = pieces("ImageData", small, &[(small, "s.vti")]);
    accepted(
        &vec![("a.pvti", good), ("s.vti", image(small))],
        "one piece",
    );
    let huge = HUGE
        .iter()
        .map(|huge| format!("0 {huge} 0 {huge} 0 {huge}"));
    let others = [
        "0 2000000000 0 1 0 1",
        "0 60000 0 60000 0 60000",
        "0 nan 0 1 0 1",
        "0 -1 0 1 0 1",
    ];
    for extent in huge.chain(others.map(String::from)) {
        for kind in ["ImageData", "StructuredGrid", "RectilinearGrid"] {
            let list = pieces(kind, &extent, &[(&extent, "s.vti")]);
            let files = |piece| vec![("a.pvti", list.clone()), ("s.vti", piece)];
            refused(&files(image(&extent)), " at ");
            refused(&files(image(small)), " at ");
        }
    }
    // A piece twice, under two names, and one that is not what is listed.
    let twice = pieces("ImageData", small, &[(small, "s.vti"), (small, "t.vti")]);
    let _ = measured(&vec![
        ("a.pvti", twice),
        ("s.vti", image(small)),
        ("t.vti", image(small)),
    ]);
    let list = pieces("ImageData", small, &[(small, "s.vti")]);
    refused(&vec![("a.pvti", list.clone()), ("s.vti", list)], " at ");
}
