//! Reads from a connection without a buffer of its own: thousands of them say nothing most of the time.

use std::future::poll_fn;
use std::io;
use std::mem::MaybeUninit;
use std::pin::Pin;
use std::task::{Context, Poll, ready};

use tokio::io::{AsyncRead, ReadBuf};

/// Bytes that are read at once: half of the largest message, which is rare.
const READ_SIZE: usize = 8 * 1024;

/// Waits for bytes and hands them over. Returns how many came; 0: nothing comes any more.
pub(crate) async fn read(
    half: &mut (impl AsyncRead + Unpin),
    mut take: impl FnMut(&[u8]),
) -> io::Result<usize> {
    poll_fn(|context| poll_read(half, context, &mut take)).await
}

/// The buffer is on the stack of the thread: it is gone while the connection waits.
fn poll_read(
    half: &mut (impl AsyncRead + Unpin),
    context: &mut Context<'_>,
    take: &mut impl FnMut(&[u8]),
) -> Poll<io::Result<usize>> {
    let mut space = [const { MaybeUninit::uninit() }; READ_SIZE];
    let mut buffer = ReadBuf::uninit(&mut space);
    ready!(Pin::new(half).poll_read(context, &mut buffer))?;
    take(buffer.filled());
    Poll::Ready(Ok(buffer.filled().len()))
}

#[cfg(test)]
mod tests {
    use tokio::io::AsyncWriteExt;

    use super::*;

    #[tokio::test]
    async fn all_bytes_come_in_their_order_and_then_none() {
        let (mut nearby, mut far) = tokio::io::duplex(3 * READ_SIZE);
        let sent: Vec<u8> = (0..=255).cycle().take(2 * READ_SIZE + 7).collect();
        far.write_all(&sent).await.unwrap();
        drop(far);
        let mut came = Vec::new();
        while read(&mut nearby, |bytes| came.extend_from_slice(bytes)).await.unwrap() > 0 {}
        assert_eq!(came, sent);
    }
}
