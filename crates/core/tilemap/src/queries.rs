//! The queries that are published with MovingAI maps: `.scen` files (Sturtevant, *Benchmarks for Grid-Based Pathfinding*, 2012).

use thiserror::Error;

/// Most queries in a file, so that what is read is bounded.
const QUERIES_MAX: usize = 1 << 20;

/// From where to where, and how far it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Query {
    /// The file of the map, as written.
    pub map: String,
    /// Width and height of the map, in tiles.
    pub size: (u32, u32),
    /// Column and row of the first tile.
    pub start: (u32, u32),
    /// Column and row of the last tile.
    pub goal: (u32, u32),
    /// The length of a shortest way in eight directions, corners not cut, in tiles.
    pub length: f64,
}

/// Why queries could not be read. The caller adds the name of the file.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
pub enum QueryError {
    /// The first line is not that of such a file.
    #[error("line 1: expected `version 1`, found {found:?}")]
    Version {
        /// What is there.
        found: String,
    },
    /// A line has not the nine fields of a query.
    #[error(
        "line {line}: expected bucket, map, width, height, start x, start y, goal x, goal y and length, found {found:?}"
    )]
    Fields {
        /// The line, from 1.
        line: usize,
        /// What is there.
        found: String,
    },
    /// An end is not on the map.
    #[error("line {line}: ({x}, {y}) is not on the map of {width} x {height} tiles")]
    Outside {
        /// The line, from 1.
        line: usize,
        /// The column.
        x: u32,
        /// The row.
        y: u32,
        /// The width that the line says.
        width: u32,
        /// The height that the line says.
        height: u32,
    },
    /// More lines than are read.
    #[error("line {line}: a file has at most {QUERIES_MAX} queries; split it")]
    TooMany {
        /// The line, from 1.
        line: usize,
    },
}

/// Returns the queries of a `.scen` file, in their order; blank lines are none.
///
/// # Errors
/// See [`QueryError`].
pub fn read_queries(bytes: &[u8]) -> Result<Vec<Query>, QueryError> {
    let text = String::from_utf8_lossy(bytes);
    let mut lines = (1..).zip(text.trim_start_matches('\u{feff}').lines());
    let (_, first) = lines.next().unwrap_or((1, ""));
    if !matches!(first.split_ascii_whitespace().collect::<Vec<_>>()[..], ["version", "1" | "1.0"]) {
        return Err(QueryError::Version { found: excerpt(first) });
    }
    let mut queries = Vec::new();
    for (line, text) in lines.filter(|(_, text)| !text.trim().is_empty()) {
        if queries.len() == QUERIES_MAX {
            return Err(QueryError::TooMany { line });
        }
        let query = query(text).ok_or_else(|| QueryError::Fields { line, found: excerpt(text) })?;
        let (width, height) = query.size;
        for (x, y) in [query.start, query.goal] {
            if x >= width || y >= height {
                return Err(QueryError::Outside { line, x, y, width, height });
            }
        }
        queries.push(query);
    }
    Ok(queries)
}

/// The query of a line: fields are separated by tabs, in some files by spaces.
fn query(text: &str) -> Option<Query> {
    let fields: Vec<&str> = text.split_ascii_whitespace().collect();
    let &[_, map, width, height, x, y, to_x, to_y, length] = &fields[..] else { return None };
    let pair = |x: &str, y: &str| Some((x.parse().ok()?, y.parse().ok()?));
    let length = length.parse::<f64>().ok().filter(|length| length.is_finite() && *length >= 0.0)?;
    Some(Query {
        map: map.to_owned(),
        size: pair(width, height)?,
        start: pair(x, y)?,
        goal: pair(to_x, to_y)?,
        length,
    })
}

/// The beginning of a line, short enough for a message.
fn excerpt(line: &str) -> String {
    line.chars().take(60).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_a_query() {
        let text = b"version 1\r\n41\tden520d.map\t256\t257\t228\t115\t123\t167\t166.96551208\r\n\r\n";
        let expected = Query {
            map: "den520d.map".to_owned(),
            size: (256, 257),
            start: (228, 115),
            goal: (123, 167),
            length: 166.965_512_08,
        };
        assert_eq!(read_queries(text), Ok(vec![expected]));
    }

    #[test]
    fn every_mistake_is_named_with_its_line() {
        let fields = |line, found: &str| QueryError::Fields { line, found: found.to_owned() };
        let version = |found: &str| QueryError::Version { found: found.to_owned() };
        let cases = [
            ("", version("")),
            ("version 2\n", version("version 2")),
            ("version 1\n0 a.map 3 3 0 0 1 1\n", fields(2, "0 a.map 3 3 0 0 1 1")),
            ("version 1\n\n0 a.map 3 3 0 0 1 -1 2\n", fields(3, "0 a.map 3 3 0 0 1 -1 2")),
            ("version 1\n0 a.map 3 3 0 0 1 1 inf\n", fields(2, "0 a.map 3 3 0 0 1 1 inf")),
            (
                "version 1\n0 a.map 3 2 0 0 1 2 2\n",
                QueryError::Outside { line: 2, x: 1, y: 2, width: 3, height: 2 },
            ),
        ];
        for (text, expected) in cases {
            assert_eq!(read_queries(text.as_bytes()), Err(expected), "{text:?}");
        }
    }
}
