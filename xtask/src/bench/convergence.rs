//! How the error falls with the number of samples: a table, a slope and a picture for each scene.

use super::peers::{Peers, REFERENCES};
use super::plot::{Diagram, Line};
use super::{Folder, number_option, rel_mse};
use crate::run::{Call, Outcome, release_binary, root};

/// Samplers of ours, and the colour of their lines: to be told apart with any kind of sight.
const SAMPLERS: [(&str, &str); 3] =
    [("sobol", "#0072b2"), ("stratified", "#009e73"), ("independent", "#d55e00")];
const MITSUBA: (&str, &str) = ("Mitsuba, independent", "#555555");
const FEWEST: u32 = 4;

/// The slope is that of the points whose error is this many times the noise of the reference or more: what is subtracted is
/// then a quarter of the rest at most.
const CLEAR: f64 = 5.0;

/// Renders at 4, 8, … samples per pixel, up to `--most N` (default 4096), and writes `docs/images/convergence-*.svg`.
pub fn run(options: &[&str]) -> Outcome {
    let most = number_option(options, "--most", 4096)?;
    let peers = Peers::find()?;
    super::build_command()?;
    let folder = Folder::new("convergence")?;
    let counts: Vec<u32> = (0..).map(|i| FEWEST << i).take_while(|n| *n <= most).collect();
    println!("relMSE against references whose own noise is subtracted; 256 × 256, one thread");
    for (scene, noise) in REFERENCES {
        let file = peers.scene_file(scene, folder.path(), 256)?;
        let reference = peers.reference(scene);
        let mut lines = Vec::new();
        for (sampler, color) in SAMPLERS {
            let error = |spp: u32| {
                let image = folder.file("image.exr");
                let set = format!("render.sampler=\"{sampler}\"");
                let spp = spp.to_string();
                let words = ["render", &file, "--asset-root", "/", "--set", &set, "--spp", &spp];
                let output = ["--threads", "1", "--no-progress", "-q", "-o", &image];
                Call::new(release_binary(), &[&words[..], &output[..]].concat()).status()?;
                rel_mse(&image, &reference)
            };
            lines.push(line(scene, sampler, color, noise, &counts, error)?);
        }
        let error = |spp| peers.mitsuba(scene, spp);
        match line(scene, MITSUBA.0, MITSUBA.1, noise, &counts, error) {
            Ok(line) => lines.push(line),
            Err(message) => println!("{scene}: without Mitsuba: {message}"),
        }
        let title = format!("ref-{scene}: relMSE against samples per pixel");
        let place = format!("docs/images/convergence-{scene}.svg");
        let svg = Diagram { title, across: "samples per pixel".to_owned(), lines }.svg();
        std::fs::write(root().join(&place), svg).map_err(|e| format!("{place}: {e}"))?;
        println!("{place}");
    }
    Ok(())
}

/// Measures one line, prints it, and returns it for the picture.
fn line(
    scene: &str,
    name: &str,
    color: &'static str,
    noise: f64,
    counts: &[u32],
    error: impl Fn(u32) -> Result<f64, String>,
) -> Result<Line, String> {
    let mut points = Vec::new();
    for spp in counts {
        points.push((f64::from(*spp), error(*spp)? - noise));
    }
    let clear: Vec<(f64, f64)> = points.iter().copied().filter(|(_, e)| *e > (CLEAR - 1.0) * noise).collect();
    let slope = slope(&clear);
    let values: Vec<String> = points.iter().map(|(spp, e)| format!("{spp:.0}: {e:.2e}")).collect();
    println!("{scene}, {name}: slope {slope:.3} of {} points; {}", clear.len(), values.join(", "));
    points.retain(|(_, e)| *e > 0.0);
    Ok(Line { name: format!("{name}, slope {slope:.2}"), color, points })
}

/// Least squares through the logarithms.
fn slope(points: &[(f64, f64)]) -> f64 {
    let n = points.len() as f64;
    let logs = || points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mx, my) = (logs().map(|p| p.0).sum::<f64>() / n, logs().map(|p| p.1).sum::<f64>() / n);
    let (up, across) = logs()
        .fold((0.0, 0.0), |(up, across), (x, y)| (up + (x - mx) * (y - my), across + (x - mx) * (x - mx)));
    up / across
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_slope_of_a_power_is_its_exponent() {
        let points: Vec<(f64, f64)> = [4.0f64, 8.0, 64.0].iter().map(|x| (*x, 3.0 * x.powf(-1.25))).collect();
        assert!((slope(&points) + 1.25).abs() < 1e-12);
    }
}
