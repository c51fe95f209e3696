//! The figures of a render, for people and programs.

use crate::scene::Prepared;
use penombre::Render;
use penombre_image::Image;
use serde_json::{Value, json};
use std::time::Duration;

/// What was measured around a render.
pub struct Measured {
    /// Seconds spent on reading and decoding files.
    pub load_s: f64,
    /// Seconds spent on building.
    pub build_s: f64,
    /// Seconds spent on rendering.
    pub render_s: f64,
    /// Processor time of the render, all threads.
    pub cpu: Option<Duration>,
    /// Threads of the render.
    pub threads: usize,
    /// Memory that it was estimated to take, bytes.
    pub memory_estimate: u64,
    /// What ended it.
    pub end: End,
}

/// What ended a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All samples were taken.
    Samples,
    /// The error is below the limit.
    Noise,
    /// Time is up.
    Time,
    /// The user.
    Interrupt,
}

impl End {
    /// How programs call it.
    fn name(self) -> &'static str {
        match self {
            Self::Samples => "spp",
            Self::Noise => "noise",
            Self::Time => "time",
            Self::Interrupt => "interrupt",
        }
    }
}

/// Mean samples per pixel taken.
pub fn mean_spp(render: &Render) -> f64 {
    let [w, h] = render.job().size.map(f64::from);
    render.statistics().samples as f64 / (w * h)
}

impl Measured {
    /// Begins with what preparing took.
    pub fn new(prepared: &Prepared, threads: usize) -> Self {
        let (load_s, build_s, memory_estimate) = (prepared.load_s, prepared.build_s, prepared.memory.total());
        Self { load_s, build_s, render_s: 0.0, cpu: None, threads, memory_estimate, end: End::Samples }
    }
}

/// The line of `--json`.
pub fn json_line(
    scene: &str,
    render: &Render,
    image: &Image,
    measured: &Measured,
    files: &[String],
) -> Value {
    let (job, statistics) = (render.job(), render.statistics());
    let summary = render.scene().summary();
    let per_second = |count: u64| count as f64 / measured.render_s.max(1e-9) / 1e6;
    let mib = |bytes: u64| bytes as f64 / (1024.0 * 1024.0);
    json!({
        "scene": scene,
        "integrator": render.integrator().name(),
        "width": job.size[0],
        "height": job.size[1],
        "spp": mean_spp(render),
        "seed": job.seed,
        "samples": statistics.samples,
        "rays": statistics.rays,
        "load_s": measured.load_s,
        "build_s": measured.build_s,
        "render_s": measured.render_s,
        "cpu_s": measured.cpu.map(|d| d.as_secs_f64()),
        "msamples_per_s": per_second(statistics.samples),
        "mrays_per_s": per_second(statistics.rays),
        "threads": measured.threads,
        "peak_rss_mb": penombre_sys::peak_rss().map(mib),
        "memory_estimate_mb": mib(measured.memory_estimate),
        "bvh_mb": mib(summary.bvh_bytes as u64),
        "triangles": summary.triangles,
        "instances": summary.instances,
        "mean": image.mean(),
        "error": statistics.estimate.map(|e| e.error),
        "stopped_by": measured.end.name(),
        "non_finite": statistics.non_finite,
        "clamp": render.integrator().clamp(),
        "digest": image.digest(),
        "outputs": files,
    })
}

/// `6.2 s`, `1 min 03 s`, `2 h 05 min`.
pub fn duration(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match whole {
        0..10 => format!("{seconds:.2} s"),
        10..60 => format!("{seconds:.1} s"),
        60..3600 => format!("{} min {:02} s", whole / 60, whole % 60),
        _ => format!("{} h {:02} min", whole / 3600, whole % 3600 / 60),
    }
}

#[cfg(test)]
mod tests {
    use super::duration;

    #[test]
    fn durations_read_well() {
        assert_eq!(duration(0.123), "0.12 s");
        assert_eq!(duration(42.04), "42.0 s");
        assert_eq!(duration(63.0), "1 min 03 s");
        assert_eq!(duration(7500.0), "2 h 05 min");
    }
}
