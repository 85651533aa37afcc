use maniple_view::Shape;

use super::*;
