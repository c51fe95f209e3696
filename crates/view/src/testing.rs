//! What the tests of several modules share.

use penombre::{Event, Observer, Plan, Render};
use std::ops::ControlFlow;

struct Quiet;

impl Observer for Quiet {
    fn on(&self, _: Event<'_>) -> ControlFlow<()> {
        ControlFlow::Continue(())
    }
}

/// Digest of what the command computes for a plan.
pub fn digest(plan: Plan) -> String {
    let mut render = Render::new(plan);
    render.run(2, &Quiet);
    render.image().digest()
}
