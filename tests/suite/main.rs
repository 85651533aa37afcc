//! The one test suite of the workspace.
