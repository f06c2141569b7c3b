use super::fill;

/// The result of `xz --check=crc32 --block-size=16` for [`TEXT`]: two blocks, of which the second is
/// stored as it is.
const FILE: &[u8] = include_bytes!("../../../tests/fixtures/cells.xz");
const TEXT: &[u8] = b"cells cells cells cells\n";

#[test]
fn blocks_are_joined_and_fill_their_place() {
    let mut place = vec![0; TEXT.len()];
    assert!(fill(FILE, &mut place));
    assert_eq!(place, TEXT);
    for other in [0, TEXT.len() - 1, TEXT.len() + 1, 1000] {
        assert!(!fill(FILE, &mut vec![0; other]), "{other}");
    }
}

#[test]
fn what_is_damaged_is_refused_and_does_no_harm() {
    // The index and the footer, which are not read.
    let end = FILE.len() - 12 - 16;
    for length in 0..end {
        assert!(!fill(&FILE[..length], &mut vec![0; TEXT.len()]), "{length}");
    }
    let mut refused = 0;
    for at in 0..end {
        for bit in 0..8 {
            let mut file = FILE.to_vec();
            file[at] ^= 1 << bit;
            let mut place = vec![0; TEXT.len()];
            match fill(&file, &mut place) {
                true => assert_eq!(place, TEXT, "bit {bit} of byte {at}"),
                false => refused += 1,
            }
        }
    }
    // The checksum of the first flags is not compared, and how many bits of a literal's
    // neighbor count makes no difference for so few literals.
    assert!(refused >= 8 * (end - 5), "{refused} of {}", 8 * end);
}

// What is read is right, too, with the greatest dictionary that a file may ask for.
#[test]
fn dictionaries_may_be_of_any_size() {
    let mut file = FILE.to_vec();
    // In the header of the first block, behind the filter's number and 1.
    file[16] = 40;
    let sum = super::checksum(&file[12..20]);
    file[20..24].copy_from_slice(&sum);
    let mut place = vec![0; TEXT.len()];
    assert!(fill(&file, &mut place));
    assert_eq!(place, TEXT);
}
