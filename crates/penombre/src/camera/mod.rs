//! Cameras: where the rays of the image begin.

mod view;

use crate::registry::{Context, registry};
use penombre_bvh::Ray;
use penombre_math::Vec2;
use penombre_scene::ParamSpec;
use penombre_scene::params::Params;

pub use view::View;

/// A ray of the image.
#[derive(Clone, Copy, Debug)]
pub struct CameraRay {
    /// The ray, its direction of unit length, limited to what lies between the near and the far plane.
    pub ray: Ray,
}

/// Makes rays from points of the film.
pub trait Camera: Send + Sync + Sized {
    /// The value of `type` in scene files.
    const TYPE_NAME: &'static str;
    /// Other accepted names.
    const ALIASES: &'static [&'static str] = &[];
    /// The parameters.
    const SCHEMA: &'static [ParamSpec];

    /// Builds it from checked parameters. Faults go to the context; `None` if it cannot stand.
    fn build(params: &Params, context: &mut Context<'_, '_>) -> Option<Self>;

    /// The ray through a point of the screen: x to the right from −aspect to aspect, y up from −1 to 1.
    /// `None` where the camera sees nothing.
    fn ray(&self, screen: Vec2) -> Option<CameraRay>;

    /// Where it stands and how it is turned.
    fn view(&self) -> &View;
}

/// Declares the cameras: the module, then the type.
macro_rules! cameras {
    ($($module:ident :: $type:ident),+ $(,)?) => {
        registry! {
            /// Any camera.
            AnyCamera: Camera { $($module::$type),+ }
        }

        impl AnyCamera {
            /// The ray through a point of the screen: x to the right from −aspect to aspect, y up from −1 to 1.
            pub fn ray(&self, screen: Vec2) -> Option<CameraRay> {
                match self { $(Self::$type(c) => c.ray(screen)),+ }
            }

            /// Where it stands and how it is turned.
            pub fn view(&self) -> &View {
                match self { $(Self::$type(c) => c.view()),+ }
            }
        }
    };
}

cameras! {
    perspective::Perspective,
    orthographic::Orthographic,
}
