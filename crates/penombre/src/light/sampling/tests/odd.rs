//! Input at the ends of what is possible.

use super::*;

/// All numbers of a sample are sound; some uniform points of the rim among them.
fn sound(name: &str, sampler: &dyn DirectionSampler, rng: &mut Pcg32) {
    let last = 1.0f32.next_down();
    let rim = [[0.0, 0.0], [last, 0.0], [0.0, last], [last, last], [0.5, 0.0], [f32::NAN, 2.0], [-1.0, 0.5]];
    let within = [uniform(rng), uniform(rng)];
    for u in rim.map(Vec2::from).into_iter().chain(within) {
        let s = sampler.sample(u);
        let finite = s.wi.is_finite() && s.point.is_finite() && s.distance.is_finite();
        assert!(finite && s.pdf.is_finite() && s.pdf > 0.0, "{name} {u}: {s:?}");
        assert!((s.wi.length() - 1.0).abs() < 1e-6 && s.distance >= 0.0, "{name} {u}: {s:?}");
        let again = sampler.pdf(s.wi);
        assert!(again.is_finite() && again >= 0.0, "{name} {u}: {s:?}, pdf {again}");
    }
    for wi in [Vec3::NAN, Vec3::ZERO, Vec3::X, -Vec3::Z, any_direction(rng), Vec3::splat(f32::INFINITY)] {
        let pdf = sampler.pdf(wi);
        assert!(pdf.is_finite() && pdf >= 0.0, "{name} {wi}: pdf {pdf}");
    }
}

#[test]
fn what_cannot_be_seen_is_none() {
    let unit = [Vec3::X, Vec3::Y];
    let at = |x, y, z| Vec3::new(x, y, z);
    // In the plane: inside, on a side, in a corner, beside.
    for from in [at(0.5, 0.5, 0.0), at(0.5, 0.0, 0.0), Vec3::ZERO, at(5.0, 0.0, 0.0)] {
        assert_eq!(SphericalQuad::new(from, Vec3::ZERO, unit), None);
        assert_eq!(SphericalTriangle::new(from, [Vec3::ZERO, Vec3::X, Vec3::Y]), None);
        assert_eq!(SphericalDisk::new(from, Vec3::ZERO, Vec3::Z, 1.0), None);
    }
    // No extent, or none that is known.
    let from = at(0.2, 0.3, 1.0);
    let nothing = [Vec3::ZERO, Vec3::Y * 0.25, Vec3::Y * -3.0, Vec3::NAN, Vec3::X * f32::INFINITY];
    for side in nothing {
        assert_eq!(SphericalQuad::new(from, Vec3::ZERO, [side, Vec3::Y]), None, "{side}");
        assert_eq!(SphericalQuad::new(from, Vec3::ZERO, [Vec3::Y, side]), None, "{side}");
        assert_eq!(SphericalTriangle::new(from, [Vec3::ZERO, side, Vec3::Y]), None, "{side}");
    }
    for radius in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        assert_eq!(SphericalDisk::new(from, Vec3::ZERO, Vec3::Z, radius), None, "{radius}");
        assert_eq!(SphericalCap::new(from, Vec3::ZERO, radius), None, "{radius}");
    }
    assert_eq!(SphericalDisk::new(from, Vec3::ZERO, Vec3::ZERO, 1.0), None);
    assert_eq!(SphericalCap::new(Vec3::NAN, Vec3::ZERO, 1.0), None);
    // Too small beside the distance for a density in f32.
    assert_eq!(SphericalCap::new(Vec3::X, Vec3::ZERO, 1e-40), None);
    assert_eq!(SphericalDisk::new(from, Vec3::ZERO, Vec3::Z, 1e-40), None);
}

#[test]
fn corners_edges_and_grazing_points_are_sound() {
    let mut rng = Pcg32::new(5);
    for k in [-30, -6, -3, 0, 3, 6, 12] {
        let scale = 10f32.powi(k);
        for height in [1e-9f32, 1e-7, 1e-4, 1.0, 1e4, 1e9] {
            for (x, y) in
                [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (1.0, 1.0), (1.0, 7.0), (-1e3, 0.2), (-1e6, 1e6)]
            {
                let from = Vec3::new(x, y, height) * scale;
                let [a, b] = [Vec3::X * scale, Vec3::Y * scale];
                let name = format!("scale {scale:e}, from {x} {y} {height:e}");
                let seen = height * scale > 0.0;
                let quad = SphericalQuad::new(from, Vec3::ZERO, [a, b]);
                let skewed = SphericalQuad::new(from, Vec3::ZERO, [a, b + 0.3 * a]);
                let triangle = SphericalTriangle::new(from, [Vec3::ZERO, a, b]);
                let disk = SphericalDisk::new(from, Vec3::ZERO, Vec3::Z, scale);
                let sphere = SphericalCap::new(from, Vec3::ZERO, scale);
                assert!(
                    quad.is_some() == seen && triangle.is_some() == seen && disk.is_some() == seen,
                    "{name}"
                );
                assert!(sphere.is_some(), "{name}");
                [quad, skewed].iter().flatten().for_each(|s| sound(&name, s, &mut rng));
                triangle.iter().for_each(|s| sound(&name, s, &mut rng));
                disk.iter().for_each(|s| sound(&name, s, &mut rng));
                sphere.iter().for_each(|s| sound(&name, s, &mut rng));
            }
        }
    }
}

/// Any float, sizes spread evenly over the exponents, some of them special.
fn any_float(rng: &mut Pcg32) -> f32 {
    const SPECIAL: [f32; 6] = [0.0, 1.0, -1.0, 1e-45, f32::MIN_POSITIVE, -0.5];
    match rng.below(10) {
        0 => SPECIAL[rng.below(6) as usize],
        1 => f32::from_bits(rng.next_u32()),
        2..5 => (rng.next_f32() - 0.5) * 10f32.powi(rng.below(17) as i32 - 8),
        _ => rng.next_f32() - 0.5,
    }
}

#[test]
fn random_input_never_gives_nan() {
    let mut rng = Pcg32::new(6);
    let vector = |rng: &mut Pcg32| Vec3::new(any_float(rng), any_float(rng), any_float(rng));
    let mut seen = [0; 4];
    for i in 0..100_000 {
        let [from, a, b, c] = [0; 4].map(|_| vector(&mut rng));
        let size = any_float(&mut rng);
        let name = format!("{i}: {from:?} {a:?} {b:?} {c:?} {size:e}");
        if let Some(s) = SphericalQuad::new(from, a, [b, c]) {
            sound(&name, &s, &mut rng);
            seen[0] += 1;
        }
        if let Some(s) = SphericalTriangle::new(from, [a, b, c]) {
            sound(&name, &s, &mut rng);
            seen[1] += 1;
        }
        if let Some(s) = SphericalDisk::new(from, a, b, size) {
            sound(&name, &s, &mut rng);
            seen[2] += 1;
        }
        if let Some(s) = SphericalCap::new(from, a, size) {
            sound(&name, &s, &mut rng);
            seen[3] += 1;
        }
    }
    assert!(seen.iter().all(|&n| n > 20_000), "{seen:?}");
}
