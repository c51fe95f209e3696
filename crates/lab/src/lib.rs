//! Statistics for tests: goodness of fit, means, images, directions on the sphere, and random numbers to feed
//! them; and the inputs that fuzzing has kept.
//!
//! A dev-dependency: it knows no type of the renderer, only slices and closures. It uses the system's
//! elementary functions, since its verdicts, unlike pictures, need no equal bits.
//!
//! How to use a p-value here: it is the probability of data at least as odd as the observed if the hypothesis
//! is true. A test takes a fixed seed, states its significance α (0.01 by custom, [`sidak`] for many tests at
//! once) and fails if `p < α`. With a fixed seed the outcome never changes from run to run.

#![forbid(unsafe_code)]

mod corpus;
mod fit;
mod image;
mod mean;
mod rng;
mod special;
mod sphere;

pub use corpus::kept_corpus;
pub use fit::{ChiSquare, TestResult, chi_square, chi_square_uniform, kolmogorov_smirnov, sidak};
pub use image::{BlockDifference, BlockReport, Layout, MeanImage, compare_blocks};
pub use mean::{Moments, t_test, welch_t_test, z_test};
pub use rng::Pcg32;
pub use special::{beta_regularized, erfc, gamma_q, ln_gamma};
pub use sphere::{BinDifference, DensityCheck, DensityReport, check_density};
