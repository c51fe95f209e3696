//! Numbers without rounding: sums of `f64` parts that do not overlap (Shewchuk's expansions).

use penombre_lab::Pcg32;

/// An exact number. Its parts, smallest first, have no binary digits in common; none is 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exact(Vec<f64>);

/// 2²⁷ + 1: splits a double into halves of 26 digits.
const SPLITTER: f64 = 134_217_729.0;

impl Exact {
    /// `a − b`.
    pub fn difference(a: f32, b: f32) -> Self {
        let mut exact = Self::default();
        exact.add(f64::from(a));
        exact.add(-f64::from(b));
        exact
    }

    /// Of a single number.
    pub fn of(a: f32) -> Self {
        Self::difference(a, 0.0)
    }

    fn add(&mut self, number: f64) {
        let mut carry = number;
        let mut parts = Vec::with_capacity(self.0.len() + 1);
        for &part in &self.0 {
            let (sum, rest) = two_sum(carry, part);
            carry = sum;
            parts.extend((rest != 0.0).then_some(rest));
        }
        parts.extend((carry != 0.0).then_some(carry));
        self.0 = parts;
    }

    pub fn plus(mut self, other: &Self) -> Self {
        other.0.iter().for_each(|&part| self.add(part));
        self
    }

    pub fn minus(mut self, other: &Self) -> Self {
        other.0.iter().for_each(|&part| self.add(-part));
        self
    }

    pub fn times(&self, other: &Self) -> Self {
        let mut product = Self::default();
        for &a in &self.0 {
            for &b in &other.0 {
                let (high, low) = two_product(a, b);
                product.add(low);
                product.add(high);
            }
        }
        product
    }

    /// −1, 0 or 1.
    pub fn sign(&self) -> i32 {
        self.0.last().map_or(0, |&largest| if largest > 0.0 { 1 } else { -1 })
    }

    /// The number, rounded.
    pub fn value(&self) -> f64 {
        self.0.iter().sum()
    }
}

/// The rounded sum and what rounding took.
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let of_b = sum - a;
    (sum, (a - (sum - of_b)) + (b - of_b))
}

/// The rounded product and what rounding took.
fn two_product(a: f64, b: f64) -> (f64, f64) {
    let halves = |x: f64| {
        let scaled = SPLITTER * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    };
    let (product, (a_high, a_low), (b_high, b_low)) = (a * b, halves(a), halves(b));
    let rest = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    (product, rest)
}

/// Compares triple products of random whole numbers with those of integers. An oracle that fails this says nothing.
pub fn check() -> Result<(), String> {
    let mut rng = Pcg32::new(1997);
    for round in 0..10_000 {
        // Few digits make products that vanish.
        let range = if round % 2 == 0 { 3 } else { 1 << 24 };
        let vectors: [[i128; 3]; 3] = std::array::from_fn(|_| {
            std::array::from_fn(|_| i128::from(rng.below(range)) - i128::from(range / 2))
        });
        let exact = vectors.map(|v| v.map(|x| Exact::difference(x as f32, 0.5).plus(&Exact::of(0.5))));
        let [a, b, c] = vectors;
        let minor = |i: usize, j: usize| b[i] * c[j] - b[j] * c[i];
        let truth = a[0] * minor(1, 2) + a[1] * minor(2, 0) + a[2] * minor(0, 1);
        let found = dot(&exact[0], &cross(&exact[1], &exact[2]));
        if found.value() != truth as f64 || i128::from(found.sign()) != truth.signum() {
            return Err(format!("the oracle's arithmetic is wrong: {vectors:?}"));
        }
    }
    Ok(())
}

/// A vector of exact numbers.
pub type Exact3 = [Exact; 3];

/// `a · b`.
pub fn dot(a: &Exact3, b: &Exact3) -> Exact {
    a[0].times(&b[0]).plus(&a[1].times(&b[1])).plus(&a[2].times(&b[2]))
}

/// `a × b`.
pub fn cross(a: &Exact3, b: &Exact3) -> Exact3 {
    std::array::from_fn(|i| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j].times(&b[k]).minus(&a[k].times(&b[j]))
    })
}
