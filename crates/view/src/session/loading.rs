//! Loading in the background.

use super::{Session, Source};
use crate::preview::Limits;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};

/// What is said when the thread has ended without a result.
const BROKEN: &str = "loading broke off: this is a fault of the program";

/// A scene on its way. The one that is shown stays until [`Loading::poll`] brings the new one. Dropped, it is
/// forgotten: its thread ends by itself.
#[derive(Debug)]
pub struct Loading {
    source: Source,
    /// Empty once the result was taken.
    result: Option<Receiver<Result<Session, String>>>,
}

impl Loading {
    /// Starts. `wake` is called at the end, from the loading thread. `size`: see [`Session::load`].
    pub fn start(source: Source, size: Option<[u32; 2]>, wake: Arc<dyn Fn() + Send + Sync>) -> Self {
        let (send, result) = channel();
        let (theirs, failed) = (source.clone(), send.clone());
        let thread = std::thread::Builder::new().name("load".to_owned());
        let spawned = thread.spawn(move || {
            // Nobody may be waiting any more.
            let _ = send.send(Session::load(&theirs, size, &Limits::default()));
            wake();
        });
        if let Err(e) = spawned {
            let _ = failed.send(Err(format!("the system gives no thread: {e}")));
        }
        Self { source, result: Some(result) }
    }

    /// What is being loaded.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// The scene, or all faults as text for a person; `None` while it is not there yet, and after it was taken.
    pub fn poll(&mut self) -> Option<Result<Session, String>> {
        let result = match self.result.as_ref()?.try_recv() {
            Ok(result) => result,
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => Err(BROKEN.to_owned()),
        };
        self.result = None;
        Some(result)
    }

    /// Waits for the scene.
    ///
    /// # Errors
    ///
    /// All faults, as text for a person.
    pub fn wait(self) -> Result<Session, String> {
        let received = self.result.and_then(|result| result.recv().ok());
        received.unwrap_or_else(|| Err(BROKEN.to_owned()))
    }
}
