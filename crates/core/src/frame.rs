//! What a renderer returns.

/// A rendered image and how it was made.
#[derive(Clone, Debug)]
pub struct Frame {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Premultiplied linear RGBA, row-major, top row first, `width * height` texels.
    pub pixels: Vec<[f32; 4]>,
    /// In the model `Isosurfaces`: how far along its ray each pixel's surface is, world
    /// units, infinite where there is none; laid out as `pixels`. An orthographic ray
    /// starts in the camera's plane.
    pub depths: Option<Vec<f32>>,
    /// What it took.
    pub stats: FrameStats,
}

/// What a frame took, and what was left out of it. `None` is "not measured" or
/// "does not apply".
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
    /// Ray-cell intervals that were integrated.
    pub cell_visits: Option<u64>,
    /// Stretches of rays from where they enter the mesh to where they leave it.
    pub paths: Option<u64>,
    /// Rays that cross the boundary an odd number of times, which should never happen.
    pub unpaired_faces: Option<u64>,
    /// Rays that were given up inside the mesh, or came out where they do not cross it.
    pub lost_rays: Option<u64>,
    /// Layers of boundary faces that were peeled and not empty.
    pub layers: Option<u64>,
    /// Parts of the image that some ray of theirs made worth drawing.
    pub tiles_drawn: Option<u64>,
    /// Parts of the image that no ray through the volume touches.
    pub tiles_skipped: Option<u64>,
    /// The least and the greatest number of steps' passes among the tiles drawn.
    pub tile_passes: Option<[u64; 2]>,
    /// Fragments of the passes through the volume, as the device counts them: it may count
    /// those beside a polygon that complete a block, and `raycast-peel` counts idle rays.
    pub fragments: Option<u64>,
    /// Cells sent to the rasterizer.
    pub cells_drawn: Option<u64>,
    /// Cells left out because they have no volume, or map to nothing.
    pub cells_skipped: Option<u64>,
    /// Cells that were sorted; 0 when the optical model commutes.
    pub cells_sorted: Option<u64>,
    /// Boxes of a grid that were drawn.
    pub bricks_drawn: Option<u64>,
    /// Boxes of a grid left out because they map to nothing, or are outside of the image or
    /// behind clip planes.
    pub bricks_skipped: Option<u64>,
    /// Vertices sent to the vertex stage.
    pub vertices: Option<u64>,
    /// Bytes of the volume sent to the device for this frame.
    pub bytes_uploaded: u64,
    /// Bytes that say what is drawn where, sent to the device for this frame: boxes or
    /// polygons, and the camera.
    pub geometry_bytes: Option<u64>,
    /// Faces across which the order of cells was given up because cells hide each
    /// other in a cycle.
    pub visibility_cycles: Option<u64>,
    /// Where cells had to be blended in an order: whether it is known to be right, in every
    /// pixel. The notes say why it is not.
    pub order_proven: Option<bool>,
    /// Fragments that were kept to be sorted in their pixels.
    pub fragments_sorted: Option<u64>,
    /// Bytes that one of the volume's cells takes on the device on average, whatever the
    /// view and the appearance.
    pub bytes_per_cell: Option<f64>,
    /// Bytes of the volume that stay on the device (or in memory) between frames.
    pub bytes_resident: u64,
    /// How many of `bytes_resident` each view writes anew.
    pub bytes_per_view: Option<u64>,
    /// The image's worst error bound, absolute, if the renderer has one.
    pub error_bound: Option<f64>,
    /// Pixels in which cells overlap or leave gaps beyond rounding.
    pub inconsistent_pixels: Option<u64>,
    /// Fallbacks that were taken, a sentence each.
    pub notes: Vec<String>,
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
