#![no_main]

tetrascope_fuzz_guided::target!("dicom");
