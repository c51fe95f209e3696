//! Tests of rendering in the background.

use super::*;
use crate::testing::digest;
use penombre_scene::{Assets, Diagnostics, Role, Value};

/// A plan for a built-in scene at a small size.
fn plan(name: &str, size: [i64; 2], spp: i64) -> Plan {
    let mut d = penombre_scene::builtin::builtin(name).unwrap();
    let id = d.find(Role::Render, "").unwrap();
    d.node_mut(id).set("size", Value::from(size));
    d.node_mut(id).set("spp", spp.into());
    Plan::new(&d, &Assets::default(), &mut Diagnostics::default()).unwrap()
}

/// Options that keep every snapshot that is seen from the render's threads.
fn options(threads: usize) -> Options {
    Options { threads, interval: Duration::ZERO, ..Options::default() }
}

#[test]
fn the_complete_image_has_the_bits_of_the_command() {
    // 20 samples: one whole chunk of the film and an open one. 37 pixels: tiles that are cut.
    let expected = digest(plan("cornell", [37, 30], 20));
    for threads in [1, 2, 5] {
        let mut render = ProgressiveRender::start(|| Ok(plan("cornell", [37, 30], 20)), options(threads));
        assert_eq!(render.wait(), State::Finished);
        let complete = render.complete().unwrap();
        assert_eq!(complete.image.digest(), expected, "{threads} threads");
        assert_eq!(
            (complete.stage, complete.figures.spp, complete.figures.target),
            (Stage::Complete, 20.0, 20)
        );
        assert_eq!(complete.figures.seconds_left, 0.0);
        assert_eq!(render.take_snapshot().unwrap().image.digest(), expected);
        assert!(render.take_snapshot().is_none(), "a snapshot is taken once");
    }
}

#[test]
fn coarse_pictures_come_first_and_samples_grow() {
    // The wake-up call runs on the render's thread: it sees every snapshot in order.
    let seen: Arc<Mutex<Vec<Snapshot>>> = Arc::default();
    let slot: Arc<Mutex<Option<Arc<Shared>>>> = Arc::default();
    let (theirs, source) = (seen.clone(), slot.clone());
    let wake = move || {
        let shared = source.lock().unwrap().clone();
        theirs.lock().unwrap().extend(shared.and_then(|s| s.lock().newest.take()));
    };
    let opts = Options { wake: Arc::new(wake), ..options(1) };
    // The plan is not given before the slot is filled, so that no snapshot is missed.
    let (go, wait) = std::sync::mpsc::channel::<()>();
    let start = move || {
        wait.recv().unwrap();
        Ok(plan("sphere", [64, 48], 3))
    };
    let mut render = ProgressiveRender::start(start, opts);
    *slot.lock().unwrap() = Some(render.shared.clone());
    go.send(()).unwrap();
    assert_eq!(render.wait(), State::Finished);
    let seen = seen.lock().unwrap();
    let stages: Vec<Stage> = seen.iter().map(|s| s.stage).collect();
    assert_eq!(stages[..3], [Stage::Coarse, Stage::Coarse, Stage::Refining]);
    assert_eq!(stages.last(), Some(&Stage::Complete));
    assert!(stages.is_sorted() && seen.iter().map(|s| s.figures.spp).is_sorted());
    // The first picture is of full size, in blocks of eight pixels, and shows the sphere.
    let coarse = &seen[0].image;
    assert_eq!((coarse.width(), coarse.height()), (64, 48));
    for (x, y) in [(0, 0), (32, 24), (40, 16)] {
        assert_eq!(coarse.rgb(x, y), coarse.rgb(x + 7, y + 7));
    }
    assert!(coarse.rgb(31, 23)[0] > 0.1);
    assert_eq!(coarse.rgb(0, 0), [0.0; 3]);
    // After one tile of the first sample, the rest is still the coarse picture: no black holes.
    let first = &seen[2];
    assert!(first.figures.spp < 0.2);
    assert!(seen[1].image.rgb(31, 23)[0] > 0.1);
    assert_eq!(first.image.rgb(31, 23), seen[1].image.rgb(31, 23));
}

#[test]
fn going_on_beyond_gives_the_image_of_twice_the_samples() {
    let opts = Options { beyond: true, ..options(2) };
    let render = ProgressiveRender::start(|| Ok(plan("square", [20, 20], 6)), opts);
    let expected = [6, 12, 24].map(|spp| digest(plan("square", [20, 20], spp)));
    let begin = Instant::now();
    let mut spp = 0.0;
    while spp <= 12.0 {
        spp = render.take_snapshot().map_or(spp, |s| s.figures.spp);
        assert_eq!(render.state(), State::Running);
        assert!(begin.elapsed() < Duration::from_secs(60));
    }
    // It goes on, and keeps the image of exactly the job's samples.
    assert_eq!(render.complete().unwrap().image.digest(), expected[0]);
    drop(render);
    // Without chance: three targets, each folded in one film, on one thread.
    let plan = plan("square", [20, 20], 6);
    let (shared, opts) = (Shared::default(), Options { beyond: true, ..options(1) });
    let worker = Worker::new(plan, &shared, &opts);
    let sums = Mutex::new(Sums::new(&worker.job));
    for (range, expected) in [(0, 6), (6, 12), (12, 24)].into_iter().zip(&expected) {
        let job = Job { spp: range.1, ..worker.job };
        let units = range.0 as usize * job.tiles()..job.units();
        worker.sweep(&job, units, &|r| sums.lock().unwrap().merge(r));
        assert_eq!(&sums.lock().unwrap().film.develop().digest(), expected, "{range:?}");
    }
}

#[test]
fn cancelling_stops_at_once_and_dropping_leaves_no_thread() {
    // Far too much to finish.
    let big = || Ok(plan("cornell", [2000, 2000], 1_000_000));
    let render = ProgressiveRender::start(big, options(2));
    while render.take_snapshot().is_none() {
        std::thread::yield_now();
    }
    let shared = Arc::downgrade(&render.shared);
    let begin = Instant::now();
    drop(render);
    assert!(begin.elapsed() < Duration::from_secs(5), "{:?}", begin.elapsed());
    // The render's thread held the other reference: it has ended.
    assert!(shared.upgrade().is_none());
    let mut render = ProgressiveRender::start(big, options(2));
    render.cancel();
    assert_eq!(render.wait(), State::Cancelled);
    assert!(render.is_over() && render.complete().is_none());
}

#[test]
fn a_cancelled_render_hands_out_nothing() {
    let (shared, opts) = (Shared::default(), options(2));
    let worker = Worker::new(plan("cornell", [40, 40], 4), &shared, &opts);
    shared.cancelled.store(true, Ordering::Relaxed);
    worker.sweep(&worker.job, 0..worker.job.units(), &|_| panic!("it was cancelled"));
    assert!(worker.coarse(COARSE[0]).is_none());
    assert_eq!(worker.run(), State::Cancelled);
    assert!(shared.lock().newest.is_none());
}

/// Niceness of the calling thread: field 19 of its line in /proc, where field 2 is a name in parentheses.
#[cfg(target_os = "linux")]
fn niceness() -> i32 {
    let line = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
    line.rsplit_once(") ").unwrap().1.split(' ').nth(16).unwrap().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[test]
fn behind_the_coarse_pictures_the_threads_yield() {
    // On one thread, pictures are published and the window is woken where samples are taken.
    let seen_at = |yielding: bool| {
        let seen: Arc<Mutex<Vec<i32>>> = Arc::default();
        let theirs = seen.clone();
        let wake = Arc::new(move || theirs.lock().unwrap().push(niceness()));
        let opts = Options { yielding, wake, ..options(1) };
        ProgressiveRender::start(|| Ok(plan("square", [20, 20], 2)), opts).wait();
        let seen = seen.lock().unwrap().clone();
        assert!(seen.len() > COARSE.len() + 1, "{seen:?}");
        seen
    };
    let usual = niceness();
    assert!(seen_at(false).iter().all(|n| *n == usual));
    let seen = seen_at(true);
    let (coarse, rest) = seen.split_at(COARSE.len());
    assert!(coarse.iter().all(|n| *n == usual) && rest.iter().all(|n| *n == 19), "{seen:?}");
}

#[test]
fn a_scene_that_cannot_be_built_is_told() {
    let mut render = ProgressiveRender::start(|| Err("no such camera".to_owned()), options(1));
    assert_eq!(render.wait(), State::Failed("no such camera".to_owned()));
    assert!(render.take_snapshot().is_none());
}

#[test]
fn renders_replace_each_other_without_waiting() {
    let mut renders = Renders::default();
    assert!(renders.current().is_none());
    for _ in 0..5 {
        renders.start(|| Ok(plan("cornell", [500, 500], 100_000)), options(2));
    }
    renders.start(|| Ok(plan("square", [8, 8], 2)), options(1));
    let begin = Instant::now();
    while renders.retiring() > 0 || renders.current().is_some_and(|r| !r.is_over()) {
        assert!(begin.elapsed() < Duration::from_secs(60), "they end by themselves");
        std::thread::yield_now();
    }
    let complete = renders.current().and_then(ProgressiveRender::complete).unwrap();
    assert_eq!(complete.image.digest(), digest(plan("square", [8, 8], 2)));
    renders.cancel();
    assert!(renders.current().is_none());
}

#[test]
fn a_window_of_one_pixel_renders_too() {
    for size in [[1, 1], [1, 9], [9, 1]] {
        let mut render = ProgressiveRender::start(move || Ok(plan("square", size, 2)), options(2));
        assert_eq!(render.wait(), State::Finished);
        assert_eq!(render.complete().unwrap().image.digest(), digest(plan("square", size, 2)));
    }
}
