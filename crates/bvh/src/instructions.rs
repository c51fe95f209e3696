//! Which instructions of the processor are used.

use std::fmt;
use std::str::FromStr;

/// Instructions with which rays are followed, the slower first. All give the same hits, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum InstructionSet {
    /// Those that every processor of its kind has.
    Portable,
    /// AVX2, FMA, BMI1, BMI2, LZCNT and POPCNT of x86-64.
    Avx2,
    /// AVX-512 F and VL beside these.
    Avx512,
}

impl InstructionSet {
    const ALL: [Self; 3] = [Self::Portable, Self::Avx2, Self::Avx512];

    /// Names the set that hierarchies use at most unless [`BuildOptions::instructions`](crate::BuildOptions::instructions)
    /// says otherwise: for measurements and to find out whether a fault comes from a processor.
    pub const VARIABLE: &str = "PENOMBRE_INSTRUCTIONS";

    /// Those of this processor, the fastest last.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|set| set.is_available()).collect()
    }

    /// The fastest of this processor that the environment allows. What [`InstructionSet::from_environment`] refuses
    /// limits nothing.
    pub fn best() -> Self {
        let limit = Self::from_environment().ok().flatten();
        let allowed = |set: &Self| limit.is_none_or(|limit| *set <= limit);
        Self::available().into_iter().rfind(allowed).unwrap_or(Self::Portable)
    }

    /// The set that [`InstructionSet::VARIABLE`] names, if there is such a variable.
    ///
    /// # Errors
    /// A name of no set.
    pub fn from_environment() -> Result<Option<Self>, UnknownInstructionSet> {
        std::env::var_os(Self::VARIABLE).map(|name| name.to_string_lossy().parse()).transpose()
    }

    /// Its name: `portable`, `avx2`, `avx512`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    #[cfg(target_arch = "x86_64")]
    fn is_available(self) -> bool {
        use std::is_x86_feature_detected as has;
        let avx2 =
            || has!("avx2") && has!("fma") && has!("bmi1") && has!("bmi2") && has!("lzcnt") && has!("popcnt");
        match self {
            Self::Portable => true,
            Self::Avx2 => avx2(),
            Self::Avx512 => avx2() && has!("avx512f") && has!("avx512vl"),
        }
    }

    #[cfg(not(target_arch = "x86_64"))]
    fn is_available(self) -> bool {
        self == Self::Portable
    }
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name of no set of instructions.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is no set of instructions; there are portable, avx2 and avx512")]
pub struct UnknownInstructionSet(String);

impl FromStr for InstructionSet {
    type Err = UnknownInstructionSet;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        let found = Self::ALL.into_iter().find(|set| set.name() == name);
        found.ok_or_else(|| UnknownInstructionSet(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for set in InstructionSet::ALL {
            assert_eq!(set.to_string().parse(), Ok(set));
        }
        let unknown: Result<InstructionSet, _> = "sse".parse();
        assert!(unknown.is_err_and(|e| e.to_string().contains("`sse`")));
    }

    #[test]
    fn every_processor_has_the_first() {
        assert_eq!(InstructionSet::available().first(), Some(&InstructionSet::Portable));
    }
}
