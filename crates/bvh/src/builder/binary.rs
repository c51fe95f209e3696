//! A binary tree by the surface area heuristic, down to single references or a few.
//!
//! Large ranges are parted level by level, all threads at work on each level; small ones by one thread each. Which is
//! which, and the order in which references end up, depends on their number alone.

use super::bins::{Bins, Grid, Split, is_few, part_few};
use super::box4::{BLANK, BinaryNode, Box4, Content, NO_REF, PrimRef, Reference as _, Tree as _, extent_of};
use super::parallel::{self, take};
use std::ops::Range;

/// From this depth on, ranges are halved by count, so that no depth exceeds this plus 32.
pub(super) const BALANCE_FROM: usize = 64;

/// Ranges of up to so many references are built by one thread each.
pub(super) const SMALL: usize = 1 << 14;

/// References that one thread sorts at a time in ranges that are not small.
const CHUNK: usize = 1 << 14;

/// A binary tree over references.
pub(super) struct Binary {
    /// The root is the first; none if there is nothing to hold. Children lie side by side behind their parents.
    pub(super) nodes: Vec<BinaryNode>,
    /// How many of the nodes are the top of the tree.
    pub(super) top: usize,
    /// Subtrees below leaves of the top, in the order of their nodes, which follow the top without gaps.
    pub(super) subtrees: Vec<Subtree>,
}

impl Binary {
    /// Closes the gaps between subtrees.
    pub(super) fn squeeze(&mut self) {
        let mut end = self.top;
        for subtree in &mut self.subtrees {
            let start = subtree.below.start;
            let closer = |node: &BinaryNode| match node.child() {
                Some(child) => BinaryNode::new(node.extent(), Content::Children(child - (start - end))),
                None => *node,
            };
            self.nodes[subtree.root] = closer(&self.nodes[subtree.root]);
            for i in 0..subtree.used {
                self.nodes[end + i] = closer(&self.nodes[start + i]);
            }
            subtree.below = end..end + subtree.used;
            end += subtree.used;
        }
        self.nodes.truncate(end);
        self.nodes.shrink_to_fit();
    }
}

/// How a binary tree is built.
#[derive(Clone, Copy)]
pub(super) struct Rules<'a> {
    /// Bins per axis.
    pub(super) bins: usize,
    /// Primitives that fill a leaf of the final tree, a power of two: ranges are parted so that few leaves stay half
    /// empty.
    pub(super) block: u32,
    /// Most primitives in a leaf, 1 to 8. With one, more can be made of the tree; with a few it is built sooner.
    pub(super) leaf: usize,
    /// Whether the primitives of a geometry may share a leaf.
    pub(super) shares: &'a [bool],
}

impl Rules<'_> {
    fn is_leaf(&self, refs: &[PrimRef]) -> bool {
        let shares = |r: &PrimRef| self.shares[r.key().geometry as usize];
        let count = || refs.iter().map(|r| r.count() as usize).sum::<usize>();
        refs.len() == 1 || (refs.len() <= self.leaf && count() <= self.leaf && refs.iter().all(shares))
    }
}

/// A part of the tree that one thread works on.
#[derive(Clone, Debug)]
pub(super) struct Subtree {
    /// Its root, one of the top nodes.
    pub(super) root: usize,
    /// All nodes below the root, and perhaps room for more.
    pub(super) below: Range<usize>,
    /// How many there are.
    pub(super) used: usize,
}

/// A range of references that is to become a subtree.
#[derive(Clone, Copy)]
struct Task {
    node: usize,
    first: usize,
    count: usize,
    depth: usize,
    extent: Box4,
}

/// Sorts `refs` so that each subtree has a range of them, and builds the tree. `spare` may have room for as many more.
pub(super) fn build(refs: &mut [PrimRef], spare: Vec<PrimRef>, rules: Rules<'_>, threads: usize) -> Binary {
    if refs.is_empty() {
        return Binary { nodes: Vec::new(), top: 0, subtrees: Vec::new() };
    }
    let threads = if refs.len() > SMALL { threads } else { 1 };
    let extent = extent_of(refs, threads);
    let root = Task { node: 0, first: 0, count: refs.len(), depth: 0, extent };
    let mut top = Top { nodes: vec![BLANK], small: Vec::new() };
    if root.count <= SMALL {
        top.small.push((root, false));
    } else {
        top.grow(refs, spare, root, &rules, threads);
    }
    let Top { nodes: top, mut small } = top;
    small.sort_unstable_by_key(|(task, _)| task.first);
    // Only now, when there is nothing to sort into any more.
    let mut nodes = vec![BLANK; 2 * refs.len() - 1];
    nodes[..top.len()].copy_from_slice(&top);
    let subtrees = build_all(refs, &mut nodes, top.len(), &small, rules, threads);
    Binary { nodes, top: top.len(), subtrees }
}

/// Builds the small ranges. `top` is the number of nodes that there are.
fn build_all(
    refs: &mut [PrimRef],
    nodes: &mut [BinaryNode],
    top: usize,
    tasks: &[(Task, bool)],
    rules: Rules<'_>,
    threads: usize,
) -> Vec<Subtree> {
    let (mut subtrees, mut jobs) = (Vec::with_capacity(tasks.len()), Vec::with_capacity(tasks.len()));
    let (tops, mut left) = nodes.split_at_mut(top);
    let (mut refs, mut at) = (refs, top);
    for (task, balanced) in tasks {
        let below = 2 * task.count - 2;
        subtrees.push(Subtree { root: task.node, below: at..at + below, used: 0 });
        jobs.push(Job {
            refs: take(&mut refs, task.count),
            nodes: take(&mut left, below),
            start: at,
            task: *task,
            balanced: *balanced,
        });
        at += below;
    }
    let roots = parallel::map(threads, jobs, |job| job.run(&rules));
    for (subtree, (root, used)) in subtrees.iter_mut().zip(roots) {
        tops[subtree.root] = root;
        subtree.used = used;
    }
    subtrees
}

/// Bounding box of the double centroids.
fn centroids(refs: &[PrimRef]) -> Box4 {
    // Four at a time, so that they need not wait for each other.
    let (fours, rest) = refs.as_chunks::<4>();
    let mut all = [Box4::EMPTY; 4];
    for four in fours {
        for (all, r) in all.iter_mut().zip(four) {
            *all = all.with_point(r.extent().double_center());
        }
    }
    let [a, b, c, d] = all;
    let all = a.union(b).union(c.union(d));
    rest.iter().fold(all, |all, r| all.with_point(r.extent().double_center()))
}

/// The top of the tree while it grows.
struct Top {
    nodes: Vec<BinaryNode>,
    /// What is left for one thread each; true: must be halved.
    small: Vec<(Task, bool)>,
}

/// A range to be parted in the top of the tree.
struct Large {
    task: Task,
    /// Box of the double centroids.
    centroids: Box4,
}

impl Top {
    /// Parts large ranges level by level.
    fn grow(
        &mut self,
        refs: &mut [PrimRef],
        mut spare: Vec<PrimRef>,
        root: Task,
        rules: &Rules<'_>,
        threads: usize,
    ) {
        if spare.len() < refs.len() {
            spare = vec![NO_REF; refs.len()];
        }
        spare.truncate(refs.len());
        let parts = parallel::map(threads, refs.chunks(CHUNK).collect(), centroids);
        let centroids = parts.iter().fold(Box4::EMPTY, |a, b| a.union(*b));
        let (mut tasks, mut in_spare) = (vec![Large { task: root, centroids }], false);
        while !tasks.is_empty() {
            let (from, to) = if in_spare { (&mut *spare, &mut *refs) } else { (&mut *refs, &mut *spare) };
            let splits = split_all(from, &tasks, rules, threads);
            let mut parted = scatter(from, to, &tasks, &splits, threads).into_iter();
            let (mut next, mut done) = (Vec::new(), Vec::new());
            for (Large { task, .. }, parting) in tasks.iter().zip(&splits) {
                let boxes = parted.by_ref().take(task.chunks());
                let boxes = boxes.fold([Box4::EMPTY; 2], |[a, b], [c, d]| [a.union(c), b.union(d)]);
                let Some(parting) = parting else {
                    done.push((*task, true));
                    continue;
                };
                for (child, centroids) in self.children(task, &parting.split).into_iter().zip(boxes) {
                    if child.count > SMALL {
                        next.push(Large { task: child, centroids });
                    } else {
                        done.push((child, false));
                    }
                }
            }
            in_spare = !in_spare;
            // What is done must lie in `refs`.
            if in_spare {
                bring_home(refs, &spare, &done, threads);
            }
            self.small.extend(done);
            tasks = next;
        }
    }

    fn children(&mut self, task: &Task, split: &Split) -> [Task; 2] {
        let child = self.nodes.len();
        self.nodes.extend([BLANK; 2]);
        self.nodes[task.node] = BinaryNode::new(task.extent, Content::Children(child));
        task.children(child, split.sides, split.left)
    }
}

impl Task {
    fn chunks(&self) -> usize {
        self.count.div_ceil(CHUNK)
    }

    fn children(&self, child: usize, sides: [Box4; 2], left: usize) -> [Self; 2] {
        let depth = self.depth + 1;
        [
            Self { node: child, first: self.first, count: left, depth, extent: sides[0] },
            Self {
                node: child + 1,
                first: self.first + left,
                count: self.count - left,
                depth,
                extent: sides[1],
            },
        ]
    }
}

/// How a large range is parted.
struct Parting {
    grid: Grid,
    split: Split,
    /// How many references go left, by chunk.
    lefts: Vec<usize>,
}

/// The best parting of each range. None where halving is called for.
fn split_all(refs: &[PrimRef], tasks: &[Large], rules: &Rules<'_>, threads: usize) -> Vec<Option<Parting>> {
    let grid = |large: &Large| Grid::new(&large.centroids, rules, large.task.count);
    let grids: Vec<Grid> = tasks.iter().map(grid).collect();
    let jobs = tasks.iter().zip(&grids).flat_map(|(Large { task, .. }, grid)| {
        refs[task.first..task.first + task.count].chunks(CHUNK).map(move |chunk| (grid, chunk))
    });
    let filled = parallel::map(threads, jobs.collect(), |(grid, chunk)| {
        let (mut bins, mut spare) = (Box::new(Bins::EMPTY), Box::new(Bins::EMPTY));
        bins.fill(grid, chunk, &mut spare);
        bins
    });
    let mut rest = &*filled;
    let best = |(Large { task, .. }, grid): (&Large, Grid)| {
        let (parts, behind) = rest.split_at(task.chunks());
        rest = behind;
        let mut all = Bins::EMPTY;
        parts.iter().for_each(|bins| all.add(&grid, bins));
        let split = if task.depth < BALANCE_FROM { all.best(&grid, task.extent) } else { None };
        split.map(|split| {
            let lefts = parts.iter().map(|bins| bins.left_of(&split)).collect();
            Parting { grid, split, lefts }
        })
    };
    tasks.iter().zip(grids).map(best).collect()
}

/// Moves what belongs left to the front; ranges without a split stay as they are. Returns the boxes of the double
/// centroids on both sides, by chunk of each range.
fn scatter(
    from: &mut [PrimRef],
    to: &mut [PrimRef],
    tasks: &[Large],
    partings: &[Option<Parting>],
    threads: usize,
) -> Vec<[Box4; 2]> {
    let (mut jobs, mut from, mut to, mut at) = (Vec::new(), from, to, 0);
    for (Large { task, .. }, parting) in tasks.iter().zip(partings) {
        take(&mut from, task.first - at);
        take(&mut to, task.first - at);
        at = task.first + task.count;
        let chunks = take(&mut from, task.count).chunks_mut(CHUNK);
        let places = take(&mut to, task.count);
        let Some(Parting { grid, split, lefts }) = parting else {
            let places = places.chunks_mut(CHUNK);
            jobs.extend(chunks.zip(places).map(|(from, to)| Move { from, to: [to, &mut []], by: None }));
            continue;
        };
        let (mut left, mut right) = places.split_at_mut(split.left);
        for (from, count) in chunks.zip(lefts) {
            let to = [take(&mut left, *count), take(&mut right, from.len() - count)];
            jobs.push(Move { from, to, by: Some((grid, split)) });
        }
    }
    parallel::map(threads, jobs, Move::run)
}

/// References that are moved, some to the left and some to the right.
struct Move<'a> {
    from: &'a mut [PrimRef],
    to: [&'a mut [PrimRef]; 2],
    /// None: all go left.
    by: Option<(&'a Grid, &'a Split)>,
}

impl Move<'_> {
    fn run(self) -> [Box4; 2] {
        if let Some((grid, split)) = self.by {
            partition(self.from, |r| grid.is_right(split, r));
        }
        let [left, right] = self.to;
        let (from_left, from_right) = self.from.split_at(left.len());
        left.copy_from_slice(from_left);
        right.copy_from_slice(from_right);
        [centroids(from_left), centroids(from_right)]
    }
}

/// Copies the ranges of tasks.
fn bring_home(refs: &mut [PrimRef], spare: &[PrimRef], tasks: &[(Task, bool)], threads: usize) {
    let (mut rest, mut at, mut jobs) = (refs, 0, Vec::new());
    for (task, _) in tasks {
        take(&mut rest, task.first - at);
        at = task.first + task.count;
        jobs.push((&spare[task.first..at], take(&mut rest, task.count)));
    }
    parallel::map(threads, jobs, |(from, to)| to.copy_from_slice(from));
}

/// A small range and the places for its nodes below the root.
struct Job<'a> {
    refs: &'a mut [PrimRef],
    nodes: &'a mut [BinaryNode],
    /// Number of the first of these nodes.
    start: usize,
    task: Task,
    /// Binning was tried in vain.
    balanced: bool,
}

impl Job<'_> {
    /// Builds all nodes below the root. Returns the root and how many are below it.
    fn run(self, rules: &Rules<'_>) -> (BinaryNode, usize) {
        let Self { refs, nodes, start, task, balanced } = self;
        let start_ref = task.first;
        let (mut next, mut filled) = (0, Box::new([Bins::EMPTY, Bins::EMPTY]));
        let mut root = BLANK;
        let mut tasks = vec![(task, balanced)];
        while let Some((task, balanced)) = tasks.pop() {
            let range = &mut refs[task.first - start_ref..][..task.count];
            let content = if rules.is_leaf(range) {
                Content::Leaf { first: task.first, count: task.count }
            } else {
                let (sides, left) = part(range, &task, rules, balanced, &mut filled);
                let child = start + next;
                next += 2;
                let [a, b] = task.children(child, sides, left);
                tasks.extend([(b, false), (a, false)]);
                Content::Children(child)
            };
            let place = if task.node < start { &mut root } else { &mut nodes[task.node - start] };
            *place = BinaryNode::new(task.extent, content);
        }
        (root, next)
    }
}

/// Parts a range in two. Returns the boxes of both sides and how many are on the left one.
fn part(
    range: &mut [PrimRef],
    task: &Task,
    rules: &Rules<'_>,
    balanced: bool,
    filled: &mut [Bins; 2],
) -> ([Box4; 2], usize) {
    if is_few(range.len()) {
        return part_few(range, task.extent);
    }
    let centroids = centroids(range);
    if task.depth < BALANCE_FROM && !balanced {
        let grid = Grid::new(&centroids, rules, range.len());
        let [bins, spare] = filled;
        bins.fill(&grid, range, spare);
        if let Some(split) = bins.best(&grid, task.extent) {
            partition(range, |r| grid.is_right(&split, r));
            return (split.sides, split.left);
        }
    }
    let left = halve(range, &centroids);
    let (a, b) = range.split_at(left);
    ([extent_of(a, 1), extent_of(b, 1)], left)
}

/// Halves by centroid along the longest axis, by id among equals.
fn halve(range: &mut [PrimRef], centroids: &Box4) -> usize {
    let size = centroids.high.truncate() * 0.5 - centroids.low.truncate() * 0.5;
    let axis = size.max_position();
    let middle = range.len() / 2;
    let place = |r: &PrimRef| r.extent().double_center()[axis];
    let ids = |r: &PrimRef| (r.key().geometry, r.key().prim);
    range.select_nth_unstable_by(middle, |a, b| {
        place(a).total_cmp(&place(b)).then_with(|| ids(a).cmp(&ids(b)))
    });
    middle
}

/// Moves what does not belong right to the front. Without branches, for they could not be foretold.
#[inline(always)]
fn partition(range: &mut [PrimRef], is_right: impl Fn(&PrimRef) -> bool) {
    let mut end = 0;
    for i in 0..range.len() {
        let stays = !is_right(&range[i]);
        range.swap(i, end);
        end += usize::from(stays);
    }
}
