//! The window: its logic, and the thin layer that shows it.
//!
//! A [`state::Viewer`] takes what a person does and says what is to be done; a [`session::Session`] is the scene
//! that is shown, and the command that gives the same image; a [`progressive::ProgressiveRender`] traces it in
//! the background, coarse first; [`preview::PreviewMesh`] is what a rasteriser draws meanwhile. None of
//! these knows of a graphics card, a window system or a widget: they are tested without. [`window`] puts them on the
//! screen.
#![forbid(unsafe_code)]

#[cfg(test)]
mod testing;

pub mod camera;
pub mod keys;
pub mod preview;
pub mod progressive;
pub mod raster;
pub mod session;
pub mod state;
pub mod trackball;
pub mod window;
