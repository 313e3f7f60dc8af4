//! The live server without a browser: who is refused, what a page gets, and that nobody holds it up.
#![allow(clippy::unwrap_used)] // a test that cannot go on has failed

use std::io::{Read, Write};
use std::net::TcpStream;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use acerra_imaging::PlaneGrid;
use acerra_live::Board;
use acerra_live::picture::Picture;
use acerra_view::{FinalView, LiveServer};
use num_complex::Complex32;

/// A server, stopped when it goes out of scope.
struct Serving {
    board: Arc<Board>,
    host: String,
    base: String,
    last: FinalView,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Serving {
    fn start() -> Self {
        let board = Board::new();
        let server = LiveServer::open(Arc::clone(&board), 0).unwrap();
        let rest = server.address().strip_prefix("http://").unwrap().to_owned();
        let (host, token) = rest.split_once('/').unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let is_over = Arc::clone(&stop);
        let last = server.final_view();
        let run = move || server.run(move || is_over.load(Ordering::SeqCst)).unwrap();
        Self {
            board,
            host: host.to_owned(),
            base: format!("/{}", token.trim_end_matches('/')),
            last,
            stop,
            thread: Some(std::thread::spawn(run)),
        }
    }

    fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(&self.host).unwrap();
        stream
            .set_read_timeout(Some(Duration::from_secs(10)))
            .unwrap();
        stream
    }

    /// Asks to open a socket with these headers; returns the stream and the head of the answer.
    fn upgrade(&self, path: &str, headers: &str) -> (TcpStream, String) {
        let mut stream = self.connect();
        write!(
            stream,
            "GET {}{path} HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\
             Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n{headers}\r\n",
            self.base
        )
        .unwrap();
        let mut head = Vec::new();
        let mut byte = [0];
        while !head.ends_with(b"\r\n\r\n") && stream.read(&mut byte).unwrap() == 1 {
            head.push(byte[0]);
        }
        (stream, String::from_utf8(head).unwrap())
    }

    fn socket(&self) -> TcpStream {
        let (stream, head) = self.upgrade("/live", &format!("Host: {}\r\n", self.host));
        assert!(head.starts_with("HTTP/1.1 101"), "{head}");
        stream
    }

    fn status(&self, path: &str) -> u16 {
        let mut stream = self.connect();
        write!(
            stream,
            "GET {}{path} HTTP/1.1\r\nHost: {}\r\nConnection: close\r\n\r\n",
            self.base, self.host
        )
        .unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer[9..12]).parse().unwrap()
    }

    /// Posts a body to `stop`; the status of the answer.
    fn post_stop(&self, headers: &str, body: &str) -> u16 {
        let mut stream = self.connect();
        write!(
            stream,
            "POST {}/stop HTTP/1.1\r\n{headers}Content-Length: {}\r\nConnection: close\r\n\r\n{body}",
            self.base,
            body.len()
        )
        .unwrap();
        let mut answer = Vec::new();
        stream.read_to_end(&mut answer).unwrap();
        String::from_utf8_lossy(&answer[9..12]).parse().unwrap()
    }

    /// A state of the picture with one pixel more.
    fn grow(&self, picture: &mut Picture, image: &mut [Complex32], pixel: usize) {
        image[pixel] = Complex32::new(1.0, 0.0);
        picture.update(image);
        let now = Instant::now();
        self.board.show_picture(picture.clone(), &[now], now);
    }
}

impl Drop for Serving {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        // Those who wait for a connection's end give up with it.
        self.thread.take().map(JoinHandle::join);
    }
}

/// A frame of a server: opcode and payload; none at the end.
fn frame(stream: &mut TcpStream) -> Option<(u8, Vec<u8>)> {
    let mut head = [0; 2];
    stream.read_exact(&mut head).ok()?;
    let length = match head[1] & 0x7F {
        126 => {
            let mut bytes = [0; 2];
            stream.read_exact(&mut bytes).ok()?;
            usize::from(u16::from_be_bytes(bytes))
        }
        127 => {
            let mut bytes = [0; 8];
            stream.read_exact(&mut bytes).ok()?;
            usize::try_from(u64::from_be_bytes(bytes)).unwrap()
        }
        length => usize::from(length),
    };
    let mut payload = vec![0; length];
    stream.read_exact(&mut payload).ok()?;
    Some((head[0] & 0x0F, payload))
}

/// A frame of a client: masked by zeros.
fn send(stream: &mut TcpStream, opcode: u8, payload: &[u8]) {
    let mut frame = vec![0x80 | opcode];
    match u8::try_from(payload.len()) {
        Ok(length) if length < 126 => frame.push(0x80 | length),
        _ => {
            frame.push(0x80 | 126);
            frame.extend((payload.len() as u16).to_be_bytes());
        }
    }
    frame.extend([0; 4]);
    frame.extend(payload);
    // A server that has closed refuses more.
    let _ = stream.write_all(&frame);
}

/// A round: its bytes and its JSON; none where the connection ended.
fn round(stream: &mut TcpStream) -> Option<(Vec<Vec<u8>>, serde_json::Value)> {
    let mut bytes = Vec::new();
    loop {
        match frame(stream)? {
            (2, payload) => bytes.push(payload),
            (1, text) => return Some((bytes, serde_json::from_slice(&text).unwrap())),
            (8, _) => return None,
            _ => {}
        }
    }
}

fn picture() -> (Picture, Vec<Complex32>) {
    let grid = PlaneGrid::new([0.0; 3], 0.1, [300, 200]).unwrap();
    (Picture::new(grid), vec![Complex32::ZERO; 60_000])
}

#[test]
fn a_foreign_origin_or_host_and_a_wrong_token_are_refused() {
    let server = Serving::start();
    let own = format!("Host: {}\r\n", server.host);
    for strange in [
        "Host: evil.example\r\n".to_owned(),
        format!("{own}Origin: http://evil.example\r\n"),
        format!("{own}Origin: null\r\n"),
        format!("{own}Sec-Fetch-Site: cross-site\r\n"),
    ] {
        let (_, head) = server.upgrade("/live", &strange);
        assert!(head.starts_with("HTTP/1.1 403"), "{strange}: {head}");
    }
    let (_, head) = server.upgrade("x/live", &own);
    assert!(head.starts_with("HTTP/1.1 404"), "{head}");
    let same = format!("{own}Origin: http://{}\r\n", server.host);
    assert!(server.upgrade("/live", &same).1.starts_with("HTTP/1.1 101"));
    for (path, status) in [
        ("/", 200),
        ("/js/live.js", 200),
        ("/view/", 404),
        ("/api/runs", 404),
    ] {
        assert_eq!(server.status(path), status, "{path}");
    }
}

#[test]
fn a_page_that_skips_states_gets_what_changed_since_its_last() {
    let server = Serving::start();
    let (mut made, mut image) = picture();
    let mut page = server.socket();
    let (bytes, state) = round(&mut page).unwrap();
    assert!(bytes.is_empty() && state["grid"].is_null());
    server.grow(&mut made, &mut image, 0);
    send(&mut page, 1, b"drawn 0");
    let (bytes, state) = round(&mut page).unwrap();
    assert_eq!(
        (state["sequence"].as_u64(), state["grid"]["nx"].as_u64()),
        (Some(1), Some(300))
    );
    // Only the tile that changed, though nobody had anything before.
    assert_eq!(u16::from_le_bytes([bytes[0][2], bytes[0][3]]), 1);
    // Three states while the page draws: it gets the last, with the tiles of all.
    for pixel in [1, 299, 59_999] {
        server.grow(&mut made, &mut image, pixel);
    }
    send(&mut page, 1, b"drawn 1");
    let (bytes, state) = round(&mut page).unwrap();
    assert_eq!(state["sequence"], 4);
    assert_eq!(u16::from_le_bytes([bytes[0][2], bytes[0][3]]), 3);
    // Another page gets all of it at once.
    let (bytes, state) = round(&mut server.socket()).unwrap();
    assert_eq!(state["sequence"], 4);
    assert_eq!(u16::from_le_bytes([bytes[0][2], bytes[0][3]]), 3);
}

#[test]
fn hostile_pages_are_shut_out_and_hold_nobody_up() {
    let server = Serving::start();
    let (mut made, mut image) = picture();
    let hostile: [(u8, Vec<u8>); 6] = [
        (1, vec![b'x'; 200]),
        (1, b"drawn 18446744073709551616".to_vec()),
        (1, b"drawn 7".to_vec()),
        (1, b"nonsense".to_vec()),
        (2, vec![0; 32]),
        (3, vec![1]),
    ];
    for (opcode, payload) in &hostile {
        let mut page = server.socket();
        round(&mut page).unwrap();
        send(&mut page, *opcode, payload);
        assert!(round(&mut page).is_none(), "{payload:?}");
    }
    // One that never answers and one that only pings: the picture goes on, and others see it.
    let mut silent = server.socket();
    round(&mut silent).unwrap();
    let mut pinging = server.socket();
    round(&mut pinging).unwrap();
    for _ in 0..40 {
        send(&mut pinging, 9, b"");
    }
    let begun = Instant::now();
    for pixel in 0..50 {
        server.grow(&mut made, &mut image, pixel);
    }
    assert!(begun.elapsed() < Duration::from_secs(5));
    assert_eq!(round(&mut server.socket()).unwrap().1["sequence"], 50);
    assert!(std::iter::from_fn(|| frame(&mut pinging)).last().is_some());
    // More pages than there is room for.
    let pages: Vec<TcpStream> = (0..7).map(|_| server.socket()).collect();
    let own = format!("Host: {}\r\n", server.host);
    assert!(server.upgrade("/live", &own).1.starts_with("HTTP/1.1 503"));
    drop(pages);
}

#[test]
fn a_final_run_that_is_none_is_not_shown() {
    let server = Serving::start();
    let folder = tempfile::tempdir().unwrap();
    assert!(server.last.show(folder.path()).is_err());
    assert_eq!(server.status("/view/"), 404);
}

#[test]
fn a_recording_is_ended_by_its_own_page_alone_and_once() {
    let serving = Serving::start();
    let own = format!("Host: {}\r\n", serving.host);
    let json = format!("{own}Content-Type: application/json\r\n");
    let yes = "{\"confirmed\": true}";
    // Nothing goes on that could be ended, as in a replay.
    assert_eq!(serving.post_stop(&json, yes), 409);
    let stops = Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let counted = Arc::clone(&stops);
    serving.board.let_stop(move || {
        counted.fetch_add(1, Ordering::SeqCst);
    });
    let foreign = format!("{json}Origin: http://evil.example\r\n");
    let cross = format!("{json}Sec-Fetch-Site: cross-site\r\n");
    let other_host = "Host: evil.example\r\nContent-Type: application/json\r\n";
    for headers in [foreign.as_str(), cross.as_str(), other_host] {
        assert_eq!(serving.post_stop(headers, yes), 403, "{headers}");
    }
    // A form of another page sends no JSON.
    assert_eq!(serving.post_stop(&own, yes), 415);
    for (body, status) in [("", 400), ("{\"confirmed\": false}", 400), ("{}", 422)] {
        assert_eq!(serving.post_stop(&json, body), status, "{body}");
    }
    assert_eq!(serving.status("/stop"), 405);
    assert_eq!(stops.load(Ordering::SeqCst), 0);
    assert!(serving.board.shown().can_stop);
    assert_eq!(serving.post_stop(&json, yes), 204);
    assert_eq!(serving.post_stop(&json, yes), 409);
    assert_eq!(stops.load(Ordering::SeqCst), 1);
    assert_eq!(serving.board.shown().last, acerra_live::Final::Ending);
}
