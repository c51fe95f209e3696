"""Upper tail of the chi-squared distribution, from the incomplete gamma function."""

from __future__ import annotations

import math


def chi2_tail(statistic: float, degrees: int) -> float:
    """Probability that a chi-squared variable with `degrees` of freedom exceeds `statistic`."""
    if statistic <= 0.0:
        return 1.0
    a, x = degrees / 2.0, statistic / 2.0
    front = math.exp(a * math.log(x) - x - math.lgamma(a))
    if x < a + 1.0:
        return max(0.0, 1.0 - front * _series(a, x))
    return front * _continued_fraction(a, x)


def _series(a: float, x: float) -> float:
    """Lower incomplete gamma over x^a e^-x: sum of x^k / (a (a+1) … (a+k))."""
    term = total = 1.0 / a
    k = a
    while term > total * 1e-16:
        k += 1.0
        term *= x / k
        total += term
    return total


def _continued_fraction(a: float, x: float) -> float:
    """Upper incomplete gamma over x^a e^-x, by Lentz's evaluation of its continued fraction."""
    tiny = 1e-300
    b = x + 1.0 - a
    c, d = 1.0 / tiny, 1.0 / b
    value = d
    for i in range(1, 100_000):
        an = -i * (i - a)
        b += 2.0
        d = 1.0 / (an * d + b or tiny)
        c = b + an / c or tiny
        value *= c * d
        if abs(c * d - 1.0) < 1e-15:
            break
    return value
