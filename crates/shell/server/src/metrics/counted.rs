//! Connections that are counted.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::Metrics;

/// Who counts the bytes of a connection.
pub trait Traffic {
    /// Takes note of bytes that have come.
    fn note_received(&self, bytes: u64);

    /// Takes note of bytes that the system has taken.
    fn note_sent(&self, bytes: u64);
}

/// A stream whose bytes are counted in both directions.
#[derive(Debug)]
pub struct Counted<S, T> {
    stream: S,
    traffic: T,
}

/// An open connection of a daemon, which is one as long as it lives.
#[derive(Debug)]
pub(crate) struct Connected(Arc<Metrics>);

impl<S, T: Traffic> Counted<S, T> {
    /// Returns the stream with who counts its bytes.
    pub fn new(stream: S, traffic: T) -> Self {
        Self { stream, traffic }
    }

    fn count_sent(&self, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if let Poll::Ready(Ok(count)) = written {
            self.traffic.note_sent(count_of(count));
        }
        written
    }
}

impl Connected {
    pub(crate) fn new(metrics: Arc<Metrics>) -> Self {
        metrics.connections.change(1);
        Self(metrics)
    }
}

impl Traffic for Connected {
    fn note_received(&self, bytes: u64) {
        self.0.bytes_received.add(bytes);
    }

    fn note_sent(&self, bytes: u64) {
        self.0.bytes_sent.add(bytes);
    }
}

impl Drop for Connected {
    fn drop(&mut self) {
        self.0.connections.change(-1);
    }
}

impl<S: AsyncRead + Unpin, T: Traffic + Unpin> AsyncRead for Counted<S, T> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.traffic.note_received(count_of(buffer.filled().len() - before));
        read
    }
}

impl<S: AsyncWrite + Unpin, T: Traffic + Unpin> AsyncWrite for Counted<S, T> {
    fn poll_write(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[u8],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.count_sent(written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        bytes: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, bytes);
        self.count_sent(written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

fn count_of(bytes: usize) -> u64 {
    u64::try_from(bytes).expect("a length has at most 64 bits")
}

#[cfg(test)]
mod tests {
    use tokio::io::{AsyncReadExt, AsyncWriteExt};

    use super::*;

    #[tokio::test]
    async fn bytes_are_counted_as_often_as_they_go() {
        let metrics = Arc::new(Metrics::default());
        let (near, mut far) = tokio::io::duplex(64);
        let mut near = Counted::new(near, Connected::new(Arc::clone(&metrics)));
        assert_eq!(metrics.connections.value(), 1);
        near.write_all(b"twelve bytes").await.unwrap();
        far.write_all(b"four").await.unwrap();
        near.read_exact(&mut [0; 4]).await.unwrap();
        assert_eq!((metrics.bytes_sent.value(), metrics.bytes_received.value()), (12, 4));
        drop(near);
        assert_eq!(metrics.connections.value(), 0);
    }
}
