//! The WebSocket of a live image. A slow page gets the latest state when it is ready; no other part waits for
//! a page, and no states are queued for it.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use acerra_live::Board;
use acerra_live::board::Page;
use axum::extract::State;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use tokio::sync::watch;
use tokio::time::timeout;

use super::live_message::Sent;

/// Pages at once.
const MOST_CLIENTS: usize = 8;
/// Longest message that a page sends: `drawn` and a number.
const LONGEST_MESSAGE: usize = 64;
/// Time for a page to draw, and to receive data.
const LONGEST_DRAWING: Duration = Duration::from_secs(20);
/// Longest silence: the interval of messages without changes.
const LONGEST_SILENCE: Duration = Duration::from_secs(1);
/// Messages other than the answer that a page may send before it.
const MOST_OTHERS: usize = 16;

/// The pages of a board.
#[derive(Clone)]
pub struct Clients {
    board: Arc<Board>,
    changes: watch::Receiver<u64>,
    count: Arc<AtomicUsize>,
}

impl Clients {
    /// None yet.
    pub fn of(board: Arc<Board>) -> Self {
        let (send, changes) = watch::channel(0);
        board.listen(move || send.send_modify(|count| *count += 1));
        Self {
            board,
            changes,
            count: Arc::default(),
        }
    }
}

/// A page's place among those at once.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn take(count: &Arc<AtomicUsize>) -> Option<Self> {
        let taken = count.fetch_add(1, Ordering::SeqCst);
        let place = Self(Arc::clone(count));
        (taken < MOST_CLIENTS).then_some(place)
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Opens a socket, where there is room for another page.
pub async fn socket(State(clients): State<Clients>, upgrade: WebSocketUpgrade) -> Response {
    let Some(place) = Place::take(&clients.count) else {
        let refusal = "too many pages show this image";
        return (StatusCode::SERVICE_UNAVAILABLE, refusal).into_response();
    };
    upgrade
        .max_message_size(LONGEST_MESSAGE)
        .max_frame_size(LONGEST_MESSAGE)
        .on_upgrade(move |socket| async move {
            // The page went away, or sent an invalid message: it is closed.
            let _ = talk(socket, &clients).await;
            drop(place);
        })
}

/// End of the connection to a page.
struct Over;

async fn talk(mut socket: WebSocket, clients: &Clients) -> Result<(), Over> {
    let mut changes = clients.changes.clone();
    let mut sent = Sent::default();
    let page = Page::come(Arc::clone(&clients.board));
    loop {
        changes.mark_unchanged();
        page.is_busy(true);
        let round = sent.round(&clients.board);
        for bytes in round.bytes {
            send(&mut socket, Message::Binary(bytes.into())).await?;
        }
        send(&mut socket, Message::Text(round.text.into())).await?;
        if has_drawn(&mut socket, sent.sequence).await? {
            clients.board.drawn(sent.sequence, Instant::now());
        }
        page.is_busy(false);
        if let Ok(Err(_)) = timeout(LONGEST_SILENCE, changes.changed()).await {
            // No further changes will come.
            return Ok(());
        }
    }
}

async fn send(socket: &mut WebSocket, message: Message) -> Result<(), Over> {
    match timeout(LONGEST_DRAWING, socket.send(message)).await {
        Ok(Ok(())) => Ok(()),
        Ok(Err(_)) | Err(_) => Err(Over),
    }
}

/// Waits for a page's answer to a round: `drawn` with the state of the picture, or `kept`, where it is not in
/// view and draws nothing.
async fn has_drawn(socket: &mut WebSocket, sequence: u64) -> Result<bool, Over> {
    for _ in 0..MOST_OTHERS {
        let message = timeout(LONGEST_DRAWING, socket.recv()).await;
        match message {
            Ok(Some(Ok(Message::Text(text)))) => {
                let (word, number) = text.split_once(' ').ok_or(Over)?;
                if number.parse() != Ok(sequence) {
                    return Err(Over);
                }
                return match word {
                    "drawn" => Ok(true),
                    "kept" => Ok(false),
                    _ => Err(Over),
                };
            }
            Ok(Some(Ok(Message::Ping(_) | Message::Pong(_)))) => {}
            _ => return Err(Over),
        }
    }
    Err(Over)
}
