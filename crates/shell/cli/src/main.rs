//! The command `maniple`.
fn main() {}
