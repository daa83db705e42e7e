//! Links on a tokio runtime: one thread reads as many boards as there are.
//!
//! [`super::StreamSource`] on a thread of its own is what a board at 1 kHz is read with; this is for programs
//! that live on a runtime and for several boards at a time. Nothing may compute on that runtime: what it
//! keeps from running comes late.

use std::collections::VecDeque;
use std::future::ready;
use std::io::{self, ErrorKind};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;

use serialport::{ClearBuffer, SerialPort};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::{Instant, sleep_until, timeout, timeout_at};
use tokio_serial::{SerialPortBuilderExt, SerialStream};

use super::serial::{builder, refused};
use super::session::{READ_LEN, REOPEN_NS, Session};
use super::{LinkFault, LinkState, SerialParams, SourceStats, StreamParams};
use crate::Message;
use crate::clock::HostClock;

/// Longest wait for bytes, so that silence is noticed.
const SILENT: Duration = Duration::from_millis(100);
const CONNECT_TIMEOUT: Duration = Duration::from_millis(500);
const WRITE_TIMEOUT: Duration = Duration::from_millis(50);

type Opening<S> = Pin<Box<dyn Future<Output = Result<S, LinkFault>> + Send>>;

/// A link that is opened, and opened again, on a tokio runtime.
pub trait AsyncLink {
    /// What carries the bytes.
    type Stream: AsyncRead + AsyncWrite + Unpin;

    /// Opens it, or opens it again. What is returned is kept until it ends, so that opening goes on where
    /// waiting for it was given up.
    ///
    /// # Errors
    /// Why it can't be opened now.
    fn open(&self) -> impl Future<Output = Result<Self::Stream, LinkFault>> + Send + 'static;

    /// What it is, in words.
    fn name(&self) -> String;
}

/// A serial port by its path, as [`super::SerialLink`] has it, by tokio-serial.
#[derive(Clone, Debug)]
pub struct AsyncSerial {
    path: String,
    params: SerialParams,
}

/// A device's TCP port, `host:port`.
#[derive(Clone, Debug)]
pub struct AsyncTcp {
    address: String,
}

/// Frames from a link of a tokio runtime: what [`super::StreamSource`] is on a thread.
///
/// ```no_run
/// use hapdef_daq::Message;
/// use hapdef_daq::source::{AsyncSerial, AsyncSource, SerialParams, StreamParams};
///
/// async fn read(port: &str) {
///     let link = AsyncSerial::new(port, SerialParams::default());
///     let mut board = AsyncSource::new(link, StreamParams::default());
///     loop {
///         if let Message::Frame(frame) = board.next().await {
///             println!("{port}: {}, {} lost before", frame.seq, frame.n_lost_before);
///         }
///     }
/// }
/// # async fn read_both() {
/// tokio::join!(read("/dev/ttyACM0"), read("/dev/ttyACM1"));
/// # }
/// ```
pub struct AsyncSource<L: AsyncLink> {
    link: L,
    opening: Option<Opening<L::Stream>>,
    stream: Option<L::Stream>,
    clock: Arc<dyn HostClock>,
    session: Session,
    buffer: Vec<u8>,
    /// What was understood and not handed out yet.
    messages: VecDeque<Message>,
    last_fault: Option<LinkFault>,
    /// When it is opened again, or is found to be silent.
    due: Instant,
}

impl AsyncSerial {
    /// A port, not opened yet.
    #[must_use]
    pub fn new(path: &str, params: SerialParams) -> Self {
        Self { path: path.to_owned(), params }
    }

    fn opened(&self) -> Result<SerialStream, LinkFault> {
        let refused = |error: serialport::Error| refused(&self.path, &error);
        let port = builder(&self.path, &self.params).open_native_async().map_err(refused)?;
        // What was sent to whoever had the port before.
        port.clear(ClearBuffer::Input).map_err(refused)?;
        if self.params.low_latency {
            super::low_latency::ask(&port);
        }
        Ok(port)
    }
}

impl AsyncLink for AsyncSerial {
    type Stream = SerialStream;

    fn open(&self) -> impl Future<Output = Result<SerialStream, LinkFault>> + Send + 'static {
        ready(self.opened())
    }

    fn name(&self) -> String {
        self.path.clone()
    }
}

impl AsyncTcp {
    /// A port, not connected to yet.
    #[must_use]
    pub fn new(address: &str) -> Self {
        Self { address: address.to_owned() }
    }
}

impl AsyncLink for AsyncTcp {
    type Stream = TcpStream;

    fn open(&self) -> impl Future<Output = Result<TcpStream, LinkFault>> + Send + 'static {
        let address = self.address.clone();
        async move {
            let connected = timeout(CONNECT_TIMEOUT, TcpStream::connect(&address)).await;
            let connected = connected.unwrap_or_else(|_| Err(ErrorKind::TimedOut.into()));
            let stream = connected.map_err(|error| LinkFault::of_connecting(address, &error))?;
            // It only saves time.
            let _ = stream.set_nodelay(true);
            Ok(stream)
        }
    }

    fn name(&self) -> String {
        self.address.clone()
    }
}

impl<L: AsyncLink> AsyncSource<L> {
    /// A source from a link, which is opened when the first message is asked for.
    #[must_use]
    pub fn new(link: L, params: StreamParams) -> Self {
        Self {
            link,
            opening: None,
            stream: None,
            clock: params.clock,
            session: Session::new(params.protocol),
            buffer: vec![0; READ_LEN],
            messages: VecDeque::new(),
            last_fault: None,
            due: Instant::now(),
        }
    }

    /// The next message. Trouble with the link comes as [`Message::Link`], and the link is opened again
    /// as soon as that works. When this is dropped nothing is lost: no message, nor a connection that is being
    /// made.
    pub async fn next(&mut self) -> Message {
        loop {
            if let Some(message) = self.messages.pop_front() {
                return message;
            }
            let words = match &mut self.stream {
                None => self.open().await,
                Some(stream) => match timeout_at(self.due, stream.read(&mut self.buffer)).await {
                    // A hung-up port reads as empty for ever.
                    Ok(Ok(0)) => Err(self.gone(&ErrorKind::UnexpectedEof.into())),
                    Ok(Err(error)) => Err(self.gone(&error)),
                    Ok(Ok(n)) => Ok(self.took(n)),
                    Err(_) => Ok(self.took(0)),
                },
            };
            let said = match words {
                Ok(words) => self.say(&words).await,
                Err(fault) => Err(fault),
            };
            if let Err(fault) = said {
                self.away(fault);
            }
        }
    }

    /// What came so far.
    #[must_use]
    pub fn stats(&self) -> SourceStats {
        self.session.stats()
    }

    /// What it is, in words: a path, an address.
    #[must_use]
    pub fn name(&self) -> String {
        self.link.name()
    }

    async fn open(&mut self) -> Result<Vec<u8>, LinkFault> {
        if self.opening.is_none() {
            sleep_until(self.due).await;
        }
        let opened = self.opening.get_or_insert_with(|| Box::pin(self.link.open())).await;
        self.opening = None;
        self.stream = Some(opened?);
        self.last_fault = None;
        self.due = Instant::now() + SILENT;
        let messages = &mut self.messages;
        let now_ns = self.clock.now_ns();
        let words = self.session.opened(now_ns, &mut |message| messages.push_back(message));
        Ok(words)
    }

    fn took(&mut self, n: usize) -> Vec<u8> {
        self.due = Instant::now() + SILENT;
        let messages = &mut self.messages;
        let (bytes, now_ns) = (&self.buffer[..n], self.clock.now_ns());
        self.session.took(bytes, now_ns, &mut |message| messages.push_back(message))
    }

    async fn say(&mut self, words: &[u8]) -> Result<(), LinkFault> {
        let Some(stream) = self.stream.as_mut().filter(|_| !words.is_empty()) else {
            return Ok(());
        };
        match timeout(WRITE_TIMEOUT, stream.write_all(words)).await {
            Ok(Err(error)) => Err(self.gone(&error)),
            // A device that takes nothing may send all the same.
            Ok(Ok(())) | Err(_) => Ok(()),
        }
    }

    fn gone(&self, error: &io::Error) -> LinkFault {
        LinkFault::of_use(&self.link.name(), error)
    }

    /// The link is gone, or could not be opened.
    fn away(&mut self, fault: LinkFault) {
        if self.stream.take().is_some() {
            self.session.closed();
        }
        self.due = Instant::now() + Duration::from_nanos(REOPEN_NS);
        if self.last_fault.as_ref() != Some(&fault) {
            self.last_fault = Some(fault.clone());
            self.messages.push_back(Message::Link(LinkState::Away(fault)));
        }
    }
}
