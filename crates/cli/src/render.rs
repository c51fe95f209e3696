//! `penombre render`.

use crate::args::{RenderArgs, Verbosity};
use crate::memory::Use;
use crate::outputs::Output;
use crate::progress::Progress;
use crate::scene::{Prepared, prepare};
use crate::statistics::{End, Measured, duration, json_line, mean_spp};
use crate::{Exit, interrupt, limits, report, terminal};
use penombre::film::FilmLayer;
use penombre::render::{SPP_ENTRY, default_tone};
use penombre::{Outcome, Render};
use penombre_image::WriteOptions;
use std::time::Instant;

/// Renders a scene and writes its images.
pub fn run(args: &RenderArgs, verbosity: &Verbosity) -> Exit {
    if let Err(message) = interrupt::listen() {
        report::error(&message, "");
        return Exit::Failure;
    }
    let Some(mut prepared) = prepare(&args.scene, Use::Render(args), verbosity) else { return Exit::Usage };
    if let Some(tile) = args.tile {
        prepared.plan.job.tile = tile;
    }
    limits::apply(args, &mut prepared.plan.job);
    let outputs = Output::all(&args.output, &prepared.loaded.name);
    let (size, layers) = (prepared.plan.job.size, wanted_layers(args));
    // All of them, so that all faults are told at once.
    let faulty = outputs.iter().filter(|o| !o.check(size, &layers)).count();
    if faulty > 0 || !Output::check_all(&outputs, args.course_ppm, &layers) {
        return Exit::Usage;
    }
    let mut options = write_options(args, &prepared);
    let threads = args.threads.map_or_else(all_cores, |n| n as usize);
    let mut measured = Measured::new(&prepared, threads);
    if verbosity.verbose > 0 {
        describe(&prepared, threads);
    }
    let mut render = Render::new(prepared.plan);
    compute(&mut render, &mut measured, args, verbosity);
    warn_of_dropped(&args.scene.scene, &render);
    if let Some(most) = render.integrator().clamp().filter(|_| !verbosity.quiet) {
        terminal::err(&format!(
            "note: indirect light was limited to {most} per sample (`integrator.path.clamp`): the image may be too dark"
        ));
    }
    if measured.end == End::Interrupt && render.statistics().samples == 0 {
        terminal::err("interrupted before the first sample: nothing was saved");
        return Exit::Interrupted;
    }
    for (_, value) in options.metadata.iter_mut().filter(|(key, _)| key == SPP_ENTRY) {
        *value = mean_spp(&render).to_string();
    }
    let layers = render.layers(&layers);
    // All of them are tried, whatever becomes of the others.
    let written: Vec<_> = outputs.iter().map(|o| o.write(&layers, &options)).collect();
    let Some(files) = written.into_iter().collect::<Option<Vec<_>>>() else { return Exit::Failure };
    tell(args, verbosity, &render, &measured, &files.concat());
    if measured.end == End::Interrupt {
        terminal::err("interrupted: the image holds what was done");
        return Exit::Interrupted;
    }
    Exit::Done
}

/// The layers that were asked for, each once.
fn wanted_layers(args: &RenderArgs) -> Vec<FilmLayer> {
    let mut layers = args.aov.clone();
    layers.sort();
    layers.dedup();
    layers
}

/// Runs the job, measuring it.
fn compute(render: &mut Render, measured: &mut Measured, args: &RenderArgs, verbosity: &Verbosity) {
    let visible = !verbosity.quiet && !verbosity.no_progress;
    let progress = Progress::new(render.job(), args.time, visible);
    let (begin, cpu) = (Instant::now(), penombre_sys::process_cpu_time());
    let outcome = render.run(measured.threads, &progress);
    measured.render_s = begin.elapsed().as_secs_f64();
    measured.cpu =
        penombre_sys::process_cpu_time().zip(cpu).map(|(after, before)| after.saturating_sub(before));
    progress.finish();
    measured.end = match outcome {
        Outcome::Finished => End::Samples,
        Outcome::Converged => End::Noise,
        Outcome::Stopped if progress.timed_out() && !interrupt::requested() => End::Time,
        Outcome::Stopped => End::Interrupt,
    };
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
fn tell(args: &RenderArgs, verbosity: &Verbosity, render: &Render, measured: &Measured, files: &[String]) {
    // Standard output belongs to the image if it goes there.
    let is_image = |file: &String| file == "-";
    let say = if files.iter().any(is_image) { terminal::err } else { terminal::out };
    if args.json {
        say(&json_line(&args.scene.scene, render, &render.image(), measured, files).to_string());
        return;
    }
    if verbosity.quiet {
        return;
    }
    let ([w, h], statistics) = (render.job().size, render.statistics());
    let error = statistics.estimate.map(|e| format!("error {:.2} %, ", 100.0 * e.error)).unwrap_or_default();
    for file in files.iter().filter(|file| !is_image(file)) {
        say(&format!(
            "{file}  {w}×{h}, {:.0} spp, {error}{}, {:.1} Mrays/s",
            mean_spp(render),
            duration(measured.render_s),
            statistics.rays as f64 / measured.render_s.max(1e-9) / 1e6,
        ));
    }
}
