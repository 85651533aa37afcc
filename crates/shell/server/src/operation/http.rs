//! Health, metrics and matches over HTTP, for those who watch the daemon.

use std::convert::Infallible;
use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use hyper::body::Incoming;
use hyper::header::{ALLOW, CACHE_CONTROL, CONTENT_TYPE, HeaderValue};
use hyper::server::conn::http1;
use hyper::service::service_fn;
use hyper::{Method, Request, Response, StatusCode};
use hyper_util::rt::TokioIo;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;
use tokio::time::timeout;

use super::Operated;
use crate::metrics::Metrics;

/// Connections at the same time; more wait in the backlog of the socket. Those who ask are a few machines.
pub const HTTP_CONNECTIONS_MAX: usize = 32;

/// Time for a request and its answer: one a connection.
pub const HTTP_TIMEOUT: Duration = Duration::from_secs(5);

/// Bytes of a request at most; hyper permits no less.
pub const HTTP_REQUEST_MAX: usize = 8 * 1024;

/// Pause after a connection could not be accepted.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

const TEXT: &str = "text/plain; charset=utf-8";
const JSON: &str = "application/json";
const OPEN_METRICS: &str = "application/openmetrics-text; version=1.0.0; charset=utf-8";

/// A socket on which the daemon is asked how it is.
#[derive(Debug)]
pub struct HttpServer {
    listener: TcpListener,
}

impl HttpServer {
    /// Returns a server that listens; port 0 is any that is free.
    ///
    /// # Errors
    /// An address that cannot be had.
    pub async fn bind(address: SocketAddr) -> io::Result<Self> {
        Ok(Self { listener: TcpListener::bind(address).await? })
    }

    /// Returns the address on which it listens.
    ///
    /// # Errors
    /// Whatever the operating system says.
    pub fn local_addr(&self) -> io::Result<SocketAddr> {
        self.listener.local_addr()
    }

    /// Answers until it is dropped.
    pub async fn run(self, daemon: Arc<dyn Operated>, metrics: Arc<Metrics>) {
        let slots = Arc::new(Semaphore::new(HTTP_CONNECTIONS_MAX));
        loop {
            let slot = Arc::clone(&slots).acquire_owned().await.expect("the semaphore is never closed");
            match self.listener.accept().await {
                Ok((stream, _)) => {
                    let (daemon, metrics) = (Arc::clone(&daemon), Arc::clone(&metrics));
                    tokio::spawn(async move {
                        // Who is too slow, or speaks no HTTP, is of no interest.
                        let _ = timeout(HTTP_TIMEOUT, serve(stream, daemon, metrics)).await;
                        drop(slot);
                    });
                }
                Err(error) => {
                    tracing::warn!(%error, "a connection for HTTP could not be accepted");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    }
}

async fn serve(stream: TcpStream, daemon: Arc<dyn Operated>, metrics: Arc<Metrics>) -> hyper::Result<()> {
    let answer = service_fn(move |request: Request<Incoming>| {
        let response = answer(request.method(), request.uri().path(), &*daemon, &metrics);
        async move { Ok::<_, Infallible>(response) }
    });
    http1::Builder::new()
        .keep_alive(false)
        .max_buf_size(HTTP_REQUEST_MAX)
        .serve_connection(TokioIo::new(stream), answer)
        .await
}

/// Returns the answer to a request.
fn answer(method: &Method, path: &str, daemon: &dyn Operated, metrics: &Arc<Metrics>) -> Response<String> {
    let health = daemon.health();
    let said = |is_good, what: &str| {
        let status = if is_good { StatusCode::OK } else { StatusCode::SERVICE_UNAVAILABLE };
        response(status, TEXT, format!("{what}\n"))
    };
    let told = serde_json::to_value(health).expect("a word is JSON");
    let told = told.as_str().expect("health is a word");
    let found = match path {
        "/healthz" => said(health.is_alive(), told),
        "/readyz" => said(health.is_ready(), told),
        "/metrics" => response(StatusCode::OK, OPEN_METRICS, metrics.text()),
        "/matches" => {
            let matches = serde_json::to_string(&daemon.matches()).expect("a status is JSON");
            response(StatusCode::OK, JSON, matches + "\n")
        }
        _ => {
            let known = "there are /healthz, /readyz, /metrics and /matches\n";
            return response(StatusCode::NOT_FOUND, TEXT, known.to_owned());
        }
    };
    if *method == Method::GET || *method == Method::HEAD {
        return found;
    }
    let mut refused = response(StatusCode::METHOD_NOT_ALLOWED, TEXT, "use GET\n".to_owned());
    refused.headers_mut().insert(ALLOW, HeaderValue::from_static("GET, HEAD"));
    refused
}

fn response(status: StatusCode, kind: &'static str, body: String) -> Response<String> {
    let mut response = Response::new(body);
    *response.status_mut() = status;
    response.headers_mut().insert(CONTENT_TYPE, HeaderValue::from_static(kind));
    response.headers_mut().insert(CACHE_CONTROL, HeaderValue::from_static("no-store"));
    response
}

#[cfg(test)]
mod tests;
