//! The native part of the Python package `tetrascope`.
//!
//! Python converts what people give (lists, other number types, objects of PyVista, VTK and
//! meshio) into few kinds of contiguous arrays, and names into a scene; see
//! `python/tetrascope`. Here these become a volume, a scene and a renderer of the facade, which
//! does all the rest.
//!
//! Reading order: `arrays` reads NumPy's arrays; `volume` and `scene` hold what is drawn and how;
//! `renderer`, `choice` and `samples` are the work; `work` lets other threads of Python run
//! meanwhile, and people interrupt it; `errors` makes exceptions; `image` and `catalog` are
//! pictures in bytes and lists of what there is.

mod arrays;
mod catalog;
mod choice;
mod errors;
mod image;
mod renderer;
mod samples;
mod scene;
mod volume;
mod work;

use std::sync::OnceLock;

use tetrascope::Context;

/// The context that all renderers of a process share: one graphics device.
fn context() -> &'static Context {
    static CONTEXT: OnceLock<Context> = OnceLock::new();
    CONTEXT.get_or_init(Context::new)
}

#[pyo3::pymodule]
mod _tetrascope {
    #[pymodule_export]
    use crate::catalog::{adapter, algorithms, info, names, nearest, steps};
    #[pymodule_export]
    use crate::choice::choose;
    #[pymodule_export]
    use crate::image::{encode_png, to_srgb8, write_image};
    #[pymodule_export]
    use crate::renderer::Renderer;
    #[pymodule_export]
    use crate::samples::resample;
    #[pymodule_export]
    use crate::scene::{Scene, resolve};
    #[pymodule_export]
    use crate::volume::{Volume, grid, load, mesh};

    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
