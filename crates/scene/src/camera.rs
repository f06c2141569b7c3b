//! The camera of a scene, as written.

use serde::{Deserialize, Serialize};
use tetrascope_core::camera::DEFAULT_VIEW_ANGLE;
use tetrascope_core::glam::DVec3;
use tetrascope_core::{Camera, CameraFit, Error, Projection};

use crate::defaults::side_of;
use crate::subject::Subject;

/// A camera as written: `fit`, or position and the rest.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraSpec {
    /// Fit the volume from this side; excludes the four below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<CameraFit>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub position: Option<DVec3>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub focal_point: Option<DVec3>,
    /// World space.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_up: Option<DVec3>,
    /// Perspective, unless there is a `parallel_scale`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub projection: Option<ProjectionKind>,
    /// Vertical, degrees.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub view_angle: Option<f64>,
    /// Half the image's height, world units; makes the camera orthographic.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parallel_scale: Option<f64>,
}

/// How rays spread, by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ProjectionKind {
    /// From a point.
    Perspective,
    /// In parallel.
    Orthographic,
}

impl CameraSpec {
    /// The camera for `volume` in a picture of this width over its height; adds what was
    /// chosen to `defaults`.
    pub(crate) fn resolve(
        &self,
        volume: &dyn Subject,
        aspect: f64,
        defaults: &mut Vec<String>,
    ) -> Result<Camera, Error> {
        let refuse = |what: &str, help: &str| {
            Err(Error::Scene {
                at: "[camera]".into(),
                what: what.into(),
                help: Some(help.into()),
            })
        };
        let orthographic = match self.projection {
            Some(kind) => kind == ProjectionKind::Orthographic,
            None => self.parallel_scale.is_some(),
        };
        if orthographic && self.view_angle.is_some() {
            return refuse(
                "an orthographic camera has no view_angle",
                "use parallel_scale",
            );
        }
        if !orthographic && self.parallel_scale.is_some() {
            return refuse(
                "a perspective camera has no parallel_scale",
                "use view_angle",
            );
        }
        let Some(position) = self.position else {
            if self.focal_point.is_some()
                || self.view_up.is_some()
                || self.view_angle.is_some()
                || self.parallel_scale.is_some()
            {
                return refuse(
                    "the camera has no position",
                    "add position, or use fit alone",
                );
            }
            let (fit, orthographic) = match self.fit {
                Some(fit) => (fit, orthographic),
                None => {
                    let (fit, why) = side_of(volume);
                    let why = why.map_or(String::new(), |why| format!(", {why}"));
                    defaults.push(format!("camera: fit{}{why}", fit.name()));
                    // Near a needle's tip, perspective shows little but the tip.
                    let parallel = !why.is_empty() && self.projection.is_none();
                    (fit, orthographic || parallel)
                }
            };
            return Ok(volume.framed(fit, orthographic, aspect));
        };
        if self.fit.is_some() {
            return refuse("fit excludes position", "keep one of the two ways");
        }
        let focal_point = self.focal_point.unwrap_or_else(|| volume.bounds().center());
        let projection = match (orthographic, self.parallel_scale) {
            (false, _) => Projection::Perspective {
                view_angle: self.view_angle.unwrap_or(DEFAULT_VIEW_ANGLE),
            },
            (true, Some(parallel_scale)) => Projection::Orthographic { parallel_scale },
            (true, None) => {
                return refuse(
                    "an orthographic camera needs parallel_scale",
                    "give half the image's height, world units",
                );
            }
        };
        Ok(Camera {
            position,
            focal_point,
            view_up: self.view_up.unwrap_or(DVec3::Y),
            projection,
        })
    }

    /// Whether nothing is left out that is chosen from the volume.
    pub(crate) fn is_complete(&self) -> bool {
        self.position.is_some() && self.focal_point.is_some()
    }

    /// Whether the camera may be fitted from this side.
    pub(crate) fn may_look_from(&self, side: CameraFit) -> bool {
        self.position.is_none() && self.fit.is_none_or(|fit| fit == side)
    }

    /// The camera with nothing left out.
    pub fn of(camera: &Camera) -> CameraSpec {
        let (projection, view_angle, parallel_scale) = match camera.projection {
            Projection::Perspective { view_angle } => {
                (ProjectionKind::Perspective, Some(view_angle), None)
            }
            Projection::Orthographic { parallel_scale } => {
                (ProjectionKind::Orthographic, None, Some(parallel_scale))
            }
        };
        CameraSpec {
            fit: None,
            position: Some(camera.position),
            focal_point: Some(camera.focal_point),
            view_up: Some(camera.view_up),
            projection: Some(projection),
            view_angle,
            parallel_scale,
        }
    }
}
