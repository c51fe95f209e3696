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
pub struct Loading<T> {
    source: Source,
    /// Empty once the result was taken.
    result: Option<Receiver<Loaded<T>>>,
}

/// A scene and what was made of it, or all faults as text for a person.
type Loaded<T> = Result<(Session, T), String>;

impl<T: Send + 'static> Loading<T> {
    /// Starts. `size`: see [`Session::load`]. `prepare` makes what the window needs of the scene, and `wake` is called
    /// at the end; both on the loading thread.
    pub fn start(
        source: Source,
        size: Option<[u32; 2]>,
        prepare: impl FnOnce(&Session) -> T + Send + 'static,
        wake: Arc<dyn Fn() + Send + Sync>,
    ) -> Self {
        let (send, result) = channel();
        let (theirs, failed) = (source.clone(), send.clone());
        let thread = std::thread::Builder::new().name("load".to_owned());
        let spawned = thread.spawn(move || {
            let session = Session::load(&theirs, size, &Limits::default());
            // Nobody may be waiting any more.
            let _ = send.send(session.map(|session| {
                let prepared = prepare(&session);
                (session, prepared)
            }));
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
    pub fn poll(&mut self) -> Option<Loaded<T>> {
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
    pub fn wait(self) -> Loaded<T> {
        let received = self.result.and_then(|result| result.recv().ok());
        received.unwrap_or_else(|| Err(BROKEN.to_owned()))
    }
}
