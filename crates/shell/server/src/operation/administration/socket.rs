//! The socket of the administration, at both ends, and the file with its token.

use std::fs;
use std::io::{self, BufRead, BufReader, Write};
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt, PermissionsExt};
use std::os::unix::net::UnixStream as StdStream;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use serde_json::Value;
use thiserror::Error;
use tokio::io::{AsyncBufReadExt, AsyncReadExt, AsyncWriteExt, BufStream};
use tokio::net::{UnixListener, UnixStream};
use tokio::sync::Semaphore;
use tokio::time::timeout;

use super::{AdminError, AdminRequest, Administration, Verb, refusal};
use crate::token::Token;

/// Bytes of a request at most: many times the longest.
pub const ADMIN_LINE_MAX: usize = 4 * 1024;

/// Connections at the same time; more wait.
pub const ADMIN_CONNECTIONS_MAX: usize = 8;

/// Time for a request, and for its answer to be taken, before the connection is closed.
pub const ADMIN_TIMEOUT: Duration = Duration::from_secs(30);

/// Pause after a connection could not be accepted.
const ACCEPT_PAUSE: Duration = Duration::from_millis(100);

/// Why the administration cannot begin.
#[derive(Debug, Error)]
pub enum AdminSocketError {
    /// The socket cannot be made.
    #[error("the socket of the administration cannot be made at {path}: {problem}", path = .path.display())]
    Bind {
        /// Its path.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// Another daemon listens there.
    #[error("another daemon listens at {path}; give this one another listen.admin_socket", path = .path.display())]
    InUse {
        /// The path.
        path: PathBuf,
    },
    /// Something else is there.
    #[error("{path} is no socket, and is left alone; give another listen.admin_socket", path = .path.display())]
    NoSocket {
        /// The path.
        path: PathBuf,
    },
    /// The file with the token cannot be used.
    #[error("the token of the administration in {path}: {problem}", path = .path.display())]
    TokenFile {
        /// The file.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// There is no token in the file.
    #[error("{path} holds no token; it has to hold 32 hex digits, or be deleted: then it is made anew", path = .path.display())]
    NoToken {
        /// The file.
        path: PathBuf,
    },
    /// Others may read the file with the token.
    #[error("others than the owner may read {path}; run `chmod 600` on it", path = .path.display())]
    Readable {
        /// The file.
        path: PathBuf,
    },
}

/// Returns the token of the administration from its file; where there is none, makes it.
///
/// # Errors
/// A file that cannot be read or written, holds no token, or can be read by others.
pub fn admin_token(path: &Path) -> Result<Token, AdminSocketError> {
    let failed = |problem| AdminSocketError::TokenFile { path: path.to_owned(), problem };
    match read_admin_token(path) {
        Err(AdminSocketError::TokenFile { problem, .. }) if problem.kind() == io::ErrorKind::NotFound => {}
        read => return read,
    }
    let token = Token::random().map_err(|error| failed(io::Error::other(error)))?;
    let mut file =
        fs::OpenOptions::new().write(true).create_new(true).mode(0o600).open(path).map_err(failed)?;
    writeln!(file, "{token}").map_err(failed)?;
    Ok(token)
}

/// Returns the token of the administration from its file.
///
/// # Errors
/// A file that cannot be read, holds no token, or can be read by others.
pub fn read_admin_token(path: &Path) -> Result<Token, AdminSocketError> {
    let path = path.to_owned();
    let text =
        fs::read_to_string(&path).and_then(|text| Ok((text, fs::metadata(&path)?.permissions().mode())));
    match text {
        Err(problem) => Err(AdminSocketError::TokenFile { path, problem }),
        Ok((_, mode)) if mode & 0o077 != 0 => Err(AdminSocketError::Readable { path }),
        Ok((text, _)) => text.trim_end().parse().map_err(|_| AdminSocketError::NoToken { path }),
    }
}

/// The socket of the administration. It is gone when this is dropped.
#[derive(Debug)]
pub struct AdminServer {
    listener: UnixListener,
    path: PathBuf,
}

impl AdminServer {
    /// Returns a server that listens, for the owner alone. What a daemon that was killed has left there is cleared away.
    ///
    /// # Errors
    /// A path where no socket can be, or something else is.
    pub fn bind(path: &Path) -> Result<Self, AdminSocketError> {
        let failed = |problem| AdminSocketError::Bind { path: path.to_owned(), problem };
        if let Ok(found) = fs::symlink_metadata(path) {
            if !found.file_type().is_socket() {
                return Err(AdminSocketError::NoSocket { path: path.to_owned() });
            }
            if StdStream::connect(path).is_ok() {
                return Err(AdminSocketError::InUse { path: path.to_owned() });
            }
            fs::remove_file(path).map_err(failed)?;
        }
        let listener = UnixListener::bind(path).map_err(failed)?;
        fs::set_permissions(path, fs::Permissions::from_mode(0o600)).map_err(failed)?;
        Ok(Self { listener, path: path.to_owned() })
    }

    /// Answers until it is dropped.
    pub async fn run(self, administration: Arc<Administration>) {
        let slots = Arc::new(Semaphore::new(ADMIN_CONNECTIONS_MAX));
        loop {
            let slot = Arc::clone(&slots).acquire_owned().await.expect("the semaphore is never closed");
            match self.listener.accept().await {
                Ok((stream, _)) => {
                    let administration = Arc::clone(&administration);
                    tokio::spawn(async move {
                        // Who has gone before the answer does not want it.
                        let _ = serve(stream, &administration).await;
                        drop(slot);
                    });
                }
                Err(error) => {
                    tracing::warn!(%error, "a connection of the administration could not be accepted");
                    tokio::time::sleep(ACCEPT_PAUSE).await;
                }
            }
        }
    }
}

impl Drop for AdminServer {
    fn drop(&mut self) {
        // It may be gone already; then there is nothing to do.
        let _ = fs::remove_file(&self.path);
    }
}

/// Answers a line by a line until there is none.
async fn serve(stream: UnixStream, administration: &Administration) -> io::Result<()> {
    let mut stream = BufStream::new(stream);
    loop {
        let mut line = Vec::new();
        // One more for the line end, and one more to see that it is too long.
        let limit = u64::try_from(ADMIN_LINE_MAX + 2).expect("the limit is small");
        let mut limited = (&mut stream).take(limit);
        if timeout(ADMIN_TIMEOUT, limited.read_until(b'\n', &mut line)).await?? == 0 {
            return Ok(());
        }
        let is_whole = line.pop_if(|byte| *byte == b'\n').is_some();
        let is_too_long = line.len() > ADMIN_LINE_MAX;
        let answer = if is_too_long {
            refusal(AdminError::TooLong { limit: ADMIN_LINE_MAX })
        } else {
            administration.answer(&line).await
        };
        let mut text = serde_json::to_vec(&answer).map_err(io::Error::other)?;
        text.push(b'\n');
        let write = async {
            stream.write_all(&text).await?;
            stream.flush().await
        };
        timeout(ADMIN_TIMEOUT, write).await??;
        if is_too_long || !is_whole {
            return Ok(());
        }
    }
}

/// Why the administration of a daemon cannot be asked.
#[derive(Debug, Error)]
pub enum AdminClientError {
    /// No daemon is there.
    #[error("no daemon answers at {path}: {problem}; name the socket that listen.admin_socket of the daemon names", path = .path.display())]
    Unreachable {
        /// The socket.
        path: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// The daemon has gone, or is none.
    #[error("the daemon gave no answer: {0}")]
    NoAnswer(io::Error),
    /// The daemon says no.
    #[error("{0}")]
    Refused(String),
}

/// Who asks the administration of a daemon.
#[derive(Debug)]
pub struct AdminClient {
    stream: BufReader<StdStream>,
}

impl AdminClient {
    /// Connects.
    ///
    /// # Errors
    /// No daemon is there.
    pub fn connect(path: &Path) -> Result<Self, AdminClientError> {
        let opened = StdStream::connect(path).and_then(|stream| {
            stream.set_read_timeout(Some(ADMIN_TIMEOUT))?;
            stream.set_write_timeout(Some(ADMIN_TIMEOUT))?;
            Ok(stream)
        });
        let stream =
            opened.map_err(|problem| AdminClientError::Unreachable { path: path.to_owned(), problem })?;
        Ok(Self { stream: BufReader::new(stream) })
    }

    /// Asks, and returns what there is to tell, as JSON.
    ///
    /// # Errors
    /// A daemon that refuses, or gives no answer.
    pub fn ask(&mut self, token: &str, verb: Verb) -> Result<Value, AdminClientError> {
        let request = AdminRequest { token: token.to_owned(), verb };
        let mut line = serde_json::to_vec(&request).expect("a request is JSON");
        line.push(b'\n');
        let mut answer = String::new();
        let asked = self.stream.get_mut().write_all(&line).and_then(|()| self.stream.read_line(&mut answer));
        asked.map_err(AdminClientError::NoAnswer)?;
        let mut answer: Value =
            serde_json::from_str(&answer).map_err(|error| AdminClientError::NoAnswer(error.into()))?;
        match answer.get_mut("ok") {
            Some(ok) => Ok(ok.take()),
            None => Err(AdminClientError::Refused(answer["message"].as_str().unwrap_or_default().to_owned())),
        }
    }
}
