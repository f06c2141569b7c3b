//! One algorithm with one setting: what it draws, and how long that takes.
//!
//! The first frame is drawn from the scene's own camera, and errors are judged by it. The frames that
//! are timed come after it, each from a camera that has moved on a little, so that nothing of the
//! view can be kept from one to the next.

use std::time::{Duration, Instant};

use tetrascope::core::glam::{DMat3, DVec3};
use tetrascope::core::{Camera, Error, Frame, View, Volume, VolumeRenderer as _};
use tetrascope::scene::Scene;
use tetrascope::{Algorithm, Context, Renderer, Settings};

use crate::metrics::{Errors, median};
use crate::report::{Drawn, Outcome};

/// An algorithm with a setting, and what it has drawn.
pub(super) struct Contender {
    pub(super) algorithm: &'static Algorithm,
    pub(super) setting: &'static str,
    pub(super) settings: Settings,
    /// The picture that is judged.
    pub(super) frame: Option<Frame>,
    renderer: Result<Renderer, Error>,
    prepare: Duration,
    first: Duration,
    wall_ms: Vec<f64>,
    gpu_ms: Vec<f64>,
    restyle: Option<Duration>,
}

/// A setting's frames are not repeated any more once they took so long in all, the first included,
/// but for one: a default run has hundreds of settings, and what takes long varies less. The first
/// alone says little: drivers compile shaders in it.
const ENOUGH: Duration = Duration::from_millis(600);

/// How far the camera goes around the focal point from frame to frame.
const STEP_DEGREES: f64 = 0.5;

impl Contender {
    /// Builds a renderer.
    pub(super) fn new(
        context: &Context,
        (algorithm, setting): (&'static Algorithm, &'static str),
        volume: &Volume,
        scene: &Scene,
    ) -> Result<Contender, Error> {
        if algorithm.needs_gpu {
            // The device is made once a program: no algorithm is charged for it.
            // An error comes up again in `build`.
            _ = context.gpu();
        }
        let settings = Settings::parse(algorithm, setting.split(','))?;
        let start = Instant::now();
        let renderer = (algorithm.supports)(volume, &scene.appearance, &scene.view, &settings)
            .and_then(|()| (algorithm.build)(context, volume, &scene.appearance, &settings));
        Ok(Contender {
            algorithm,
            setting,
            settings,
            frame: None,
            renderer,
            prepare: start.elapsed(),
            first: Duration::ZERO,
            wall_ms: Vec::new(),
            gpu_ms: Vec::new(),
            restyle: None,
        })
    }

    /// Draws the frame of a round: the first is judged, those after it are timed unless they would
    /// take too long.
    pub(super) fn draw(&mut self, scene: &Scene, round: u32) {
        if !self.wall_ms.is_empty() && self.spent() >= ENOUGH {
            return;
        }
        let Ok(renderer) = &self.renderer else { return };
        let view = View {
            camera: moved(&scene.view.camera, STEP_DEGREES * f64::from(round)),
            ..scene.view
        };
        let start = Instant::now();
        match renderer.render(&view) {
            Ok(frame) if round > 0 => {
                self.wall_ms.push(milliseconds(start.elapsed()));
                self.gpu_ms.extend(frame.stats.gpu_seconds.map(|s| s * 1e3));
            }
            Ok(frame) => {
                self.first = start.elapsed();
                self.frame = Some(frame);
            }
            Err(error) => self.fail(error),
        }
    }

    /// Times another look at the same volume: the same appearance again, of which nothing is kept.
    pub(super) fn restyle(&mut self, scene: &Scene) {
        // What has drawn and was prepared quickly: a look takes no longer than all.
        if self.prepare > ENOUGH {
            return;
        }
        let Ok(renderer) = &mut self.renderer else {
            return;
        };
        let start = Instant::now();
        match renderer.restyle(&scene.appearance) {
            Ok(()) => self.restyle = Some(start.elapsed()),
            Err(error) => self.fail(error),
        }
    }

    fn fail(&mut self, error: Error) {
        self.renderer = Err(error);
        self.frame = None;
    }

    /// The time that frames took.
    fn spent(&self) -> Duration {
        self.first + Duration::from_secs_f64(self.wall_ms.iter().sum::<f64>() / 1e3)
    }

    pub(super) fn is_default(&self) -> bool {
        self.settings == Settings::defaults(self.algorithm)
    }

    /// The numbers, if there is a picture.
    pub(super) fn outcome(&self, truth: Option<&Frame>) -> Outcome {
        let frame = match (&self.frame, &self.renderer) {
            (Some(frame), _) => frame,
            (None, Err(error)) => return Outcome::Skipped(error.to_string()),
            (None, Ok(_)) => unreachable!("a renderer draws or fails"),
        };
        let truth = truth.filter(|_| !self.algorithm.is_truth());
        let first_ms = milliseconds(self.first);
        // Where no other was asked for, the first is all there is.
        let (wall_ms, gpu_ms) = match self.wall_ms.is_empty() {
            true => {
                let gpu_ms = frame.stats.gpu_seconds.map(|s| s * 1e3);
                (vec![first_ms], Vec::from_iter(gpu_ms))
            }
            false => (self.wall_ms.clone(), self.gpu_ms.clone()),
        };
        // Device time only where every frame has it.
        let on_device = gpu_ms.len() == wall_ms.len();
        let times = if on_device { &gpu_ms } else { &wall_ms };
        let middle = |times: &[f64]| median(times).expect("a frame was drawn");
        Outcome::Drawn(Box::new(Drawn {
            error: truth.map(|truth| Errors::between(truth, frame)),
            prepare_ms: milliseconds(self.prepare),
            first_ms,
            frame_ms: middle(times),
            frame_range_ms: [
                times.iter().copied().fold(f64::INFINITY, f64::min),
                times.iter().copied().fold(0.0, f64::max),
            ],
            frames: self.wall_ms.len(),
            clock: if on_device { "gpu" } else { "wall" }.into(),
            wall_ms: middle(&wall_ms),
            restyle_ms: self.restyle.map(milliseconds),
            peak_bytes: None,
            stats: (&frame.stats).into(),
        }))
    }
}

/// A camera that has gone around what it looks at, about its own upward axis.
fn moved(camera: &Camera, degrees: f64) -> Camera {
    let up: DVec3 = camera.axes().1;
    let turn = DMat3::from_axis_angle(up, degrees.to_radians());
    Camera {
        position: camera.focal_point + turn * (camera.position - camera.focal_point),
        ..*camera
    }
}

pub(super) fn milliseconds(duration: Duration) -> f64 {
    duration.as_secs_f64() * 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use tetrascope::core::{Bounds, CameraFit};

    #[test]
    fn a_camera_goes_around_and_keeps_its_distance() {
        let bounds = Bounds {
            min: DVec3::ZERO,
            max: DVec3::ONE,
        };
        let camera = Camera::fit(&bounds, CameraFit::PlusX, false, 1.0);
        assert_eq!(moved(&camera, 0.0), camera);
        let other = moved(&camera, 90.0);
        let [before, after] = [&camera, &other].map(|c| c.position - c.focal_point);
        // Rounding of a product of 3 by 3.
        assert!((before.length() - after.length()).abs() < 1e-12);
        assert!(before.dot(after).abs() < 1e-12 && after.dot(camera.view_up).abs() < 1e-12);
    }
}
