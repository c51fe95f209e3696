//! Tests of halves, check points, limits and filters.

use super::*;
use crate::film::{FilterKind, PixelFilter};
use crate::sampler::Dimension;
use penombre_scene::SceneDescription;

/// Digest, samples and outcome of a job that is changed by `change`.
fn outcome(
    description: &SceneDescription,
    threads: usize,
    change: impl Fn(&mut Job),
) -> (String, u64, Outcome, Option<f64>) {
    let mut plan = plan(description);
    change(&mut plan.job);
    let mut render = Render::new(plan);
    let outcome = render.run(threads, &Quiet);
    let statistics = render.statistics();
    (render.image().digest(), statistics.samples, outcome, statistics.estimate.map(|e| e.error))
}

#[test]
fn halves_change_no_bit_for_threads_tiles_and_single_samples() {
    let scene = small("cornell", 40, 21);
    let run = |threads, tile, progressive| {
        outcome(&scene, threads, |job| {
            *job = Job { tile, progressive, estimate: true, features: true, ..*job };
        })
    };
    let expected = run(1, 16, false);
    assert!(expected.3.is_some_and(|e| e > 0.0 && e < 1.0));
    for (threads, tile, progressive) in [(2, 16, false), (3, 7, false), (2, 64, true), (1, 5, true)] {
        assert_eq!(run(threads, tile, progressive), expected);
    }
    let plain = outcome(&scene, 1, |_| ());
    assert_ne!(plain.0, expected.0);
    assert_eq!((plain.1, plain.3), (expected.1, None));
}

/// Sample k of a pixel is the same whatever the number of samples, and the path inspector follows the same path.
#[test]
fn samples_of_halves_are_prefix_stable_and_can_be_recorded() {
    let mut p = plan(&small("cornell", 8, 5));
    p.job = Job { estimate: true, tile: 8, progressive: true, ..p.job };
    p.job.filter = PixelFilter::of_kind(FilterKind::Gaussian);
    for spp in [5, 100] {
        p.job.spp = spp;
        for k in 0..5 {
            let result = Render::unit(&p.scene, &*p.integrator, &p.job, p.job.unit(k as usize));
            let plane = if k % 2 == 0 { &result.sums.color } else { &result.sums.odd };
            for (slot, pixel) in p.job.unit(0).tile.iter().enumerate() {
                let path = record(&p.scene, &*p.integrator, &p.job, pixel, k);
                assert_eq!(plane[slot].rgb, path.radiance.to_rgb().map(f64::from), "{pixel:?} {k}");
            }
        }
    }
}

#[test]
fn halves_share_no_points_and_begin_where_plain_ones_do() {
    let mut job = plan(&small("square", 8, 4)).job;
    let point = |job: &Job, k| job.sampler_of([3, 4], k).get_2d(Dimension(9));
    let plain: Vec<_> = (0..64).map(|k| point(&job, k)).collect();
    job.estimate = true;
    for k in 0..32 {
        assert_eq!(point(&job, 2 * k), plain[k as usize]);
        assert!(plain.iter().all(|p| *p != point(&job, 2 * k + 1)));
    }
}

#[test]
fn check_points_are_four_to_a_doubling_and_chunks_apart() {
    let mut checks = vec![Job::next_check(0)];
    while *checks.last().unwrap() < 512 {
        checks.push(Job::next_check(*checks.last().unwrap()));
    }
    assert_eq!(checks[..10], [32, 48, 64, 80, 96, 112, 128, 160, 192, 224]);
    assert!(checks.iter().all(|c| c.is_multiple_of(SAMPLE_CHUNK)));
    assert!(checks.contains(&256) && checks.contains(&512));
    assert_eq!([31, 32, 33, 47].map(Job::next_check), [32, 48, 48, 48]);
}

/// The film ends as that of the check point's samples, whoever computed it.
#[test]
fn a_noise_limit_ends_at_a_check_point_with_the_bits_of_so_many_samples() {
    let scene = small("cornell", 32, 4096);
    let run = |threads, tile, progressive, noise| {
        let estimate = true;
        outcome(&scene, threads, |job| *job = Job { tile, progressive, estimate, noise, ..*job })
    };
    let expected = run(1, 16, false, 0.015);
    assert_eq!(expected.2, Outcome::Converged);
    assert!(expected.3.is_some_and(|e| e < 0.015), "{expected:?}");
    let spp = (expected.1 / (32 * 32)) as u32;
    assert!((32..4096).contains(&spp) && Job::next_check(spp - 1) == spp, "{spp}");
    for (threads, tile, progressive) in [(2, 16, false), (3, 5, false), (2, 16, true)] {
        assert_eq!(run(threads, tile, progressive, 0.015), expected);
    }
    let direct = outcome(&scene, 2, |job| *job = Job { spp, estimate: true, ..*job });
    assert_eq!((&direct.0, direct.1, direct.2), (&expected.0, expected.1, Outcome::Finished));
    // The cap holds.
    let capped = outcome(&scene, 2, |job| *job = Job { spp: 40, estimate: true, noise: 1e-9, ..*job });
    assert_eq!((capped.1, capped.2), (40 * 32 * 32, Outcome::Finished));
    assert!(run(1, 16, false, 0.01).1 > expected.1);
}

/// The estimate is the relMSE against the converged image: t-test of their differences over seeds at 0.01.
#[test]
fn the_estimate_predicts_the_relative_error() {
    let scene = small("cornell", 32, 64);
    let mut reference = Render::new(plan(&small("cornell", 32, 1024)));
    reference.run(2, &Quiet);
    let reference = reference.image();
    let mut differences = penombre_lab::Moments::default();
    let (mut found, mut estimated) = (0.0, 0.0);
    for seed in 1..=20 {
        let mut p = plan(&scene);
        p.job = Job { estimate: true, seed, ..p.job };
        let mut render = Render::new(p);
        render.run(2, &Quiet);
        let real = penombre_image::metrics::compare(&render.image(), &reference).unwrap().rel_mse;
        let claimed = render.statistics().estimate.unwrap().error.powi(2);
        differences.push(real - claimed);
        (found, estimated) = (found + real, estimated + claimed);
    }
    let test = penombre_lab::t_test(&differences, 0.0);
    assert!(test.p_value > 0.01, "{test:?}");
    assert!((found / estimated - 1.0).abs() < 0.1, "{found} {estimated}");
}

/// Stops once so many samples are in the film.
struct StopAt(u64);

impl Observer for StopAt {
    fn on(&self, event: Event<'_>) -> ControlFlow<()> {
        match event {
            Event::Progress(statistics, _) if statistics.samples >= self.0 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }
}

#[test]
fn a_stopped_job_of_whole_passes_is_one_of_fewer_samples() {
    for (progressive, pass) in [(true, 1), (false, 16)] {
        let change = |job: &mut Job| *job = Job { whole_passes: true, progressive, ..*job };
        let mut p = plan(&small("cornell", 40, 4096));
        change(&mut p.job);
        let mut render = Render::new(p);
        assert_eq!(render.run(3, &StopAt(40 * 40 * 20)), Outcome::Stopped);
        let samples = render.statistics().samples;
        assert!(samples >= 40 * 40 * 20 && samples.is_multiple_of(40 * 40 * pass), "{samples}");
        let spp = (samples / (40 * 40)) as u32;
        let direct = outcome(&small("cornell", 40, i64::from(spp)), 2, |_| ());
        assert_eq!(direct.0, render.image().digest());
        // It goes on as if nothing had been dropped.
        assert_eq!(render.run(2, &StopAt(samples + 40 * 40 * 20)), Outcome::Stopped);
        let spp = (render.statistics().samples / (40 * 40)) as i64;
        assert_eq!(outcome(&small("cornell", 40, spp), 2, |_| ()).0, render.image().digest());
    }
}

#[test]
fn a_constant_scene_stays_constant_with_any_filter_up_to_the_border() {
    let mut d = small("square", 12, 16);
    set(&mut d, Role::Integrator, "classic", "phase", 1);
    // The square fills the image and more.
    set(&mut d, Role::Camera, "main", "fov", 5.0);
    let constant = outcome(&d, 1, |_| ());
    for name in FilterKind::NAMES {
        let filter = PixelFilter::of_kind(FilterKind::from_name(name));
        assert_eq!(outcome(&d, 2, |job| job.filter = filter), constant, "{name}");
    }
}

#[test]
fn scenes_choose_filter_and_sampler_and_the_box_is_the_pixel() {
    let mut d = small("cornell", 16, 4);
    let default = plan(&d).job;
    assert!(default.filter.is_pixel());
    set(&mut d, Role::Render, "", "filter", "gaussian");
    let job = plan(&d).job;
    assert_eq!(job.filter, PixelFilter { kind: FilterKind::Gaussian, radius: 1.5, sigma: 0.5 });
    set(&mut d, Role::Render, "", "filter_radius", 1.0);
    set(&mut d, Role::Render, "", "filter_sigma", 0.3);
    set(&mut d, Role::Render, "", "sampler", "stratified");
    let job = plan(&d).job;
    assert_eq!(job.filter, PixelFilter { kind: FilterKind::Gaussian, radius: 1.0, sigma: 0.3 });
    assert_eq!(job.sampler.name(), "stratified");
}

/// A wide filter blurs: sums over an edge stay, differences shrink.
#[test]
fn filters_blur_edges_and_keep_the_mean() {
    let mut d = small("square", 32, 256);
    set(&mut d, Role::Integrator, "classic", "phase", 1);
    let image = |filter| {
        let mut p = plan(&d);
        p.job.filter = filter;
        let mut render = Render::new(p);
        render.run(2, &Quiet);
        render.image()
    };
    let sharp = image(PixelFilter::default());
    let wide = image(PixelFilter { radius: 3.0, ..PixelFilter::of_kind(FilterKind::BlackmanHarris) });
    let (a, b) = (sharp.mean()[0], wide.mean()[0]);
    assert!(a > 0.01 && (a / b - 1.0).abs() < 0.02, "{a} {b}");
    let roughness = |image: &penombre_image::Image| {
        let row = |y: u32| (1..32).map(move |x| (image.rgb(x, y)[0] - image.rgb(x - 1, y)[0]).powi(2));
        (0..32).flat_map(row).sum::<f32>()
    };
    assert!(roughness(&wide) < 0.7 * roughness(&sharp));
}
