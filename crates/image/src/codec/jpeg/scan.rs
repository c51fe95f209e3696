//! Whether a JPEG file holds all of its picture \[JPEG\].
//!
//! The decoding library paints grey what a cut file lacks, and does not tell. So the codes of all blocks are walked over
//! here, without decoding what they mean. What is wrong in other ways is left to the library.

use std::ops::ControlFlow::{self, Break, Continue};

/// Why the walk ends early.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stop {
    /// The data of a scan end at this byte, before its last block.
    Short(usize),
    /// Something that is not understood here.
    Unknown,
}

/// The first byte behind the data of a scan that lacks blocks.
pub fn cut_at(bytes: &[u8]) -> Option<usize> {
    let mut walk = Walk { bytes, at: 2, frame: None, tables: Default::default(), restart: 0 };
    match walk.run() {
        Break(Stop::Short(at)) => Some(at),
        _ => None,
    }
}

type Walked<T> = ControlFlow<Stop, T>;

fn known<T>(value: Option<T>) -> Walked<T> {
    value.map_or(Break(Stop::Unknown), Continue)
}

struct Component {
    id: u8,
    /// Blocks in a unit of the picture, across and down.
    h: usize,
    v: usize,
    /// Which coefficients of each block are not zero so far, in progressive files. Rows of whole units.
    seen: Vec<u64>,
}

struct Frame {
    progressive: bool,
    width: usize,
    height: usize,
    components: Vec<Component>,
}

impl Frame {
    /// The most blocks of a component in a unit, across and down.
    fn most(&self) -> [usize; 2] {
        let most = |of: fn(&Component) -> usize| self.components.iter().map(of).max().unwrap_or(1);
        [most(|c| c.h), most(|c| c.v)]
    }

    /// Units of the picture, across and down.
    fn units(&self) -> [usize; 2] {
        let [h, v] = self.most();
        [self.width.div_ceil(8 * h), self.height.div_ceil(8 * v)]
    }
}

/// Codes of a Huffman table.
#[derive(Default)]
struct Table {
    /// By the next eight bits: length and symbol of a code that short, or 0.
    short: Vec<[u8; 2]>,
    /// For each length the first code, the number of codes, and where their symbols begin.
    lengths: [(u32, u32, usize); 17],
    symbols: Vec<u8>,
}

impl Table {
    fn new(counts: &[u8], symbols: &[u8]) -> Self {
        let mut table = Self { short: vec![[0; 2]; 256], symbols: symbols.to_vec(), ..Self::default() };
        let (mut code, mut first) = (0u32, 0);
        for (length, count) in (1..17).zip(counts) {
            table.lengths[length] = (code, u32::from(*count), first);
            for i in 0..usize::from(*count) {
                if length <= 8 && code < 1 << length {
                    let from = (code as usize) << (8 - length);
                    let symbol = symbols.get(first + i).copied().unwrap_or(0);
                    table.short[from..from + (1 << (8 - length))].fill([length as u8, symbol]);
                }
                code += 1;
            }
            first += usize::from(*count);
            code <<= 1;
        }
        table
    }
}

/// Bits of a scan: up to the first mark that is none of a restart.
struct Bits<'a> {
    bytes: &'a [u8],
    at: usize,
    held: u64,
    count: u32,
}

impl Bits<'_> {
    fn fill(&mut self) {
        while self.count <= 48 {
            let byte = match self.bytes[self.at.min(self.bytes.len())..] {
                [0xff, 0, ..] => {
                    self.at += 2;
                    0xff
                }
                [0xff, ..] | [] => return,
                [byte, ..] => {
                    self.at += 1;
                    byte
                }
            };
            self.held = self.held << 8 | u64::from(byte);
            self.count += 8;
        }
    }

    fn bits(&mut self, n: u32) -> Walked<u32> {
        if self.count < n {
            self.fill();
        }
        if self.count < n {
            return Break(Stop::Short(self.at));
        }
        self.count -= n;
        Continue((self.held >> self.count) as u32 & ((1 << n) - 1))
    }

    fn symbol(&mut self, table: &Table) -> Walked<u8> {
        if self.count < 16 {
            self.fill();
        }
        if self.count >= 8 {
            let [length, symbol] = table.short[(self.held >> (self.count - 8)) as usize & 0xff];
            if length > 0 {
                self.count -= u32::from(length);
                return Continue(symbol);
            }
        }
        let mut code = 0;
        for (first, count, symbols) in &table.lengths[1..] {
            code = code << 1 | self.bits(1)?;
            if code.wrapping_sub(*first) < *count {
                return known(table.symbols.get(symbols + (code - first) as usize).copied());
            }
        }
        Break(Stop::Unknown)
    }

    /// Passes over the mark of a restart.
    fn restart(&mut self) -> Walked<()> {
        (self.held, self.count) = (0, 0);
        match self.bytes[self.at.min(self.bytes.len())..] {
            [0xff, 0xd0..=0xd7, ..] => {
                self.at += 2;
                Continue(())
            }
            [0xff, 0xd9, ..] => Break(Stop::Short(self.at)),
            _ => Break(Stop::Unknown),
        }
    }
}

/// What a scan says: its components with the numbers of their tables, and the coefficients that it has.
struct Scan {
    components: Vec<(usize, usize, usize)>,
    first: u32,
    last: u32,
    refines: bool,
}

struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    frame: Option<Frame>,
    /// Four tables for the first coefficient, four for the others.
    tables: [[Table; 4]; 2],
    /// Units between restarts; 0: there are none.
    restart: usize,
}

impl Walk<'_> {
    fn run(&mut self) -> Walked<()> {
        loop {
            let rest = known(self.bytes.get(self.at..))?;
            match *rest {
                [0xff, 0xd9, ..] => return Continue(()),
                [0xff, 0x01 | 0xd0..=0xd8, ..] => self.at += 2,
                [0xff, 0xff, ..] => self.at += 1,
                [0xff, mark, a, b, ..] => {
                    let length = usize::from(u16::from_be_bytes([a, b]));
                    let segment = known(rest.get(4..2 + length))?;
                    self.at += 2 + length;
                    self.segment(mark, segment)?;
                }
                _ => return Break(Stop::Unknown),
            }
        }
    }

    fn segment(&mut self, mark: u8, segment: &[u8]) -> Walked<()> {
        match mark {
            0xc0..=0xc2 if self.frame.is_none() => self.frame = Some(known(frame(mark, segment))?),
            0xc4 => known(self.read_tables(segment))?,
            0xc0..=0xcf => return Break(Stop::Unknown),
            0xdd => self.restart = u16::from_be_bytes(*known(segment.first_chunk())?).into(),
            0xda => {
                let mut frame = known(self.frame.take())?;
                let scan = known(scan(segment, &frame))?;
                let end = self.scan(&scan, &mut frame)?;
                self.frame = Some(frame);
                self.at = end;
            }
            _ => {}
        }
        Continue(())
    }

    fn read_tables(&mut self, mut segment: &[u8]) -> Option<()> {
        while let [kind, rest @ ..] = segment {
            let counts = rest.get(..16)?;
            let total = counts.iter().map(|n| usize::from(*n)).sum();
            let symbols = rest.get(16..)?.get(..total)?;
            let (class, id) = (usize::from(kind >> 4), usize::from(kind & 15));
            *self.tables.get_mut(class)?.get_mut(id)? = Table::new(counts, symbols);
            segment = &rest[16 + total..];
        }
        Some(())
    }

    /// Walks over the data of a scan. The byte behind them.
    fn scan(&self, scan: &Scan, frame: &mut Frame) -> Walked<usize> {
        let mut bits = Bits { bytes: self.bytes, at: self.at, held: 0, count: 0 };
        let [units_across, units_down] = frame.units();
        let [most_h, most_v] = frame.most();
        let single = scan.components.len() == 1;
        let [across, down] = match scan.components[..] {
            [(index, ..)] => {
                let c = &frame.components[index];
                [(frame.width * c.h).div_ceil(8 * most_h), (frame.height * c.v).div_ceil(8 * most_v)]
            }
            _ => [units_across, units_down],
        };
        let mut run = 0;
        for unit in 0..across * down {
            if self.restart > 0 && unit > 0 && unit.is_multiple_of(self.restart) {
                bits.restart()?;
                run = 0;
            }
            for &(index, dc, ac) in &scan.components {
                let tables = [&self.tables[0][dc], &self.tables[1][ac]];
                let component = &mut frame.components[index];
                if !frame.progressive {
                    let blocks = if single { 1 } else { component.h * component.v };
                    (0..blocks).try_for_each(|_| sequential(&mut bits, tables))?;
                } else if scan.first > 0 {
                    let stride = units_across * component.h;
                    let block = unit / across * stride + unit % across;
                    let seen = known(component.seen.get_mut(block))?;
                    progressive(&mut bits, tables[1], scan, seen, &mut run)?;
                } else {
                    let blocks = if single { 1 } else { component.h * component.v };
                    (0..blocks).try_for_each(|_| first_coefficient(&mut bits, tables[0], scan.refines))?;
                }
            }
        }
        // Bytes that were taken but not needed are no marks, so the next one lies ahead.
        let rest = self.bytes.get(bits.at..).unwrap_or(&[]);
        let next = rest.windows(2).position(|w| w[0] == 0xff && !matches!(w[1], 0 | 0xd0..=0xd7 | 0xff));
        Continue(bits.at + next.unwrap_or(rest.len()))
    }
}

fn frame(mark: u8, segment: &[u8]) -> Option<Frame> {
    let [_, h1, h0, w1, w0, count, rest @ ..] = segment else { return None };
    let [height, width] = [[*h1, *h0], [*w1, *w0]].map(|n| usize::from(u16::from_be_bytes(n)));
    let parts = rest.chunks_exact(3).take(usize::from(*count));
    let component = |p: &[u8]| Component {
        id: p[0],
        h: usize::from(p[1] >> 4),
        v: usize::from(p[1] & 15),
        seen: Vec::new(),
    };
    let components: Vec<Component> = parts.map(component).collect();
    let is_sound = components.iter().all(|c| (1..=4).contains(&c.h) && (1..=4).contains(&c.v));
    if !is_sound || components.is_empty() || components.len() > 4 || width * height == 0 {
        return None;
    }
    let mut frame = Frame { progressive: mark == 0xc2, width, height, components };
    // A component alone has blocks of its own, whatever it says.
    if let [only] = &mut frame.components[..] {
        (only.h, only.v) = (1, 1);
    }
    let [across, down] = frame.units();
    for c in frame.components.iter_mut().filter(|_| mark == 0xc2) {
        c.seen = vec![0; across * c.h * down * c.v];
    }
    Some(frame)
}

fn scan(segment: &[u8], frame: &Frame) -> Option<Scan> {
    let [count, rest @ ..] = segment else { return None };
    let (parts, tail) = rest.split_at_checked(2 * usize::from(*count))?;
    let component = |p: &[u8]| {
        let index = frame.components.iter().position(|c| c.id == p[0])?;
        let tables = [usize::from(p[1] >> 4), usize::from(p[1] & 15)];
        tables.iter().all(|t| *t < 4).then_some((index, tables[0], tables[1]))
    };
    let components: Vec<_> = parts.chunks_exact(2).map(component).collect::<Option<_>>()?;
    let [first, last, approximation, ..] = *tail else { return None };
    let is_sound = !components.is_empty() && components.len() <= 4 && last < 64;
    let is_alone = components.len() == 1 || first == 0;
    let refines = approximation >> 4 > 0;
    (is_sound && is_alone).then_some(Scan { components, first: first.into(), last: last.into(), refines })
}

/// A block of a sequential file.
fn sequential(bits: &mut Bits<'_>, [dc, ac]: [&Table; 2]) -> Walked<()> {
    first_coefficient(bits, dc, false)?;
    let mut k = 1;
    while k < 64 {
        let symbol = bits.symbol(known(Some(ac).filter(|t| !t.short.is_empty()))?)?;
        match (symbol >> 4, symbol & 15) {
            (15, 0) => k += 16,
            (_, 0) => break,
            (zeros, size) => {
                bits.bits(size.into())?;
                k += 1 + u32::from(zeros);
            }
        }
    }
    Continue(())
}

fn first_coefficient(bits: &mut Bits<'_>, table: &Table, refines: bool) -> Walked<()> {
    let size = if refines { 1 } else { bits.symbol(known(Some(table).filter(|t| !t.short.is_empty()))?)? };
    if size > 16 {
        return Break(Stop::Unknown);
    }
    bits.bits(size.into()).map_continue(drop)
}

/// A block of a progressive scan of higher coefficients. `run`: blocks that have no more of them, this one included.
fn progressive(bits: &mut Bits<'_>, table: &Table, scan: &Scan, seen: &mut u64, run: &mut u32) -> Walked<()> {
    let table = known(Some(table).filter(|t| !t.short.is_empty()))?;
    let mut k = scan.first;
    while *run == 0 && k <= scan.last {
        let symbol = bits.symbol(table)?;
        let (mut zeros, size) = (symbol >> 4, symbol & 15);
        if size == 0 && zeros < 15 {
            *run = (1 << zeros) + bits.bits(zeros.into())?;
            break;
        }
        bits.bits(size.into())?;
        while k <= scan.last {
            let is_seen = scan.refines && *seen >> k & 1 == 1;
            if is_seen {
                bits.bits(1)?;
            } else if zeros == 0 {
                break;
            } else {
                zeros -= 1;
            }
            k += 1;
        }
        if size > 0 && k <= scan.last {
            *seen |= 1 << k;
        }
        k += 1;
    }
    if *run > 0 {
        let rest = (k..=scan.last).filter(|k| scan.refines && *seen >> k & 1 == 1).count();
        (0..rest).try_for_each(|_| bits.bits(1).map_continue(drop))?;
        *run -= 1;
    }
    Continue(())
}
