//! Tests of schedules and runs.

mod estimate;
mod layers;

use super::*;
use crate::testing::{plan, set, small};
use penombre_image::ToneCurve;
use penombre_scene::Role;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

struct Quiet;

impl Observer for Quiet {
    fn on(&self, _: Event<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

fn digest(threads: usize, tile: u32) -> String {
    digest_of(threads, tile, false)
}

fn digest_of(threads: usize, tile: u32, progressive: bool) -> String {
    let mut plan = plan(&small("cornell", 40, 20));
    (plan.job.tile, plan.job.progressive) = (tile, progressive);
    let mut render = Render::new(plan);
    assert_eq!(render.run(threads, &Quiet), Outcome::Finished);
    render.image().digest()
}

#[test]
fn threads_and_tiles_change_no_bit() {
    let expected = digest(1, 16);
    for (threads, tile) in [(2, 16), (3, 8), (7, 17), (1, 32), (2, 4096), (2, 1)] {
        assert_eq!(digest(threads, tile), expected, "{threads} threads, tiles of {tile}");
    }
}

#[test]
fn sample_by_sample_gives_the_same_bits() {
    assert_eq!(digest_of(2, 16, true), digest(1, 16));
}

#[test]
fn units_merge_in_any_order() {
    let expected = digest(1, 16);
    let p = plan(&small("cornell", 40, 20));
    let (job, units) = (p.job, p.job.units());
    let results: Vec<UnitResult> =
        (0..units).rev().map(|i| Render::unit(&p.scene, &*p.integrator, &job, job.unit(i))).collect();
    let mut render = Render::new(p);
    for result in results {
        render.merge(result.clone());
        render.merge(result);
    }
    assert_eq!(render.image().digest(), expected);
    assert_eq!(render.statistics().samples, 40 * 40 * 20);
    assert_eq!(render.run(2, &Quiet), Outcome::Finished);
}

#[test]
fn units_cover_every_sample_of_every_pixel_once() {
    let mut job = plan(&small("square", 37, 35)).job;
    for tile in [1, 5, 16, 64] {
        job.tile = tile;
        let mut seen = std::collections::HashMap::new();
        for unit in (0..job.units()).map(|i| job.unit(i)) {
            assert_eq!(unit.first_sample % SAMPLE_CHUNK, 0);
            for pixel in unit.tile.iter() {
                *seen.entry(pixel).or_insert(0) += unit.count;
            }
        }
        assert_eq!(seen.len(), 37 * 37);
        assert!(seen.values().all(|n| *n == 35));
    }
}

#[test]
fn a_unit_is_given_up_whenever_it_is_asked_to() {
    let mut d = small("cornell", 3, 2);
    let light = d.of_role(Role::Light).next().unwrap().1.name.clone();
    set(&mut d, Role::Light, &light, "shadow_samples", 20_000);
    let p = plan(&d);
    let asked = AtomicUsize::new(0);
    let unit = |stop: &dyn Fn(usize) -> bool| {
        asked.store(0, Ordering::Relaxed);
        let stop = || stop(asked.fetch_add(1, Ordering::Relaxed));
        Render::unit_unless(&p.scene, &*p.integrator, &p.job, p.job.unit(0), &stop)
    };
    let whole = unit(&|_| false).unwrap();
    assert_eq!(whole, Render::unit(&p.scene, &*p.integrator, &p.job, p.job.unit(0)));
    // Often: no ray of a heavy step waits long for the question.
    let asked = asked.load(Ordering::Relaxed);
    assert!(whole.rays / asked as u64 <= 2048, "asked {asked} times in {} rays", whole.rays);
    // Whether it says true from then on or only once.
    for at in (0..asked).step_by(11).chain([asked - 1]) {
        assert_eq!(unit(&|k| k == at), None);
        assert_eq!(unit(&|k| k >= at), None);
    }
}

#[test]
fn files_say_how_their_image_was_made() {
    let mut d = small("square", 8, 3);
    set(&mut d, Role::Render, "", "seed", 7);
    let said = plan(&d).provenance("square", "abc".to_owned(), "penombre render square".to_owned());
    let value = |key: &str| said.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str());
    let expected = [
        ("scene", "square"),
        ("scene-digest", "abc"),
        ("command", "penombre render square"),
        ("integrator", "classic"),
        ("spp", "3"),
        ("seed", "7"),
    ];
    for (key, expected) in expected {
        assert_eq!(value(&format!("penombre:{key}")), Some(expected));
    }
    assert!(value("Software").is_some_and(|v| v.starts_with("penombre 0.")));
    assert_eq!(["classic", "path"].map(default_tone), [ToneCurve::Raw, ToneCurve::Srgb]);
}

/// Stops after some units.
struct StopAfter(AtomicUsize);

impl Observer for StopAfter {
    fn on(&self, event: Event<'_>) -> ControlFlow<()> {
        if matches!(event, Event::Progress(..)) {
            self.0.fetch_sub(1, Ordering::Relaxed);
        }
        if self.0.load(Ordering::Relaxed) == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }
}

#[test]
fn a_stopped_render_goes_on_to_the_same_bits() {
    let expected = digest(1, 16);
    let mut render = Render::new(plan(&small("cornell", 40, 20)));
    assert_eq!(render.run(2, &StopAfter(AtomicUsize::new(3))), Outcome::Stopped);
    let partial = render.statistics().samples;
    assert!(partial > 0 && partial < 40 * 40 * 20);
    assert_eq!(render.run(2, &Quiet), Outcome::Finished);
    assert_eq!(render.image().digest(), expected);
}

#[test]
fn samples_that_are_not_finite_are_dropped_counted_and_named() {
    let mut d = small("square", 16, 4);
    let light = d.of_role(Role::Light).next().unwrap().1.name.clone();
    set(&mut d, Role::Light, &light, "color", [3e38, 3e38, 3e38]);
    let material = d.of_role(Role::Material).next().unwrap().1.name.clone();
    set(&mut d, Role::Material, &material, "diffuse", [3e38, 0.0, 0.0]);
    let mut render = Render::new(plan(&d));
    render.run(2, &Quiet);
    let statistics = render.statistics();
    assert!(statistics.non_finite > 0);
    assert!(!statistics.dropped.is_empty());
    let image = render.image();
    assert!(image.to_data().iter().all(|v| v.is_finite()));
    let named = statistics.dropped[0];
    let job = *render.job();
    let path = record(render.scene(), render.integrator(), &job, named.pixel, named.sample);
    assert!(!path.radiance.is_finite());
}
