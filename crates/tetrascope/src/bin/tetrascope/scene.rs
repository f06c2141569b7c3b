//! `print-scene`, and where the scene of other commands comes from.

pub(crate) use tetrascope::cli::request::{Request, mesh_source, name, source, usage};

use crate::args::SceneArgs;
use crate::output::{Output, Stop};
use crate::series::{self, Steps};

/// Prints the complete scene.
pub(crate) fn run(args: &SceneArgs, output: &Output) -> Result<(), Stop> {
    let scene = match Steps::find(&args.volume)? {
        Some(steps) => {
            let request = Request::new(args, Some(&steps.first().file))?;
            series::Common::find(&request, &steps, output)?.scene
        }
        None => {
            let request = Request::new(args, args.volume.first())?;
            let (loaded, _) = request.load(output)?;
            request.resolve(&loaded.volume, output)?
        }
    };
    if output.json() {
        let value = serde_json::to_value(scene.to_file()).expect("a scene is JSON");
        return output.json_result(&value);
    }
    output.result(scene.to_toml().trim_end())
}
