//! Those who mean it ill. Each does one thing, and comes again when it is sent away.

use std::time::Duration;

use maniple_protocol::{ClientMessage, Encoding, encode_client};
use maniple_view::Digest;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::time::sleep;

use super::crowd::watch;

/// Time before one that was sent away comes again.
const PAUSE: Duration = Duration::from_millis(200);

/// Pings that are sent in one piece.
const PINGS: u32 = 200;

/// Does harm for ever; the number says which: to watch and never read, to flood, to talk nonsense, to say nothing, or to say a byte
/// at a time.
pub(super) async fn beset(address: String, number: usize, ids: Vec<Digest>) {
    let id = ids[number % ids.len()];
    loop {
        // That it fails is what the daemon is for.
        let _ = match number % 5 {
            0 => stall(&address, id).await,
            1 => flood(&address, id).await,
            2 => babble(&address).await,
            3 => keep_silent(&address).await,
            _ => drip(&address, id).await,
        };
        sleep(PAUSE).await;
    }
}

async fn stall(address: &str, id: Digest) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(address).await?;
    stream.write_all(&watch(id)?).await?;
    // Until what it does not read has filled all there is, and it is found out.
    while stream.write_all(&encode_client(Encoding::Binary, &ClientMessage::Ping { id: 0 })?).await.is_ok() {
        sleep(Duration::from_secs(5)).await;
    }
    Ok(())
}

async fn flood(address: &str, id: Digest) -> anyhow::Result<()> {
    let stream = TcpStream::connect(address).await?;
    let (mut reader, mut writer) = stream.into_split();
    writer.write_all(&watch(id)?).await?;
    let mut pings = Vec::new();
    for id in 0..PINGS {
        pings.extend(encode_client(Encoding::Binary, &ClientMessage::Ping { id })?);
    }
    let read = async {
        let mut buffer = [0; 1024];
        while let Ok(1..) = reader.read(&mut buffer).await {}
    };
    let write = async { while writer.write_all(&pings).await.is_ok() {} };
    tokio::select! {
        () = read => {}
        () = write => {}
    }
    Ok(())
}

async fn babble(address: &str) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(address).await?;
    stream.write_all(b"MNPL\xff\xff\xff\x7fI am a frame of two gigabytes").await?;
    stream.read_to_end(&mut Vec::new()).await?;
    Ok(())
}

async fn keep_silent(address: &str) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(address).await?;
    stream.read_to_end(&mut Vec::new()).await?;
    Ok(())
}

async fn drip(address: &str, id: Digest) -> anyhow::Result<()> {
    let mut stream = TcpStream::connect(address).await?;
    stream.set_nodelay(true)?;
    for byte in watch(id)? {
        stream.write_all(&[byte]).await?;
        sleep(Duration::from_millis(300)).await;
    }
    stream.read_to_end(&mut Vec::new()).await?;
    Ok(())
}
