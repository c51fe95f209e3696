//! Work on several threads whose result does not depend on their number.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// The threads that this machine runs at once.
pub(crate) fn all_threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Results of all jobs in their order. Jobs are begun in their order.
pub(super) fn map<J: Send, R: Send>(threads: usize, jobs: Vec<J>, work: impl Fn(J) -> R + Sync) -> Vec<R> {
    let threads = threads.min(jobs.len());
    if threads < 2 {
        return jobs.into_iter().map(work).collect();
    }
    let jobs: Vec<Mutex<Option<J>>> = jobs.into_iter().map(|job| Mutex::new(Some(job))).collect();
    let done: Vec<Mutex<Option<R>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let next = AtomicUsize::new(0);
    let worker = || {
        while let Some((job, place)) = {
            let i = next.fetch_add(1, Ordering::Relaxed);
            jobs.get(i).zip(done.get(i))
        } {
            let taken = lock(job).take();
            let result = taken.map(&work);
            *lock(place) = result;
        }
    };
    std::thread::scope(|scope| {
        (1..threads).for_each(|_| drop(scope.spawn(worker)));
        worker();
    });
    done.into_iter().filter_map(|place| place.into_inner().unwrap_or_else(PoisonError::into_inner)).collect()
}

/// Hands the results of all jobs on in their order, each as soon as it is its turn: while one thread takes them, the
/// others go on with their jobs.
pub(super) fn feed<J: Send, R: Send>(
    threads: usize,
    jobs: Vec<J>,
    work: impl Fn(J) -> R + Sync,
    take: impl FnMut(R) + Send,
) {
    let done: Vec<Mutex<Option<R>>> = jobs.iter().map(|_| Mutex::new(None)).collect();
    let taker = Mutex::new((0, take));
    let take_all = |taker: &mut (usize, _)| hand_on(&done, taker);
    map(threads, jobs.into_iter().enumerate().collect(), |(i, job)| {
        *lock(&done[i]) = Some(work(job));
        if let Ok(mut taker) = taker.try_lock() {
            take_all(&mut taker);
        }
    });
    take_all(&mut lock(&taker));
}

/// Hands on what is done from the next one on.
fn hand_on<R>(done: &[Mutex<Option<R>>], (next, take): &mut (usize, impl FnMut(R))) {
    while let Some(result) = done.get(*next).and_then(|place| lock(place).take()) {
        take(result);
        *next += 1;
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Splits off the first `count` items of what is left of a list.
pub(super) fn take<'a, T>(left: &mut &'a mut [T], count: usize) -> &'a mut [T] {
    let (first, rest) = std::mem::take(left).split_at_mut(count);
    *left = rest;
    first
}
