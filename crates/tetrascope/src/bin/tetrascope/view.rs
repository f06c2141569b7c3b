//! `view`: a volume in the browser.

use std::io::IsTerminal as _;
use std::net::IpAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::json;
use tetrascope::Settings;
use tetrascope::choose::user_cache;
use tetrascope::cli::use_threads;
use tetrascope::core::Error;
use tetrascope::io::read_steps;
use tetrascope::view::{Access, Hub, Server, Session, Start, Token, serve};

use crate::args::ViewArgs;
use crate::output::{Output, Stop};
use crate::scene::Request;
use crate::series::Steps;

/// A token that stays the same, so that an address does, too.
const TOKEN: &str = "TETRASCOPE_TOKEN";

pub(crate) fn run(args: &ViewArgs, output: &Output) -> Result<(), Stop> {
    // Refuse what can be refused at once before the volume is read.
    let algorithm = tetrascope::algorithm(&args.algorithm)?;
    let settings = Settings::parse(algorithm, args.settings.iter().map(String::as_str))?;
    let token = match std::env::var(TOKEN) {
        Ok(text) => Token::given(&text)?,
        Err(_) => Token::random()?,
    };
    if let Some(threads) = args.threads {
        use_threads(threads.into())?;
    }
    let server = Server::bind(args.host, args.port)?;

    let (mut request, steps) = what(args)?;
    let source = &mut request.file.volume;
    for file in [&mut source.file, &mut source.solution]
        .into_iter()
        .flatten()
    {
        // A scene that is saved finds it from any folder.
        *file = std::path::absolute(&*file).unwrap_or_else(|_| file.clone());
    }
    let steps = steps.map_or(Vec::new(), |steps| steps.list);
    if let Some(time) = source.time
        && steps.len() > 1
    {
        let far = |step: &tetrascope::io::Step| (step.time.unwrap_or(f64::INFINITY) - time).abs();
        let nearest = (0..steps.len()).min_by(|a, b| far(&steps[*a]).total_cmp(&far(&steps[*b])));
        (source.step, source.time) = (nearest, None);
    }
    let (loaded, _) = request.load(output)?;

    let access = Access {
        token,
        names: match args.host.is_loopback() {
            true => Vec::new(),
            false => host_name().into_iter().collect(),
        },
        is_wide: !args.host.is_loopback(),
    };
    let hub = Arc::new(Hub::default());
    let start = Start {
        scene: request.file.clone(),
        loaded,
        steps,
        algorithm,
        settings,
        measurements: user_cache(),
    };
    let session = request.in_words(Session::start(start, hub.teller()))?;
    say(args, &server, &access, output)?;
    let url = server.url(&access);
    if !args.no_open && has_screen() {
        open(&url);
    }
    serve(server, access, Arc::new(session), hub)?;
    Ok(())
}

/// The scene that is asked for, and its time steps.
fn what(args: &ViewArgs) -> Result<(Request, Option<Steps>), Error> {
    let volumes = &args.scene.volume;
    if let Some(steps) = Steps::find(volumes)? {
        let request = Request::new(&args.scene, Some(&steps.first().file))?;
        return Ok((request, Some(steps)));
    }
    let is_scene = |path: &Path| {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        extension.is_some_and(|e| e == "toml" || e == "json")
    };
    let request = match (volumes.first(), &args.scene.scene) {
        (Some(path), None) if is_scene(path) => Request::of(&args.scene, None, Some(path))?,
        (volume, _) => Request::new(&args.scene, volume)?,
    };
    let file = request.file.volume.file.clone();
    // Reading the file says what is wrong with it.
    let times = |file: &PathBuf| read_steps(file).unwrap_or_default();
    let steps = file.and_then(|file| {
        let times = times(&file);
        (times.len() > 1).then(|| Steps::within(&file, times))
    });
    Ok((request, steps))
}

/// Prints the address, and how to reach it from elsewhere.
fn say(args: &ViewArgs, server: &Server, access: &Access, output: &Output) -> Result<(), Stop> {
    let url = server.url(access);
    let port = server.address().port();
    let name = host_name().unwrap_or_else(|| "HOST".into());
    let tunnel = format!("ssh -N -L {port}:localhost:{port} {name}");
    if output.json() {
        output.json_result(&json!({"url": url, "port": port, "tunnel": tunnel}))?;
    } else {
        output.result(&url)?;
    }
    output.note("open this address in a browser; Ctrl-C ends the viewer");
    match access.is_wide {
        false => output.note(format_args!(
            "from another machine, first type there: {tunnel}"
        )),
        true => output.warning(&Error::Invalid {
            what: format!(
                "other machines can reach {}, and what is sent is not encrypted",
                args.host
            ),
            help: Some(format!(
                "leave out --host and use a tunnel; from there the address is \
                 http://{name}:{port}/{}/",
                access.token.text()
            )),
        }),
    }
    Ok(())
}

/// The name by which other machines know this one.
fn host_name() -> Option<String> {
    let name = std::fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let name = name.or_else(|| std::env::var("HOSTNAME").ok())?;
    let name = name.trim().to_ascii_lowercase();
    let fits = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '.';
    (!name.is_empty() && name.chars().all(fits)).then_some(name)
}

/// Whether a person sits before a screen of this machine.
fn has_screen() -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    let screen = is_set("DISPLAY") || is_set("WAYLAND_DISPLAY") || cfg!(target_os = "macos");
    screen && !is_set("SSH_CONNECTION") && std::io::stdout().is_terminal()
}

/// Opens a page in the browser, if there is one.
///
/// Other people on this machine can see the arguments of programs. So the browser gets a file that
/// only this person can read, and that leads to the address.
#[cfg(unix)]
fn open(url: &str) {
    use std::io::Write as _;
    use std::os::unix::fs::OpenOptionsExt as _;
    use std::process::{Command, Stdio};
    let folder = std::env::var_os("XDG_RUNTIME_DIR").map(PathBuf::from);
    let folder = folder
        .filter(|f| f.is_dir())
        .unwrap_or_else(std::env::temp_dir);
    let path = folder.join(format!("tetrascope-view-{}.html", std::process::id()));
    let page = format!(
        "<!doctype html><meta charset=\"utf-8\"><title>Tetrascope</title>\
         <meta http-equiv=\"refresh\" content=\"0;url={url}\"><a href=\"{url}\">Tetrascope</a>"
    );
    let mut options = std::fs::OpenOptions::new();
    let file = options.write(true).create_new(true).mode(0o600).open(&path);
    // The address is printed; a browser that does not open is no error.
    if file
        .and_then(|mut file| file.write_all(page.as_bytes()))
        .is_err()
    {
        return;
    }
    let program = if cfg!(target_os = "macos") {
        "open"
    } else {
        "xdg-open"
    };
    let started = Command::new(program)
        .arg(&path)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn();
    std::thread::spawn(move || {
        if let Ok(mut browser) = started {
            let _ = browser.wait();
            std::thread::sleep(std::time::Duration::from_secs(20));
        }
        let _ = std::fs::remove_file(&path);
    });
}

#[cfg(not(unix))]
fn open(_: &str) {}

/// An address to listen at.
pub(crate) fn address(text: &str) -> Result<IpAddr, String> {
    let text = if text == "localhost" {
        "127.0.0.1"
    } else {
        text
    };
    text.parse().map_err(|_| {
        "give an address of this machine, such as 127.0.0.1, or 0.0.0.0 for all".into()
    })
}
