//! Colours that are numbers in a palette: whether it has them all. The decoding libraries show what it lacks black.

/// The first of `count` samples of `depth` bits (1, 2, 4 or 8), the highest bits of a byte first, that is none of the
/// numbers below `colors`: its byte and itself.
pub fn first_outside(bytes: &[u8], depth: u32, count: usize, colors: usize) -> Option<(usize, usize)> {
    let per_byte = (8 / depth) as usize;
    let (log, mask) = (per_byte.ilog2(), (1 << depth) - 1);
    let sample = |n: usize| {
        let shift = 8 - depth - (n & (per_byte - 1)) as u32 * depth;
        usize::from(bytes[n >> log] >> shift) & mask
    };
    let count = count.min(bytes.len() * per_byte);
    (0..count).map(|n| (n >> log, sample(n))).find(|(_, sample)| *sample >= colors)
}

#[cfg(test)]
mod tests {
    use super::first_outside;

    #[test]
    fn samples_are_counted_from_the_highest_bits() {
        assert_eq!(first_outside(&[0b0110_0011], 2, 4, 3), Some((0, 3)));
        assert_eq!(first_outside(&[0b0110_0011], 2, 3, 3), None);
        assert_eq!(first_outside(&[0x12, 0x34], 4, 9, 4), Some((1, 4)));
        assert_eq!(first_outside(&[7, 8], 8, 2, 8), Some((1, 8)));
        assert_eq!(first_outside(&[0x80], 1, 8, 1), Some((0, 1)));
        assert_eq!(first_outside(&[], 1, 8, 1), None);
    }
}
