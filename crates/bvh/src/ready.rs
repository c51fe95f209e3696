//! Eight rays made ready at once, which takes a fifth of the instructions of one after the other.

use crate::Ray;
use crate::bvh::Tree;
use crate::kernel::{READY_WORDS, ROW, numbers_of, words_of_mut};
use crate::lanes::{Eight, Machine};
use crate::node::{BESIDE, ORIGIN_ROUNDINGS, PARALLEL, STRETCH, UNDERFLOW};
use crate::prepared::{NEGLIGIBLE, NORMAL, ORDINARY, TAME};
use crate::traverse::ReadyRay;

/// A vector of each ray.
type Vectors<M> = [<M as Machine>::Eight; 3];

/// What decides the order of axes: sizes of the components, and the largest of them.
struct Sizes<M: Machine> {
    components: Vectors<M>,
    longest: M::Eight,
}

impl<M: Machine> Sizes<M> {
    /// The first of `choices` where x is the main axis, and so on; the first axis among equals.
    #[inline(always)]
    fn choose(&self, choices: Vectors<M>) -> M::Eight {
        let ([x, y, _], [if_x, if_y, if_z]) = (self.components, choices);
        x.if_below(self.longest, y.if_below(self.longest, if_z, if_y), if_x)
    }

    /// In the order of axes that makes the main one the last.
    #[inline(always)]
    fn turn(&self, [x, y, z]: Vectors<M>) -> Vectors<M> {
        [self.choose([y, z, x]), self.choose([z, x, y]), self.choose([x, y, z])]
    }
}

/// Makes `rays` ready: what [`ReadyRay::new`] of [`crate::prepared::PreparedRay::new`] is. Returns as bits which of them
/// are; the others are not ordinary, look before their origin, or hit nothing.
#[inline(always)]
pub(crate) fn eight<M: Machine>(rays: &[Ray; 8], tree: &Tree, to: &mut [ReadyRay; 8]) -> u32 {
    // No closures and no `map`: they would not be compiled for the instruction set chosen.
    let [r0, r1, r2, r3, r4, r5, r6, r7] = rays;
    let [ox, oy, oz, t_min, dx, dy, dz, t_max] = M::Eight::transposed([
        M::Eight::load(numbers_of(r0)),
        M::Eight::load(numbers_of(r1)),
        M::Eight::load(numbers_of(r2)),
        M::Eight::load(numbers_of(r3)),
        M::Eight::load(numbers_of(r4)),
        M::Eight::load(numbers_of(r5)),
        M::Eight::load(numbers_of(r6)),
        M::Eight::load(numbers_of(r7)),
    ]);
    let (zero, one) = (M::Eight::splat(0.0), M::Eight::splat(1.0));
    let sizes = [dx.abs(), dy.abs(), dz.abs()];
    let longest = sizes[0].larger(sizes[1]).larger(sizes[2]);
    let far = M::Eight::splat(tree.extent).plus(ox.abs().larger(oy.abs()).larger(oz.abs()));
    let nothing = ox.plus(oy).plus(oz).plus(dx).plus(dy).plus(dz).times(zero);
    let sane = nothing.abs().below(one)
        & t_min.below(t_max)
        & M::Eight::splat(1.0 / ORDINARY).below(longest)
        & longest.below(M::Eight::splat(ORDINARY))
        & far.below(M::Eight::splat(TAME))
        & M::Eight::splat(-f32::MIN_POSITIVE).below(t_min);

    let least = longest.times(M::Eight::splat(NEGLIGIBLE));
    let shift = far.times(M::Eight::splat(tree.aside));
    let shift_along = far.times(M::Eight::splat(tree.aside + BESIDE));
    let x = Axis::<M>::new(ox, dx, sizes[0], least, shift, shift_along);
    let y = Axis::<M>::new(oy, dy, sizes[1], least, shift, shift_along);
    let z = Axis::<M>::new(oz, dz, sizes[2], least, shift, shift_along);
    let octant = x.backward(1).or(y.backward(2)).or(z.backward(4));
    let tiny = M::Eight::splat(f32::MIN_POSITIVE);
    let slack = t_max.abs().times(M::Eight::splat(STRETCH - 1.0)).plus(tiny);

    let sizes = Sizes::<M> { components: sizes, longest };
    let [tx, ty, tz] = sizes.turn([ox, oy, oz]);
    let [a, b, pace] = sizes.turn([x.dir, y.dir, z.dir]);
    let normal = M::Eight::splat(NORMAL);
    let [kx, ky, kz] = sizes.turn([zero, word::<M>(ROW), word::<M>(2 * ROW)]);
    let columns = [
        [x.inverse, y.inverse, z.inverse, x.near, y.near, z.near, x.far, y.far],
        [z.far, t_min.minus(tiny), one, octant, x.stretched, y.stretched, z.stretched, t_max.plus(slack)],
        [tx, ty, tz, a.over(pace), b.over(pace), pace, one.over(pace), normal.if_below(t_min, t_min, normal)],
        [zero, kx, ky, kz, t_min, t_max, one, far],
        [ox, oy, oz, zero, x.dir, y.dir, z.dir, zero],
    ];
    let mut at = 0;
    while at < columns.len() {
        write::<M>(columns[at], 8 * at, to);
        at += 1;
    }
    sane
}

/// Writes eight words of each ray.
#[inline(always)]
fn write<M: Machine>(columns: [M::Eight; 8], at: usize, to: &mut [ReadyRay; 8]) {
    const { assert!(READY_WORDS == 40) }
    let rows = M::Eight::transposed(columns);
    let mut i = 0;
    while i < 8 {
        let words = words_of_mut(&mut to[i]);
        if let Some(words) = words[at..].first_chunk_mut() {
            rows[i].store(words);
        }
        i += 1;
    }
}

/// A number by its bits.
#[inline(always)]
fn word<M: Machine>(bits: u32) -> M::Eight {
    M::Eight::splat(f32::from_bits(bits))
}

/// What [`crate::node::BoxRay`] derives for one axis.
struct Axis<M: Machine> {
    /// The direction's component, 0 if it is negligible.
    dir: M::Eight,
    inverse: M::Eight,
    near: M::Eight,
    far: M::Eight,
    stretched: M::Eight,
}

impl<M: Machine> Axis<M> {
    #[inline(always)]
    fn new(
        origin: M::Eight,
        dir: M::Eight,
        size: M::Eight,
        least: M::Eight,
        shift: M::Eight,
        shift_along: M::Eight,
    ) -> Self {
        let parallel =
            dir.if_below(M::Eight::splat(0.0), M::Eight::splat(-PARALLEL), M::Eight::splat(PARALLEL));
        let inverse = size.if_below(least, parallel, M::Eight::splat(1.0).over(dir));
        let shift = size.if_below(least, shift_along, shift);
        let allowance = (origin.abs().times(M::Eight::splat(ORIGIN_ROUNDINGS)).plus(shift))
            .times(inverse.abs())
            .plus(M::Eight::splat(UNDERFLOW));
        let at = origin.times(inverse);
        Self {
            dir: size.if_below(least, M::Eight::splat(0.0), dir),
            inverse,
            near: at.plus(allowance),
            far: at.minus(allowance).times(M::Eight::splat(STRETCH)),
            stretched: inverse.times(M::Eight::splat(STRETCH)),
        }
    }

    /// `bit` where the ray goes backward.
    #[inline(always)]
    fn backward(&self, bit: u32) -> M::Eight {
        let zero = M::Eight::splat(0.0);
        self.inverse.if_below(zero, word::<M>(bit), zero)
    }
}
