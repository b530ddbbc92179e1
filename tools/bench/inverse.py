"""Inverse dynamics: the leg with linkage and friction against Pinocchio's rnea on two plain joints, both
compiled, in loops over the same random states."""

import json
import subprocess
from pathlib import Path

from measure import Comparison, Outcome

SOURCE = Path(__file__).parent / "inverse_dynamics.cpp"
STATES, REPETITIONS = 10_000, 100


def prefix():
    """Where the Python package `pin` keeps Pinocchio's headers and libraries."""
    import cmeel

    found = Path(cmeel.__file__).parents[1] / "cmeel.prefix"
    if not (found / "include" / "pinocchio").is_dir():
        raise FileNotFoundError(f"no Pinocchio in {found}")
    return found


def build(size):
    """Compiles the program, unless it is newer than what it is made of; half a minute."""
    program, library = size.folder / "inverse_dynamics", size.build / "lib" / "libtalus.a"
    program.parent.mkdir(parents=True, exist_ok=True)
    if program.exists() and program.stat().st_mtime > max(p.stat().st_mtime for p in (SOURCE, library)):
        return program
    pin = prefix()
    subprocess.run(
        ["g++", "-std=c++17", "-O3", "-DNDEBUG", f"-I{size.repository}/include", f"-I{pin}/include",
         f"-I{pin}/include/eigen3", str(SOURCE), str(library), f"-L{pin}/lib", "-lpinocchio_default",
         f"-Wl,-rpath,{pin}/lib", "-o", str(program)],
        check=True,
    )  # fmt: skip
    return program


def measure(size):
    """What the program prints: difference of the sides, times [ns a state], and the controller's last status (0)."""
    arguments = [str(size.scaled(STATES, 100)), str(size.scaled(REPETITIONS, 3))]
    done = subprocess.run([build(size), *arguments], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def bench(size):
    """One call a state, and the batch call."""
    found = measure(size)
    rnea, single, batch, tick = ([1e-9 * t for t in found[name]] for name in ("rnea", "single", "batch", "tick"))
    peer = "Pinocchio's rnea, two revolute joints, constant ratio, no friction"
    leg = "leg with screw linkage and friction"
    return Outcome(
        [
            Comparison("inverse dynamics", f"tl_inverse, {leg}", peer, single, rnea, 6.0),
            Comparison("inverse dynamics, batch", f"tl_inverse_batch, {leg}", peer, batch, rnea),
            Comparison("controller", f"tl_controller_tick_f64, {leg}, with its checks and limits", peer, tick, rnea),
        ],
        [f"same torques on the plain leg to {found['difference']:.1e} of the largest"],
        {"torque_difference": found["difference"]},
    )
