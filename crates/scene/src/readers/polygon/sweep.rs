//! Large polygons into triangles, in n log n.
//!
//! A line sweeps over the corners, upwards. Between the edges that it crosses it passes through spans of the inside;
//! each span keeps the corners that are not yet cut off, and cuts off what the next corner makes possible
//! \[Garey1978\], \[Berg2008\] chapter 3. The result is measured: polygons that cross themselves are found by their
//! surface, and not by a test of all their edges.

use super::{signed_area, turn};
use std::cmp::Ordering;

/// How far the surface of the triangles may differ from that of the polygon, relative.
const TOLERANCE: f64 = 1e-6;
/// Most spans in one row of [`Order`].
const ROW: usize = 512;

/// Appends the triangles of a polygon that turns to the left; they turn to the left too. False if it crosses or
/// touches itself in a way that this cannot cut; nothing is appended then.
pub(super) fn triangulate(flat: &[[f64; 2]], triangles: &mut Vec<[u32; 3]>) -> bool {
    let before = triangles.len();
    let mut sweep = Sweep {
        flat,
        span_of: vec![u32::MAX; flat.len()],
        spans: Vec::new(),
        free: Vec::new(),
        order: Order::default(),
        triangles,
    };
    let is_whole = sweep.run().is_some() && sweep.spans.len() == sweep.free.len();
    let area = |t: &[u32; 3]| turn(flat[t[0] as usize], flat[t[1] as usize], flat[t[2] as usize]);
    let covered: f64 = triangles[before..].iter().map(|t| area(t).abs()).sum();
    let surface = signed_area(flat);
    let fits = is_whole && (covered - surface).abs() <= TOLERANCE * surface;
    if !fits {
        triangles.truncate(before);
    }
    fits
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Side {
    Left,
    Right,
}

/// Corners that are not yet cut off, in the order of the sweep: all but the first on one side, and curved inwards.
#[derive(Debug)]
struct Chain {
    corners: Vec<u32>,
    side: Side,
}

/// A part of the inside between two edges that the line crosses.
#[derive(Debug)]
struct Span {
    /// The edges, by the number of their first corner.
    left: u32,
    right: u32,
    chain: Chain,
    /// What lies to the right of the last corner, if two spans have met there.
    beside: Option<Chain>,
}

struct Sweep<'a> {
    flat: &'a [[f64; 2]],
    /// The span that an edge bounds.
    span_of: Vec<u32>,
    spans: Vec<Span>,
    free: Vec<u32>,
    order: Order,
    triangles: &'a mut Vec<[u32; 3]>,
}

impl Sweep<'_> {
    fn at(&self, corner: u32) -> [f64; 2] {
        self.flat[corner as usize]
    }

    /// Passes all corners. `None` where the polygon cannot be simple.
    fn run(&mut self) -> Option<()> {
        let count = self.flat.len() as u32;
        let mut corners: Vec<u32> = (0..count).collect();
        corners.sort_unstable_by(|a, b| along(self.flat, *a, *b));
        for i in corners {
            let before = if i == 0 { count - 1 } else { i - 1 };
            let after = if i + 1 == count { 0 } else { i + 1 };
            let comes_from_below = along(self.flat, before, i).is_lt();
            let goes_up = along(self.flat, i, after).is_lt();
            let turns_left = turn(self.at(before), self.at(i), self.at(after)) > 0.0;
            match (comes_from_below, goes_up) {
                (false, true) if turns_left => self.start(i, before),
                (false, true) => self.split(i, before)?,
                (true, false) if turns_left => self.end(i, before)?,
                (true, false) => self.merge(i, before)?,
                (true, true) => self.pass(i, before, i, Side::Right)?,
                (false, false) => self.pass(i, i, before, Side::Left)?,
            }
        }
        Some(())
    }

    /// A span begins: its left edge comes down to the corner `i`, its right edge goes up from there.
    fn start(&mut self, i: u32, left: u32) {
        let chain = Chain { corners: vec![i], side: Side::Left };
        let place = self.place(i);
        let span = self.add(Span { left, right: i, chain, beside: None });
        self.order.insert(place, span);
    }

    /// A span ends at the corner `i`.
    fn end(&mut self, i: u32, right: u32) -> Option<()> {
        let span = self.bounded_by(i)?;
        if self.bounded_by(right)? != span {
            return None;
        }
        let place = self.place(i);
        self.order.remove(place, span)?;
        let (chain, beside) = self.remove(span);
        self.finish(chain, i);
        if let Some(chain) = beside {
            self.finish(chain, i);
        }
        Some(())
    }

    /// The boundary goes on along the next edge.
    fn pass(&mut self, i: u32, ends: u32, begins: u32, side: Side) -> Option<()> {
        let span = self.bounded_by(ends)?;
        self.feed_span(span, i, side);
        let s = &mut self.spans[span as usize];
        *(if side == Side::Left { &mut s.left } else { &mut s.right }) = begins;
        self.span_of[ends as usize] = u32::MAX;
        self.span_of[begins as usize] = span;
        Some(())
    }

    /// A corner inside a span parts it in two: it is joined with the last corner of the span.
    fn split(&mut self, i: u32, left: u32) -> Option<()> {
        let place = self.place(i);
        let id = self.order.before(place)?;
        let span = &mut self.spans[id as usize];
        let right_of_it = std::mem::replace(&mut span.right, i);
        let beside = span.beside.take();
        let other = match beside {
            Some(beside) => beside,
            // The chain stays on the side of its edge; on the other side only its last corner counts.
            None => {
                let last = Chain { corners: vec![*span.chain.corners.last()?], side: span.chain.side };
                match span.chain.side {
                    Side::Left => std::mem::replace(&mut span.chain, last),
                    Side::Right => last,
                }
            }
        };
        self.span_of[i as usize] = id;
        let new = self.add(Span { left, right: right_of_it, chain: other, beside: None });
        self.order.insert(place, new);
        self.feed_span(id, i, Side::Right);
        self.feed_span(new, i, Side::Left);
        Some(())
    }

    /// Two spans meet at a corner; both wait for the next one, with which this one is joined.
    fn merge(&mut self, i: u32, right: u32) -> Option<()> {
        let (first, second) = (self.bounded_by(right)?, self.bounded_by(i)?);
        let place = self.place(i);
        if first == second {
            return None;
        }
        self.order.remove(place, second)?;
        self.feed_span(first, i, Side::Right);
        self.feed_span(second, i, Side::Left);
        let outer = self.spans[second as usize].right;
        let (chain, _) = self.remove(second);
        let span = &mut self.spans[first as usize];
        (span.right, span.beside) = (outer, Some(chain));
        self.span_of[outer as usize] = first;
        Some(())
    }

    /// The span with that edge.
    fn bounded_by(&self, edge: u32) -> Option<u32> {
        Some(self.span_of[edge as usize]).filter(|span| *span != u32::MAX)
    }

    fn add(&mut self, span: Span) -> u32 {
        let (left, right) = (span.left as usize, span.right as usize);
        let id = match self.free.pop() {
            Some(id) => {
                self.spans[id as usize] = span;
                id
            }
            None => {
                self.spans.push(span);
                self.spans.len() as u32 - 1
            }
        };
        (self.span_of[left], self.span_of[right]) = (id, id);
        id
    }

    fn remove(&mut self, id: u32) -> (Chain, Option<Chain>) {
        let nothing = Chain { corners: Vec::new(), side: Side::Left };
        let span = &mut self.spans[id as usize];
        let chains = (std::mem::replace(&mut span.chain, nothing), span.beside.take());
        let (left, right) = (span.left as usize, span.right as usize);
        (self.span_of[left], self.span_of[right]) = (u32::MAX, u32::MAX);
        self.free.push(id);
        chains
    }

    /// The place behind all spans that begin at or to the left of a corner.
    fn place(&self, corner: u32) -> Place {
        let (flat, spans, point) = (self.flat, &self.spans, self.at(corner));
        self.order.place(|id| {
            let upper = spans[id as usize].left as usize;
            let lower = if upper + 1 == flat.len() { 0 } else { upper + 1 };
            turn(flat[lower], flat[upper], point) <= 0.0
        })
    }

    /// Gives a span a corner of its boundary.
    fn feed_span(&mut self, id: u32, corner: u32, side: Side) {
        let span = &mut self.spans[id as usize];
        if let Some(beside) = span.beside.take() {
            let ended = if side == Side::Left { std::mem::replace(&mut span.chain, beside) } else { beside };
            self.finish(ended, corner);
        }
        let (flat, span) = (self.flat, &mut self.spans[id as usize]);
        span.chain.feed(flat, corner, side, self.triangles);
    }

    /// Cuts off all that is left of a chain.
    fn finish(&mut self, mut chain: Chain, corner: u32) {
        chain.fan(corner, self.triangles);
    }
}

impl Chain {
    fn feed(&mut self, flat: &[[f64; 2]], corner: u32, side: Side, triangles: &mut Vec<[u32; 3]>) {
        if self.side != side && self.corners.len() > 1 {
            self.fan(corner, triangles);
        }
        self.side = side;
        let at = |i: u32| flat[i as usize];
        while let [.., a, b] = self.corners[..] {
            let turned = turn(at(a), at(b), at(corner));
            match side {
                Side::Left if turned < 0.0 => triangles.push([a, corner, b]),
                Side::Right if turned > 0.0 => triangles.push([a, b, corner]),
                _ => break,
            }
            self.corners.pop();
        }
        self.corners.push(corner);
    }

    /// Joins all corners with one that lies opposite; the last of them is left.
    fn fan(&mut self, corner: u32, triangles: &mut Vec<[u32; 3]>) {
        for pair in self.corners.windows(2) {
            triangles.push(match self.side {
                Side::Left => [pair[0], corner, pair[1]],
                Side::Right => [pair[0], pair[1], corner],
            });
        }
        self.corners.drain(..self.corners.len().saturating_sub(1));
    }
}

/// The order of the sweep: upwards, and to the right.
fn along(flat: &[[f64; 2]], a: u32, b: u32) -> Ordering {
    let key = |i: u32| (flat[i as usize][1], flat[i as usize][0], i);
    key(a).partial_cmp(&key(b)).unwrap_or(Ordering::Equal)
}

/// The spans from left to right, in rows.
#[derive(Debug, Default)]
struct Order {
    rows: Vec<Vec<u32>>,
}

/// A place between spans: row, and number in it.
type Place = (usize, usize);

impl Order {
    /// The place before the first span for which `is_left` is false.
    fn place(&self, is_left: impl Fn(u32) -> bool) -> Place {
        let row = self.rows.partition_point(|row| row.first().is_some_and(|id| is_left(*id)));
        let row = row.saturating_sub(1);
        (row, self.rows.get(row).map_or(0, |row| row.partition_point(|id| is_left(*id))))
    }

    fn before(&self, (row, at): Place) -> Option<u32> {
        self.rows.get(row)?.get(at.checked_sub(1)?).copied()
    }

    fn insert(&mut self, (row, at): Place, id: u32) {
        if self.rows.is_empty() {
            self.rows.push(Vec::new());
        }
        self.rows[row].insert(at, id);
        if self.rows[row].len() > ROW {
            let rest = self.rows[row].split_off(ROW / 2);
            self.rows.insert(row + 1, rest);
        }
    }

    /// Removes a span that should stand before a place, or near it if edges touch.
    fn remove(&mut self, (row, _): Place, id: u32) -> Option<()> {
        let near = row.saturating_sub(1)..(row + 2).min(self.rows.len());
        for row in near {
            if let Some(at) = self.rows[row].iter().rposition(|other| *other == id) {
                self.rows[row].remove(at);
                if self.rows[row].is_empty() {
                    self.rows.remove(row);
                }
                return Some(());
            }
        }
        None
    }
}
