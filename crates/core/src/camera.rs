//! Cameras with VTK's parameters.

use crate::Unit as _;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Bounds, Error};

/// A camera in world space, right-handed, with VTK's names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is; for an orthographic camera, a point of the image plane.
    /// Nothing behind it is drawn.
    pub position: DVec3,
    /// The point that it looks at.
    pub focal_point: DVec3,
    /// A direction that points up in the image; need not be perpendicular to the view.
    pub view_up: DVec3,
    /// How rays spread.
    pub projection: Projection,
}

/// How rays spread over the image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    /// All rays start at the position.
    Perspective {
        /// The vertical opening angle, degrees, in (0, 180).
        view_angle: f64,
    },
    /// All rays are parallel.
    Orthographic {
        /// Half the height of the image, world units.
        parallel_scale: f64,
    },
}

/// A ray x(t) = origin + t direction, t ≥ 0, world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where t = 0.
    pub origin: DVec3,
    /// A unit vector.
    pub direction: DVec3,
}

impl Ray {
    /// The point at distance `t`.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.direction
    }
}

/// The default vertical opening angle, degrees (VTK's).
pub const DEFAULT_VIEW_ANGLE: f64 = 30.0;

impl Camera {
    /// Refuses a camera that looks nowhere.
    pub fn validate(&self) -> Result<(), Error> {
        let wrong = |what: &str, help: &str| {
            Err(Error::Invalid {
                what: what.into(),
                help: Some(help.into()),
            })
        };
        let finite =
            self.position.is_finite() && self.focal_point.is_finite() && self.view_up.is_finite();
        if !finite {
            return wrong(
                "the camera has a coordinate that is not finite",
                "give three numbers each",
            );
        }
        let forward = self.focal_point - self.position;
        if forward.length() == 0.0 || !forward.length().is_finite() {
            return wrong(
                "the camera is at its focal point",
                "move `position` away from `focal_point`, or let the camera fit the volume",
            );
        }
        // Below this sine, rounding of the inputs decides where up is.
        let sine = forward
            .unit()
            .cross(self.view_up.normalize_or_zero())
            .length();
        if sine < 1e-9 {
            return wrong(
                "the camera's view_up is zero or along the view",
                "choose a view_up across the view, such as [0, 1, 0] or [0, 0, 1]",
            );
        }
        match self.projection {
            Projection::Perspective { view_angle } if !(view_angle > 0.0 && view_angle < 180.0) => {
                wrong(
                    &format!("a view_angle of {view_angle} degrees"),
                    "give more than 0 and less than 180 degrees; 30 is usual",
                )
            }
            Projection::Orthographic { parallel_scale }
                if !(parallel_scale > 0.0 && parallel_scale.is_finite()) =>
            {
                wrong(
                    &format!("a parallel_scale of {parallel_scale}"),
                    "give half the image's height in world units, more than 0",
                )
            }
            _ => Ok(()),
        }
    }

    /// Unit vectors (right, up, forward) of the image, world space.
    ///
    /// Right × up points from the scene to the eye, so the frame is right-handed
    /// as (right, up, −forward).
    pub fn axes(&self) -> (DVec3, DVec3, DVec3) {
        let forward = (self.focal_point - self.position).unit();
        let right = forward.cross(self.view_up.unit()).unit();
        (right, right.cross(forward), forward)
    }

    /// The ray through (x, y) of the image plane, each in [−1, 1], y up.
    ///
    /// `aspect` is width over height.
    pub fn ray(&self, x: f64, y: f64, aspect: f64) -> Ray {
        let (right, up, forward) = self.axes();
        match self.projection {
            Projection::Perspective { view_angle } => {
                let half = (view_angle.to_radians() / 2.0).tan();
                let direction = forward + right * (x * aspect * half) + up * (y * half);
                Ray {
                    origin: self.position,
                    direction: direction.unit(),
                }
            }
            Projection::Orthographic { parallel_scale } => Ray {
                origin: self.position
                    + right * (x * aspect * parallel_scale)
                    + up * (y * parallel_scale),
                direction: forward,
            },
        }
    }

    /// The same view in parallel projection: what lies at the focal point keeps its size.
    pub fn to_orthographic(self) -> Camera {
        let parallel_scale = match self.projection {
            Projection::Orthographic { parallel_scale } => parallel_scale,
            Projection::Perspective { view_angle } => {
                let half = (view_angle.to_radians() / 2.0).tan();
                self.position.distance(self.focal_point) * half
            }
        };
        Camera {
            projection: Projection::Orthographic { parallel_scale },
            ..self
        }
    }

    /// A camera at the distance from which all of `bounds` is seen from any side.
    ///
    /// The bounding sphere touches the image's nearer border, so that cameras on several
    /// sides show the volume in one size. [`Camera::frame`] fills the picture.
    pub fn fit(bounds: &Bounds, from: CameraFit, orthographic: bool, aspect: f64) -> Camera {
        let radius = match bounds.diagonal() / 2.0 {
            r if r > 0.0 => r,
            _ => 1.0, // a point or nothing: any distance will do
        };
        // A narrow image sees less sideways than upward.
        let narrow = aspect.min(1.0);
        let (toward_eye, view_up) = from.axes();
        let half = (DEFAULT_VIEW_ANGLE.to_radians() / 2.0).tan() * narrow;
        let distance = radius / half.atan().sin();
        let projection = if orthographic {
            Projection::Orthographic {
                parallel_scale: radius / narrow,
            }
        } else {
            Projection::Perspective {
                view_angle: DEFAULT_VIEW_ANGLE,
            }
        };
        Camera {
            position: bounds.center() + toward_eye * distance,
            focal_point: bounds.center(),
            view_up,
            projection,
        }
    }

    /// A camera on the side `from` whose picture `points` fill.
    ///
    /// They keep [`MARGIN`] from the image's borders and touch it on two opposite sides.
    /// The focal point lies in the middle of their depths.
    pub fn frame(
        points: impl IntoIterator<Item = DVec3>,
        from: CameraFit,
        orthographic: bool,
        aspect: f64,
    ) -> Camera {
        let mut framing = Framing::new(from, aspect);
        framing.extend(points);
        framing.camera(orthographic)
    }
}

/// [`Camera::frame`] for points that come in parts, such as the steps of a series: what it
/// keeps of them does not grow.
#[derive(Clone, Debug)]
pub struct Framing {
    from: CameraFit,
    aspect: f64,
    /// How far the points reach; `None` before the first one.
    outline: Option<Outline>,
}

impl Framing {
    /// Without points yet, seen from the side `from` in a picture of this width over its height.
    pub fn new(from: CameraFit, aspect: f64) -> Framing {
        Framing {
            from,
            aspect,
            outline: None,
        }
    }

    /// The side from which the camera looks.
    pub fn from(&self) -> CameraFit {
        self.from
    }

    /// Adds points.
    pub fn extend(&mut self, points: impl IntoIterator<Item = DVec3>) {
        let slopes = self.slopes();
        for point in points {
            let outline = self
                .outline
                .get_or_insert_with(|| Outline::at(point, self.from));
            outline.add(point, slopes);
        }
    }

    /// The camera whose picture all points so far fill.
    pub fn camera(&self, orthographic: bool) -> Camera {
        let (_, view_up) = self.from.axes();
        let slopes = self.slopes();
        let outline = self.outline.unwrap_or_else(|| {
            let mut outline = Outline::at(DVec3::ZERO, self.from);
            outline.add(DVec3::ZERO, slopes);
            outline
        });
        let [x, y, z] = [outline.x, outline.y, outline.z];
        let radius = DVec3::new(x.length(), y.length(), z.length()).length() / 2.0;
        // A point or nothing: any distance will do.
        let radius = if radius > 0.0 { radius } else { 1.0 };
        let (eye, projection) = if orthographic {
            let scale = (y.length() / 2.0).max(x.length() / 2.0 / self.aspect) / (1.0 - MARGIN);
            let parallel_scale = if scale > 0.0 { scale } else { radius };
            let depth = z.middle() - radius / half_view();
            (
                DVec3::new(x.middle(), y.middle(), depth),
                Projection::Orthographic { parallel_scale },
            )
        } else {
            let (x, depth_for_x) = outline.beside.apex(slopes.0);
            let (y, depth_for_y) = outline.above.apex(slopes.1);
            // Not into the nearest point, which a needle along the view would give.
            let before = z.low - radius * NEAREST;
            let depth = depth_for_x.min(depth_for_y).min(before);
            (
                DVec3::new(x, y, depth),
                Projection::Perspective {
                    view_angle: DEFAULT_VIEW_ANGLE,
                },
            )
        };
        let world = |p: DVec3| {
            outline.origin + outline.right * p.x + outline.up * p.y + outline.forward * p.z
        };
        Camera {
            position: world(eye),
            focal_point: world(DVec3::new(eye.x, eye.y, z.middle())),
            view_up,
            projection,
        }
    }

    /// Slopes of the planes through the eye between which the points shall lie.
    fn slopes(&self) -> (f64, f64) {
        let inside = 1.0 - MARGIN;
        (half_view() * self.aspect * inside, half_view() * inside)
    }
}

/// Half the height of what a camera of the default opening sees at distance 1.
fn half_view() -> f64 {
    (DEFAULT_VIEW_ANGLE.to_radians() / 2.0).tan()
}

/// The part of half an image that [`Camera::frame`] leaves free on each side.
pub const MARGIN: f64 = 0.03;

/// The least distance between the eye of [`Camera::frame`] and the nearest point, in radii
/// of the box around the points.
const NEAREST: f64 = 1e-3;

/// How far points reach in the axes of an image, seen in a direction.
#[derive(Clone, Copy, Debug)]
struct Outline {
    /// The first point, or 0 without any. The others are taken relative to it, so that
    /// points far from 0 keep their digits.
    origin: DVec3,
    right: DVec3,
    up: DVec3,
    forward: DVec3,
    x: Reach,
    y: Reach,
    z: Reach,
    beside: Wedge,
    above: Wedge,
}

/// The least and greatest value, in one direction.
#[derive(Clone, Copy, Debug)]
struct Reach {
    low: f64,
    high: f64,
}

impl Reach {
    const NONE: Reach = Reach {
        low: f64::INFINITY,
        high: f64::NEG_INFINITY,
    };

    fn add(&mut self, value: f64) {
        self.low = self.low.min(value);
        self.high = self.high.max(value);
    }

    fn length(self) -> f64 {
        self.high - self.low
    }

    fn middle(self) -> f64 {
        self.low * 0.5 + self.high * 0.5
    }
}

/// The two planes of a given slope that touch points from outside: w ≤ a + slope z and
/// −w ≤ b + slope z, where w is x or y.
#[derive(Clone, Copy, Debug)]
struct Wedge {
    a: f64,
    b: f64,
}

impl Wedge {
    const NONE: Wedge = Wedge {
        a: f64::NEG_INFINITY,
        b: f64::NEG_INFINITY,
    };

    fn add(&mut self, w: f64, z: f64, slope: f64) {
        self.a = self.a.max(w - slope * z);
        self.b = self.b.max(-w - slope * z);
    }

    /// Where the planes meet, (w, z): an eye there sees the points just between them.
    fn apex(self, slope: f64) -> (f64, f64) {
        (
            self.a * 0.5 - self.b * 0.5,
            -(self.a * 0.5 + self.b * 0.5) / slope,
        )
    }
}

impl Outline {
    /// The outline of no point; those that are added are taken relative to `origin`.
    fn at(origin: DVec3, from: CameraFit) -> Outline {
        let (toward_eye, view_up) = from.axes();
        let forward = -toward_eye;
        let right = forward.cross(view_up).unit();
        Outline {
            origin,
            right,
            up: right.cross(forward),
            forward,
            x: Reach::NONE,
            y: Reach::NONE,
            z: Reach::NONE,
            beside: Wedge::NONE,
            above: Wedge::NONE,
        }
    }

    fn add(&mut self, point: DVec3, slopes: (f64, f64)) {
        let p = point - self.origin;
        let (x, y, z) = (p.dot(self.right), p.dot(self.up), p.dot(self.forward));
        self.x.add(x);
        self.y.add(y);
        self.z.add(z);
        self.beside.add(x, z, slopes.0);
        self.above.add(y, z, slopes.1);
    }
}

/// From which side a fitted camera looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum CameraFit {
    /// From +x, z up.
    #[serde(rename = "+x")]
    PlusX,
    /// From −x, z up.
    #[serde(rename = "-x")]
    MinusX,
    /// From +y, z up.
    #[serde(rename = "+y")]
    PlusY,
    /// From −y, z up.
    #[serde(rename = "-y")]
    MinusY,
    /// From +z, y up.
    #[serde(rename = "+z")]
    PlusZ,
    /// From −z, y up.
    #[serde(rename = "-z")]
    MinusZ,
    /// From (1, 1, 1), z up.
    #[serde(rename = "+iso")]
    PlusIso,
    /// From (−1, −1, −1), z up.
    #[serde(rename = "-iso")]
    MinusIso,
}

impl CameraFit {
    /// Every side, with its name after `fit`.
    pub const ALL: [(&'static str, CameraFit); 8] = [
        ("+x", CameraFit::PlusX),
        ("-x", CameraFit::MinusX),
        ("+y", CameraFit::PlusY),
        ("-y", CameraFit::MinusY),
        ("+z", CameraFit::PlusZ),
        ("-z", CameraFit::MinusZ),
        ("+iso", CameraFit::PlusIso),
        ("-iso", CameraFit::MinusIso),
    ];

    /// The side called `name`, as in `fit+x` or `+x`.
    pub fn parse(name: &str) -> Result<CameraFit, Error> {
        let side = name.strip_prefix("fit").unwrap_or(name);
        let found = CameraFit::ALL.iter().find(|(n, _)| *n == side);
        found.map(|(_, fit)| *fit).ok_or_else(|| Error::Unknown {
            kind: "camera",
            name: name.into(),
            valid: CameraFit::ALL
                .iter()
                .map(|(n, _)| format!("fit{n}"))
                .collect(),
        })
    }

    /// The name after `fit`, as `+x`.
    pub fn name(self) -> &'static str {
        let found = CameraFit::ALL.into_iter().find(|(_, fit)| *fit == self);
        found.expect("all sides are listed").0
    }

    /// Unit vectors (toward the eye, up).
    pub fn axes(self) -> (DVec3, DVec3) {
        match self {
            CameraFit::PlusX => (DVec3::X, DVec3::Z),
            CameraFit::MinusX => (DVec3::NEG_X, DVec3::Z),
            CameraFit::PlusY => (DVec3::Y, DVec3::Z),
            CameraFit::MinusY => (DVec3::NEG_Y, DVec3::Z),
            CameraFit::PlusZ => (DVec3::Z, DVec3::Y),
            CameraFit::MinusZ => (DVec3::NEG_Z, DVec3::Y),
            CameraFit::PlusIso => (DVec3::ONE.unit(), DVec3::Z),
            CameraFit::MinusIso => (-DVec3::ONE.unit(), DVec3::Z),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Bounds = Bounds {
        min: DVec3::ZERO,
        max: DVec3::ONE,
    };

    // The rays of one point of the image meet in the plane of the focal point.
    #[test]
    fn in_parallel_the_focal_plane_keeps_its_size() {
        let perspective = Camera::fit(&UNIT, CameraFit::PlusIso, false, 1.5);
        let parallel = perspective.to_orthographic();
        let (_, _, forward) = perspective.axes();
        for (x, y) in [(0.0, 0.0), (0.7, -0.4), (-1.0, 1.0)] {
            let [a, b] = [perspective, parallel].map(|camera| {
                let ray = camera.ray(x, y, 1.5);
                let depth = (camera.focal_point - ray.origin).dot(forward);
                ray.at(depth / ray.direction.dot(forward))
            });
            assert!(a.distance(b) < 1e-14, "{x} {y}: {a} {b}");
        }
        assert_eq!(parallel.to_orthographic(), parallel);
    }

    #[test]
    fn a_fitted_camera_sees_every_corner() {
        for (name, fit) in CameraFit::ALL {
            for (orthographic, aspect) in [(false, 1.0), (true, 1.0), (false, 0.5), (true, 2.0)] {
                let camera = Camera::fit(&UNIT, fit, orthographic, aspect);
                camera.validate().expect(name);
                let (right, up, forward) = camera.axes();
                for corner in 0..8 {
                    let corner = DVec3::new(
                        f64::from(corner & 1),
                        f64::from(corner >> 1 & 1),
                        f64::from(corner >> 2 & 1),
                    );
                    let p = corner - camera.position;
                    let half = match camera.projection {
                        Projection::Perspective { view_angle } => {
                            p.dot(forward) * (view_angle.to_radians() / 2.0).tan()
                        }
                        Projection::Orthographic { parallel_scale } => parallel_scale,
                    };
                    assert!(p.dot(forward) > 0.0, "{name}");
                    assert!(p.dot(up).abs() <= half, "{name} aspect {aspect}");
                    assert!(
                        p.dot(right).abs() <= half * aspect,
                        "{name} aspect {aspect}"
                    );
                }
            }
        }
    }

    /// Where `point` is in the image, each of x and y in [−1, 1] inside.
    fn project(camera: &Camera, point: DVec3, aspect: f64) -> (f64, f64) {
        let (right, up, forward) = camera.axes();
        let p = point - camera.position;
        assert!(p.dot(forward) > 0.0, "before the eye");
        let half = match camera.projection {
            Projection::Perspective { view_angle } => {
                p.dot(forward) * (view_angle.to_radians() / 2.0).tan()
            }
            Projection::Orthographic { parallel_scale } => parallel_scale,
        };
        (p.dot(right) / half / aspect, p.dot(up) / half)
    }

    // Boxes of all shapes, far from the origin and near: all corners keep the margin, and
    // the nearest ones on two opposite sides touch it.
    #[test]
    fn a_frame_is_filled_up_to_its_margin() {
        let boxes = [
            UNIT,
            Bounds {
                min: DVec3::new(-1e-9, 0.0, 2e-9),
                max: DVec3::new(3e-9, 5e-9, 2.001e-9),
            },
            Bounds {
                min: DVec3::new(4e6, -3e6, 100.0),
                max: DVec3::new(4e6 + 30.0, -3e6 + 1.0, 101.0),
            },
        ];
        for bounds in boxes {
            for (name, fit) in CameraFit::ALL {
                for orthographic in [false, true] {
                    for aspect in [1.0, 0.25, 3.0] {
                        let camera = Camera::frame(bounds.corners(), fit, orthographic, aspect);
                        camera.validate().expect(name);
                        let images = bounds.corners().map(|c| project(&camera, c, aspect));
                        let touch = |of: fn(&(f64, f64)) -> f64| {
                            let [low, high] = [f64::min, f64::max]
                                .map(|fold| images.iter().map(of).reduce(fold).expect("eight"));
                            // Coordinates of 4e6 leave f64 9 digits of the box's size.
                            assert!(high < 1.0 - MARGIN + 1e-6, "{name} {aspect}: {high}");
                            assert!(low > MARGIN - 1.0 - 1e-6, "{name} {aspect}: {low}");
                            (high - (1.0 - MARGIN)).abs() < 1e-6
                                && (low - (MARGIN - 1.0)).abs() < 1e-6
                        };
                        let touches = [touch(|p| p.0), touch(|p| p.1)];
                        assert!(touches.contains(&true), "{name} {orthographic} {aspect}");
                    }
                }
            }
        }
    }

    #[test]
    fn points_in_parts_are_framed_as_all_at_once() {
        let corners = UNIT
            .corners()
            .map(|p| p * DVec3::new(3.0, 1.0, 0.1) + DVec3::X);
        for (_, fit) in CameraFit::ALL {
            let mut framing = Framing::new(fit, 1.5);
            corners
                .chunks(3)
                .for_each(|some| framing.extend(some.iter().copied()));
            for orthographic in [false, true] {
                let camera = Camera::frame(corners, fit, orthographic, 1.5);
                assert_eq!(framing.camera(orthographic), camera);
            }
        }
    }

    // A needle along the view has no width: the eye still stays before its tip.
    #[test]
    fn a_frame_of_points_without_extent_is_a_camera() {
        let needle = [DVec3::ZERO, DVec3::X * 5.0];
        for points in [&needle[..], &needle[..1], &[]] {
            for orthographic in [false, true] {
                let points = points.iter().copied();
                let camera = Camera::frame(points.clone(), CameraFit::PlusX, orthographic, 1.0);
                camera.validate().expect("a camera");
                for point in points {
                    project(&camera, point, 1.0);
                }
            }
        }
    }

    #[test]
    fn up_is_up_and_right_is_right() {
        // From +z with y up, +x is right.
        let camera = Camera::fit(&UNIT, CameraFit::PlusZ, true, 1.0);
        let (right, up, forward) = camera.axes();
        assert_eq!((right, up, forward), (DVec3::X, DVec3::Y, DVec3::NEG_Z));
        assert!(camera.ray(0.5, 0.5, 1.0).origin.x > 0.5);
    }

    #[test]
    fn cameras_that_look_nowhere_are_refused() {
        let good = Camera::fit(&UNIT, CameraFit::PlusX, false, 1.0);
        let at_focus = Camera {
            position: good.focal_point,
            ..good
        };
        let along = Camera {
            view_up: good.focal_point - good.position,
            ..good
        };
        let nan = Camera {
            position: DVec3::NAN,
            ..good
        };
        let flat = Camera {
            projection: Projection::Perspective { view_angle: 180.0 },
            ..good
        };
        for camera in [at_focus, along, nan, flat] {
            let error = camera.validate().expect_err("the camera looks nowhere");
            assert!(error.help().is_some());
        }
    }
}
