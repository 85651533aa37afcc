//! Error against cost as SVG: a panel for each scene, a mark for each setting.

use std::fmt::Write;

use crate::commands::bench::tradeoff::row::Row;
use crate::commands::bench::tradeoff::setting::Precision;

/// Width and height of a panel with its axes, in pixels.
const PANEL: (f64, f64) = (620.0, 460.0);

/// Panels in a row.
const COLUMNS: usize = 2;

/// Room for the title and the legend.
const HEAD: f64 = 84.0;

/// Room within a panel to the left, right, above and below what is drawn.
const MARGINS: (f64, f64, f64, f64) = (64.0, 14.0, 30.0, 46.0);

/// Height of the strip below the axis in which the errors are 0.
const ZERO_STRIP: f64 = 26.0;

/// Size of a letter, in pixels.
const FONT: f64 = 11.0;

/// Half the size of a mark.
const MARK: f64 = 4.5;

/// Returns the picture of all rows; those of a scene lie one behind the other.
pub(super) fn svg(rows: &[Row]) -> String {
    let panels: Vec<&[Row]> = rows.chunk_by(|a, b| a.scene == b.scene).collect();
    let lines = panels.len().div_ceil(COLUMNS).max(1);
    let columns = panels.len().clamp(1, COLUMNS);
    let (width, height) = (PANEL.0 * columns as f64, HEAD + PANEL.1 * lines as f64);
    let mut text = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"DejaVu Sans, Verdana, sans-serif\" font-size=\"{FONT}\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    draw_head(&mut text);
    let errors = rows.iter().map(|row| row.error).filter(|&error| error > 0.0);
    let error_axis = Range::around(errors).whole_decades();
    for (place, rows) in panels.into_iter().enumerate() {
        let corner = (PANEL.0 * (place % COLUMNS) as f64, HEAD + PANEL.1 * (place / COLUMNS) as f64);
        Panel::new(corner, rows, error_axis).draw(rows, &mut text);
    }
    text + "</svg>\n"
}

/// A kind of setting, which has a colour (Okabe and Ito, 2008).
#[derive(Clone, Copy)]
enum Kind {
    Exact,
    Single,
    Stepped,
    SteppedSingle,
    Slow,
    Grid,
}

impl Kind {
    const ALL: [Self; 6] =
        [Self::Exact, Self::Single, Self::Stepped, Self::SteppedSingle, Self::Slow, Self::Grid];

    fn of(row: &Row) -> Self {
        match (row.scalar, row.substeps) {
            _ if row.positions != "exact" => Self::Grid,
            _ if row.rate < 1.0 => Self::Slow,
            (Precision::F64, None) => Self::Exact,
            (Precision::F32, None) => Self::Single,
            (Precision::F64, Some(_)) => Self::Stepped,
            (Precision::F32, Some(_)) => Self::SteppedSingle,
        }
    }

    fn color(self) -> &'static str {
        match self {
            Self::Exact => "#0072b2",
            Self::Single => "#d55e00",
            Self::Stepped => "#009e73",
            Self::SteppedSingle => "#cc79a7",
            Self::Slow => "#a07800",
            Self::Grid => "#56b4e9",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Exact => "event, f64",
            Self::Single => "event, f32",
            Self::Stepped => "stepped, f64",
            Self::SteppedSingle => "stepped, f32",
            Self::Slow => "longer cycle",
            Self::Grid => "grid on the wire",
        }
    }
}

fn draw_head(text: &mut String) {
    *text += "<text x=\"16\" y=\"26\" font-size=\"17\">Error against cost, by scene and setting</text>\n\
              <text x=\"16\" y=\"46\" fill=\"#444\">across: ns an object and base cycle; upwards: mean distance from where the \
              oracle says after a cycle, in world units (0: rounding); both logarithmic</text>\n";
    let mut x = 16.0;
    for kind in Kind::ALL {
        draw_mark(text, (x + 5.0, 64.0), kind, true);
        *text += &words((x + 14.0, 68.0), kind.name(), "start", "#222");
        x += 34.0 + width_of(kind.name());
    }
    *text += &words((x, 68.0), "filled: on the Pareto front; hollow: beaten", "start", "#222");
}

/// A range of positive numbers.
#[derive(Clone, Copy, Debug)]
struct Range {
    from: f64,
    to: f64,
}

impl Range {
    /// The range of numbers; from 1 to 10 where there are none.
    fn around(numbers: impl Iterator<Item = f64>) -> Self {
        let whole = numbers.fold(None, |range: Option<Self>, number| {
            let Self { from, to } = range.unwrap_or(Self { from: number, to: number });
            Some(Self { from: from.min(number), to: to.max(number) })
        });
        whole.unwrap_or(Self { from: 1.0, to: 10.0 })
    }

    fn whole_decades(self) -> Self {
        let (from, to) = (self.from.log10().floor(), self.to.log10().ceil());
        Self { from: 10f64.powf(from), to: 10f64.powf(to.max(from + 1.0)) }
    }

    fn widened(self, below: f64, above: f64) -> Self {
        Self { from: self.from / below, to: self.to * above }
    }

    /// Returns which share of the way from `from` to `to` a number is, in logarithms.
    fn share(self, number: f64) -> f64 {
        (number / self.from).ln() / (self.to / self.from).ln()
    }
}

/// The place of a scene in the picture.
struct Panel {
    corner: (f64, f64),
    costs: Range,
    errors: Range,
}

impl Panel {
    fn new(corner: (f64, f64), rows: &[Row], errors: Range) -> Self {
        let costs = Range::around(rows.iter().map(|row| row.ns_per_object_cycle).filter(|&cost| cost > 0.0));
        Self { corner, costs: costs.widened(1.25, 1.6), errors }
    }

    fn left(&self) -> f64 {
        self.corner.0 + MARGINS.0
    }

    fn right(&self) -> f64 {
        self.corner.0 + PANEL.0 - MARGINS.1
    }

    fn top(&self) -> f64 {
        self.corner.1 + MARGINS.2
    }

    /// Where the smallest error is; the strip for none lies below.
    fn bottom(&self) -> f64 {
        self.corner.1 + PANEL.1 - MARGINS.3 - ZERO_STRIP
    }

    fn x(&self, cost: f64) -> f64 {
        self.left() + (self.right() - self.left()) * self.costs.share(cost.max(self.costs.from))
    }

    fn y(&self, error: f64) -> f64 {
        if error > 0.0 {
            self.bottom() - (self.bottom() - self.top()) * self.errors.share(error)
        } else {
            self.bottom() + ZERO_STRIP / 2.0
        }
    }

    fn draw(&self, rows: &[Row], text: &mut String) {
        self.draw_axes(rows, text);
        let mut front: Vec<(f64, f64)> = rows
            .iter()
            .filter(|row| row.pareto && row.positions == "exact" && row.rate == 1.0)
            .map(|row| (self.x(row.ns_per_object_cycle), self.y(row.error)))
            .collect();
        front.sort_by(|a, b| a.0.total_cmp(&b.0));
        let points: Vec<String> = front.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
        let _ = writeln!(
            text,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"#bbb\" stroke-dasharray=\"4 3\"/>",
            points.join(" ")
        );
        let at: Vec<(f64, f64)> =
            rows.iter().map(|row| (self.x(row.ns_per_object_cycle), self.y(row.error))).collect();
        let mut taken: Vec<Area> = at.iter().map(|&(x, y)| Area::mark(x, y)).collect();
        for (row, &point) in rows.iter().zip(&at) {
            let label = self.place(row.setting, point, &taken);
            taken.push(label.area);
            label.draw(row.setting, point, Kind::of(row).color(), text);
        }
        for (row, &point) in rows.iter().zip(&at) {
            draw_mark(text, point, Kind::of(row), row.pareto);
        }
    }

    fn draw_axes(&self, rows: &[Row], text: &mut String) {
        let (left, right, top, bottom) = (self.left(), self.right(), self.top(), self.bottom());
        let title = rows.first().map_or(String::new(), |row| {
            format!("{} ({} objects timed, {} judged)", row.scene, row.timed_objects, row.judged_objects)
        });
        let title = title.replace('&', "&amp;").replace('<', "&lt;");
        let _ = writeln!(text, "<text x=\"{left}\" y=\"{}\" font-size=\"14\">{title}</text>", top - 10.0);
        let mut decade = self.errors.from;
        while decade <= self.errors.to * 1.001 {
            let y = self.y(decade);
            *text += &line((left, y), (right, y), "#eee");
            *text += &words((left - 6.0, y + 4.0), &format!("{decade:.0e}"), "end", "#222");
            // At most about nine numbers along the axis.
            decade *= 10f64.powf((self.decades() / 9.0).ceil());
        }
        *text += &words((left - 6.0, self.y(0.0) + 4.0), "0", "end", "#222");
        for power in -1..8 {
            for digit in [1.0, 2.0, 5.0] {
                let cost = digit * 10f64.powi(power);
                if (self.costs.from..=self.costs.to).contains(&cost) {
                    let (x, foot) = (self.x(cost), bottom + ZERO_STRIP);
                    *text += &line((x, top), (x, foot), "#eee");
                    *text += &words((x, foot + 16.0), &format!("{cost}"), "middle", "#222");
                }
            }
        }
        *text += &line((left, bottom), (right, bottom), "#ccc");
        let _ = writeln!(
            text,
            "<rect x=\"{left}\" y=\"{top}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#888\"/>",
            right - left,
            bottom + ZERO_STRIP - top
        );
        *text += &words((right, bottom + ZERO_STRIP + 32.0), "ns an object and base cycle", "end", "#444");
    }

    fn decades(&self) -> f64 {
        (self.errors.to / self.errors.from).log10()
    }

    /// Finds room for a label: beside its mark, or else further and further away.
    fn place(&self, label: &str, (x, y): (f64, f64), taken: &[Area]) -> Label {
        let width = width_of(label);
        let free = |area: &Area| {
            let is_inside = area.left >= self.left()
                && area.right <= self.right()
                && area.top >= self.top()
                && area.bottom <= self.bottom() + ZERO_STRIP;
            is_inside && !taken.iter().any(|other| other.meets(area))
        };
        for ring in 0..40 {
            let away = f64::from(ring) * 6.0;
            for (dx, dy) in
                [(8.0, 0.0), (-8.0 - width, 0.0), (-width / 2.0, 0.0), (14.0, 0.0), (-14.0 - width, 0.0)]
            {
                for side in [-1.0, 1.0] {
                    let (left, middle) = (x + dx, y + dy + side * away);
                    let area = Area {
                        left,
                        right: left + width,
                        top: middle - FONT / 2.0 - 1.0,
                        bottom: middle + FONT / 2.0 + 1.0,
                    };
                    if free(&area) {
                        return Label { area };
                    }
                }
            }
        }
        Label {
            area: Area { left: x + 8.0, right: x + 8.0 + width, top: y - FONT / 2.0, bottom: y + FONT / 2.0 },
        }
    }
}

/// A rectangle that is drawn on.
#[derive(Clone, Copy)]
struct Area {
    left: f64,
    right: f64,
    top: f64,
    bottom: f64,
}

impl Area {
    fn mark(x: f64, y: f64) -> Self {
        Self { left: x - MARK, right: x + MARK, top: y - MARK, bottom: y + MARK }
    }

    fn meets(&self, other: &Self) -> bool {
        self.left < other.right
            && other.left < self.right
            && self.top < other.bottom
            && other.top < self.bottom
    }
}

struct Label {
    area: Area,
}

impl Label {
    fn draw(&self, label: &str, (x, y): (f64, f64), color: &str, text: &mut String) {
        let Area { left, right, top, bottom } = self.area;
        let nearest = (x.clamp(left, right), y.clamp(top, bottom));
        if (nearest.0 - x).hypot(nearest.1 - y) > 10.0 {
            *text += &line((x, y), nearest, "#aaa");
        }
        *text += &words((left, (top + bottom) / 2.0 + FONT * 0.36), label, "start", color);
    }
}

fn draw_mark(text: &mut String, (x, y): (f64, f64), kind: Kind, is_filled: bool) {
    let (color, fill) = (kind.color(), if is_filled { kind.color() } else { "white" });
    let _ = writeln!(
        text,
        "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{MARK}\" fill=\"{fill}\" stroke=\"{color}\" stroke-width=\"1.5\"/>"
    );
}

fn line(from: (f64, f64), to: (f64, f64), color: &str) -> String {
    format!(
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{color}\"/>\n",
        from.0, from.1, to.0, to.1
    )
}

fn words((x, y): (f64, f64), words: &str, anchor: &str, color: &str) -> String {
    format!("<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\" fill=\"{color}\">{words}</text>\n")
}

/// About how wide a text is.
fn width_of(text: &str) -> f64 {
    text.chars().count() as f64 * FONT * 0.62
}
