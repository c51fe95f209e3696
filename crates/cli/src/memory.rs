//! `--memory-limit`: what a scene may take, told before its files are decoded and again before it is built.

use crate::args::RenderArgs;
use crate::limits;
use penombre::Job;
use penombre::film::FilmLayer;
use penombre::render::MemoryEstimate;
use penombre_scene::assets::AssetMemory;
use penombre_scene::{Diagnostic, SceneDescription, Severity, Span};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Units of `--memory-limit` and their bytes; those of one letter are as people mean them.
const UNITS: [(&str, u64); 13] = [
    ("", 1),
    ("B", 1),
    ("K", 1 << 10),
    ("KB", 1000),
    ("KiB", 1 << 10),
    ("M", 1 << 20),
    ("MB", 1_000_000),
    ("MiB", 1 << 20),
    ("G", 1 << 30),
    ("GB", 1_000_000_000),
    ("GiB", 1 << 30),
    ("T", 1 << 40),
    ("TiB", 1 << 40),
];

/// A limit below this would refuse everything: a unit was forgotten.
const LEAST: u64 = 1 << 20;

/// `--memory-limit`: a number of bytes, or with a unit.
pub fn parse_memory(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let split =
        text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+'))).unwrap_or(text.len());
    let (number, unit) = (&text[..split], text[split..].trim());
    let known = UNITS.iter().find(|(name, _)| name.eq_ignore_ascii_case(unit));
    let factor = known
        .ok_or_else(|| format!("found the unit `{unit}`, expected K, M, G, KiB, MiB, GiB, KB, MB or GB"))?
        .1;
    let example = "for example 8G, 512M or 1.5GiB";
    match number.parse::<f64>().map(|v| v * factor as f64) {
        Ok(bytes) if bytes >= LEAST as f64 && bytes < (1u64 << 60) as f64 => Ok(bytes as u64),
        Ok(bytes) if (0.0..LEAST as f64).contains(&bytes) => {
            Err(format!("found {bytes} bytes, expected at least 1 MiB, {example}"))
        }
        _ => Err(format!("expected an amount of memory, {example}")),
    }
}

/// What a loaded scene is for.
#[derive(Clone, Copy, Debug)]
pub enum Use<'a> {
    /// It is rendered as those arguments say.
    Render(&'a RenderArgs),
    /// It is told what is in it: a render counts only for a limit that was asked for.
    Tell,
    /// Single paths are followed: no render counts.
    Trace,
}

/// Compares what a scene takes with what it may take.
pub struct Budget<'a> {
    asked: Option<u64>,
    usage: Use<'a>,
    /// Memory of the process when the first estimate is made, and what is free then, bytes.
    begin: OnceLock<(u64, Option<u64>)>,
    /// Most that decoding was estimated to take beside the files' contents, bytes: afterwards that is not known.
    decoding: AtomicU64,
}

impl<'a> Budget<'a> {
    /// `asked`: the limit, bytes; without one it is what the machine can give.
    pub fn new(asked: Option<u64>, usage: Use<'a>) -> Self {
        Self { asked, usage, begin: OnceLock::new(), decoding: AtomicU64::new(0) }
    }

    /// What it takes to load the scene and do what it is loaded for; with `whole` to render it in any case.
    pub fn estimate(
        &self,
        description: &SceneDescription,
        assets: &AssetMemory,
        whole: bool,
    ) -> MemoryEstimate {
        let (program, _) = self.begin();
        let decoding = self.decoding.fetch_max(assets.decoding, Ordering::Relaxed).max(assets.decoding);
        let assets = &AssetMemory { decoding, ..*assets };
        let mut job = Job::planned(description);
        let (mut layers, mut threads): (&[FilmLayer], _) = (&[], all_cores());
        if let Use::Render(args) = self.usage {
            limits::apply(args, &mut job);
            (layers, threads) = (&args.aov, args.threads.map_or(threads, |n| n as usize));
        }
        let counts = match self.usage {
            Use::Render(_) => true,
            Use::Tell => whole || self.asked.is_some(),
            Use::Trace => false,
        };
        // Larger images are refused whatever memory there is.
        let pixels = u64::from(job.size[0]) * u64::from(job.size[1]);
        let job = (counts && pixels <= penombre_image::MAX_PIXELS).then_some((&job, layers, threads));
        MemoryEstimate::new(program, description, assets, job)
    }

    fn begin(&self) -> (u64, Option<u64>) {
        let now = || (penombre_sys::peak_rss().unwrap_or(0), penombre_sys::available_memory());
        *self.begin.get_or_init(now)
    }

    /// A fault if the scene takes more than it may.
    pub fn check(&self, description: &SceneDescription, assets: &AssetMemory) -> Option<Diagnostic> {
        let estimate = self.estimate(description, assets, false);
        let (program, free) = self.begin();
        let (limit, said) = match (self.asked, free) {
            (Some(limit), _) => (limit, format!("`--memory-limit` is {}", bytes(limit))),
            // What the process has already is not free any more.
            (None, Some(free)) => (free.saturating_add(program), format!("{} are free", bytes(free))),
            (None, None) => return None,
        };
        refusal(&estimate, limit, &said)
    }
}

fn refusal(estimate: &MemoryEstimate, limit: u64, said: &str) -> Option<Diagnostic> {
    let total = estimate.total();
    if total <= limit {
        return None;
    }
    // What is less than a hundredth helps nobody.
    let parts = estimate.parts().iter().filter(|part| part.bytes >= total / 100);
    let parts: Vec<String> = parts.map(|part| format!("{} {}", part.what, bytes(part.bytes))).collect();
    let message = format!("about {} of memory are needed: {}; {said}", bytes(total), parts.join(", "));
    let smaller = match estimate.parts().first().map(|part| part.what) {
        Some("film" | "image files") => "choose a smaller `--size` or fewer layers",
        Some("images" | "tables of lights") => "make the images smaller",
        Some("meshes" | "shapes" | "the acceleration structure") => {
            "use meshes of fewer triangles, or `instance` for those that are there several times"
        }
        _ => "make the files smaller",
    };
    let help = format!("nothing was built; {smaller}, or allow more with `--memory-limit`");
    Some(Diagnostic::new(Severity::Error, "memory::limit", Span::NONE, message).help(help))
}

fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// `3 B`, `2.5 KiB`, `1.0 MiB`, `5.1 GiB`.
pub fn bytes(n: u64) -> String {
    const NAMES: [&str; 5] = ["KiB", "MiB", "GiB", "TiB", "PiB"];
    if n < 1024 {
        return format!("{n} B");
    }
    let step = (n.ilog2() as usize / 10).min(NAMES.len());
    format!("{:.1} {}", n as f64 / (1u64 << (10 * step)) as f64, NAMES[step - 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_read_strictly() {
        for (text, expected) in [
            ("8G", 8 << 30),
            ("512M", 512 << 20),
            ("1.5GiB", 3 << 29),
            ("1.5 gib", 3 << 29),
            ("2GB", 2_000_000_000),
            ("4096k", 4 << 20),
            ("2000000", 2_000_000),
            ("1T", 1 << 40),
        ] {
            assert_eq!(parse_memory(text), Ok(expected), "{text}");
        }
        for bad in ["", "G", "-1G", "8X", "nan", "1e9", "0", "1000", "8G8", "99999999T", "1,5G", "ß", "8 G B"]
        {
            assert!(parse_memory(bad).is_err(), "{bad}");
        }
        assert!(parse_memory("8").unwrap_err().contains("at least 1 MiB"));
        assert!(parse_memory("8X").unwrap_err().contains("`X`"));
    }

    #[test]
    fn amounts_read_well() {
        let cases =
            [(0, "0 B"), (1023, "1023 B"), (1536, "1.5 KiB"), (1 << 20, "1.0 MiB"), (5 << 40, "5.0 TiB")];
        for (n, text) in cases {
            assert_eq!(bytes(n), text);
        }
        assert_eq!(bytes(u64::MAX), "16384.0 PiB");
    }

    #[test]
    fn a_refusal_names_the_parts_and_what_to_do() {
        let mut assets = AssetMemory { images: 5 << 30, meshes: 100, ..AssetMemory::default() };
        let scene = SceneDescription::default();
        let said = "`--memory-limit` is 4.0 GiB";
        let estimate = MemoryEstimate::new(80 << 20, &scene, &assets, None);
        let fault = refusal(&estimate, 4 << 30, said).unwrap();
        let expected = "about 5.1 GiB of memory are needed: images 5.0 GiB, the program 80.0 MiB; `--memory-limit` is 4.0 GiB";
        assert_eq!(fault.message, expected);
        assert!(fault.help.contains("images smaller") && fault.help.contains("--memory-limit"));
        assets.images = 0;
        assert_eq!(refusal(&MemoryEstimate::new(80 << 20, &scene, &assets, None), 4 << 30, said), None);
    }
}
