//! `penombre render`.

use crate::args::{RenderArgs, Verbosity};
use crate::outputs::Output;
use crate::progress::Progress;
use crate::scene::{Prepared, prepare};
use crate::statistics::{Measured, duration, json_line};
use crate::{Exit, interrupt, report, terminal};
use penombre::film::Film;
use penombre::render::default_tone;
use penombre::{Outcome, Render};
use penombre_image::{Image, WriteOptions};
use std::time::Instant;

/// Renders a scene and writes its images.
pub fn run(args: &RenderArgs, verbosity: &Verbosity) -> Exit {
    if let Err(message) = interrupt::listen() {
        report::error(&message, "");
        return Exit::Failure;
    }
    let Some(mut prepared) = prepare(&args.scene, verbosity.quiet) else { return Exit::Usage };
    if let Some(tile) = args.tile {
        prepared.plan.job.tile = tile;
    }
    let outputs = Output::all(&args.output, &prepared.loaded.name);
    let size = prepared.plan.job.size;
    // All of them, so that all faults are told at once.
    let faulty = outputs.iter().filter(|o| !o.check(size)).count();
    if faulty > 0 || !Output::check_all(&outputs, args.course_ppm) {
        return Exit::Usage;
    }
    if !fits_in_memory(size) {
        return Exit::Usage;
    }
    let options = write_options(args, &prepared);
    let threads = args.threads.map_or_else(all_cores, |n| n as usize);
    let mut measured = Measured::new(&prepared, threads);
    if verbosity.verbose > 0 {
        describe(&prepared, threads);
    }
    let mut render = Render::new(prepared.plan);
    let outcome = compute(&mut render, &mut measured, verbosity);
    warn_of_dropped(&args.scene.scene, &render);
    let image = render.image();
    if outcome == Outcome::Stopped && render.statistics().samples == 0 {
        terminal::err("interrupted before the first sample: nothing was saved");
        return Exit::Interrupted;
    }
    let unsaved = outputs.iter().filter(|o| !o.write(&image, &options)).count();
    if unsaved > 0 {
        return Exit::Failure;
    }
    tell(args, verbosity, &render, &image, &measured, &outputs);
    match outcome {
        Outcome::Finished => Exit::Done,
        Outcome::Stopped => {
            terminal::err("interrupted: the image holds what was done");
            Exit::Interrupted
        }
    }
}

/// Reports an image that is larger than the free memory. True if all is well, as far as one can tell.
fn fits_in_memory([w, h]: [u32; 2]) -> bool {
    let needed = Film::bytes(w, h);
    match penombre_sys::available_memory() {
        Some(free) if free < needed => {
            let (needed, free) = (needed >> 20, free >> 20);
            let message =
                format!("an image of {w}×{h} pixels takes {needed} MiB of memory, {free} MiB are free");
            report::error(&message, "nothing was rendered; choose a smaller `--size`");
            false
        }
        _ => true,
    }
}

/// Runs the job, measuring it.
fn compute(render: &mut Render, measured: &mut Measured, verbosity: &Verbosity) -> Outcome {
    let job = *render.job();
    let visible = !verbosity.quiet && !verbosity.no_progress;
    let pixels = u64::from(job.size[0]) * u64::from(job.size[1]);
    let progress = Progress::new(job.samples(), pixels, visible);
    let (begin, cpu) = (Instant::now(), penombre_sys::process_cpu_time());
    let outcome = render.run(measured.threads, &progress);
    measured.render_s = begin.elapsed().as_secs_f64();
    measured.cpu =
        penombre_sys::process_cpu_time().zip(cpu).map(|(after, before)| after.saturating_sub(before));
    progress.finish();
    outcome
}

fn all_cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// What the image files are told besides the pixels.
fn write_options(args: &RenderArgs, prepared: &Prepared) -> WriteOptions {
    let Prepared { loaded, plan, .. } = prepared;
    let words: Vec<String> = std::env::args().skip(1).collect();
    let command = format!("penombre {}", words.join(" "));
    WriteOptions {
        tone: args.tone.unwrap_or_else(|| default_tone(plan.integrator.name())),
        exposure: args.exposure,
        course_ppm: args.course_ppm,
        metadata: plan.provenance(&loaded.name, loaded.description.digest(&loaded.assets), command),
    }
}

/// `-v`: what will be done.
fn describe(prepared: &Prepared, threads: usize) {
    let (job, summary) = (&prepared.plan.job, prepared.plan.scene.summary());
    terminal::err(&format!(
        "{}: {} shapes, {} triangles, {} lights; {}×{} pixels, {} spp, {}, {threads} threads",
        prepared.loaded.name,
        summary.shapes.iter().map(|c| c.count).sum::<usize>(),
        summary.triangles,
        summary.lights.iter().map(|c| c.count).sum::<usize>(),
        job.size[0],
        job.size[1],
        job.spp,
        prepared.plan.integrator.name(),
    ));
    terminal::err(&format!("loaded in {:.3} s, built in {:.3} s", prepared.load_s, prepared.build_s));
}

/// Names samples that were not finite.
fn warn_of_dropped(scene: &str, render: &Render) {
    let statistics = render.statistics();
    let Some(first) = statistics.dropped.iter().min_by_key(|d| (d.pixel[1], d.pixel[0], d.sample)) else {
        return;
    };
    let ([x, y], k) = (first.pixel, first.sample);
    terminal::err(&format!(
        "warning: {} samples were not finite and were dropped, among them sample {k} of pixel {x},{y}\n  help: `penombre \
         trace {scene} --pixel {x},{y} --sample {k}` shows that path",
        statistics.non_finite
    ));
}

/// The closing lines: files, size, time; or the statistics for programs.
fn tell(
    args: &RenderArgs,
    verbosity: &Verbosity,
    render: &Render,
    image: &Image,
    measured: &Measured,
    outputs: &[Output],
) {
    // Standard output belongs to the image if it goes there.
    let say = if outputs.contains(&Output::StandardOutput) { terminal::err } else { terminal::out };
    if args.json {
        say(&json_line(&args.scene.scene, render, image, measured, outputs).to_string());
        return;
    }
    if verbosity.quiet {
        return;
    }
    let (job, statistics) = (render.job(), render.statistics());
    let pixels = f64::from(job.size[0]) * f64::from(job.size[1]);
    for output in outputs.iter().filter(|o| **o != Output::StandardOutput) {
        say(&format!(
            "{}  {}×{}, {:.0} spp, {}, {:.1} Mrays/s",
            output.name(),
            job.size[0],
            job.size[1],
            statistics.samples as f64 / pixels,
            duration(measured.render_s),
            statistics.rays as f64 / measured.render_s.max(1e-9) / 1e6,
        ));
    }
}
