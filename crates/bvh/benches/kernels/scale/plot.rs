//! The table as a picture: four diagrams with logarithmic axes, SVG by hand.

use super::Row;
use std::fmt::Write as _;

/// Of one diagram, pixels.
const WIDTH: f64 = 460.0;
const HEIGHT: f64 = 320.0;
/// Room for labels around its frame.
const LEFT: f64 = 62.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 34.0;
const BOTTOM: f64 = 48.0;

/// Colours that people with any kind of sight can tell apart, and dashes for those who see none.
const STYLES: [(&str, &str); 4] =
    [("#0072b2", "none"), ("#d55e00", "none"), ("#555555", "6 4"), ("#009e73", "2 3")];

/// A line of points.
struct Series {
    name: &'static str,
    points: Vec<(f64, f64)>,
}

/// A diagram before it is placed.
struct Panel {
    title: String,
    unit: &'static str,
    series: Vec<Series>,
}

/// Draws all rows.
pub fn draw(rows: &[Row]) -> String {
    let mut panels: Vec<Panel> = (0..3).map(|kind| rays(rows, kind)).collect();
    panels.push(builds(rows));
    let (width, height) = (2.0 * WIDTH, 2.0 * HEIGHT);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" font-family=\"sans-serif\" font-size=\"13\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"white\"/>\n"
    );
    for (i, panel) in panels.iter().enumerate() {
        let corner = ((i % 2) as f64 * WIDTH, (i / 2) as f64 * HEIGHT);
        panel.draw(&mut svg, corner);
    }
    svg.push_str("</svg>\n");
    svg
}

fn series(name: &'static str, rows: &[Row], value: impl Fn(&Row) -> Option<f64>) -> Series {
    let points = rows.iter().filter_map(|row| Some((row.triangles as f64, value(row)?)));
    Series { name, points: points.filter(|(_, y)| y.is_finite() && *y > 0.0).collect() }
}

fn rays(rows: &[Row], kind: usize) -> Panel {
    let name = rows.first().map_or("", |row| row.costs[kind].kind.name());
    Panel {
        title: format!("{name} rays, one thread"),
        unit: "ns per ray",
        series: vec![
            series("one ray a call", rows, |r| Some(r.costs[kind].one)),
            series("batch calls", rows, |r| Some(r.costs[kind].batch)),
            series("Embree, best one-ray call", rows, |r| r.costs[kind].embree),
        ],
    }
}

fn builds(rows: &[Row]) -> Panel {
    Panel {
        title: "build, all threads".to_owned(),
        unit: "seconds",
        series: vec![
            series("fast", rows, |r| Some(r.fast.seconds)),
            series("high", rows, |r| Some(r.high.seconds)),
            series("Embree, medium", rows, |r| r.embree.map(|e| e.medium)),
            series("Embree, high", rows, |r| r.embree.map(|e| e.high)),
        ],
    }
}

/// A logarithmic axis: values from `low` to `high` onto pixels.
struct Axis {
    low: f64,
    high: f64,
    pixels: (f64, f64),
}

impl Axis {
    /// From the last of `steps` times a power of ten below all values to the first above them.
    fn around(values: impl Iterator<Item = f64>, steps: &[f64], pixels: (f64, f64)) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0_f64), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
        let marks = || marks(steps);
        let below = marks().filter(|m| *m <= low).last().unwrap_or(low);
        // What is hardly larger than a mark stands a little beside it.
        let above = marks().find(|m| *m * 1.02 >= high && *m > below).unwrap_or(high);
        Self { low: below, high: above.max(high), pixels }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value / self.low).log10() / (self.high / self.low).log10();
        self.pixels.0 + share * (self.pixels.1 - self.pixels.0)
    }

    fn ticks(&self, steps: &[f64]) -> Vec<f64> {
        let inside = |m: &f64| *m >= self.low * 0.999 && *m <= self.high * 1.001;
        marks(steps).filter(inside).collect()
    }
}

/// `steps` times all powers of ten from 10⁻⁶ to 10¹¹, ascending.
fn marks(steps: &[f64]) -> impl Iterator<Item = f64> {
    (-6..12).flat_map(move |e| steps.iter().map(move |s| s * 10f64.powi(e)))
}

impl Panel {
    fn draw(&self, svg: &mut String, (x, y): (f64, f64)) {
        let frame = (x + LEFT, x + WIDTH - RIGHT, y + TOP, y + HEIGHT - BOTTOM);
        let points = || self.series.iter().flat_map(|s| &s.points);
        let across = Axis::around(points().map(|p| p.0), &[1.0], (frame.0, frame.1));
        let (least, most) = points().fold((f64::INFINITY, 0.0_f64), |(l, m), p| (l.min(p.1), m.max(p.1)));
        let steps: &[f64] = if most > 300.0 * least { &[1.0] } else { &[1.0, 2.0, 5.0] };
        let up = Axis::around([least, most].into_iter(), steps, (frame.3, frame.2));
        self.draw_frame(svg, frame, (&across, &[1.0]), (&up, steps));
        for (series, (colour, dash)) in self.series.iter().zip(STYLES) {
            draw_series(svg, series, &across, &up, colour, dash);
        }
        self.draw_legend(svg, (frame.0 + 10.0, frame.2 + 18.0));
    }

    fn draw_frame(
        &self,
        svg: &mut String,
        frame: (f64, f64, f64, f64),
        (across, powers): (&Axis, &[f64]),
        (up, steps): (&Axis, &[f64]),
    ) {
        let (left, right, top, bottom) = frame;
        let middle = ((left + right) * 0.5, (top + bottom) * 0.5);
        text(
            svg,
            (middle.0, top - 12.0),
            "middle",
            &format!("<tspan font-weight=\"bold\">{}</tspan>", self.title),
        );
        text(svg, (middle.0, bottom + 38.0), "middle", "triangles");
        let turn = format!("transform=\"rotate(-90 {0:.1} {1:.1})\"", left - 46.0, middle.1);
        let _ = writeln!(
            svg,
            "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\" {turn}>{}</text>",
            left - 46.0,
            middle.1,
            self.unit
        );
        for tick in across.ticks(powers) {
            let x = across.at(tick);
            line(svg, (x, top), (x, bottom), "#dddddd");
            text(svg, (x, bottom + 18.0), "middle", &power(tick));
        }
        for tick in up.ticks(steps) {
            let y = up.at(tick);
            line(svg, (left, y), (right, y), "#dddddd");
            text(svg, (left - 6.0, y + 4.0), "end", &label(tick));
        }
        let _ = writeln!(
            svg,
            "<rect x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#666666\"/>",
            right - left,
            bottom - top
        );
    }

    fn draw_legend(&self, svg: &mut String, (x, y): (f64, f64)) {
        let shown = self.series.iter().zip(STYLES).filter(|(s, _)| !s.points.is_empty());
        for (i, (series, (colour, dash))) in shown.enumerate() {
            let y = y + 18.0 * i as f64;
            let _ = writeln!(
                svg,
                "<line x1=\"{x:.1}\" y1=\"{0:.1}\" x2=\"{1:.1}\" y2=\"{0:.1}\" stroke=\"{colour}\" stroke-width=\"2\" \
                 stroke-dasharray=\"{dash}\"/>",
                y - 4.0,
                x + 28.0
            );
            text(svg, (x + 34.0, y), "start", series.name);
        }
    }
}

fn draw_series(svg: &mut String, series: &Series, across: &Axis, up: &Axis, colour: &str, dash: &str) {
    let places: Vec<(f64, f64)> = series.points.iter().map(|p| (across.at(p.0), up.at(p.1))).collect();
    let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let _ = writeln!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\" stroke-dasharray=\"{dash}\"/>",
        path.join(" ")
    );
    for (x, y) in places {
        let _ = writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"3\" fill=\"{colour}\"/>");
    }
}

fn line(svg: &mut String, from: (f64, f64), to: (f64, f64), colour: &str) {
    let _ = writeln!(
        svg,
        "<line x1=\"{:.1}\" y1=\"{:.1}\" x2=\"{:.1}\" y2=\"{:.1}\" stroke=\"{colour}\"/>",
        from.0, from.1, to.0, to.1
    );
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}

/// A mark as a person writes it.
fn label(value: f64) -> String {
    if value >= 1.0 {
        return format!("{value:.0}");
    }
    let digits = -value.log10().floor();
    format!("{value:.*}", digits as usize)
}

/// A power of ten as a person writes it.
fn power(value: f64) -> String {
    const DIGITS: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let exponent = value.log10().round().max(0.0) as usize;
    let digits = exponent.to_string();
    let raised = digits.bytes().map(|digit| DIGITS[usize::from(digit - b'0')]);
    ['1', '0'].into_iter().chain(raised).collect()
}
