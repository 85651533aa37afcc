//! How the sockets of connections are set.

use std::io;

use socket2::SockRef;
use tokio::net::TcpStream;

/// Bytes of a socket's send buffer. The system would let it grow to megabytes, which is a minute and more of deltas
/// that a client has yet to see when it is found to be too slow.
pub const SEND_BUFFER_SIZE: usize = 64 * 1024;

/// Bytes in a socket's send buffer that were not sent yet, because the client's side has no room for them. Linux keeps twice the
/// send buffer, and accepts all of it from us while the client takes nothing; with this it says after a few deltas that the client lags.
pub const UNSENT_MAX: u32 = 16 * 1024;

/// Sets what the connections of a listening socket inherit.
///
/// # Errors
/// Whatever the operating system says.
pub(crate) fn set_listening<'a>(socket: impl Into<SockRef<'a>>) -> io::Result<()> {
    socket.into().set_send_buffer_size(SEND_BUFFER_SIZE)
}

/// Sets a connection: a small message is sent at once, and what a client does not take is noticed soon.
///
/// # Errors
/// Whatever the operating system says. The connection can be used all the same.
pub(crate) fn set_connected(stream: &TcpStream) -> io::Result<()> {
    stream.set_nodelay(true)?;
    limit_unsent(stream)
}

#[cfg(any(target_os = "android", target_os = "linux"))]
fn limit_unsent(stream: &TcpStream) -> io::Result<()> {
    SockRef::from(stream).set_tcp_notsent_lowat(UNSENT_MAX)
}

/// Elsewhere there is no such option, or none that can be set without unsafe code: [`SEND_BUFFER_SIZE`] alone has to do, and a client
/// that lags is found out by so many bytes later.
#[cfg(not(any(target_os = "android", target_os = "linux")))]
fn limit_unsent(_: &TcpStream) -> io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use tokio::io::AsyncWriteExt;
    use tokio::net::{TcpListener, TcpSocket};

    use super::*;

    #[cfg(target_os = "linux")]
    #[tokio::test]
    async fn a_client_that_takes_nothing_is_noticed_after_a_few_kilobytes() {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let client = TcpSocket::new_v4().unwrap();
        client.set_recv_buffer_size(4096).unwrap();
        let _client = client.connect(listener.local_addr().unwrap()).await.unwrap();
        let (mut stream, _) = listener.accept().await.unwrap();
        set_connected(&stream).unwrap();
        assert!(stream.nodelay().unwrap());
        let mut taken = 0;
        let mut write = async || {
            loop {
                stream.write_all(&[0; 600]).await.unwrap();
                taken += 600;
            }
        };
        let stalled = tokio::time::timeout(std::time::Duration::from_millis(300), write()).await;
        assert!(stalled.is_err());
        println!("{taken} bytes are taken");
        assert!(taken < 40_000, "{taken} bytes are taken");
    }
}
