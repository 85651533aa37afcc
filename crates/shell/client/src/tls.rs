//! Whom a client believes to be its server.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use thiserror::Error;
use tokio::net::TcpStream;
use tokio_rustls::TlsConnector;
use tokio_rustls::client::TlsStream;
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, ServerName};
use tokio_rustls::rustls::{self, ClientConfig, RootCertStore};

/// How a client checks the server: the name that its certificate has to have, and who has to vouch for it.
#[derive(Clone)]
pub struct Tls {
    connector: TlsConnector,
    name: ServerName<'static>,
}

/// Why a client cannot check servers.
#[derive(Debug, Error)]
pub enum TlsError {
    /// No certificate can have this name.
    #[error("{name:?} is neither a host name nor an IP address; give the name in the server's certificate")]
    Name {
        /// The name.
        name: String,
    },
    /// A file that cannot be read.
    #[error("{file} cannot be read: {problem}; name a PEM file", file = .file.display())]
    Unreadable {
        /// The file.
        file: PathBuf,
        /// What the system says.
        problem: io::Error,
    },
    /// A file that is not PEM, or holds a certificate that nobody can vouch with.
    #[error("{file} cannot be used: {problem}", file = .file.display())]
    Malformed {
        /// The file.
        file: PathBuf,
        /// What is wrong in it.
        problem: String,
    },
    /// Nobody can vouch for the server.
    #[error(
        "there is no certificate in {place}; name a file with the server's own, or that of who vouches for it"
    )]
    Nobody {
        /// Where they were looked for.
        place: String,
    },
}

impl Tls {
    /// Returns a check of servers: the certificate has to be for `name`, a host name or an IP address, and in the PEM file
    /// `authority`, or vouched for by one that is; without a file, by one that the system trusts.
    ///
    /// # Errors
    /// See [`TlsError`].
    pub fn new(name: &str, authority: Option<&Path>) -> Result<Self, TlsError> {
        let roots = match authority {
            Some(file) => roots_in(file)?,
            None => roots_of_the_system()?,
        };
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .expect("the provider can do all versions")
            .with_root_certificates(roots)
            .with_no_client_auth();
        let name =
            ServerName::try_from(name.to_owned()).map_err(|_| TlsError::Name { name: name.to_owned() })?;
        Ok(Self { connector: TlsConnector::from(Arc::new(config)), name })
    }

    /// Begins to encrypt a connection.
    pub(crate) async fn open(&self, stream: TcpStream) -> io::Result<TlsStream<TcpStream>> {
        self.connector.connect(self.name.clone(), stream).await
    }
}

impl std::fmt::Debug for Tls {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Tls").field("name", &self.name).finish_non_exhaustive()
    }
}

fn roots_in(file: &Path) -> Result<RootCertStore, TlsError> {
    let failed = |error: pem::Error| {
        let (file, problem) = (file.to_owned(), error.to_string());
        if let pem::Error::Io(problem) = error {
            TlsError::Unreadable { file, problem }
        } else {
            TlsError::Malformed { file, problem }
        }
    };
    let mut roots = RootCertStore::empty();
    for certificate in CertificateDer::pem_file_iter(file).map_err(failed)? {
        let added = roots.add(certificate.map_err(failed)?);
        added.map_err(|error: rustls::Error| TlsError::Malformed {
            file: file.to_owned(),
            problem: error.to_string(),
        })?;
    }
    if roots.is_empty() { Err(TlsError::Nobody { place: file.display().to_string() }) } else { Ok(roots) }
}

fn roots_of_the_system() -> Result<RootCertStore, TlsError> {
    let mut roots = RootCertStore::empty();
    // Systems hold certificates that are of no use here; those that are have to be some.
    roots.add_parsable_certificates(rustls_native_certs::load_native_certs().certs);
    if roots.is_empty() { Err(TlsError::Nobody { place: "the system".to_owned() }) } else { Ok(roots) }
}
