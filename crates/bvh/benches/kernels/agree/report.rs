//! What is printed: a row for each mesh and kind of rays.

use super::classes::{Classes, Errors};
use crate::rays::Kind;
use crate::report::quoted;
use penombre_math::Vec3;

/// What is compared, and the head of the table.
pub fn opening(json: bool, version: &str) {
    let head = format!(
        "our batch calls beside Embree {version}, robust. Who is right: we/they/both/neither\n\
         {:10}{:9}{:>9}{:>9}{:>20}{:>11}{:>8}{:>20}{:>16}{:>16}{:>8}",
        "", "", "rays", "same", "same triangle,", "tie of", "tie of", "other", "only we", "only they", "our"
    );
    let second = format!(
        "{:10}{:9}{:>9}{:>9}{:>20}{:>11}{:>8}{:>20}{:>16}{:>16}{:>8}",
        "mesh", "kind", "", "", "other distance", "neighbours", "others", "surface", "hit", "hit", "faults"
    );
    if json { eprintln!("{head}\n{second}") } else { println!("{head}\n{second}") }
}

/// One mesh and kind.
pub fn row(json: bool, mesh: &str, triangles: usize, kind: Kind, c: &Classes) {
    if json {
        println!("{}", line(mesh, triangles, kind, c));
    } else {
        println!(
            "{mesh:10}{:9}{:>9}{:>9}{:>20}{:>11}{:>8}{:>20}{:>16}{:>16}{:>8}",
            kind.name(),
            c.rays,
            c.same,
            c.distance.text(),
            c.tie_of_neighbours,
            c.tie_of_others,
            c.surface.text(),
            c.only_we.text(),
            c.only_they.text(),
            c.faults.len(),
        );
        details("we", &c.our_errors);
        details("they", &c.their_errors);
    }
    for ray in c.faults.iter().take(10) {
        let bits = |v: Vec3| v.to_array().map(f32::to_bits);
        let (origin, dir, ends) = (bits(ray.origin), bits(ray.dir), [ray.t_min, ray.t_max].map(f32::to_bits));
        eprintln!(
            "FAULT: {mesh}, {} ray by bits: origin {origin:x?} dir {dir:x?} range {ends:x?}",
            kind.name()
        );
    }
}

fn details(who: &str, errors: &Errors) {
    if errors.distance > 0.0 {
        let (share, units) = (errors.distance, errors.plane);
        println!(
            "{:12}{who}: distances off by a share of {share:.1e} at most, {units:.2} units from the plane",
            ""
        );
    }
    if errors.margin > 0.0 {
        println!(
            "{:12}{who}: untrue answers have margins of {:.2} units at most, unexplained {}",
            "", errors.margin, errors.unexplained
        );
    }
}

fn line(mesh: &str, triangles: usize, kind: Kind, c: &Classes) -> String {
    let right = |r: &super::classes::Right| format!("[{},{},{},{}]", r.we, r.they, r.both, r.neither);
    let errors = |e: &Errors| {
        let finite = |x: f64| if x.is_finite() { format!("{x:e}") } else { "null".to_owned() };
        let (distance, plane, margin) = (finite(e.distance), finite(e.plane), finite(e.margin));
        format!(
            r#"{{"distance":{distance},"plane":{plane},"margin":{margin},"unexplained":{}}}"#,
            e.unexplained
        )
    };
    format!(
        r#"{{"mesh":{},"triangles":{triangles},"kind":"{}","rays":{},"same":{},"distance":{},"tie_of_neighbours":{},"tie_of_others":{},"surface":{},"only_we":{},"only_they":{},"our_errors":{},"their_errors":{},"faults":{}}}"#,
        quoted(mesh),
        kind.name(),
        c.rays,
        c.same,
        right(&c.distance),
        c.tie_of_neighbours,
        c.tie_of_others,
        right(&c.surface),
        right(&c.only_we),
        right(&c.only_they),
        errors(&c.our_errors),
        errors(&c.their_errors),
        c.faults.len(),
    )
}
