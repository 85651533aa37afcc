//! A connection that is counted.

use std::io;
use std::pin::Pin;
use std::sync::Arc;
use std::task::{Context, Poll};

use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};

use super::Metrics;

/// A stream whose bytes are counted in both directions, and which is a connection as long as it lives.
#[derive(Debug)]
pub(crate) struct Counted<S> {
    stream: S,
    metrics: Arc<Metrics>,
}

impl<S> Counted<S> {
    /// Returns the stream as a connection.
    pub(crate) fn new(stream: S, metrics: Arc<Metrics>) -> Self {
        metrics.connections.change(1);
        Self { stream, metrics }
    }

    fn count_sent(&self, written: Poll<io::Result<usize>>) -> Poll<io::Result<usize>> {
        if let Poll::Ready(Ok(count)) = written {
            self.metrics.bytes_sent.add(count_of(count));
        }
        written
    }
}

impl<S> Drop for Counted<S> {
    fn drop(&mut self) {
        self.metrics.connections.change(-1);
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Counted<S> {
    fn poll_read(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        let before = buffer.filled().len();
        let read = Pin::new(&mut self.stream).poll_read(context, buffer);
        self.metrics.bytes_received.add(count_of(buffer.filled().len() - before));
        read
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Counted<S> {
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
        let mut near = Counted::new(near, Arc::clone(&metrics));
        assert_eq!(metrics.connections.value(), 1);
        near.write_all(b"twelve bytes").await.unwrap();
        far.write_all(b"four").await.unwrap();
        near.read_exact(&mut [0; 4]).await.unwrap();
        assert_eq!((metrics.bytes_sent.value(), metrics.bytes_received.value()), (12, 4));
        drop(near);
        assert_eq!(metrics.connections.value(), 0);
    }
}
