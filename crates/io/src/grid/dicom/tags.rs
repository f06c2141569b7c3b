//! The tags of the elements that are read (PS3.6).

use super::elements::Tag;

pub(super) const TRANSFER_SYNTAX: Tag = 0x0002_0010;
pub(super) const MODALITY: Tag = 0x0008_0060;
pub(super) const SERIES_DESCRIPTION: Tag = 0x0008_103E;
pub(super) const SLICE_THICKNESS: Tag = 0x0018_0050;
pub(super) const ECHO_TIME: Tag = 0x0018_0081;
pub(super) const SPACING_BETWEEN_SLICES: Tag = 0x0018_0088;
pub(super) const TRIGGER_TIME: Tag = 0x0018_1060;
pub(super) const IMAGER_PIXEL_SPACING: Tag = 0x0018_1164;
pub(super) const B_VALUE: Tag = 0x0018_9087;
pub(super) const SERIES: Tag = 0x0020_000E;
pub(super) const INSTANCE_NUMBER: Tag = 0x0020_0013;
pub(super) const POSITION: Tag = 0x0020_0032;
pub(super) const ORIENTATION: Tag = 0x0020_0037;
pub(super) const TEMPORAL_POSITION: Tag = 0x0020_0100;
pub(super) const FRAME_CONTENT: Tag = 0x0020_9111;
pub(super) const PLANE_POSITION: Tag = 0x0020_9113;
pub(super) const PLANE_ORIENTATION: Tag = 0x0020_9116;
pub(super) const TEMPORAL_INDEX: Tag = 0x0020_9128;
pub(super) const SAMPLES_PER_PIXEL: Tag = 0x0028_0002;
pub(super) const PHOTOMETRIC: Tag = 0x0028_0004;
pub(super) const PLANAR: Tag = 0x0028_0006;
pub(super) const FRAMES: Tag = 0x0028_0008;
pub(super) const ROWS: Tag = 0x0028_0010;
pub(super) const COLUMNS: Tag = 0x0028_0011;
pub(super) const PIXEL_SPACING: Tag = 0x0028_0030;
pub(super) const BITS_ALLOCATED: Tag = 0x0028_0100;
pub(super) const BITS_STORED: Tag = 0x0028_0101;
pub(super) const HIGH_BIT: Tag = 0x0028_0102;
pub(super) const REPRESENTATION: Tag = 0x0028_0103;
pub(super) const PADDING: Tag = 0x0028_0120;
pub(super) const INTERCEPT: Tag = 0x0028_1052;
pub(super) const SLOPE: Tag = 0x0028_1053;
pub(super) const RESCALE_TYPE: Tag = 0x0028_1054;
pub(super) const PIXEL_MEASURES: Tag = 0x0028_9110;
pub(super) const PIXEL_VALUES: Tag = 0x0028_9145;
pub(super) const DETECTORS: Tag = 0x0054_0022;
pub(super) const FRAME_OFFSETS: Tag = 0x3004_000C;
pub(super) const DOSE_SCALING: Tag = 0x3004_000E;
pub(super) const SHARED_GROUPS: Tag = 0x5200_9229;
pub(super) const FRAME_GROUPS: Tag = 0x5200_9230;
pub(super) const FLOAT_PIXELS: Tag = 0x7FE0_0008;
pub(super) const DOUBLE_PIXELS: Tag = 0x7FE0_0009;
pub(super) const INTEGER_PIXELS: Tag = 0x7FE0_0010;

/// Elements whose value is the pixels.
pub(super) const PIXELS: [Tag; 3] = [FLOAT_PIXELS, DOUBLE_PIXELS, INTEGER_PIXELS];

/// Sequences whose items are kept.
pub(super) const SEQUENCES: [Tag; 8] = [
    FRAME_CONTENT,
    PLANE_POSITION,
    PLANE_ORIENTATION,
    PIXEL_MEASURES,
    PIXEL_VALUES,
    DETECTORS,
    SHARED_GROUPS,
    FRAME_GROUPS,
];

/// Elements whose value is kept.
pub(super) const VALUES: [Tag; 32] = [
    TRANSFER_SYNTAX,
    MODALITY,
    SERIES_DESCRIPTION,
    SLICE_THICKNESS,
    ECHO_TIME,
    SPACING_BETWEEN_SLICES,
    TRIGGER_TIME,
    IMAGER_PIXEL_SPACING,
    B_VALUE,
    SERIES,
    INSTANCE_NUMBER,
    POSITION,
    ORIENTATION,
    TEMPORAL_POSITION,
    TEMPORAL_INDEX,
    SAMPLES_PER_PIXEL,
    PHOTOMETRIC,
    PLANAR,
    FRAMES,
    ROWS,
    COLUMNS,
    PIXEL_SPACING,
    BITS_ALLOCATED,
    BITS_STORED,
    HIGH_BIT,
    REPRESENTATION,
    PADDING,
    INTERCEPT,
    SLOPE,
    RESCALE_TYPE,
    FRAME_OFFSETS,
    DOSE_SCALING,
];
