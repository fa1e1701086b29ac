//! Independent jobs on several threads, their results in the order they finish.

use std::num::NonZero;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::thread;

/// Threads to use: as asked, or one for each processor.
#[must_use]
pub fn threads(asked: Option<u32>) -> usize {
    let all = || thread::available_parallelism().map_or(1, NonZero::get);
    asked.map_or_else(all, |n| n as usize).max(1)
}

/// Runs `work` on every job; `done` sees each result on the calling thread.
///
/// # Errors
/// The first error of `done`; jobs that run are finished, no more are begun.
pub fn parallel<J: Sync, R: Send, E>(
    jobs: &[J],
    threads: usize,
    work: impl Fn(&J) -> R + Sync,
    mut done: impl FnMut(usize, R) -> Result<(), E>,
) -> Result<(), E> {
    let next = AtomicUsize::new(0);
    let (sender, receiver) = mpsc::channel();
    thread::scope(|scope| {
        for _ in 0..threads.min(jobs.len()) {
            let (sender, next, work) = (sender.clone(), &next, &work);
            scope.spawn(move || {
                loop {
                    let i = next.fetch_add(1, Ordering::Relaxed);
                    let Some(job) = jobs.get(i) else { break };
                    if sender.send((i, work(job))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        let mut outcome = Ok(());
        for (i, result) in receiver {
            if outcome.is_ok() {
                outcome = done(i, result);
                if outcome.is_err() {
                    next.store(jobs.len(), Ordering::Relaxed);
                }
            }
        }
        outcome
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_job_is_done_once() {
        let jobs: Vec<usize> = (0..100).collect();
        let mut seen = vec![0; 100];
        let run = parallel(
            &jobs,
            3,
            |&j| j * j,
            |i, r| {
                assert_eq!(r, i * i);
                seen[i] += 1;
                Ok::<(), ()>(())
            },
        );
        assert!(run.is_ok() && seen.iter().all(|&n| n == 1));
    }

    #[test]
    fn an_error_ends_it() {
        let jobs: Vec<usize> = (0..100).collect();
        let mut count = 0;
        let run = parallel(
            &jobs,
            2,
            |&j| j,
            |_, _| {
                count += 1;
                Err::<(), &str>("full")
            },
        );
        assert_eq!((run, count), (Err("full"), 1));
    }
}
