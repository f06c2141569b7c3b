//! Renderers that are kept between frames.

use std::sync::{Arc, Mutex, PoisonError};

use tetrascope_core::{Appearance, Error, Frame, Settings, Stop, View, VolumeRenderer as _};

use super::state::{Field, State};
use crate::{Algorithm, Context, Renderer};

/// An algorithm with its settings.
#[derive(Clone, Debug)]
pub(crate) struct Setup {
    pub(crate) algorithm: &'static Algorithm,
    pub(crate) settings: Settings,
}

impl Setup {
    /// The setup that draws complete pictures of a state.
    pub(crate) fn of(state: &State) -> Setup {
        Setup {
            algorithm: state.algorithm,
            settings: state.settings.clone(),
        }
    }

    /// Whether it draws a state.
    pub(crate) fn draws(&self, state: &State) -> bool {
        let scene = &state.scene;
        let supports = self.algorithm.supports;
        let volume = state.field.volume();
        supports(volume, &scene.appearance, &scene.view, &self.settings).is_ok()
    }
}

impl PartialEq for Setup {
    fn eq(&self, other: &Setup) -> bool {
        self.algorithm.name == other.algorithm.name && self.settings == other.settings
    }
}

/// A renderer, once there is one.
pub(crate) struct Slot {
    setup: Setup,
    context: Context,
    prepared: Option<Prepared>,
}

struct Prepared {
    renderer: Renderer,
    field: Arc<Field>,
    appearance: Appearance,
    /// Whether scalars may still be rounded relative to a range of before.
    is_restyled: bool,
}

impl Slot {
    /// Draws a view of the state's volume in its look; `exactly` as a new renderer draws it, to the last
    /// bit.
    pub(crate) fn draw(
        &mut self,
        state: &State,
        view: &View,
        exactly: bool,
    ) -> Result<Frame, Error> {
        let (field, appearance) = (&state.field, &state.scene.appearance);
        if let Some(prepared) = &mut self.prepared {
            let kept = prepared.follow(field, appearance, exactly);
            // What cannot follow is made anew: a volume of another kind, a lost device.
            if kept.is_err() {
                self.prepared = None;
            }
        }
        let prepared = match &mut self.prepared {
            Some(prepared) => prepared,
            empty => {
                let Setup {
                    algorithm,
                    settings,
                } = &self.setup;
                let build = algorithm.build;
                let renderer = build(&self.context, field.volume(), appearance, settings)?;
                empty.insert(Prepared {
                    renderer,
                    field: field.clone(),
                    appearance: appearance.clone(),
                    is_restyled: false,
                })
            }
        };
        prepared.renderer.render(view)
    }

    /// The request that ends a frame early.
    pub(crate) fn stop(&self) -> &Stop {
        self.context.stop()
    }
}

impl Prepared {
    fn follow(
        &mut self,
        field: &Arc<Field>,
        appearance: &Appearance,
        exactly: bool,
    ) -> Result<(), Error> {
        if *appearance != self.appearance {
            self.renderer.restyle(appearance)?;
            self.appearance = appearance.clone();
            self.is_restyled = true;
        }
        // A restyle keeps scalars as they were rounded, where digits are left; a reload sends them
        // anew, and nothing else of the same volume.
        if field.id != self.field.id || (exactly && self.is_restyled) {
            self.renderer.reload(field.volume())?;
            self.field = field.clone();
            self.is_restyled = false;
        }
        Ok(())
    }
}

/// All that are kept: one for each setup in use.
pub(crate) struct Renderers {
    context: Context,
    slots: Mutex<Vec<(Setup, Arc<Mutex<Slot>>)>>,
}

impl Renderers {
    pub(crate) fn new(context: Context) -> Renderers {
        Renderers {
            context,
            slots: Mutex::default(),
        }
    }

    /// The slot of a setup; others stay only if they are in `used`, as each holds a volume.
    pub(crate) fn slot(&self, setup: &Setup, used: &[Setup]) -> Arc<Mutex<Slot>> {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        slots.retain(|(other, _)| other == setup || used.contains(other));
        if let Some((_, slot)) = slots.iter().find(|(other, _)| other == setup) {
            return slot.clone();
        }
        let slot = Arc::new(Mutex::new(Slot {
            setup: setup.clone(),
            // Each stops by itself, and all share the device.
            context: self.context.clone().with_stop(Stop::new()),
            prepared: None,
        }));
        slots.push((setup.clone(), slot.clone()));
        slot
    }

    /// The adapter in words, if a device was made.
    pub(crate) fn adapter(&self) -> Option<String> {
        self.context.adapter()
    }

    pub(crate) fn context(&self) -> &Context {
        &self.context
    }
}
