//! What is wrong with the picture of a PNG file, in words.

use crate::codec::Source;
use crate::error::ImageErrorKind;
use ::png::DecodingError;

/// What the decoding library says, or what we do.
pub enum Fault {
    Library(DecodingError),
    Ours(ImageErrorKind),
    /// What was found, and what was expected, at the place that the decoder has reached.
    Here(String, String),
}

impl From<DecodingError> for Fault {
    fn from(error: DecodingError) -> Self {
        Self::Library(error)
    }
}

impl Fault {
    /// As an error at the place that the decoder has reached.
    pub fn told(self, source: &Source<'_>) -> ImageErrorKind {
        let error = match self {
            Self::Ours(kind) => return kind,
            Self::Here(found, expected) => return source.fault(found, expected),
            Self::Library(error) => error,
        };
        if matches!(error, DecodingError::LimitsExceeded) {
            return source.fault("very long texts or rows", "at most 64 MiB");
        }
        let text = error.to_string();
        if let Some(filter) = text.trim_end_matches('.').strip_prefix("Unknown filter method ") {
            return source.fault(format!("filter {filter}"), "filter 0 to 4 at the start of each row");
        }
        match WORDS.iter().find(|(part, _, _)| text.contains(part)) {
            Some((_, found, expected)) => source.fault(*found, *expected),
            None => source.fault(text.trim_end_matches('.'), "a sound PNG picture"),
        }
    }
}

const ZLIB: &str = "data that zlib packed";

/// What texts of the library contain, what was found and what was expected. Other faults of a file are found before, by
/// the walk over its chunks.
const WORDS: [(&str, &str, &str); 10] = [
    ("does not have enough data", "the end of the picture's data", "data for all of its rows"),
    ("IDAT or fdAT chunk is missing", "no picture", "chunk IDAT, with the picture"),
    ("WrongChecksum", "another Adler-32 sum of the picture's data", "the sum that is stored behind them"),
    ("InsufficientInput", "the end of the picture's data", "data for all of its rows"),
    ("BadZlibHeader", "picture data that do not begin as those of zlib", ZLIB),
    ("InvalidBlockType", "a block of an unknown kind in the picture's data", ZLIB),
    ("InvalidUncompressedBlockLength", "a block with a wrong length in the picture's data", ZLIB),
    ("DistanceTooFarBack", "a copy from before the start of the picture's data", ZLIB),
    ("InputStartsWithRun", "a copy from before the start of the picture's data", ZLIB),
    ("Corrupt deflate stream", "a broken code in the picture's data", ZLIB),
];
