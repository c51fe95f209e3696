//! Lines in a diagram with logarithmic axes, SVG by hand.

use std::fmt::Write as _;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 400.0;
/// The frame: left, right, top, bottom.
const FRAME: [f64; 4] = [70.0, WIDTH - 16.0, 34.0, HEIGHT - 48.0];

/// A line of points, all above 0.
#[derive(Clone, Debug)]
pub struct Line {
    /// In the legend.
    pub name: String,
    /// CSS colour.
    pub color: &'static str,
    /// Places.
    pub points: Vec<(f64, f64)>,
}

/// A diagram.
#[derive(Clone, Debug)]
pub struct Diagram {
    /// Above it.
    pub title: String,
    /// Below it.
    pub across: String,
    /// What it shows.
    pub lines: Vec<Line>,
}

/// From values to pixels.
struct Axis {
    low: f64,
    high: f64,
    pixels: (f64, f64),
}

impl Axis {
    /// From the power of `base` below all values to that above them.
    fn around(values: impl Iterator<Item = f64>, base: f64, pixels: (f64, f64)) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, base) };
        let low = low.log(base).floor();
        Self { low: base.powf(low), high: base.powf(high.log(base).ceil().max(low + 1.0)), pixels }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value / self.low).ln() / (self.high / self.low).ln();
        self.pixels.0 + share * (self.pixels.1 - self.pixels.0)
    }

    /// Powers of the base on the axis.
    fn ticks(&self, base: f64) -> impl Iterator<Item = f64> {
        let [first, last] = [self.low, self.high].map(|v| v.log(base).round() as i32);
        (first..=last).map(move |e| base.powi(e))
    }
}

impl Diagram {
    /// Draws it.
    pub fn svg(&self) -> String {
        let [left, right, top, bottom] = FRAME;
        let points = || self.lines.iter().flat_map(|l| &l.points);
        let across = Axis::around(points().map(|p| p.0), 4.0, (left, right));
        let up = Axis::around(points().map(|p| p.1), 10.0, (bottom, top));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{WIDTH}\" height=\"{HEIGHT}\" \
             viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"13\">\n\
             <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"white\"/>\n"
        );
        let middle = (left + right) * 0.5;
        text(&mut svg, (middle, top - 12.0), "middle", &self.title);
        text(&mut svg, (middle, bottom + 38.0), "middle", &self.across);
        for tick in across.ticks(4.0) {
            let x = across.at(tick);
            stroke(&mut svg, &[(x, top), (x, bottom)], "#dddddd", 1);
            text(&mut svg, (x, bottom + 18.0), "middle", &format!("{tick:.0}"));
        }
        for tick in up.ticks(10.0) {
            let y = up.at(tick);
            stroke(&mut svg, &[(left, y), (right, y)], "#dddddd", 1);
            text(&mut svg, (left - 6.0, y + 4.0), "end", &format!("{tick:.0e}"));
        }
        for (i, line) in self.lines.iter().enumerate() {
            let places: Vec<(f64, f64)> = line.points.iter().map(|p| (across.at(p.0), up.at(p.1))).collect();
            stroke(&mut svg, &places, line.color, 2);
            let y = top + 18.0 * (i as f64 + 1.0);
            stroke(&mut svg, &[(right - 230.0, y - 4.0), (right - 202.0, y - 4.0)], line.color, 2);
            text(&mut svg, (right - 196.0, y), "start", &line.name);
        }
        svg.push_str("</svg>\n");
        svg
    }
}

fn stroke(svg: &mut String, places: &[(f64, f64)], color: &str, width: u32) {
    let path: Vec<String> = places.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    let path = path.join(" ");
    let _ = writeln!(
        svg,
        "<polyline points=\"{path}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"{width}\"/>"
    );
}

fn text(svg: &mut String, (x, y): (f64, f64), anchor: &str, words: &str) {
    let _ = writeln!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_hold_all_values() {
        let axis = Axis::around([4.0, 1024.0].into_iter(), 4.0, (0.0, 100.0));
        assert_eq!((axis.at(4.0), axis.at(1024.0)), (0.0, 100.0));
        assert_eq!(axis.ticks(4.0).count(), 5);
        let line = Line { name: "a".to_owned(), color: "red", points: vec![(4.0, 1.0), (8.0, 0.5)] };
        let svg = Diagram { title: "t".to_owned(), across: "x".to_owned(), lines: vec![line] }.svg();
        assert!(svg.contains("stroke=\"red\"") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    }
}
