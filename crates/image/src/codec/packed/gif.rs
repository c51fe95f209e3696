//! The blocks of a GIF file \[GIF\] to its end, and whether its palette has all colours of the first picture.

use crate::codec::{Result, Source};

/// Checks that all blocks are there, whole to the last, and the colours of the first picture.
pub fn check(source: &Source<'_>) -> Result<()> {
    let mut source = source.placed(6);
    let screen = source.take(7, "the size and the kind of the palette")?;
    let everywhere = palette(&mut source, screen[4])?;
    let (mut transparent, mut pictures) = (None, 0);
    loop {
        let at = source.at;
        match source.byte() {
            Some(b'!') => transparent = extension(&mut source)?.or(transparent),
            Some(b',') => {
                let place = source.take(9, "the place and size of a picture")?;
                let own = palette(&mut source, place[8])?;
                let colors = own.or(everywhere).filter(|_| pictures == 0);
                let codes = Codes::new(source.take(1, "the length of codes")?[0], transparent);
                data(&mut source, codes.filter(|_| colors.is_some()), colors.unwrap_or(0))?;
                pictures += 1;
            }
            // Some programs put one zero too many behind a picture.
            Some(0) if pictures > 0 => {}
            // Old programs leave out the mark of the end.
            Some(b';') | None if pictures > 0 => return Ok(()),
            found => {
                source.at = at;
                let found = found.map_or("the end of the file".to_owned(), |byte| match byte {
                    b';' => "the mark of the end".to_owned(),
                    byte => format!("byte 0x{byte:02x}"),
                });
                let expected =
                    if pictures == 0 { "a picture" } else { "a picture, or the mark of the end 0x3b" };
                return Err(source.fault(found, expected));
            }
        }
    }
}

/// The number of colours of the palette that follows, if these flags say that one does.
fn palette(source: &mut Source<'_>, flags: u8) -> Result<Option<usize>> {
    if flags & 0x80 == 0 {
        return Ok(None);
    }
    let colors = 2 << (flags & 7);
    source.take(3 * colors, "the palette")?;
    Ok(Some(colors))
}

/// Goes over an extension; the colour that it says is transparent.
fn extension(source: &mut Source<'_>) -> Result<Option<u8>> {
    let is_control = source.take(1, "the kind of an extension")?[0] == 0xf9;
    let mut transparent = None;
    while let Some(block) = block(source)? {
        // Flags, a time of two bytes, a colour.
        if let ([flags, _, _, color, ..], true) = (block, is_control) {
            transparent = (flags & 1 == 1).then_some(*color);
        }
    }
    Ok(transparent)
}

/// The next block of data; `None` behind the last.
fn block<'a>(source: &mut Source<'a>) -> Result<Option<&'a [u8]>> {
    let length = source.take(1, "the length of a block, 0 behind the last")?[0];
    if length == 0 {
        return Ok(None);
    }
    source.take(length.into(), "a block of data").map(Some)
}

/// Goes over the data of a picture with so many colours, and over its codes if they are to be checked.
fn data(source: &mut Source<'_>, mut codes: Option<Codes>, colors: usize) -> Result<()> {
    loop {
        let at = source.at;
        let Some(block) = block(source)? else { return Ok(()) };
        if let Some(color) = codes.as_mut().and_then(|codes| codes.outside(block, colors)) {
            source.at = at;
            let found = format!("colour {color} in the picture's data");
            return Err(source.fault(found, format!("colours 0 to {} of the palette", colors - 1)));
        }
    }
}

/// Walks over the codes of a picture without unpacking it: a colour first appears as a code of its own.
struct Codes {
    /// The code that starts anew; those below are colours, the next one is the end.
    clear: usize,
    transparent: Option<u8>,
    /// Bits of a code now.
    width: u32,
    /// Codes that have a meaning, that of the end among them.
    known: usize,
    /// Whether the next code comes first behind a new start, and gives no meaning to another.
    is_first: bool,
    held: u32,
    count: u32,
    ended: bool,
}

/// Codes are no longer than this.
const LONGEST: u32 = 12;

impl Codes {
    /// `None` if there is no such length of codes, which the decoding library tells.
    fn new(bits: u8, transparent: Option<u8>) -> Option<Self> {
        let width = u32::from(bits) + 1;
        let clear = 1 << bits.min(8);
        let state = Self {
            clear,
            transparent,
            width,
            known: clear + 2,
            is_first: true,
            held: 0,
            count: 0,
            ended: false,
        };
        (1..=8).contains(&bits).then_some(state)
    }

    /// The first colour of these bytes that is none of so many.
    fn outside(&mut self, block: &[u8], colors: usize) -> Option<usize> {
        for byte in block {
            if self.ended {
                break;
            }
            self.held |= u32::from(*byte) << self.count;
            self.count += 8;
            while self.count >= self.width && !self.ended {
                let code = self.held as usize & ((1 << self.width) - 1);
                self.held >>= self.width;
                self.count -= self.width;
                if code < self.clear && code >= colors && self.transparent.map(usize::from) != Some(code) {
                    return Some(code);
                }
                self.take(code);
            }
        }
        None
    }

    fn take(&mut self, code: usize) {
        if code == self.clear {
            self.width = self.clear.ilog2() + 1;
            self.known = self.clear + 2;
            self.is_first = true;
            return;
        }
        self.ended = code == self.clear + 1;
        if !self.is_first && self.known < 1 << LONGEST {
            self.known += 1;
            if self.known == 1 << self.width && self.width < LONGEST {
                self.width += 1;
            }
        }
        self.is_first = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use penombre_lab::Pcg32;
    use std::collections::HashMap;

    /// Codes of these colours as GIF packs them, whose lengths grow with the codes known so far.
    fn pack(colors: &[u8], bits: u32) -> Vec<u8> {
        let clear = 1usize << bits;
        let (mut table, mut width, mut known) = (HashMap::new(), bits + 1, clear + 2);
        let (mut held, mut count, mut out) = (0u64, 0, Vec::new());
        let mut put = |code: usize, width: u32| {
            held |= (code as u64) << count;
            count += width;
            while count >= 8 {
                out.push(held as u8);
                held >>= 8;
                count -= 8;
            }
        };
        put(clear, width);
        let mut current = usize::from(colors[0]);
        for color in &colors[1..] {
            if let Some(code) = table.get(&(current, *color)) {
                current = *code;
                continue;
            }
            put(current, width);
            if known < 1 << LONGEST {
                table.insert((current, *color), known);
                known += 1;
                if known > 1 << width {
                    width += 1;
                }
            } else {
                put(clear, width);
                table.clear();
                (width, known) = (bits + 1, clear + 2);
            }
            current = usize::from(*color);
        }
        put(current, width);
        put(clear + 1, width.min(LONGEST));
        put(0, 8);
        out
    }

    #[test]
    fn codes_are_walked_over_through_all_lengths() {
        let mut random = Pcg32::new(1);
        for (bits, colors) in [(2, 3), (4, 9), (7, 100), (8, 200)] {
            // Some runs, some noise: a table that fills several times.
            let mut pixels = Vec::new();
            while pixels.len() < 60_000 {
                let color = random.below(colors) as u8;
                pixels.extend(std::iter::repeat_n(color, 1 + random.below(5) as usize));
            }
            let outside = |pixels: &[u8]| {
                let mut codes = Codes::new(bits as u8, None).unwrap();
                pack(pixels, bits).chunks(255).find_map(|block| codes.outside(block, colors as usize))
            };
            assert_eq!(outside(&pixels), None, "{bits} bits");
            pixels.push(colors as u8);
            assert_eq!(outside(&pixels), Some(colors as usize), "{bits} bits");
        }
        assert!(Codes::new(0, None).is_none() && Codes::new(12, None).is_none());
    }
}
