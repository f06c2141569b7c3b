//! Who may ask, and for what.

use crate::program::Viewer;
use tungstenite::Message;

const SPHERE: &str = "sphere --cells 600";

#[test]
fn only_who_knows_the_token_is_answered() {
    let viewer = Viewer::start(SPHERE);
    let token = viewer.token.clone();
    let (status, head, body) = viewer.get(&format!("/{token}/"), "");
    assert_eq!(status, 200, "{head}");
    let page = String::from_utf8(body).expect("text");
    assert!(page.contains("<title>Tetrascope</title>"));
    // Nothing is loaded from elsewhere, and nothing is in the page that would need leave.
    let scripts = page.split("<script src=\"").skip(1);
    let scripts: Vec<&str> = scripts.filter_map(|rest| rest.split('"').next()).collect();
    assert!(scripts.len() > 5, "{scripts:?}");
    let of_scripts = ["http://", "https://", "innerHTML", "eval("];
    let scripts = scripts.iter().map(|name| (*name, of_scripts));
    let others = [
        ("", ["http://", "https://", " style=", " onclick="]),
        ("style.css", ["http://", "https://", "@import", "url("]),
    ];
    for (name, forbidden) in others.into_iter().chain(scripts) {
        let text = String::from_utf8(viewer.file(name)).expect("text");
        for word in forbidden {
            assert!(!text.contains(word), "{name} has {word}");
        }
    }
    let head = head.to_ascii_lowercase();
    assert!(
        head.contains("content-security-policy: default-src 'none'"),
        "{head}"
    );
    assert!(
        !head.contains("unsafe-inline") && head.contains("no-referrer"),
        "{head}"
    );

    let other = "0".repeat(32);
    for path in [
        "/",
        "/index.html",
        "/panels.js",
        "/ws",
        "/picture.png",
        &format!("/{other}/"),
        &format!("/{}/", &token[..31]),
        &format!("/{token}0/"),
        &format!("/%2e/{token}/"),
        "//etc/passwd",
        "/../../etc/passwd",
    ] {
        let (status, _, body) = viewer.get(path, "");
        assert_eq!(status, 403, "{path}");
        let words = String::from_utf8(body).expect("text");
        assert!(
            words.contains("token") && !words.contains(&token),
            "{words}"
        );
    }
    let (status, head, _) = viewer.get(&format!("/{token}"), "");
    assert!(
        status == 308 && head.contains(&format!("/{token}/")),
        "{head}"
    );
}

#[test]
fn nothing_of_the_disk_can_be_asked_for() {
    let viewer = Viewer::start(SPHERE);
    let token = &viewer.token;
    for name in [
        "../../../../etc/passwd",
        "..%2f..%2fetc%2fpasswd",
        "/etc/passwd",
        "page/index.html",
        "scene.toml/../../x",
        "picture.jpg",
        "picture.png%00",
        "%2e%2e/",
        "panels.js?file=/etc/passwd&x=/etc/passwd#",
    ] {
        let (status, _, body) = viewer.get(&format!("/{token}/{name}"), "");
        let body = String::from_utf8_lossy(&body);
        assert!(!body.contains("root:"), "{name}");
        let is_page = name.starts_with("panels.js");
        assert_eq!(status, if is_page { 200 } else { 404 }, "{name}");
    }
    let mut socket = viewer.socket();
    let state = socket.told("state");
    // A scene that is imported brings no volume.
    let scene =
        "version = 1\\n[volume]\\nfile = \\\"/etc/passwd\\\"\\n[image]\\nbackground = [1, 0, 0, 1]";
    socket.say(&format!(
        "{{\"seq\": 1, \"command\": {{\"do\": \"import-scene\", \"text\": \"{scene}\"}}}}"
    ));
    let next = socket.told("state");
    assert_eq!(next["background"], serde_json::json!([1.0, 0.0, 0.0, 1.0]));
    assert_eq!(next["field_id"], state["field_id"]);
    let saved = String::from_utf8(viewer.file("scene.toml")).expect("text");
    assert!(
        saved.contains("dataset = \"sphere\"") && !saved.contains("passwd"),
        "{saved}"
    );
    // No command has a name for a file.
    for command in [
        "{\"do\": \"load\", \"file\": \"/etc/passwd\"}",
        "{\"do\": \"step\", \"number\": 0, \"file\": \"/etc/passwd\"}",
        "{\"do\": \"field\", \"name\": \"/etc/passwd\"}",
        "{\"do\": \"step\", \"number\": 7}",
    ] {
        socket.say(&format!("{{\"seq\": 2, \"command\": {command}}}"));
        let problem = socket.told("problem");
        assert!(problem["message"].is_string(), "{problem}");
    }
}

#[test]
fn other_names_and_other_pages_are_refused() {
    let viewer = Viewer::start(SPHERE);
    let (token, port) = (&viewer.token, viewer.port);
    let page = format!("/{token}/");
    let status = |path: &str, headers: &str| viewer.get(path, headers).0;
    assert_eq!(status(&page, "Host: evil.example\r\n"), 403);
    assert_eq!(
        status(&page, &format!("Host: evil.example:{port}\r\n")),
        403
    );
    assert_eq!(
        status(&page, "Host: localhost\r\nHost: evil.example\r\n"),
        403
    );
    assert_eq!(status(&page, "Host: 192.168.1.1\r\n"), 403);
    // A tunnel ends at another port of the person's machine.
    assert_eq!(status(&page, "Host: localhost:4321\r\n"), 200);
    assert_eq!(status(&page, "Origin: http://evil.example\r\n"), 403);
    let upgrade = "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n\
                   Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n";
    let socket = format!("/{token}/ws");
    assert_eq!(status(&socket, upgrade), 403, "without an origin");
    for origin in [
        "null",
        "http://evil.example",
        "http://localhost",
        "http://localhost:1",
    ] {
        assert_eq!(
            status(&socket, &format!("Origin: {origin}\r\n{upgrade}")),
            403,
            "{origin}"
        );
    }
    let wrong = format!("/{}/ws", "0".repeat(32));
    let own = format!("Origin: http://localhost:{port}\r\n");
    assert_eq!(status(&wrong, &format!("{own}{upgrade}")), 403);
    assert_eq!(status(&socket, &own), 400, "no upgrade");
    let post = format!(
        "POST {page} HTTP/1.1\r\nHost: localhost\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"
    );
    assert_eq!(viewer.ask(&post).0, 405);
    assert_eq!(viewer.ask("GARBAGE\r\n\r\n").0, 400);
}

#[test]
fn messages_are_bounded_in_size_number_and_kind() {
    let viewer = Viewer::start(SPHERE);
    let mut long = viewer.socket();
    let text = "x".repeat(4 << 20);
    // It may end before all of it is sent.
    let _ = long.0.send(Message::text(text));
    assert!(matches!(long.ended(), Some(1009) | None));

    let mut flood = viewer.socket();
    for _ in 0..20_000 {
        if flood.0.write(Message::text("{}")).is_err() {
            break;
        }
    }
    let _ = flood.0.flush();
    assert!(matches!(flood.ended(), Some(1008) | None));

    let mut binary = viewer.socket();
    binary
        .0
        .send(Message::binary(vec![1, 2, 3]))
        .expect("it is sent");
    assert_eq!(binary.ended(), Some(1003));

    // What is not understood is said, and the connection stays.
    let mut socket = viewer.socket();
    for wrong in [
        "",
        "nonsense",
        "{\"seq\": -1}",
        "{\"command\": {\"do\": \"camera\"}}",
    ] {
        socket.say(wrong);
        let problem = socket.told("problem");
        assert!(
            problem["message"]
                .as_str()
                .is_some_and(|m| m.contains("not understood"))
        );
    }
    let deep = "[".repeat(100_000);
    socket.say(&deep);
    socket.told("problem");
    socket.say("{\"seq\": 9, \"histogram\": [0, 1]}");
    assert_eq!(
        socket.told("histogram")["counts"].as_array().map(Vec::len),
        Some(256)
    );
}

#[test]
fn a_second_page_sees_the_same_and_a_ninth_is_refused_in_words() {
    let viewer = Viewer::start(SPHERE);
    let mut pages: Vec<_> = (0..8).map(|_| viewer.socket()).collect();
    for page in &mut pages {
        page.told("hello");
        page.told("state");
    }
    let command = "{\"seq\": 1, \"command\": {\"do\": \"unit-distance\", \"length\": 0.125}}";
    pages[0].say(command);
    for page in &mut pages {
        while page.told("state")["look"]["unit_distance"] != 0.125 {}
    }
    let mut ninth = viewer.socket();
    match ninth.0.read() {
        Ok(Message::Close(Some(frame))) => assert!(frame.reason.contains("too many pages")),
        other => panic!("{other:?}"),
    }
    // A place is free again once a page is gone.
    drop(pages.pop());
    let mut again = viewer.socket();
    loop {
        match again.0.read() {
            Ok(Message::Text(_)) => break,
            _ => again = viewer.socket(),
        }
    }
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_as_a_shell_expects() {
    use std::os::unix::process::ExitStatusExt as _;
    use std::process::Command;
    let mut viewer = Viewer::start(SPHERE);
    let mut page = viewer.socket();
    page.told("state");
    let interrupt = Command::new("kill")
        .args(["-INT", &viewer.child.id().to_string()])
        .status();
    assert!(interrupt.expect("kill runs").success());
    let mut status = None;
    for _ in 0..600 {
        status = viewer.child.try_wait().expect("a child");
        if status.is_some() {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    // A test that was started with SIGINT ignored hands that on.
    let status = status.expect("it ends within a minute, unless SIGINT was ignored from the start");
    // A shell says 130 of that.
    assert_eq!((status.code(), status.signal()), (None, Some(2)));
    assert!(std::net::TcpStream::connect(("127.0.0.1", viewer.port)).is_err());
}
