//! `penombre diff`.

use crate::args::{DiffArgs, Verbosity};
use crate::convert::same_file;
use crate::{Exit, report, terminal};
use penombre_image::metrics::{Comparison, compare};
use penombre_image::{Image, WriteOptions, heatmap, metrics};
use serde_json::json;
use std::path::Path;

/// Compares two images. 0: equal within the tolerance, 1: different, 2: they cannot be compared.
pub fn run(args: &DiffArgs, verbosity: &Verbosity) -> Exit {
    if let Some(output) = args.output.as_deref().filter(|o| same_file(o, &args.a) || same_file(o, &args.b)) {
        let message = format!("the heat map would replace {}, one of the images", output.display());
        report::error(&message, "choose another name for `-o`");
        return Exit::Usage;
    }
    let (Some(a), Some(b)) = (read(&args.a), read(&args.b)) else { return Exit::Usage };
    let comparison = match compare(&a, &b) {
        Ok(comparison) => comparison,
        Err(error) => {
            let names = format!("{} and {}", args.a.display(), args.b.display());
            report::error(&format!("cannot compare {names}: {error}"), "render both with the same `--size`");
            return Exit::Usage;
        }
    };
    if let Some(path) = &args.output {
        let saved = metrics::flip_map(&a, &b).map_err(|e| e.to_string()).and_then(|map| {
            penombre_image::save(path, &heatmap(&map, 1.0), &WriteOptions::default())
                .map_err(|e| e.to_string())
        });
        if let Err(error) = saved {
            report::error(&format!("the heat map was not saved: {error}"), "");
            return Exit::Usage;
        }
    }
    let equal = comparison.max_abs <= f64::from(args.tolerance) && comparison.non_finite == 0;
    if args.json || !verbosity.quiet {
        print(args, &comparison, equal);
    }
    if equal { Exit::Done } else { Exit::Failure }
}

fn read(path: &Path) -> Option<Image> {
    match penombre_image::load(path) {
        Ok(image) => Some(image),
        Err(error) => {
            report::error(&error.to_string(), crate::convert::READABLE);
            None
        }
    }
}

fn print(args: &DiffArgs, c: &Comparison, equal: bool) {
    if args.json {
        // Infinite PSNR of equal images and undefined ratios have no number in JSON: null.
        let line = json!({
            "a": args.a, "b": args.b, "equal": equal, "tolerance": args.tolerance,
            "mse": c.mse, "rmse": c.rmse, "rel_mse": c.rel_mse, "psnr": c.psnr, "ssim": c.ssim,
            "flip": c.flip, "max": c.max_abs, "mean_ratio": c.mean_ratio, "non_finite": c.non_finite,
        });
        return terminal::out(&line.to_string());
    }
    if c.non_finite > 0 {
        terminal::out(&format!(
            "{} pixels are not finite in one of the images and were left out",
            c.non_finite
        ));
    }
    let verdict = if equal { "equal" } else { "different" };
    terminal::out(&format!(
        "{verdict}\nMSE        {}\nRMSE       {}\nrelMSE     {}\nPSNR       {} dB\nSSIM       {}\nFLIP       {}\nmax        \
         {}\nmean ratio {:?}",
        c.mse, c.rmse, c.rel_mse, c.psnr, c.ssim, c.flip, c.max_abs, c.mean_ratio
    ));
}
