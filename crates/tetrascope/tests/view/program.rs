//! Runs the viewer, and asks it over plain sockets.

use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use tungstenite::client::IntoClientRequest as _;
use tungstenite::stream::MaybeTlsStream;
use tungstenite::{Message, WebSocket};

pub(crate) const PROGRAM: &str = env!("CARGO_BIN_EXE_tetrascope");

/// A viewer that runs; it is killed with this.
pub(crate) struct Viewer {
    pub(crate) child: Child,
    pub(crate) url: String,
    pub(crate) port: u16,
    pub(crate) token: String,
}

/// Who waits longer than this waits for nothing.
pub(crate) const PATIENCE: Duration = Duration::from_secs(120);

impl Viewer {
    /// Starts it; `line` is split at spaces.
    pub(crate) fn start(line: &str) -> Viewer {
        Viewer::start_with(line, None)
    }

    /// The same with a token.
    pub(crate) fn start_with(line: &str, token: Option<&str>) -> Viewer {
        let mut command = Command::new(PROGRAM);
        command
            .arg("view")
            .args(line.split_whitespace())
            .arg("--no-open")
            .env_remove("TETRASCOPE_TOKEN")
            .env("NO_COLOR", "1")
            .stdout(Stdio::piped())
            .stderr(Stdio::null());
        if let Some(token) = token {
            command.env("TETRASCOPE_TOKEN", token);
        }
        let mut child = command.spawn().expect("the program starts");
        let stdout = child.stdout.take().expect("a pipe");
        let mut url = String::new();
        BufReader::new(stdout).read_line(&mut url).expect("a line");
        let url = url.trim().to_owned();
        let rest = url.strip_prefix("http://127.0.0.1:").expect("an address");
        let (port, token) = rest.trim_end_matches('/').split_once('/').expect("a token");
        Viewer {
            port: port.parse().expect("a port"),
            token: token.into(),
            child,
            url,
        }
    }

    /// Asks for a path; the status, the headers and the body.
    pub(crate) fn get(&self, path: &str, headers: &str) -> (u16, String, Vec<u8>) {
        let host = format!("Host: localhost:{}\r\n", self.port);
        let host = if headers.contains("Host:") { "" } else { &host };
        self.ask(&format!(
            "GET {path} HTTP/1.1\r\n{host}{headers}Connection: close\r\n\r\n"
        ))
    }

    /// Sends a request as it is.
    pub(crate) fn ask(&self, request: &str) -> (u16, String, Vec<u8>) {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).expect("it listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        stream.write_all(request.as_bytes()).expect("it reads");
        let mut bytes = Vec::new();
        // A connection that is cut has said what it says.
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n");
        let end = end.unwrap_or(bytes.len());
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let status = head.split(' ').nth(1).and_then(|s| s.parse().ok());
        let body = bytes.get(end + 4..).unwrap_or_default().to_vec();
        (status.unwrap_or(0), head, body)
    }

    /// A file of the page's folder.
    pub(crate) fn file(&self, name: &str) -> Vec<u8> {
        let (status, head, body) = self.get(&format!("/{}/{name}", self.token), "");
        assert_eq!(status, 200, "{head}");
        let is_chunked = head.to_ascii_lowercase().contains("transfer-encoding");
        assert!(!is_chunked, "{head}");
        body
    }

    /// Opens the page's socket.
    pub(crate) fn socket(&self) -> Socket {
        let url = format!("ws://localhost:{}/{}/ws", self.port, self.token);
        let mut request = url.into_client_request().expect("a request");
        let origin = format!("http://localhost:{}", self.port);
        let origin = origin.parse().expect("a header");
        request.headers_mut().insert("origin", origin);
        let (socket, _) = tungstenite::connect(request).expect("it is opened");
        if let MaybeTlsStream::Plain(stream) = socket.get_ref() {
            stream.set_read_timeout(Some(PATIENCE)).expect("a timeout");
        }
        Socket(socket)
    }
}

impl Drop for Viewer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A page without a browser.
pub(crate) struct Socket(pub(crate) WebSocket<MaybeTlsStream<TcpStream>>);

impl Socket {
    pub(crate) fn say(&mut self, text: &str) {
        self.0.send(Message::text(text)).expect("it is sent");
    }

    /// The next text of this type.
    pub(crate) fn told(&mut self, kind: &str) -> serde_json::Value {
        loop {
            if let Message::Text(text) = self.0.read().expect("a message") {
                let value: serde_json::Value = serde_json::from_str(&text).expect("JSON");
                if value["type"] == kind {
                    return value;
                }
            }
        }
    }

    /// The code with which the server ends.
    pub(crate) fn ended(&mut self) -> Option<u16> {
        loop {
            match self.0.read() {
                Ok(Message::Close(frame)) => return frame.map(|f| f.code.into()),
                Ok(_) => {}
                Err(_) => return None,
            }
        }
    }
}

/// Straight RGBA of 8 bits, with the size.
pub(crate) fn decode(png: &[u8]) -> ([u32; 2], Vec<u8>) {
    let reader = png::Decoder::new(std::io::Cursor::new(png)).read_info();
    let mut reader = reader.expect("a PNG file");
    let mut bytes = vec![0; reader.output_buffer_size().expect("it fits")];
    let info = reader.next_frame(&mut bytes).expect("a picture");
    ([info.width, info.height], bytes)
}

/// The picture that `tetrascope render` draws of a scene.
pub(crate) fn rendered(folder: &Path, scene: &[u8], options: &str) -> ([u32; 2], Vec<u8>) {
    std::fs::write(folder.join("scene.toml"), scene).expect("it is written");
    let run = Command::new(PROGRAM)
        .current_dir(folder)
        .args(["render", "--scene", "scene.toml", "-o", "picture.png"])
        .args(options.split_whitespace())
        .output()
        .expect("the program starts");
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    decode(&std::fs::read(folder.join("picture.png")).expect("a picture"))
}
