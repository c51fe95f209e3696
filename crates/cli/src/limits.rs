//! Limits of a render: samples, error, time.

use crate::args::RenderArgs;
use penombre::Job;
use std::time::Duration;

/// Samples per pixel of a render that ends by its error or by time, unless told otherwise.
pub const MOST_SPP: u32 = 65536;

/// Units of `--time` and their seconds.
const UNITS: [(&str, f64); 3] = [("s", 1.0), ("min", 60.0), ("h", 3600.0)];

/// Longest `--time`, seconds: a year.
const LONGEST: f64 = 366.0 * 24.0 * 3600.0;

/// Writes what the command line asks of limits and layers into the job.
pub fn apply(args: &RenderArgs, job: &mut Job) {
    let spp_is_given = args.scene.spp.is_some() || args.scene.set.iter().any(|set| sets_spp(set));
    if (args.noise.is_some() || args.time.is_some()) && !spp_is_given {
        job.spp = MOST_SPP;
    }
    job.noise = args.noise.unwrap_or(0.0);
    job.estimate = args.noise.is_some() || args.aov.iter().any(|layer| layer.needs_estimate());
    job.features = args.aov.iter().any(|layer| layer.needs_features());
    // Passes of one sample: little of the time is lost in a pass that is not whole when time is up.
    (job.whole_passes, job.progressive) = (args.time.is_some(), args.time.is_some());
}

/// True for `render.spp=…`.
fn sets_spp(set: &str) -> bool {
    set.split('=').next().is_some_and(|path| path.trim() == "render.spp")
}

/// `--noise`: above 0.
pub fn parse_noise(text: &str) -> Result<f32, String> {
    match text.parse::<f32>() {
        Ok(v) if v > 0.0 && v.is_finite() => Ok(v),
        _ => Err("expected a number above 0, for example 0.02".to_owned()),
    }
}

/// `--time`: a number of seconds, or with a unit.
pub fn parse_time(text: &str) -> Result<Duration, String> {
    let text = text.trim();
    let split =
        text.find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | '-' | '+'))).unwrap_or(text.len());
    let (number, unit) = (&text[..split], text[split..].trim());
    let factor = if unit.is_empty() {
        1.0
    } else {
        let known = UNITS.iter().find(|(name, _)| *name == unit);
        known.ok_or_else(|| format!("found the unit `{unit}`, expected s, min or h, for example 90s"))?.1
    };
    match number.parse::<f64>().map(|v| v * factor) {
        Ok(seconds) if seconds > 0.0 && seconds <= LONGEST => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("expected a time above 0 and of at most a year, for example 90s, 5min, 2h".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_read_strictly() {
        for (text, seconds) in
            [("90", 90.0), ("90s", 90.0), ("1.5 min", 90.0), ("2h", 7200.0), ("0.25s", 0.25), (".5", 0.5)]
        {
            assert_eq!(parse_time(text), Ok(Duration::from_secs_f64(seconds)), "{text}");
        }
        for bad in ["", "s", "-1s", "0", "1d", "1 m", "nan", "inf", "1e9", "1h30", "9999999h", "ß"] {
            assert!(parse_time(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn noise_limits_are_positive_numbers() {
        assert_eq!(parse_noise("0.02"), Ok(0.02));
        for bad in ["0", "-1", "nan", "inf", "x", "2%"] {
            assert!(parse_noise(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn samples_may_be_set_by_path() {
        assert!(sets_spp("render.spp=4") && sets_spp("render.spp = 4"));
        assert!(!sets_spp("render.sppx=4") && !sets_spp("render.seed=4"));
    }
}
