use crate::{Geometry, Quad, Sphere, Triangles};

mod meshes;
