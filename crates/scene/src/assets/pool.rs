//! Work on several threads, results in order.

use std::sync::atomic::{AtomicUsize, Ordering};

/// Most threads that read files.
const MOST_THREADS: usize = 8;

/// Threads that read so many files.
pub(super) fn threads(files: usize) -> usize {
    std::thread::available_parallelism().map_or(1, |n| n.get()).min(MOST_THREADS).min(files)
}

/// Does one piece of work for each index below `weights.len()`; the heaviest are begun first, so that no thread is left
/// with a heavy one at the end. The results are in the order of the indices.
pub(super) fn each<T: Send>(weights: &[u64], work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let mut order: Vec<usize> = (0..weights.len()).collect();
    order.sort_by_key(|i| std::cmp::Reverse(weights[*i]));
    let next = AtomicUsize::new(0);
    let take = || order.get(next.fetch_add(1, Ordering::Relaxed)).copied();
    let run = || std::iter::from_fn(take).map(|i| (i, work(i))).collect::<Vec<_>>();
    let mut results: Vec<(usize, T)> = std::thread::scope(|scope| {
        let helpers: Vec<_> = (1..threads(weights.len())).map(|_| scope.spawn(run)).collect();
        let mut results = run();
        for helper in helpers {
            match helper.join() {
                Ok(more) => results.extend(more),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        results
    });
    results.sort_by_key(|(i, _)| *i);
    results.into_iter().map(|(_, result)| result).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn results_are_in_order_whatever_the_weights() {
        for weights in [vec![], vec![5], (0..100).collect(), (0..100).rev().collect::<Vec<u64>>()] {
            let expected: Vec<usize> = (0..weights.len()).map(|i| i * i).collect();
            assert_eq!(each(&weights, |i| i * i), expected);
        }
    }

    /// Two pieces of work that wait for each other end only if they run at the same time.
    #[test]
    fn work_is_done_at_the_same_time() {
        if threads(2) == 2 {
            let both = std::sync::Barrier::new(2);
            let leaders = each(&[1, 1], |_| both.wait().is_leader());
            assert_ne!(leaders[0], leaders[1]);
        }
    }
}
