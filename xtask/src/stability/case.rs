//! A case of the suite: scenes, and what is known of their pictures.

use std::fmt;

use tetrascope::core::{Appearance, Ray, View, Volume};

/// The reason for which a case is hard.
#[derive(Clone, Copy, Debug, Eq, Ord, PartialEq, PartialOrd)]
pub enum Group {
    /// Extinctions and transfer functions over many decades.
    Stiff,
    /// Cells and meshes without the shape that algorithms like.
    Geometry,
    /// Cameras and pictures.
    Views,
    /// Scalars that floats hold badly or not at all.
    Values,
    /// Regular grids that are any of this.
    Grids,
    /// Laws of physics about two pictures or more.
    Laws,
}

impl Group {
    /// In the order in which they are drawn.
    pub const ALL: [Group; 6] = [
        Group::Stiff,
        Group::Geometry,
        Group::Views,
        Group::Values,
        Group::Grids,
        Group::Laws,
    ];

    /// In a word.
    pub fn name(self) -> &'static str {
        match self {
            Group::Stiff => "stiff",
            Group::Geometry => "geometry",
            Group::Views => "views",
            Group::Values => "values",
            Group::Grids => "grids",
            Group::Laws => "laws",
        }
    }
}

/// One picture that is drawn.
#[derive(Clone)]
pub struct Shot {
    /// The volume that is drawn.
    pub volume: Volume,
    /// How it looks.
    pub appearance: Appearance,
    /// From where.
    pub view: View,
    /// Its columns are compared in reverse order.
    pub mirrored: bool,
}

impl Shot {
    /// A picture whose columns are as they are.
    pub fn new(volume: Volume, appearance: Appearance, view: View) -> Shot {
        Shot {
            volume,
            appearance,
            view,
            mirrored: false,
        }
    }

    /// A picture's pixels in the order in which a case compares them.
    pub(super) fn in_order<T: Copy>(&self, pixels: &[T]) -> Vec<T> {
        let row = self.view.width as usize;
        match self.mirrored {
            true => pixels
                .chunks(row)
                .flat_map(|row| row.iter().rev().copied())
                .collect(),
            false => pixels.to_vec(),
        }
    }
}

/// A ray's premultiplied linear RGBA.
pub type Light = Box<dyn Fn(&Ray) -> [f64; 4] + Send + Sync>;

/// Knowledge about the pictures of a case beside the ground truth of each.
pub enum Expected {
    /// Nothing.
    Truth,
    /// Each ray's light.
    Light(Light),
    /// All are the first.
    Same,
    /// A law about a pixel in all pictures: a value that is 0 where physics holds, and how many times their errors
    /// it may be.
    Law(fn(&[[f64; 4]]) -> [f64; 4], f64),
}

/// Scenes that are hard to draw, and what is known of their pictures.
pub struct Case {
    /// The reason for which it is hard.
    pub group: Group,
    /// A few words.
    pub name: String,
    /// The pictures that are drawn; not empty.
    pub shots: Vec<Shot>,
    /// Knowledge about them.
    pub expected: Expected,
    /// The part of it that f32 cannot hold: how far a channel may differ for that, in parts of the greatest
    /// channel, and why.
    pub allowed: Option<(f64, &'static str)>,
    /// Whether an algorithm's pictures are alike, however far they are from the truth.
    pub is_invariant: bool,
    /// Whether its pictures take minutes.
    pub is_long: bool,
    /// Whether any way of sampling gives this picture, so that those that promise nothing are held to it.
    pub holds_for_all: bool,
    /// Whether what is known holds in its own optical model alone.
    pub is_of_one_model: bool,
}

impl Case {
    /// One scene, of which the ground truth alone says what it looks like.
    pub fn new(group: Group, name: impl Into<String>, shot: Shot) -> Case {
        Case {
            group,
            name: name.into(),
            shots: vec![shot],
            expected: Expected::Truth,
            allowed: None,
            is_invariant: false,
            is_long: false,
            holds_for_all: false,
            is_of_one_model: false,
        }
    }

    /// One scene whose rays' light is known.
    pub(super) fn known(
        group: Group,
        name: impl Into<String>,
        shot: Shot,
        light: impl Fn(&Ray) -> [f64; 4] + Send + Sync + 'static,
    ) -> Case {
        Case {
            expected: Expected::Light(Box::new(light)),
            ..Case::new(group, name, shot)
        }
    }

    /// Scenes that look alike.
    pub(super) fn same(group: Group, name: impl Into<String>, shots: Vec<Shot>) -> Case {
        Case {
            group,
            name: name.into(),
            shots,
            expected: Expected::Same,
            allowed: None,
            is_invariant: false,
            is_long: false,
            holds_for_all: false,
            is_of_one_model: false,
        }
    }

    /// Scenes whose pixels are bound by a law.
    pub(super) fn law(
        name: impl Into<String>,
        shots: Vec<Shot>,
        residual: fn(&[[f64; 4]]) -> [f64; 4],
        gain: f64,
    ) -> Case {
        Case {
            expected: Expected::Law(residual, gain),
            ..Case::same(Group::Laws, name, shots)
        }
    }

    /// Demands of each algorithm that its own pictures are alike: what differs is no reason to sample
    /// elsewhere.
    #[must_use]
    pub(super) fn for_each(self) -> Case {
        Case {
            is_invariant: true,
            is_long: false,
            ..self
        }
    }

    /// Demands the picture of those, too, that promise nothing.
    #[must_use]
    pub(super) fn for_all(self) -> Case {
        Case {
            holds_for_all: true,
            ..self
        }
    }

    /// Is not drawn in other optical models.
    #[must_use]
    pub(super) fn in_its_model(self) -> Case {
        Case {
            is_of_one_model: true,
            ..self
        }
    }

    /// Allows what f32 cannot hold.
    #[must_use]
    pub(super) fn allowing(mut self, difference: f64, reason: &'static str) -> Case {
        self.allowed = Some((difference, reason));
        self
    }
}

impl fmt::Debug for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.group.name(), self.name)
    }
}
