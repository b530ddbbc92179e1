"""Writes leg_lagrange.json: motor torques of the leg from its Lagrangian.

Nothing here is taken from the equations as talus writes them. Kinetic and
potential energy are put together from the positions of the masses; the nut's
position on the screw is a coordinate that the loop |AB| = const binds to the
ankle's angle, differentiated implicitly; Euler and Lagrange's derivatives are
sympy's; generalised forces come from virtual work. The numbers are evaluated with
50 digits and rounded once.

    python3 tests/vectors/leg_lagrange.py

Doubles are written as hexadecimal floats, so that they are read back exactly.
"""

import json
import random
from pathlib import Path

import sympy as sp
from mpmath import mp, mpf

OUTPUT = Path(__file__).with_suffix(".json")
SEED = 1
LEGS, STATES = 4, 50
DIGITS = 50
RANGE_RAD = 0.52

# name: value of the example leg; every leg but the first varies all of them
PARAMETERS = {
    "gravity_m_s2": 9.81,
    "shank_length_m": 0.3615, "shank_mass_kg": 1.624, "shank_com_m": 0.160, "shank_inertia_kg_m2": 0.0420,
    "foot_mass_kg": 0.442, "foot_com_m": 0.055, "foot_inertia_kg_m2": 0.0021,
    "ankle_motor_mass_kg": 0.4112, "ankle_motor_com_m": 0.120, "ankle_rotor_inertia_kg_m2": 2.4e-6,
    "knee_ratio": 51.0, "lead_m": 0.002, "AB_m": 0.090, "BO_m": 0.040, "AC_m": 0.035, "BOF_deg": 84.75,
    "knee_coulomb_Nm": 1.2, "knee_viscous_Nms_rad": 0.45,
    "ankle_coulomb_Nm": 0.8, "ankle_viscous_Nms_rad": 0.30,
}  # fmt: skip

P = {name: sp.Symbol(name) for name in PARAMETERS}
Q, V, A, SLIP = (sp.symbols(f"{x}0 {x}1") for x in "qvas")
NUT = sp.Symbol("nut")


def loop():
    """|AB|^2 - AB^2 of the linkage; 0 where it closes (O in the origin, the screw along x)."""
    phi = sp.pi - P["BOF_deg"] * sp.pi / 180 - Q[1]
    return (NUT - P["BO_m"] * sp.cos(phi)) ** 2 + (P["AC_m"] - P["BO_m"] * sp.sin(phi)) ** 2 - P["AB_m"] ** 2


NUT_SLOPE = -sp.diff(loop(), Q[1]) / sp.diff(loop(), NUT)


def along(expression, coordinate):
    """Derivative by a joint angle; the nut goes with the ankle."""
    slope = sp.diff(expression, Q[coordinate])
    return slope + sp.diff(expression, NUT) * NUT_SLOPE if coordinate == 1 else slope


def rate(expression):
    """Derivative by time."""
    return sum(along(expression, i) * V[i] + sp.diff(expression, V[i]) * A[i] for i in range(2))


def energies():
    """Kinetic and potential energy; the leg hangs along -y, angles clockwise."""

    def point(mass, length, angle, start=(0, 0)):
        place = (start[0] - length * sp.sin(angle), start[1] - length * sp.cos(angle))
        speed2 = rate(place[0]) ** 2 + rate(place[1]) ** 2
        return place, mass * speed2 / 2, mass * P["gravity_m_s2"] * place[1]

    knee, foot = Q[0], Q[0] + Q[1]
    ankle, _, _ = point(0, P["shank_length_m"], knee)
    bodies = [
        point(P["shank_mass_kg"], P["shank_com_m"], knee),
        point(P["ankle_motor_mass_kg"], P["ankle_motor_com_m"], knee),
        point(P["foot_mass_kg"], P["foot_com_m"], foot, ankle),
    ]
    motor_speed = 2 * sp.pi / P["lead_m"] * rate(NUT)
    turning = (
        P["shank_inertia_kg_m2"] * rate(knee) ** 2
        + P["foot_inertia_kg_m2"] * rate(foot) ** 2
        + P["ankle_rotor_inertia_kg_m2"] * motor_speed**2
    ) / 2
    potential = sum(body[2] for body in bodies)
    hanging = potential.subs({Q[0]: 0, Q[1]: 0}, simultaneous=True)
    return sum(body[1] for body in bodies) + turning, potential - hanging


def motor_torques(kinetic, potential):
    """What the motors must give: torque * d motor / d joint against inertia, gravity and friction."""
    lagrangian = kinetic - potential
    friction = [
        P[f"{joint}_coulomb_Nm"] * SLIP[i] + P[f"{joint}_viscous_Nms_rad"] * V[i]
        for i, joint in enumerate(("knee", "ankle"))
    ]
    ratio = (P["knee_ratio"], 2 * sp.pi / P["lead_m"] * NUT_SLOPE)
    return [
        (rate(sp.diff(lagrangian, V[i])) - along(lagrangian, i) + friction[i]) / ratio[i] for i in range(2)
    ]


def evaluator():
    """(parameters, state) -> (torques, kinetic, potential), all mpf."""
    symbols = [*P.values(), *Q, *V, *A, *SLIP, NUT]
    kinetic, potential = energies()
    wanted = [*motor_torques(kinetic, potential), kinetic, potential]
    function = sp.lambdify(symbols, wanted, "mpmath", cse=True)
    closure = sp.lambdify([*P.values(), Q[1], NUT], loop(), "mpmath")

    def evaluate(parameters, state):
        p = [mpf(parameters[name]) for name in PARAMETERS]
        x = [mpf(value) for key in "qva" for value in state[key]] + [mpf(s) for s in state["slip"]]
        nut = mp.findroot(lambda n: closure(*p, x[1], n), mpf(parameters["AB_m"]))
        return function(*p, *x, nut)

    return evaluate


def draw_leg(rng):
    return {name: value * rng.uniform(0.8, 1.25) for name, value in PARAMETERS.items()}


def draw_states(rng):
    return [
        {
            "q": [rng.uniform(-1.5, 1.5), rng.uniform(-RANGE_RAD, RANGE_RAD)],
            "v": [rng.uniform(-6.0, 6.0), rng.uniform(-6.0, 6.0)],
            "a": [rng.uniform(-60.0, 60.0), rng.uniform(-60.0, 60.0)],
            "slip": [rng.choice((-1.0, 1.0)), rng.uniform(-1.0, 1.0)],
        }
        for _ in range(STATES)
    ]


def make():
    """The whole content of the file."""
    rng = random.Random(SEED)
    legs = []
    with mp.workdps(DIGITS):
        evaluate = evaluator()
        for index in range(LEGS):
            parameters, states = draw_leg(rng) if index else PARAMETERS, draw_states(rng)
            for state in states:
                knee, ankle, kinetic, potential = evaluate(parameters, state)
                state.update(torque=[knee, ankle], kinetic_J=[kinetic], potential_J=[potential])
            legs.append({"parameters": hexed(parameters), "states": [hexed(state) for state in states]})
    return {"source": "tests/vectors/leg_lagrange.py", "legs": legs}


def hexed(values):
    return {
        key: [float(x).hex() for x in value] if isinstance(value, list) else float(value).hex()
        for key, value in values.items()
    }


def text(content):
    """JSON with one line for each leg's parameters and for each state."""
    legs = [
        '  {"parameters": ' + json.dumps(leg["parameters"]) + ',\n   "states": [\n    '
        + ",\n    ".join(json.dumps(state) for state in leg["states"]) + "\n   ]}"
        for leg in content["legs"]
    ]  # fmt: skip
    return f'{{"source": {json.dumps(content["source"])}, "legs": [\n' + ",\n".join(legs) + "\n]}\n"


if __name__ == "__main__":
    OUTPUT.write_text(text(make()))
