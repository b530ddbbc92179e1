"""talus/pso.h: known optima, the leg's ten parameters, and the same bits whoever moves the particles."""

import shutil
import subprocess
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from types import SimpleNamespace

import cffi
import numpy as np
import pytest
from talus import check, constants, ffi, lib, pointer
from test_random import philox_reference

SOURCE = Path(__file__).with_name("pso_costs.c")


@pytest.fixture(scope="session")
def costs(tmp_path_factory):
    """The functions of pso_costs.c as tl_pso_cost, and makers of their contexts."""
    compiler = shutil.which("cc")
    assert compiler, "a C compiler is needed"
    library = tmp_path_factory.mktemp("pso") / "libcosts.so"
    flags = ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared"]
    subprocess.run([compiler, *flags, str(SOURCE), "-o", str(library), "-lm"], check=True)
    own = cffi.FFI()
    names = ("sphere", "rosenbrock", "quadratic", "hole", "leg")
    own.cdef(
        """typedef struct { int n; double centre[64]; } sum_context;
           typedef struct { int p; double constant, shank_mass, motor_mass, foot_mass, r[1056]; } triangle;"""
        + "".join(f"double {name}(const double *x, const void *context);" for name in names)
    )
    opened = own.dlopen(str(library))

    def context(kind, **fields):
        made = own.new(f"{kind} *", fields)
        return SimpleNamespace(owner=made, address=ffi.cast("void *", int(own.cast("uintptr_t", made))))

    found = {n: ffi.cast("tl_pso_cost", int(own.cast("uintptr_t", getattr(opened, n)))) for n in names}
    return SimpleNamespace(opened=opened, context=context, **found)


def settings(**changes):
    s = lib.tl_pso_defaults()
    for name, value in changes.items():
        setattr(s, name, value)
    return s


class Swarm:
    """A tl_pso with its memory and bounds kept alive, and copies of its arrays."""

    def __init__(self, lower, upper, **changes):
        self.lower, self.upper = np.array(lower, dtype=float), np.array(upper, dtype=float)
        self.s, n = settings(**changes), len(self.lower)
        self.memory = np.full(lib.tl_pso_memory(ffi.addressof(self.s), n), np.nan)
        self.c = ffi.new("tl_pso *")
        check(
            lib.tl_pso_init(
                self.c, ffi.addressof(self.s), n, pointer(self.lower), pointer(self.upper),
                pointer(self.memory), len(self.memory),
            )
        )  # fmt: skip

    def array(self, name, *shape):
        size = 8 * int(np.prod(shape))
        return np.frombuffer(ffi.buffer(getattr(self.c, name), size), dtype=float).reshape(shape).copy()

    @property
    def positions(self):
        return self.array("position", self.s.particles, len(self.lower))

    @property
    def best(self):
        return self.array("best", len(self.lower))

    def run(self, cost, context):
        check(lib.tl_pso_run(self.c, cost, context.address))
        return self


# ---- known optima ----------------------------------------------------------


def sphere_context(costs, centre):
    return costs.context("sum_context", n=len(centre), centre=list(centre))


@pytest.mark.parametrize("form", ["CONSTRICTION", "INERTIA"])
@pytest.mark.parametrize("topology", ["GLOBAL", "RING"])
def test_sphere(costs, form, topology):
    centre = np.linspace(-3, 4, 8)
    swarm = Swarm(
        [-5] * 8, [6] * 8, form=getattr(lib, f"TL_PSO_{form}"), topology=getattr(lib, f"TL_PSO_{topology}"),
        cognitive=2.05 if form == "CONSTRICTION" else 1.5, social=2.05 if form == "CONSTRICTION" else 1.5,
    ).run(costs.sphere, sphere_context(costs, centre))  # fmt: skip
    np.testing.assert_allclose(swarm.best, centre, atol=1e-9)
    assert swarm.c.best_cost == costs.opened.sphere(
        pointer(swarm.best), costs.context("sum_context", n=8, centre=list(centre)).owner
    )


@pytest.mark.parametrize("seed", range(1, 11))
def test_rosenbrock(costs, seed):
    swarm = Swarm([-5] * 4, [10] * 4, seed=seed, restarts=3)
    swarm.run(costs.rosenbrock, costs.context("sum_context", n=4))
    np.testing.assert_allclose(swarm.best, np.ones(4), atol=1e-6)


def triangle_context(costs, x, z, constant=0.0, masses=(0.0, 0.0, 0.0)):
    p = x.shape[1]
    r = np.linalg.qr(np.column_stack([x, z]), mode="r")[:p]
    return costs.context(
        "triangle", p=p, constant=constant, shank_mass=masses[0], motor_mass=masses[1], foot_mass=masses[2],
        r=r.ravel().tolist(),
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(1, 11))
@pytest.mark.parametrize("condition, rotated", [(1e6, False), (100.0, True)])
def test_ill_conditioned_quadratic(costs, condition, rotated, seed):
    # condition number of X; the cost's is its square
    random = np.random.default_rng(5)
    x = np.diag(np.logspace(0, -np.log10(condition), 8))
    if rotated:
        x = x @ np.linalg.qr(random.normal(size=(8, 8)))[0]
    optimum = random.uniform(1, 9, 8)
    swarm = Swarm([0] * 8, [10] * 8, seed=seed)
    swarm.run(costs.quadratic, triangle_context(costs, x, x @ optimum))
    np.testing.assert_allclose(swarm.best, optimum, rtol=1e-6)


def test_optimum_on_a_face_and_in_a_corner(costs):
    swarm = Swarm([-1] * 3, [1, 1, 1]).run(costs.sphere, sphere_context(costs, [3.0, 0.25, -2.0]))
    np.testing.assert_allclose(swarm.best, [1.0, 0.25, -1.0], atol=1e-8)


# ---- what it is for: the leg -----------------------------------------------

P0 = np.array([0.042, 0.160, 0.120, 0.055, 0.0021, 2.4e-6, 1.2, 0.45, 0.8, 0.30])
MASSES = (1.624, 0.4112, 0.442)


def base_parameters(p):
    shank, motor, foot = MASSES
    return np.array(
        [p[0] + shank * p[1] ** 2 + motor * p[2] ** 2, shank * p[1] + motor * p[2], foot * p[3],
         p[4] + foot * p[3] ** 2, *p[5:]]
    )  # fmt: skip


def linkage_ratio(angle):
    """Ratio of the example model's screw linkage and its slope, by complex steps of its closed form."""
    lead, ab, bo, ac, bof = 0.002, 0.090, 0.040, 0.035, np.deg2rad(84.75)

    def motor(q):
        phi = np.pi - bof - q
        return 2 * np.pi / lead * (bo * np.cos(phi) + np.sqrt(ab**2 - (ac - bo * np.sin(phi)) ** 2))

    def ratio(q):
        return np.imag(motor(q + 1e-30j)) / 1e-30

    return ratio(angle), (ratio(angle + 1e-5) - ratio(angle - 1e-5)) / 2e-5


def leg_columns(seed, speed):
    """Both motors' torques as columns of the nine base parameters, (12) by Lagrange, on a multisine."""
    random = np.random.default_rng(seed)
    t = np.arange(0, 8, 0.004)
    harmonics = 2 * np.pi * speed * np.arange(1, 6) / 4
    q, v, a = np.zeros((2, len(t))), np.zeros((2, len(t))), np.zeros((2, len(t)))
    for joint in (0, 1):
        size, phase = random.uniform(0.02, 0.12, 5), random.uniform(0, 2 * np.pi, 5)
        for w, c, f in zip(harmonics, size, phase):
            q[joint] += c * np.sin(w * t + f)
            v[joint] += c * w * np.cos(w * t + f)
            a[joint] -= c * w * w * np.sin(w * t + f)
    ls, g, zero = 0.3615, 9.81, np.zeros_like(t)
    s, f = q[0], q[0] + q[1]
    vs, vf, as_, af = v[0], v[0] + v[1], a[0], a[0] + a[1]
    k, slope = linkage_ratio(q[1])
    row_f3 = ls * np.cos(s - f) * as_ - ls * np.sin(s - f) * vs**2 + g * np.sin(f)
    row_s3 = ls * np.cos(s - f) * af + ls * np.sin(s - f) * vf**2
    knee = np.array([as_, g * np.sin(s), row_s3 + row_f3, af, zero, np.sign(vs), vs, zero, zero]) / 51
    ankle = np.array([zero, zero, row_f3, af, k**2 * a[1] + k * slope * v[1] ** 2, zero, zero,
                      np.sign(v[1]), v[1]]) / k  # fmt: skip
    return knee.T, ankle.T


def leg_problem(seed, speed):
    """Rows over their noise, truth within 40 % of P0: (X, z, optimum, residual), the last two by lstsq."""
    random = np.random.default_rng(100 + seed)
    knee, ankle = leg_columns(seed, speed)
    truth = base_parameters(P0 * random.uniform(0.6, 1.4, 10))
    x = np.concatenate([knee / 2e-3, ankle / 5e-4])
    z = x @ truth + 0.2 * random.normal(size=len(x))
    length = np.linalg.norm(x, axis=0)
    b, residual, rank, _ = np.linalg.lstsq(x / length, z, rcond=None)
    assert rank == 9
    return x, z, b / length, residual[0]


def assert_within_bounds(b):
    """Some p in [0, 10 p0] has these base parameters: only then can the swarm reach them."""
    shank, motor, foot = MASSES
    p3 = np.linspace(0.01, 9.9, 500) * P0[2]
    p2 = (b[1] - motor * p3) / shank
    p1 = b[0] - shank * p2**2 - motor * p3**2
    p4 = b[2] / foot
    own = np.array([p4, b[3] - foot * p4**2, *b[4:]])
    assert ((p2 > 0) & (p1 > 0) & (p2 < 10 * P0[1]) & (p1 < 10 * P0[0])).any()
    assert (own > 0).all() and (own < 10 * P0[3:]).all()


@pytest.mark.parametrize("problem, speed", [(1, 0.5), (2, 1.0), (3, 2.0)])
def test_the_legs_ten_parameters_from_every_seed(costs, problem, speed):
    """At default settings, bounds [0, 10 p0], without any least-squares start or polish."""
    x, z, b, residual = leg_problem(problem, speed)
    scaled = np.linalg.svd(x * base_parameters(P0), compute_uv=False)
    assert scaled[0] / scaled[-1] > 50  # as narrow as it really is
    assert_within_bounds(b)
    whole = triangle_context(costs, x, z, residual, MASSES)
    excess = triangle_context(costs, x, z, 0.0, MASSES)
    evaluations = []
    for seed in range(1, 21):
        swarm = Swarm(0 * P0, 10 * P0, seed=seed).run(costs.leg, whole)
        assert swarm.c.best_cost <= residual * (1 + 1e-9), seed
        evaluations.append(swarm.c.evaluations)
        swarm = Swarm(0 * P0, 10 * P0, seed=seed).run(costs.leg, excess)
        np.testing.assert_allclose(base_parameters(swarm.best), b, rtol=1e-6, err_msg=f"seed {seed}")
    print(
        f"condition {scaled[0] / scaled[-1]:.0f}: "
        f"evaluations {np.median(evaluations):.0f}, most {max(evaluations)}"
    )


# ---- the algorithm, from its description -----------------------------------


def reference_swarm(cost, lower, upper, s, generations):
    """The header's rule in NumPy: positions of every particle after each generation."""
    n, d = s.particles, len(lower)
    width = upper - lower
    phi = s.cognitive + s.social
    chi = 2 / abs(2 - phi - np.sqrt(phi**2 - 4 * phi))
    key = (s.seed & 0xFFFFFFFF, (s.seed >> 32) ^ 0x7A3C19E5)

    def block(i, generation, number):
        return (np.array(philox_reference((number, i, generation, 0), key)) + 0.5) / 2**32

    def each(i, generation):
        r = np.concatenate([block(i, generation, 1 + k) for k in range((d + 1) // 2)]).reshape(-1, 2)[:d]
        return r[:, 0], r[:, 1]

    x, v, history = np.empty((n, d)), np.empty((n, d)), []
    for i in range(n):
        r1, r2 = each(i, 0)
        x[i], v[i] = lower + r1 * width, (r2 - r1) * width
    own, own_cost = x.copy(), np.array([cost(p) for p in x])
    for generation in range(1, generations):
        history.append(x.copy())
        lead = own[np.argmin(own_cost)].copy()
        for i in range(n):
            r = block(i, generation, 0)
            r1, r2 = (r[0], r[1]) if r[2] < s.common_draw else each(i, generation)
            v[i] = chi * (v[i] + s.cognitive * r1 * (own[i] - x[i]) + s.social * r2 * (lead - x[i]))
            v[i] = np.clip(v[i], -width, width)
            x[i] += v[i]
            outside = (x[i] < lower) | (x[i] > upper)
            x[i] = np.where(x[i] < lower, 2 * lower - x[i], np.where(x[i] > upper, 2 * upper - x[i], x[i]))
            v[i][outside] = 0
        values = np.array([cost(p) for p in x])
        better = values < own_cost
        own[better], own_cost[better] = x[better], values[better]
    history.append(x.copy())
    return history


def test_moves_are_those_of_the_description(costs):
    lower, upper = np.array([-1.0, 0.0, -2.0]), np.array([1.0, 3.0, 5.0])
    centre = [0.9, 0.1, 1.0]
    swarm = Swarm(lower, upper, particles=6, common_draw=0.5, seed=2**40 + 3, tolerance=0.0)
    context = sphere_context(costs, centre)
    for expected in reference_swarm(lambda p: ((p - centre) ** 2).sum(), lower, upper, swarm.s, 25):
        lib.tl_pso_move(swarm.c, 0, 6, costs.sphere, context.address)
        np.testing.assert_allclose(swarm.positions, expected, rtol=0, atol=1e-11)
        assert lib.tl_pso_close(swarm.c) == 1


def test_ring_follows_the_best_neighbour(costs):
    swarm = Swarm([-1] * 2, [1] * 2, particles=9, topology=lib.TL_PSO_RING)
    lib.tl_pso_move(swarm.c, 0, 9, costs.sphere, sphere_context(costs, [0.0, 0.0]).address)
    lib.tl_pso_close(swarm.c)
    cost, lead = swarm.array("own_cost", 9), swarm.array("lead", 9)
    for i in range(9):
        assert cost[int(lead[i])] == min(cost[i - 1], cost[i], cost[(i + 1) % 9])
        assert (lead[i] - i + 1) % 9 <= 2


# ---- the same bits ---------------------------------------------------------


def run_in_parts(costs, context, parts, pool=None, **changes):
    """Generations by hand, the particles moved in the given ranges, one after another or by threads."""
    swarm = Swarm([-5] * 6, [7] * 6, particles=40, iterations=60, restarts=2, **changes)
    states = []
    while True:

        def move(part):
            lib.tl_pso_move(swarm.c, part[0], part[1], costs.rosenbrock, context.address)

        list((pool.map if pool else map)(move, parts))
        states.append(swarm.positions.tobytes())
        if not lib.tl_pso_close(swarm.c):
            return states, swarm.best.tobytes(), swarm.c.evaluations


def test_partitions_and_threads_change_no_bit(costs):
    context = costs.context("sum_context", n=6)
    whole = run_in_parts(costs, context, [(0, 40)])
    order = np.random.default_rng(1).permutation(40)
    assert run_in_parts(costs, context, [(i, i + 1) for i in order.tolist()]) == whole
    assert run_in_parts(costs, context, [(30, 40), (0, 0), (0, 7), (7, 30)]) == whole
    with ThreadPoolExecutor(4) as pool:
        assert run_in_parts(costs, context, [(i, i + 5) for i in range(0, 40, 5)], pool) == whole
    assert whole[2] == 2 * 60 * 40
    assert run_in_parts(costs, context, [(0, 40)], seed=2)[1] != whole[1]


def test_run_is_the_generations_by_hand(costs):
    context = costs.context("sum_context", n=6)
    states, best, evaluations = run_in_parts(costs, context, [(0, 40)])
    swarm = Swarm([-5] * 6, [7] * 6, particles=40, iterations=60, restarts=2).run(costs.rosenbrock, context)
    assert swarm.best.tobytes() == best and swarm.c.evaluations == evaluations
    assert swarm.positions.tobytes() == states[-1]


def test_python_callback_sees_every_particle_once_a_generation():
    seen = []

    @ffi.callback("double(*)(const double *, const void *)")
    def cost(x, _):
        seen.append((x[0], x[1]))
        return abs(x[0]) + abs(x[1])

    swarm = Swarm([-1, -1], [1, 1], particles=5, iterations=4)
    check(lib.tl_pso_run(swarm.c, cost, ffi.NULL))
    assert len(seen) == len(set(seen)) == swarm.c.evaluations == 20
    assert swarm.c.best_cost == min(abs(a) + abs(b) for a, b in seen)


# ---- edges -----------------------------------------------------------------


def test_bounds_hold_in_every_generation(costs):
    lower, upper = np.array([-1.0, 2.0, -1e-9, 1e8]), np.array([1.0, 2.0, 1e-9, 3e8])
    swarm = Swarm(lower, upper, particles=30, iterations=100, common_draw=0.5)
    context = sphere_context(costs, [5.0, 7.0, 0.0, 3.5e8])  # the optimum is outside: many bounce
    for _ in range(100):
        lib.tl_pso_move(swarm.c, 0, 30, costs.sphere, context.address)
        assert (swarm.positions >= lower).all() and (swarm.positions <= upper).all()
        lib.tl_pso_close(swarm.c)
    assert (swarm.positions[:, 1] == 2.0).all() and swarm.best[1] == 2.0


def test_infinite_and_nan_costs_are_avoided(costs):
    swarm = Swarm([-1, -1], [1, 1], particles=30).run(costs.hole, sphere_context(costs, [0.5, 0.5]))
    np.testing.assert_allclose(swarm.best, [0.0, 0.0], atol=1e-9)
    assert swarm.best[0] <= 0 and swarm.best[1] <= 0
    nowhere = Swarm([0.5, 0.5], [1, 1], particles=4, iterations=3)
    status = lib.tl_pso_run(nowhere.c, costs.hole, sphere_context(costs, [0.5, 0.5]).address)
    assert status == lib.TL_ERR_NOT_FINITE
    assert nowhere.c.best_cost == np.inf and np.isnan(nowhere.best).all() and nowhere.c.evaluations == 12


def test_first_restart_is_the_single_swarm_and_more_never_harm(costs):
    context = costs.context("sum_context", n=6)
    found = np.empty((10, 3))
    for seed in range(10):
        for k, n in enumerate((1, 2, 5)):
            swarm = Swarm(
                [-5] * 6, [7] * 6, particles=10, iterations=30, restarts=n, tolerance=0.0, seed=seed
            )
            swarm.run(costs.rosenbrock, context)
            found[seed, k] = swarm.c.best_cost
            assert swarm.c.evaluations == n * 300
    assert (np.diff(found) <= 0).all()
    assert (found[:, 2] < found[:, 0]).sum() >= 4  # by chance the first of five is best in two of ten


def test_tolerance_stops_and_zero_never_does(costs):
    x = np.eye(4)
    context = triangle_context(costs, x, np.full(4, 0.3), constant=2.0)
    runs = {t: Swarm([-1] * 4, [1] * 4, tolerance=t, iterations=700).run(costs.quadratic, context)
            for t in (1e-3, 1e-9, 0.0)}  # fmt: skip
    evaluations = [runs[t].c.evaluations for t in (1e-3, 1e-9, 0.0)]
    assert evaluations[0] < evaluations[1] < evaluations[2] == 70_000
    for t in (1e-3, 1e-9):
        own = runs[t].array("own_cost", 100)
        assert own.max() - own.min() <= t * own.min()
        assert runs[t].c.best_cost <= 2.0 * (1 + t)


def test_one_generation_is_a_random_search(costs):
    swarm = Swarm([0] * 2, [1] * 2, iterations=1, particles=50).run(
        costs.sphere, sphere_context(costs, [0.5, 0.5])
    )
    assert swarm.c.evaluations == 50
    assert swarm.c.best_cost == ((swarm.positions - 0.5) ** 2).sum(axis=1).min()


def test_seeds_change_the_swarm_and_its_numbers_are_not_those_of_the_noise(costs):
    context = sphere_context(costs, [0.5] * 4)
    first = [Swarm([0] * 4, [1] * 4, seed=s, iterations=1).run(costs.sphere, context).positions
             for s in (1, 2, 2**32 + 1)]  # fmt: skip
    flat = np.concatenate([p.ravel() for p in first])
    assert len(np.unique(flat)) == flat.size
    out = np.empty(2)
    for counter in range(50):
        lib.tl_random_uniform2(1, 0, counter, pointer(out))
        assert np.abs(first[0] - out[0]).min() > 1e-7


def test_refusals():
    bounds = np.array([0.0, 1.0]), np.array([1.0, 2.0])

    def init(dimensions=2, lower=bounds[0], upper=bounds[1], less=0, **changes):
        s = settings(**changes)
        memory = np.empty(100_000)
        swarm = ffi.new("tl_pso *")
        standard = settings()  # addressof() does not keep it
        n = lib.tl_pso_memory(ffi.addressof(standard), 2) - less
        return lib.tl_pso_init(
            swarm, ffi.addressof(s), dimensions, pointer(lower), pointer(upper), pointer(memory), n
        )

    assert init() == lib.TL_OK
    for changes in ({"particles": 1}, {"particles": 1_000_001}, {"iterations": 0}, {"restarts": 0}):
        assert init(**changes) == lib.TL_ERR_ARGUMENT, changes
    for dimensions in (0, -1, constants.TL_PSO_MAX_DIMENSIONS + 1):
        assert init(dimensions=dimensions) == lib.TL_ERR_ARGUMENT
    ranges = ({"cognitive": -1.0}, {"social": np.nan}, {"cognitive": 2.0, "social": 2.0},
              {"tolerance": -1e-9}, {"tolerance": np.nan}, {"common_draw": 1.1},
              {"inertia_begin": 2.0})  # fmt: skip
    for changes in ranges:
        assert init(**changes) == lib.TL_ERR_RANGE, changes
    for lower in ([2.0, 1.0], [np.nan, 1.0], [-np.inf, 1.0]):
        assert init(lower=np.array(lower)) == lib.TL_ERR_RANGE
    for upper in ([np.inf, 2.0], [np.nan, 2.0], [-0.5, 2.0]):
        assert init(upper=np.array(upper)) == lib.TL_ERR_RANGE
    assert init(lower=np.array([-1.7e308, 1.0]), upper=np.array([1.7e308, 2.0])) == lib.TL_ERR_RANGE
    assert init(less=1) == lib.TL_ERR_WORKSPACE
    assert lib.tl_pso_run(ffi.NULL, ffi.NULL, ffi.NULL) == lib.TL_ERR_ARGUMENT
