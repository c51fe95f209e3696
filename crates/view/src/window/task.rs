//! One result from a thread.

use super::desk::Wake;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// Work in the background whose result is taken once.
pub struct Task<T> {
    name: &'static str,
    result: Receiver<T>,
}

/// Ends a task, also if its work panics: first it is clear whether there is a result, then the window wakes.
struct End<T> {
    send: Option<Sender<T>>,
    wake: Wake,
}

impl<T> Drop for End<T> {
    fn drop(&mut self) {
        drop(self.send.take());
        (self.wake)();
    }
}

impl<T: Send + 'static> Task<T> {
    /// Starts. `wake` is called when the result is there, or will never be.
    pub fn start(name: &'static str, work: impl FnOnce() -> T + Send + 'static, wake: Wake) -> Self {
        let (send, result) = channel();
        let run = move || {
            let end = End { send: Some(send), wake };
            if let Some(send) = &end.send {
                // Nobody may be waiting any more.
                let _ = send.send(work());
            }
        };
        // Without a thread the sender is dropped, and the next poll says so.
        drop(std::thread::Builder::new().name(name.to_owned()).spawn(run));
        Self { name, result }
    }

    /// The result, once; `None` while it is not there. `Err`, a text for a person, if it will never be.
    pub fn poll(&mut self) -> Option<Result<T, String>> {
        match self.result.try_recv() {
            Ok(result) => Some(Ok(result)),
            Err(TryRecvError::Empty) => None,
            Err(TryRecvError::Disconnected) => Some(Err(self.broken())),
        }
    }

    /// Waits for the result.
    ///
    /// # Errors
    ///
    /// A text for a person if there will never be one.
    pub fn wait(self) -> Result<T, String> {
        self.result.recv().map_err(|_| self.broken())
    }

    fn broken(&self) -> String {
        format!("`{}` broke off: this is a fault of the program", self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;
    use std::time::Duration;

    #[test]
    fn results_and_panics_come_back_and_wake() {
        let (send, woken) = channel();
        let wake: Wake = Arc::new(move || send.send(()).unwrap());
        let mut seven = Task::start("seven", || 7, wake.clone());
        woken.recv_timeout(Duration::from_secs(60)).unwrap();
        assert_eq!(seven.poll(), Some(Ok(7)));
        let mut broken: Task<i32> = Task::start("broken", || std::panic::panic_any(1u8), wake.clone());
        woken.recv_timeout(Duration::from_secs(60)).unwrap();
        assert!(broken.poll().unwrap().unwrap_err().contains("`broken` broke off"));
        assert_eq!(Task::start("nine", || 9, wake).wait(), Ok(9));
    }
}
