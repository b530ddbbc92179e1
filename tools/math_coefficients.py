#!/usr/bin/env python3
"""Derive the polynomials of lib/math.c and write lib/math_coefficients.h.

Each function is approximated on its reduced interval by the polynomial whose
weighted error is smallest in the maximum norm (Remez exchange, in 60 digits);
the weight makes it the relative error of the function's value. Coefficients
are then rounded to double. Needs mpmath.

    python tools/math_coefficients.py > lib/math_coefficients.h
"""

import sys

from mpmath import mp, mpf

mp.dps = 60


def solve_reference(f, weight, points, count):
    """Polynomial whose weighted error alternates with equal size over the points."""
    a = mp.matrix(count + 1, count + 1)
    b = mp.matrix(count + 1, 1)
    for i, x in enumerate(points):
        for j in range(count):
            a[i, j] = x**j
        a[i, count] = (-1) ** i / weight(x)
        b[i] = f(x)
    solution = mp.lu_solve(a, b)
    return [solution[j] for j in range(count)], abs(solution[count])


def extrema(error, grid):
    """The largest |error| between sign changes, one point each."""
    values = [error(x) for x in grid]
    found, best = [], 0
    for i in range(1, len(grid)):
        if values[i] * values[best] < 0:
            found.append(best)
            best = i
        elif abs(values[i]) > abs(values[best]):
            best = i
    found.append(best)
    return [grid[i] for i in found], max(abs(v) for v in values)


def remez(f, weight, low, high, count):
    """Minimax coefficients, lowest power first, and the error they reach."""
    middle, half = (high + low) / 2, (high - low) / 2
    # a grid denser at the ends, without the ends, where weights may vanish
    grid = [middle - half * mp.cos(mp.pi * (2 * i + 1) / 3001) for i in range(1500)]
    points = [middle - half * mp.cos(mp.pi * (2 * i + 1) / (2 * count + 2)) for i in range(count + 1)]

    def error_of(c):
        return lambda x: weight(x) * (mp.polyval(c[::-1], x) - f(x))

    for _ in range(30):
        c, level = solve_reference(f, weight, points, count)
        error = error_of(c)
        found, worst = extrema(error, grid)
        while len(found) > count + 1:  # keep count + 1 alternating points: drop the smaller end
            found.pop(0 if abs(error(found[0])) < abs(error(found[-1])) else -1)
        if worst < level * mpf("1.001") or len(found) < count + 1:
            return c, worst
        points = found
    return c, worst


def odd(function):
    """function(x) = x + x^3 P(x^2): P and the weight of its error, over z = x^2."""

    def rest(z):
        x = mp.sqrt(z)
        return (function(x) - x) / (x * z)

    def weight(z):
        x = mp.sqrt(z)
        return x * z / function(x)

    return rest, weight


def cosine_rest(z):
    x = mp.sqrt(z)
    return (mp.cos(x) - 1 + z / 2) / (z * z)


def exponential_rest(x):
    # the series: (e^x - 1 - x) / x^2 loses every digit near 0
    return sum(x**k / mp.factorial(k + 2) for k in range(45))


def logarithm_rest(z):
    """log((1 + s)/(1 - s)) = 2 s + s z P(z), z = s^2."""
    s = mp.sqrt(z)
    return (2 * mp.atanh(s) - 2 * s) / (s * z)


def table():
    """(name, comment, P, weight, interval, number of coefficients)"""
    quarter = (mp.pi / 4) ** 2 * mpf("1.0001")
    half_ln2 = mp.log(2) / 2 * mpf("1.0001")
    log_end = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2 * mpf("1.0001")
    return [
        ("SIN", "sin x = x + x z P(z), z = x^2, |x| <= pi/4", *odd(mp.sin), 0, quarter, 6),
        (
            "COS",
            "cos x = 1 - z/2 + z^2 P(z), z = x^2, |x| <= pi/4",
            cosine_rest,
            lambda z: z * z / mp.cos(mp.sqrt(z)),
            0,
            quarter,
            6,
        ),
        ("ATAN", "atan x = x + x z P(z), z = x^2, |x| <= 1/2", *odd(mp.atan), 0, mpf(1) / 4, 13),
        ("ASIN", "asin x = x + x z P(z), z = x^2, |x| <= 1/2", *odd(mp.asin), 0, mpf(1) / 4, 13),
        (
            "EXP",
            "e^x = 1 + x + x^2 P(x), |x| <= ln(2)/2",
            exponential_rest,
            lambda x: (x * x + mpf("1e-3")) / mp.exp(x),
            -half_ln2,
            half_ln2,
            10,
        ),
        (
            "LOG",
            "ln((1 + s)/(1 - s)) = 2 s + s z P(z), z = s^2, |s| <= tan(pi/8)^2",
            logarithm_rest,
            lambda z: mp.sqrt(z) * z / (2 * mp.atanh(mp.sqrt(z))),
            0,
            log_end,
            7,
        ),
        ("TANH", "tanh x = x + x z P(z), z = x^2, |x| <= 0.55", *odd(mp.tanh), 0, mpf("0.3025"), 11),
    ]


def split(value, bits):
    """value = first + second + ..., each but the last exact in so many bits."""
    parts = []
    for n in bits:
        scale = mpf(2) ** (n - 1 - mp.floor(mp.log(abs(value), 2)))
        parts.append(float(mp.nint(value * scale) / scale))
        value -= mpf(parts[-1])
    return parts + [float(value)]


def constants():
    """(name, comment, parts) of the constants that reductions subtract."""
    return [
        (
            "PI_2_NEAR",
            "pi/2 in 36 + 53 bits: k times the first is exact for k < 2^17",
            split(mp.pi / 2, [36]),
        ),
        (
            "PI_2_FAR",
            "pi/2 in 22 + 22 + 22 + 53 bits: products exact for k < 2^31",
            split(mp.pi / 2, [22, 22, 22]),
        ),
        ("LN2", "ln 2 in 40 + 53 bits", split(mp.log(2), [40])),
        ("PI_4", "pi/4 in 53 + 53 bits", split(mp.pi / 4, [53])),
        ("PI_3_4", "3 pi/4 in 53 + 53 bits", split(3 * mp.pi / 4, [53])),
    ]


def main(out=sys.stdout):
    out.write("/* math_coefficients.h: written by tools/math_coefficients.py, not by hand. */\n")
    out.write("#ifndef TALUS_MATH_COEFFICIENTS_H\n#define TALUS_MATH_COEFFICIENTS_H\n")
    for name, comment, parts in constants():
        out.write(f"\n/* {comment} */\n")
        for i, part in enumerate(parts):
            out.write(f"#define TL_{name}_{i} {part.hex()}\n")
    for name, comment, f, weight, low, high, count in table():
        c, worst = remez(f, weight, mpf(low), mpf(high), count)
        out.write(f"\n/* {comment}; relative error {mp.nstr(worst, 2)} before rounding */\n")
        for i, value in enumerate(c):
            out.write(f"#define TL_{name}_{i} {float(value).hex()}\n")
    out.write("\n#endif\n")


if __name__ == "__main__":
    main()
