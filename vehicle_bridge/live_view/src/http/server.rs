//! Connections: few, short, and each with a limit of time.

use std::io::Write;
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use std::time::Duration;

use anyhow::{Context as _, Result};

use super::orders::{OrderRequest, Orders};
use super::request::{self, Request};
use super::{files, guard, stream};
use crate::view::View;

/// Connections at one time. \[-\]
const CONNECTIONS: usize = 32;
/// A browser that takes or gives nothing for so long is gone.
const PATIENCE: Duration = Duration::from_secs(5);
/// Sent with everything: nothing of other places is loaded, nobody frames the page, nothing is kept.
pub(super) const HEADERS: &str = "Cache-Control: no-store\r\n\
    Content-Security-Policy: default-src 'none'; script-src 'self'; style-src 'self'; \
    img-src 'self'; connect-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'\r\n\
    Cross-Origin-Resource-Policy: same-origin\r\n\
    Cross-Origin-Opener-Policy: same-origin\r\n\
    X-Content-Type-Options: nosniff\r\n\
    X-Frame-Options: DENY\r\n\
    Referrer-Policy: no-referrer\r\n";

/// Why a request is not answered.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Refused {
    /// The connection ended, or the request came too slowly.
    Gone,
    /// It is no request of HTTP/1.1.
    Malformed,
    /// Head or body are too long.
    TooLong,
    /// It is not of a page that was handed out here.
    Foreign,
    /// There is no such file.
    Unknown,
    /// It is neither GET nor an order.
    Method,
    /// Orders are not taken, or not from this page.
    Forbidden,
    /// Too many pages are open.
    Busy,
}

impl Refused {
    fn line(self) -> &'static str {
        match self {
            Self::Gone => "408 Request Timeout",
            Self::Malformed => "400 Bad Request",
            Self::TooLong => "413 Content Too Large",
            Self::Foreign | Self::Forbidden => "403 Forbidden",
            Self::Unknown => "404 Not Found",
            Self::Method => "405 Method Not Allowed",
            Self::Busy => "503 Service Unavailable",
        }
    }
}

/// What a server does beside showing.
#[derive(Default)]
pub struct ServerOptions {
    /// Who may give orders; `None`: nobody, the page only shows.
    pub orders: Option<Orders>,
}

/// What all connections share.
pub(super) struct Shared {
    pub(super) view: Arc<View>,
    pub(super) options: ServerOptions,
    bound: SocketAddr,
    open: AtomicUsize,
}

/// A server that hands out the page of a view.
pub struct Server {
    address: SocketAddr,
}

impl Server {
    /// Begins to serve `view` at `address`; port 0 is any free one. Its threads end with the program.
    ///
    /// # Errors
    /// If the address cannot be had.
    pub fn start(address: SocketAddr, view: Arc<View>, options: ServerOptions) -> Result<Self> {
        let listener = TcpListener::bind(address)
            .with_context(|| format!("cannot serve at {address}; --port chooses another"))?;
        let bound = listener.local_addr()?;
        let shared = Arc::new(Shared { view, options, bound, open: AtomicUsize::new(0) });
        thread::Builder::new().name("lmpc-view".to_owned()).spawn(move || {
            for stream in listener.incoming() {
                match stream {
                    Ok(stream) => accept(&shared, stream),
                    // Out of file descriptors: others end meanwhile.
                    Err(_) => thread::sleep(Duration::from_millis(50)),
                }
            }
        })?;
        Ok(Self { address: bound })
    }

    /// Where it serves.
    #[must_use]
    pub fn address(&self) -> SocketAddr {
        self.address
    }
}

fn accept(shared: &Arc<Shared>, mut stream: TcpStream) {
    let times = [stream.set_read_timeout(Some(PATIENCE)), stream.set_write_timeout(Some(PATIENCE))];
    if times.iter().any(Result::is_err) {
        return;
    }
    if shared.open.fetch_add(1, Ordering::Relaxed) >= CONNECTIONS {
        shared.open.fetch_sub(1, Ordering::Relaxed);
        // Whether it learns why matters to nobody here.
        let _ = refuse(&mut stream, Refused::Busy);
        return;
    }
    let own = Arc::clone(shared);
    let spawned = thread::Builder::new().name("lmpc-page".to_owned()).spawn(move || {
        // A page that went away is no error of ours.
        let _ = stream.set_nodelay(true).and_then(|()| answer(&own, &mut stream));
        own.open.fetch_sub(1, Ordering::Relaxed);
    });
    if spawned.is_err() {
        shared.open.fetch_sub(1, Ordering::Relaxed);
    }
}

fn answer(shared: &Shared, stream: &mut TcpStream) -> std::io::Result<()> {
    let request = match request::read(stream).and_then(|request| {
        guard::check(&request, shared.bound)?;
        Ok(request)
    }) {
        Ok(request) => request,
        Err(why) => return refuse(stream, why),
    };
    match (request.method.as_str(), request.path.as_str()) {
        ("GET", "/stream") => stream::run(shared, stream),
        ("GET", path) => match files::find(path) {
            Some((kind, text)) => write(stream, "200 OK", kind, text),
            None => refuse(stream, Refused::Unknown),
        },
        ("POST", "/order") => match order(shared, &request) {
            Ok((line, text)) => write(stream, line, "text/plain; charset=utf-8", &text),
            Err(why) => refuse(stream, why),
        },
        _ => refuse(stream, Refused::Method),
    }
}

/// Carries an order out, if this program takes orders and the page may give them.
fn order(shared: &Shared, request: &Request) -> Result<(&'static str, String), Refused> {
    let orders = shared.options.orders.as_ref().ok_or(Refused::Forbidden)?;
    let token = request.token.as_deref().unwrap_or_default();
    // A browser sends the origin with every order.
    if request.origin.is_none() || !guard::equal(token, &orders.token) {
        return Err(Refused::Forbidden);
    }
    let order: OrderRequest =
        serde_json::from_slice(&request.body).map_err(|_| Refused::Malformed)?;
    Ok(match (orders.give)(&order) {
        Ok(text) => ("200 OK", text),
        Err(text) => ("409 Conflict", text),
    })
}

fn refuse(stream: &mut TcpStream, why: Refused) -> std::io::Result<()> {
    write(stream, why.line(), "text/plain; charset=utf-8", why.line())
}

fn write(stream: &mut TcpStream, line: &str, kind: &str, text: &str) -> std::io::Result<()> {
    let head = format!(
        "HTTP/1.1 {line}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\n{HEADERS}Connection: close\r\n\r\n",
        text.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(text.as_bytes())?;
    stream.flush()
}
