//! One way to draw: each renderer records a frame once, into its caller's commands or its own.
//!
//! [`Draw::encode`] is for an application that has a device, an encoder and a target, perhaps
//! with its own opaque geometry in them; [`render`] is [`encode`](Draw::encode) into a texture
//! that is read back.

use std::time::Instant;

use tetrascope_core::glam::DMat4;
use tetrascope_core::{Error, Frame, FrameStats, View, VolumeRenderer};
use wgpu::{CommandEncoder, TextureFormat, TextureUsages};

use crate::canvas::Canvas;
use crate::memory::{Source, read_back};
use crate::timer;
use crate::{Gpu, Timer};

/// Where a frame is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Target<'a> {
    /// As large as the view. It gets linear premultiplied RGBA.
    pub color: &'a wgpu::TextureView,
    /// The format of `color`: any that can be rendered to, and blended where the volume is drawn
    /// over what is there.
    pub format: TextureFormat,
    /// The background that the volume is drawn over.
    pub over: Over,
    /// The application's depth buffer, if it has drawn opaque geometry: rays end there.
    pub depth: Option<SceneDepth<'a>>,
}

/// The background that a volume is drawn over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Over {
    /// The view's background; every texel of the target is written.
    Background,
    /// The target as it is.
    WhatIsThere,
}

/// An application's depth buffer.
///
/// A volume is drawn in front of what is there and leaves depths as they are; an isosurface is
/// hidden by what is nearer, and writes its own depth.
#[derive(Clone, Copy, Debug)]
pub struct SceneDepth<'a> {
    /// As large as the view, with one layer, one mip level and one sample, of a format with
    /// depth. Volumes read it ([`TextureUsages::TEXTURE_BINDING`]), isosurfaces draw into it
    /// ([`TextureUsages::RENDER_ATTACHMENT`]).
    pub texture: &'a wgpu::Texture,
    /// From world space to clip space, as the application has drawn with; depth may grow or fall
    /// with distance, and the far plane may be infinitely far. It must see what the view's camera
    /// sees: pixels are the camera's. Where depth is 1 (0 if it falls) nothing was drawn.
    pub clip_from_world: DMat4,
}

impl<'a> Target<'a> {
    /// All of `color`, over the view's background.
    pub fn new(color: &'a wgpu::TextureView, format: TextureFormat) -> Target<'a> {
        Target {
            color,
            format,
            over: Over::Background,
            depth: None,
        }
    }

    /// # Errors
    /// [`Error::Invalid`] for textures that do not fit the view, [`Error::Unsupported`] for a
    /// format that the device does not draw into, or not as asked.
    fn check(&self, gpu: &Gpu, view: &View) -> Result<(), Error> {
        let size = (view.width, view.height);
        let has_size = |what: &str, texture: &wgpu::Texture, mip: u32| {
            let (width, height) = (texture.width() >> mip, texture.height() >> mip);
            match (width.max(1), height.max(1)) == size {
                true => Ok(()),
                false => Err(Error::invalid(format!(
                    "a {what} of {width}x{height} for a view of {}x{}",
                    size.0, size.1
                ))),
            }
        };
        // A view of one level of a texture may be smaller than it: wgpu checks that one.
        let color = self.color.texture();
        if color.mip_level_count() == 1 {
            has_size("target", color, 0)?;
        }
        let unsupported = |what: String, reason: &str| {
            Err(Error::Unsupported {
                renderer: "gpu",
                what,
                reason: reason.into(),
            })
        };
        let allowed = self.format.guaranteed_format_features(gpu.features());
        let kind = self.format.sample_type(None, Some(gpu.features()));
        let is_color = matches!(kind, Some(wgpu::TextureSampleType::Float { .. }));
        let renders = allowed
            .allowed_usages
            .contains(TextureUsages::RENDER_ATTACHMENT);
        if !is_color || !renders {
            let what = format!("a target of format {:?}", self.format);
            return unsupported(what, "the device does not draw colors into it");
        }
        let blends = allowed
            .flags
            .contains(wgpu::TextureFormatFeatureFlags::BLENDABLE);
        if self.over == Over::WhatIsThere && !blends {
            let what = format!(
                "drawing over what is in a target of format {:?}",
                self.format
            );
            return unsupported(what, "the device does not blend it");
        }
        let Some(depth) = &self.depth else {
            return Ok(());
        };
        has_size("depth buffer", depth.texture, 0)?;
        let format = depth.texture.format();
        if !format.has_depth_aspect() {
            return Err(Error::invalid(format!(
                "a depth buffer of format {format:?}, which has no depth"
            )));
        }
        if depth.texture.sample_count() != 1 || depth.texture.depth_or_array_layers() != 1 {
            return unsupported(
                "a depth buffer with several samples or layers".into(),
                "a ray ends at one depth",
            );
        }
        match depth.clip_from_world.is_finite() && depth.clip_from_world.determinant() != 0.0 {
            true => Ok(()),
            false => Err(Error::invalid(
                "a transform of the depth buffer that has no inverse",
            )),
        }
    }
}

/// The commands of a frame while they are recorded.
#[derive(Debug)]
pub struct Commands<'a> {
    encoder: &'a mut CommandEncoder,
    /// Where they are submitted by whoever records them.
    own: Option<&'a Gpu>,
    submitted: Option<Instant>,
}

impl<'a> Commands<'a> {
    /// Where to record.
    pub fn encoder(&mut self) -> &mut CommandEncoder {
        self.encoder
    }

    /// Whether commands may be submitted before the frame is complete, to read between.
    pub fn may_submit(&self) -> bool {
        self.own.is_some()
    }

    /// Submits what was recorded so far, waits for it, and goes on.
    ///
    /// # Errors
    /// A lost device, and [`Error::Stopped`] where [`Gpu::stop`] asks for it. Panics in a caller's
    /// encoder: ask [`Commands::may_submit`] before.
    pub fn submit(&mut self) -> Result<(), Error> {
        let gpu = self.own.expect("the commands are the renderer's own");
        gpu.stop().check()?;
        self.submitted.get_or_insert_with(Instant::now);
        let next = gpu.device().create_command_encoder(&Default::default());
        gpu.finish(std::mem::replace(self.encoder, next))
    }
}

/// The work that is left to do for a frame once its commands have run.
pub type Later = Box<dyn FnOnce(&mut FrameStats) -> Result<Outcome, Error> + Send>;

/// Whether a frame is complete.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It is.
    Complete,
    /// It is not: recorded once more it would be, in another way.
    Incomplete,
}

/// A frame that was recorded.
#[must_use]
pub struct Recorded {
    /// The statistics that are known before the commands run.
    pub stats: FrameStats,
    later: Vec<Later>,
    /// How far along their rays isosurfaces are, normalized units, and the world units in one.
    distances: Option<(wgpu::Texture, f64)>,
}

impl Recorded {
    /// A frame with these statistics.
    pub fn new(stats: FrameStats) -> Recorded {
        Recorded {
            stats,
            later: Vec::new(),
            distances: None,
        }
    }

    /// Adds what is done once the commands have run, such as to read counters.
    pub fn then(
        mut self,
        later: impl FnOnce(&mut FrameStats) -> Result<Outcome, Error> + Send + 'static,
    ) -> Recorded {
        self.later.push(Box::new(later));
        self
    }

    /// Adds the distances of isosurfaces, R32Float, normalized units of `scale` world units from
    /// where rays start, [`NOWHERE`](crate::canvas::NOWHERE) where there is none.
    pub fn with_distances(mut self, distances: &wgpu::Texture, scale: f64) -> Recorded {
        self.distances = Some((distances.clone(), scale));
        self
    }

    /// The frame's statistics, and what was noted about it; waits for the device.
    ///
    /// The commands must have been submitted.
    pub fn statistics(self) -> Result<FrameStats, Error> {
        Ok(self.finish()?.0)
    }

    fn finish(self) -> Result<(FrameStats, Outcome), Error> {
        let mut stats = self.stats;
        let mut all = Outcome::Complete;
        for later in self.later {
            if later(&mut stats)? == Outcome::Incomplete {
                all = Outcome::Incomplete;
            }
        }
        Ok((stats, all))
    }
}

/// A renderer that records its frames on a GPU.
pub trait Draw: VolumeRenderer {
    /// The device, and what frames share.
    fn canvas(&self) -> &Canvas;

    /// Records a frame of `view`, which is valid, into `target`, which fits it.
    ///
    /// # Errors
    /// [`Error::Unsupported`] for what cannot be recorded where
    /// [`Commands::may_submit`] is false, with the reason.
    fn record(
        &self,
        commands: &mut Commands,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error>;

    /// Records a frame into an application's commands; nothing is submitted.
    ///
    /// [`Recorded::statistics`] has the statistics once the commands have run.
    ///
    /// # Errors
    /// Refusals of [`View::validate`], a target that does not fit, and what the renderer cannot
    /// record without reading in between.
    fn encode(
        &self,
        encoder: &mut CommandEncoder,
        view: &View,
        target: &Target,
    ) -> Result<Recorded, Error> {
        view.validate()?;
        target.check(self.canvas().gpu(), view)?;
        let mut commands = Commands {
            encoder,
            own: None,
            submitted: None,
        };
        self.record(&mut commands, view, target)
    }
}

/// Draws a frame of `view` and reads it back: `VolumeRenderer::render` of all that [`Draw`].
pub fn render(renderer: &impl Draw, view: &View) -> Result<Frame, Error> {
    let start = Instant::now();
    view.validate()?;
    let canvas = renderer.canvas();
    let gpu = canvas.gpu();
    let image = canvas.image((view.width, view.height))?;
    let image_view = image.create_view(&Default::default());
    let target = Target::new(&image_view, image.format());
    loop {
        let mut encoder = gpu.device().create_command_encoder(&Default::default());
        let timer = Timer::new(gpu)?;
        if let Some(timer) = &timer {
            timer.begin(&mut encoder);
        }
        let mut commands = Commands {
            encoder: &mut encoder,
            own: Some(gpu),
            submitted: None,
        };
        let mut recorded = renderer.record(&mut commands, view, &target)?;
        let submitted = commands.submitted;
        if let Some(timer) = &timer {
            timer.end(&mut encoder);
        }
        let pixels = read_back(gpu, &mut encoder, Source::Texture(&image))?;
        let distances = recorded.distances.take();
        let distances = distances.map(|(texture, scale)| {
            let copy = read_back(gpu, &mut encoder, Source::Texture(&texture))?;
            Ok::<_, Error>((copy, scale))
        });
        let distances = distances.transpose()?;
        let times = timer.map(|t| t.resolve(gpu, &mut encoder)).transpose()?;
        let submitted = submitted.unwrap_or_else(Instant::now);
        gpu.stop().check()?;
        gpu.finish(encoder)?;
        let waited = submitted.elapsed();
        let (mut stats, outcome) = recorded.finish()?;
        if outcome == Outcome::Incomplete {
            continue;
        }
        stats.gpu_seconds = timer::seconds(gpu, times, waited)?;
        let pixels = pixels.read()?;
        let depths = distances.map(|(copy, scale)| {
            let distances: Vec<f32> = copy.read()?;
            Ok::<_, Error>(distances.into_iter().map(|d| world(d, scale)).collect())
        });
        let depths = depths.transpose()?;
        stats.cpu_seconds = start.elapsed().as_secs_f64();
        let mut frame = Frame::new((view.width, view.height), pixels, stats);
        frame.depths = depths;
        return Ok(frame);
    }
}

/// A distance in world units; infinite where there is none.
fn world(distance: f32, scale: f64) -> f32 {
    match distance < crate::canvas::NOWHERE {
        true => (f64::from(distance) * scale) as f32,
        false => f32::INFINITY,
    }
}
