"""Figure 3 and table 2: Fourier series (10) of the ankle's linkage against its closed form."""

import numpy

from talus import check, constants, ffi, lib, pointer

ORDERS = (6, 7, 8)
SAMPLES = 1001
OMEGA_RANGE = (0.5, 8.0)  # where the best base frequency is looked for [1/rad]
OMEGA_SHOWN = (0.5, 6.0)  # 6 is the series whose period is the range itself


def ankle_drive(model):
    return ffi.addressof(model.struct.drive[1], "transmission")


def fit(reference, order, low, high):
    """The least-squares series of `order` with a base frequency in [low, high]."""
    size = lib.tl_fourier_fit_workspace(SAMPLES, order)
    work, out = numpy.empty(size), ffi.new("tl_fourier *")
    check(lib.tl_fourier_fit(reference, constants.TL_JOINT_RANGE_RAD, SAMPLES, order, low, high,
                             pointer(work), size, out))  # fmt: skip
    return out


def error(series, reference):
    """Largest error over the range: motor angle [rad] and ratio (relative)."""
    approximation, out = ffi.new("tl_transmission *"), ffi.new("double[2]")
    check(lib.tl_transmission_fourier(approximation, series))
    lib.tl_transmission_error(
        approximation, reference, constants.TL_JOINT_RANGE_RAD, 2 * SAMPLES, out, out + 1
    )
    return out[0], out[1]


def best_fits(reference):
    """Table 2: for each order omega, coefficients and errors."""
    out = []
    for order in ORDERS:
        found = fit(reference, order, *OMEGA_RANGE)
        motor, ratio = error(found, reference)
        out.append({"order": order, "omega_1_rad": found.omega, "a": list(found.a)[: order + 1],
                    "b": list(found.b)[:order], "motor_error_rad": motor, "ratio_error": ratio})  # fmt: skip
    return out


def ratio_of(series, joint):
    """The series' ratio at joint angles; also of one that no drive may have (its ratio changes sign)."""
    j = numpy.arange(1, constants.TL_FOURIER_ORDER + 1)
    a, b, turns = (
        numpy.array(list(series.a))[1:],
        numpy.array(list(series.b)),
        numpy.outer(joint, j * series.omega),
    )
    return numpy.cos(turns) @ (j * series.omega * b) - numpy.sin(turns) @ (j * series.omega * a)


def error_against_omega(reference, points=111):
    """Largest ratio error of the best series of each order at a given omega."""
    joint, _, ratio = curves(reference)
    omega = numpy.linspace(*OMEGA_SHOWN, points)
    largest = {
        k: [numpy.abs(ratio_of(fit(reference, k, w, w), joint) / ratio - 1).max() for w in omega]
        for k in ORDERS
    }
    return omega, {k: numpy.array(values) for k, values in largest.items()}


def omega_of_error(omega, ratio_error, wanted):
    """Up to which omega the error stays below `wanted` (log-interpolated); None if it never does."""
    beyond = numpy.flatnonzero(ratio_error > wanted)
    if len(beyond) == 0 or beyond[0] == 0:
        return None
    k = beyond[0]
    low, high, at = numpy.log([ratio_error[k - 1], ratio_error[k], wanted])
    return float(omega[k - 1] + (omega[k] - omega[k - 1]) * (at - low) / (high - low))


def curves(reference, points=241):
    """Joint angle, motor angle and ratio over the range."""
    joint = numpy.linspace(-constants.TL_JOINT_RANGE_RAD, constants.TL_JOINT_RANGE_RAD, points)
    motor = numpy.array([lib.tl_transmission_motor_angle(reference, q) for q in joint])
    ratio, slope = ffi.new("double *"), ffi.new("double *")
    ratios = numpy.empty(points)
    for i, q in enumerate(joint):
        lib.tl_transmission_ratio(reference, q, ratio, slope)
        ratios[i] = ratio[0]
    return joint, motor, ratios
