//! Cameras with VTK's parameters.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::{Bounds, Error};

/// A camera in world space, right-handed, with VTK's names.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Where the eye is; for an orthographic camera, a point of the image plane.
    /// Nothing behind it is drawn.
    pub position: DVec3,
    /// What it looks at.
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
                "move `position` away from `focal_point`, or use --camera fit+iso",
            );
        }
        // Below this sine, rounding of the inputs decides where up is.
        let sine = forward
            .normalize()
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
        let forward = (self.focal_point - self.position).normalize();
        let right = forward.cross(self.view_up.normalize()).normalize();
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
                    direction: direction.normalize(),
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

    /// A camera outside `bounds` that shows all of it, whatever the aspect.
    ///
    /// The bounding sphere touches the image's nearer border.
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

    /// Unit vectors (toward the eye, up).
    fn axes(self) -> (DVec3, DVec3) {
        match self {
            CameraFit::PlusX => (DVec3::X, DVec3::Z),
            CameraFit::MinusX => (DVec3::NEG_X, DVec3::Z),
            CameraFit::PlusY => (DVec3::Y, DVec3::Z),
            CameraFit::MinusY => (DVec3::NEG_Y, DVec3::Z),
            CameraFit::PlusZ => (DVec3::Z, DVec3::Y),
            CameraFit::MinusZ => (DVec3::NEG_Z, DVec3::Y),
            CameraFit::PlusIso => (DVec3::ONE.normalize(), DVec3::Z),
            CameraFit::MinusIso => (-DVec3::ONE.normalize(), DVec3::Z),
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
