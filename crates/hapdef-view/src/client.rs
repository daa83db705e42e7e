//! One page: what it is sent, what it says.

use std::sync::Arc;
use std::sync::mpsc::TrySendError;
use std::time::Duration;

use axum::body::Bytes;
use axum::extract::ws::{CloseFrame, Message, WebSocket};
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt, StreamExt};
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior, interval, interval_at, timeout};

use crate::client_stats::ClientStats;
use crate::command::{PageMessage, ViewCommand};
use crate::feed::{Feed, Place};
use crate::wire::{self, Hello};

/// A page that says nothing for so long at first is let go.
const HELLO_TIME: Duration = Duration::from_secs(3);
/// Between frames: 60 a second at most.
const FRAME_TIME: Duration = Duration::from_micros(16_667);
/// Answers that wait for a page that does not read.
const MAX_ANSWERS: usize = 16;
/// Pings in the time for which a page may answer nothing.
const PINGS: u32 = 3;
/// Between signs of life: a page without any for three of them knows that the program is gone.
const ALIVE_TIME: Duration = Duration::from_millis(500);
/// A sign of life.
const ALIVE: &str = r#"{"type":"alive"}"#;
/// Close code of a page without the token where one is needed.
const CLOSE_TOKEN: u16 = 4401;

/// Serves one page until it leaves.
pub(crate) async fn serve(place: Place, mut socket: WebSocket) {
    let feed = Arc::clone(&place.feed);
    let Some(has_token) = greet(&feed, &mut socket).await else {
        return;
    };
    if feed.token_always && !has_token {
        let close = CloseFrame { code: CLOSE_TOKEN, reason: "the address needs its token".into() };
        let _ = timeout(HELLO_TIME, socket.send(Message::Close(Some(close)))).await;
        return;
    }
    let stats = Arc::new(ClientStats::new(feed.n_pushed().saturating_sub(1)));
    feed.enter(&stats);
    let (sink, stream) = socket.split();
    let (answers, answered) = mpsc::channel(MAX_ANSWERS);
    let page = Page { feed: &feed, stats: &stats, has_token };
    tokio::select! {
        () = page.read(stream, answers) => {}
        () = page.write(sink, answered) => {}
    }
    feed.end_press(&stats);
    feed.leave(&stats);
}

/// The page's first message: whether it has the token; `None`: it said something else or nothing.
async fn greet(feed: &Feed, socket: &mut WebSocket) -> Option<bool> {
    let first = timeout(HELLO_TIME, socket.recv()).await.ok()??.ok()?;
    match PageMessage::parse(first.to_text().ok()?).ok()? {
        PageMessage::Hello { token } => Some(token.is_some_and(|token| feed.token.is(&token))),
        _ => None,
    }
}

/// A page that was greeted.
struct Page<'a> {
    feed: &'a Feed,
    stats: &'a Arc<ClientStats>,
    has_token: bool,
}

impl Page<'_> {
    /// Until the page leaves, or neither says anything nor answers a ping.
    async fn read(&self, mut stream: SplitStream<WebSocket>, answers: mpsc::Sender<String>) {
        while let Ok(Some(Ok(message))) = timeout(self.feed.patience, stream.next()).await {
            let Message::Text(text) = message else {
                continue;
            };
            if let Some(answer) = self.answer(&text) {
                let _ = answers.try_send(answer);
            }
        }
    }

    /// Does what a message says and answers it, if it is one to be answered.
    fn answer(&self, text: &str) -> Option<String> {
        let message = match PageMessage::parse(text) {
            Ok(PageMessage::Got { drawn }) => {
                self.stats.took(drawn);
                return None;
            }
            Ok(message) => message,
            Err(why) => return Some(wire::refusal(&why)),
        };
        if !self.has_token {
            return Some(wire::refusal("view only: commands need the token of the address"));
        }
        let sent = message
            .command(&self.feed.offers)
            .and_then(|command| command.map_or(Ok(()), |command| self.send(command)));
        sent.err().map(|why| wire::refusal(&why))
    }

    fn send(&self, command: ViewCommand) -> Result<(), String> {
        let sent = match command {
            ViewCommand::Press { .. } => self.feed.press(self.stats, command),
            ViewCommand::Release => {
                self.feed.end_press(self.stats);
                Ok(())
            }
            _ => self.feed.commands.try_send(command),
        };
        sent.map_err(|error| match error {
            TrySendError::Full(_) => "too many commands at a time".to_owned(),
            TrySendError::Disconnected(_) => "nobody takes commands any more".to_owned(),
        })
    }

    /// Sends until the page is gone: what it needs at first, answers, notices, the newest frame.
    async fn write(&self, mut sink: Sink, mut answers: mpsc::Receiver<String>) {
        let device = self.feed.device();
        let mut seen = Seen { frame: 0, notice: self.feed.last_notice(), device: device.seq };
        let hello = Hello::new(&self.feed.picture, &self.feed.offers, self.has_token);
        let Ok(hello) = serde_json::to_string(&hello) else {
            return;
        };
        let first = [
            Message::Text(hello.into()),
            Message::Text(device.value.as_str().into()),
            Message::Binary(self.feed.surface.clone()),
        ];
        for message in first {
            if sink.send(message).await.is_err() {
                return;
            }
        }
        let mut ticks = interval(FRAME_TIME);
        ticks.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut pings = interval(self.feed.patience / PINGS);
        let mut beats = interval_at(Instant::now() + ALIVE_TIME, ALIVE_TIME);
        loop {
            let sent = tokio::select! {
                Some(answer) = answers.recv() => sink.send(Message::Text(answer.into())).await,
                _ = ticks.tick() => self.send_newest(&mut sink, &mut seen).await,
                _ = beats.tick() => sink.send(Message::Text(ALIVE.into())).await,
                _ = pings.tick() => sink.send(Message::Ping(Bytes::new())).await,
            };
            if sent.is_err() {
                return;
            }
        }
    }

    async fn send_newest(&self, sink: &mut Sink, seen: &mut Seen) -> Result<(), axum::Error> {
        if let Some(notice) = self.feed.notice_after(seen.notice) {
            seen.notice = notice.seq;
            sink.send(Message::Text(wire::notice(&notice.value).into())).await?;
        }
        let device = self.feed.device();
        if device.seq != seen.device {
            seen.device = device.seq;
            sink.send(Message::Text(device.value.as_str().into())).await?;
        }
        if !self.stats.has_room() {
            return Ok(());
        }
        if let Some(frame) = self.feed.frame_after(seen.frame) {
            seen.frame = frame.seq;
            self.stats.sent();
            sink.send(Message::Binary(frame.value.clone())).await?;
        }
        Ok(())
    }
}

type Sink = SplitSink<WebSocket, Message>;

/// Numbers of what was sent last.
struct Seen {
    frame: u64,
    notice: u64,
    device: u64,
}
