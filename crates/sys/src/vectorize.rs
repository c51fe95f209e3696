//! Code compiled for wider vectors, chosen at run time.

#[cfg(target_arch = "x86_64")]
use std::sync::LazyLock;

/// A piece of work that gains from wider vectors: plain loops over arrays.
///
/// Mark `run` and all that it calls `#[inline(always)]`, so that it is compiled anew for each instruction set.
/// Nothing is contracted into fused operations, so the results have the same bits on all of them.
pub trait Vectorizable {
    /// What the work yields.
    type Output;

    /// Does the work.
    fn run(self) -> Self::Output;
}

/// Does the work with AVX2 if the processor has it, else with the baseline instruction set, and always with that if the
/// environment variable `PENOMBRE_INSTRUCTIONS` is `portable`. Costs a few nanoseconds: call it for pieces of work
/// that take much longer.
#[inline]
pub fn vectorize<V: Vectorizable>(work: V) -> V::Output {
    #[cfg(target_arch = "x86_64")]
    if std::is_x86_feature_detected!("avx2") && !is_limited() {
        // SAFETY: the processor has just been found to have AVX2.
        return unsafe { with_avx2(work) };
    }
    work.run()
}

/// Whether the environment asks for the baseline instruction set.
#[cfg(target_arch = "x86_64")]
fn is_limited() -> bool {
    static LIMITED: LazyLock<bool> =
        LazyLock::new(|| std::env::var_os("PENOMBRE_INSTRUCTIONS").is_some_and(|set| set == "portable"));
    *LIMITED
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2")]
fn with_avx2<V: Vectorizable>(work: V) -> V::Output {
    work.run()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Clone)]
    struct Polynomial([f32; 37]);

    impl Vectorizable for Polynomial {
        type Output = [u32; 37];

        #[inline(always)]
        fn run(self) -> [u32; 37] {
            self.0.map(|x| ((x * 1.1 + 0.3) * x - x / (x + 1e-3)).to_bits())
        }
    }

    #[test]
    fn results_have_the_bits_of_plain_code() {
        let work = Polynomial(std::array::from_fn(|i| (i as f32 - 11.3) * 0.37));
        assert_eq!(vectorize(work.clone()), work.run());
    }
}
