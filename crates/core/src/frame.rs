//! Frames: the pictures that renderers return.

/// A rendered image and how it was made.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Premultiplied linear RGBA, row-major, top row first, `width * height` texels.
    pub pixels: Vec<[f32; 4]>,
    /// In the model `Isosurfaces`: how far along its ray each pixel's surface is, world
    /// units, infinite where there is none; laid out as `pixels`. An orthographic ray
    /// starts in the camera's plane.
    pub depths: Option<Vec<f32>>,
    /// The work that it took.
    pub stats: FrameStats,
}

/// The work that a frame took. `None` is "not measured" or "does not apply".
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize)]
#[non_exhaustive]
pub struct FrameStats {
    /// Wall time of the frame on the CPU, readback included, seconds.
    pub cpu_seconds: f64,
    /// Time between the first and last command on the GPU, seconds. On a software adapter,
    /// whose clocks cannot be relied on, from submitting the commands until they are done.
    pub gpu_seconds: Option<f64>,
    /// Render and compute passes recorded.
    pub passes: u64,
    /// Counts of the algorithm, as its [`Entry`](crate::Entry) lists them; fields of their own in
    /// JSON.
    #[serde(flatten, serialize_with = "as_fields")]
    pub counts: Vec<Count>,
    /// Bytes of the volume sent to the device for this frame.
    pub bytes_uploaded: u64,
    /// Bytes of the volume that stay on the device (or in memory) between frames.
    pub bytes_resident: u64,
    /// Bytes that one of the volume's cells takes on the device on average, whatever the
    /// view and the appearance.
    pub bytes_per_cell: Option<f64>,
    /// Where cells had to be blended in an order: whether it is known to be right, in every
    /// pixel. The notes say why it is not.
    pub order_proven: Option<bool>,
    /// The image's worst error bound, absolute, if the renderer has one.
    pub error_bound: Option<f64>,
    /// Fallbacks that were taken, a sentence each.
    pub notes: Vec<String>,
}

/// Something that an algorithm counts in its frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    /// In snake case, as in JSON.
    pub name: &'static str,
    /// Unit, in words.
    pub unit: &'static str,
    /// An explanation, in sentences.
    pub about: &'static str,
}

/// The count of a [`Counter`] in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count {
    /// The counter.
    pub counter: Counter,
    /// How many.
    pub value: u64,
}

impl FrameStats {
    /// The count of a counter; `None` where it did not count.
    pub fn get(&self, counter: Counter) -> Option<u64> {
        let count = self.counts.iter().find(|c| c.counter.name == counter.name);
        count.map(|count| count.value)
    }

    /// Says that there are `value`, whatever was said before.
    pub fn count(&mut self, counter: Counter, value: u64) {
        match self
            .counts
            .iter_mut()
            .find(|c| c.counter.name == counter.name)
        {
            Some(count) => count.value = value,
            None => self.counts.push(Count { counter, value }),
        }
    }

    /// Says that there are `more` than was said before.
    pub fn add(&mut self, counter: Counter, more: u64) {
        self.count(counter, self.get(counter).unwrap_or(0) + more);
    }
}

fn as_fields<S: serde::Serializer>(counts: &[Count], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(counts.iter().map(|count| (count.counter.name, count.value)))
}

/// Makes a constant of each [`Counter`], and `ALL` of them; the sentences are those of its doc
/// comment.
///
/// ```
/// tetrascope_core::counters! {
///     /// Cells that were drawn.
///     CELLS_DRAWN = "cells_drawn", "cells";
/// }
/// assert_eq!(CELLS_DRAWN.about, "Cells that were drawn.");
/// assert_eq!(ALL, [CELLS_DRAWN]);
/// ```
#[macro_export]
macro_rules! counters {
    ($($(#[doc = $about:literal])+ $counter:ident = $name:literal, $unit:literal;)+) => {
        $(
            $(#[doc = $about])+
            pub const $counter: $crate::frame::Counter = $crate::frame::Counter {
                name: $name,
                unit: $unit,
                about: concat!($($about),+).trim_ascii(),
            };
        )+

        /// All of them.
        pub const ALL: &[$crate::frame::Counter] = &[$($counter),+];
    };
}

impl Frame {
    /// A frame without depths.
    pub fn new(size: (u32, u32), pixels: Vec<[f32; 4]>, stats: FrameStats) -> Frame {
        let (width, height) = size;
        Frame {
            width,
            height,
            pixels,
            depths: None,
            stats,
        }
    }

    /// The pixel in (column, row), row 0 at the top.
    pub fn pixel(&self, column: u32, row: u32) -> [f32; 4] {
        self.pixels[row as usize * self.width as usize + column as usize]
    }
}
