//! Encrypted connections: a certificate, its key, and who opens connections with them.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;
use tokio::io::{AsyncRead, AsyncWrite};
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
use tokio_rustls::rustls::{self, InconsistentKeys, ServerConfig};
use tokio_rustls::server::TlsStream;

use crate::settings::TlsFiles;

/// Who opens encrypted connections.
#[derive(Clone)]
pub struct Tls(TlsAcceptor);

/// Why TLS cannot be had.
#[derive(Debug, Error)]
pub enum TlsError {
    /// A file that cannot be read.
    #[error("{file} cannot be read: {problem}; name a PEM file that the daemon may read", file = .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// A file that is not PEM.
    #[error("{file} is no PEM file: {problem}", file = .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// What is wrong in it.
        problem: String,
    },
    /// A file without a certificate.
    #[error("there is no certificate in {file}; it needs a block -----BEGIN CERTIFICATE-----", file = .file.display())]
    NoCertificate {
        /// The file.
        file: PathBuf,
    },
    /// A file without a private key.
    #[error(
        "there is no private key in {file}; it needs a block -----BEGIN PRIVATE KEY-----, without a password",
        file = .file.display()
    )]
    NoKey {
        /// The file.
        file: PathBuf,
    },
    /// The key is not that of the certificate.
    #[error(
        "the key in {key} is not that of the first certificate in {certificate}; put the server's own certificate first",
        key = .key.display(), certificate = .certificate.display()
    )]
    OtherKey {
        /// The file of the certificate.
        certificate: PathBuf,
        /// The file of the key.
        key: PathBuf,
    },
    /// A certificate or a key that TLS cannot use.
    #[error(
        "{certificate} and {key} cannot be used: {problem}",
        key = .key.display(), certificate = .certificate.display()
    )]
    Unusable {
        /// The file of the certificate.
        certificate: PathBuf,
        /// The file of the key.
        key: PathBuf,
        /// Why not.
        problem: rustls::Error,
    },
}

/// Reads the files, and returns who opens encrypted connections with them: TLS 1.2 or 1.3, without certificates of clients.
///
/// # Errors
/// See [`TlsError`].
pub fn acceptor(files: &TlsFiles) -> Result<Tls, TlsError> {
    let TlsFiles { certificate, key } = files;
    let chain = certificates(certificate)?;
    let private = private_key(key)?;
    let config = ServerConfig::builder_with_provider(Arc::new(ring::default_provider()))
        .with_safe_default_protocol_versions()
        .expect("the provider can do all versions")
        .with_no_client_auth()
        .with_single_cert(chain, private);
    let config = config.map_err(|problem| {
        let (certificate, key) = (certificate.clone(), key.clone());
        if problem == rustls::Error::InconsistentKeys(InconsistentKeys::KeyMismatch) {
            TlsError::OtherKey { certificate, key }
        } else {
            TlsError::Unusable { certificate, key, problem }
        }
    })?;
    Ok(Tls(TlsAcceptor::from(Arc::new(config))))
}

impl Tls {
    /// Opens an encrypted connection over one that is not.
    pub(crate) async fn accept<S: AsyncRead + AsyncWrite + Unpin>(
        &self,
        stream: S,
    ) -> io::Result<TlsStream<S>> {
        self.0.accept(stream).await
    }
}

/// Without the key.
impl std::fmt::Debug for Tls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Tls")
    }
}

fn certificates(file: &Path) -> Result<Vec<CertificateDer<'static>>, TlsError> {
    let read = CertificateDer::pem_file_iter(file).map_err(|error| unreadable(file, error))?;
    let chain = read.collect::<Result<Vec<_>, _>>().map_err(|error| unreadable(file, error))?;
    if chain.is_empty() { Err(TlsError::NoCertificate { file: file.to_owned() }) } else { Ok(chain) }
}

fn private_key(file: &Path) -> Result<PrivateKeyDer<'static>, TlsError> {
    PrivateKeyDer::from_pem_file(file).map_err(|error| {
        if matches!(error, pem::Error::NoItemsFound) {
            TlsError::NoKey { file: file.to_owned() }
        } else {
            unreadable(file, error)
        }
    })
}

fn unreadable(file: &Path, error: pem::Error) -> TlsError {
    let (file, problem) = (file.to_owned(), error.to_string());
    if let pem::Error::Io(problem) = error {
        TlsError::Unreadable { file, problem }
    } else {
        TlsError::Malformed { file, problem }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use rcgen::{CertifiedKey, KeyPair, generate_simple_self_signed};
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::{TcpListener, TcpStream};
    use tokio::time::{Instant, timeout};
    use tokio_rustls::TlsConnector;
    use tokio_rustls::rustls::pki_types::ServerName;
    use tokio_rustls::rustls::{ClientConfig, RootCertStore};
    use tokio_util::sync::CancellationToken;

    use super::*;
    use crate::connection::HELLO_TIMEOUT;
    use crate::limits::Limits;
    use crate::operation::{Entry, Operated};
    use crate::server::House;

    #[tokio::test]
    async fn a_client_that_trusts_the_certificate_talks_over_loopback_and_another_does_not() {
        let folder = Folder::new("handshake");
        let made = certificate();
        let files = folder.files(&made.cert.pem(), &made.signing_key.serialize_pem());
        let acceptor = acceptor(&files).unwrap();
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let server = tokio::spawn(async move {
            let mut outcomes = Vec::new();
            for _ in 0..3 {
                let (stream, _) = listener.accept().await.unwrap();
                let Ok(mut stream) = acceptor.accept(stream).await else {
                    outcomes.push(false);
                    continue;
                };
                // Who does not trust the certificate says so in TLS 1.3 after the server's part of the handshake.
                let mut said = [0; 4];
                outcomes.push(stream.read_exact(&mut said).await.is_ok());
                let _ = stream.write_all(&said).await;
                let _ = stream.shutdown().await;
            }
            outcomes
        });
        let talk = |trusted: CertificateDer<'static>| async move {
            let stream = TcpStream::connect(address).await.unwrap();
            let name = ServerName::try_from("localhost").unwrap();
            let mut stream = connector(trusted).connect(name, stream).await?;
            stream.write_all(b"ping").await?;
            let mut heard = String::new();
            stream.read_to_string(&mut heard).await?;
            Ok::<_, io::Error>(heard)
        };
        assert_eq!(talk(made.cert.der().clone()).await.unwrap(), "ping");
        let error = talk(certificate().cert.der().clone()).await.unwrap_err().to_string();
        assert!(error.contains("invalid peer certificate"), "{error}");
        // Who does not encrypt gets nothing.
        let mut plain = TcpStream::connect(address).await.unwrap();
        plain.write_all(b"MANIPLE1 and more than a record of TLS has").await.unwrap();
        let mut heard = Vec::new();
        let _ = plain.read_to_end(&mut heard).await;
        assert!(!heard.windows(4).any(|window| window == b"MANI"), "{heard:?}");
        assert_eq!(server.await.unwrap(), [true, false, false]);
    }

    #[tokio::test(start_paused = true)]
    async fn a_handshake_has_so_much_time_and_who_is_refused_gets_none() {
        let folder = Folder::new("refused");
        let made = certificate();
        let files = folder.files(&made.cert.pem(), &made.signing_key.serialize_pem());
        let limits = Limits { connections_per_address: 1, ..Limits::default() };
        let house =
            House::new(limits, BTreeMap::new(), None, 0).unwrap().encrypted(acceptor(&files).unwrap());
        let connector = connector(made.cert.der().clone());
        let come = |from: &str| {
            let (nearby, far) = tokio::io::duplex(1024);
            house.receive(nearby, from.parse().unwrap(), &CancellationToken::new());
            far
        };
        // Who says nothing, and who says it bit by bit.
        for first in [&b""[..], b"\x16\x03\x01\x02\x00"] {
            let mut slow = come("192.0.2.1:1");
            let begun = Instant::now();
            slow.write_all(first).await.unwrap();
            let mut heard = Vec::new();
            let closed = timeout(2 * HELLO_TIMEOUT, slow.read_to_end(&mut heard)).await;
            assert!(closed.is_ok_and(|read| read.is_ok()), "it is closed");
            assert_eq!((begun.elapsed(), heard), (HELLO_TIMEOUT, vec![]));
        }
        let name = ServerName::try_from("localhost").unwrap();
        let connect = |far| connector.connect(name.clone(), far);
        let _in = connect(come("192.0.2.1:2")).await.unwrap();
        house.ban("192.0.2.2".parse().unwrap(), Entry::Denied).unwrap();
        for refused in ["192.0.2.1:3", "192.0.2.2:1"] {
            assert!(connect(come(refused)).await.is_err(), "{refused}");
        }
        assert!(connect(come("192.0.2.3:1")).await.is_ok());
    }

    #[test]
    fn every_mistake_names_the_file_and_the_remedy() {
        let folder = Folder::new("mistakes");
        let made = certificate();
        let (pem, key) = (made.cert.pem(), made.signing_key.serialize_pem());
        let other = KeyPair::generate().unwrap().serialize_pem();
        let at = |name: &str| folder.0.join(name).display().to_string();
        let (c, k) = (at("certificate.pem"), at("key.pem"));
        for (pem, key, expected) in [
            (
                "",
                &*key,
                format!("there is no certificate in {c}; it needs a block -----BEGIN CERTIFICATE-----"),
            ),
            (
                &*pem,
                "",
                format!(
                    "there is no private key in {k}; it needs a block -----BEGIN PRIVATE KEY-----, without a password"
                ),
            ),
            (
                &*pem,
                &*other,
                format!(
                    "the key in {k} is not that of the first certificate in {c}; put the server's own certificate first"
                ),
            ),
        ] {
            let files = folder.files(pem, key);
            assert_eq!(acceptor(&files).err().unwrap().to_string(), expected);
        }
        let broken = &pem[..pem.len() / 2];
        let error = acceptor(&folder.files(broken, &key)).err().unwrap();
        assert!(
            matches!(&error, TlsError::Malformed { file, .. } if file.ends_with("certificate.pem")),
            "{error}"
        );
        let error =
            acceptor(&folder.files(&pem, "-----BEGIN PRIVATE KEY-----\nAAAA\n-----END PRIVATE KEY-----\n"));
        assert!(matches!(error.err().unwrap(), TlsError::Unusable { .. }));
        let missing = TlsFiles { certificate: folder.0.join("none.pem"), key: folder.0.join("key.pem") };
        let error = acceptor(&missing).err().unwrap().to_string();
        assert!(error.starts_with(&format!("{} cannot be read: ", at("none.pem"))), "{error}");
        assert!(error.ends_with("; name a PEM file that the daemon may read"), "{error}");
    }

    fn certificate() -> CertifiedKey<KeyPair> {
        generate_simple_self_signed(["localhost".to_owned()]).unwrap()
    }

    /// Returns who opens connections to servers with this certificate alone.
    fn connector(trusted: CertificateDer<'static>) -> TlsConnector {
        let mut roots = RootCertStore::empty();
        roots.add(trusted).unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        TlsConnector::from(Arc::new(config))
    }

    /// A folder of a test's own, which is gone when it is dropped.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("maniple-tls-{name}-{}", std::process::id()));
            fs::create_dir_all(&folder).unwrap();
            Self(folder)
        }

        fn files(&self, certificate: &str, key: &str) -> TlsFiles {
            let files = TlsFiles { certificate: self.0.join("certificate.pem"), key: self.0.join("key.pem") };
            fs::write(&files.certificate, certificate).unwrap();
            fs::write(&files.key, key).unwrap();
            files
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            let _ = fs::remove_dir_all(&self.0);
        }
    }
}
