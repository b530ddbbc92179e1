"""Mechanics stands in the library alone: no module of the Python package computes inertia, friction, a spring, gravity or a
linkage. What a name says it holds must not be a factor, a term or a power there."""

import ast
import re

import pytest
from support import REPOSITORY

PACKAGE = REPOSITORY / "tools" / "talus"
# the drawing of withheld cases is a second program with laws of its own, on purpose: docs/blind.md. What another simulator is
# told stands in that one's terms: links' masses and inertias, its own friction (held to the library by tests/test_export_mujoco.py)
APART = {"blind", "exporting", "mujoco.py"}
PHYSICS = re.compile(r"inertia|gravity|coulomb|viscous_?N|stiffness|damping_s|slip|foot_kg|shank_m|_kg_m|AB_m|BO_m|AC_m|BOF|lead_m"
                     r"|^a\[|link_Nm|rotor_Nm|friction_Nm")  # fmt: skip
# limits and units of the search's grid, and sums of what the library computed
ALLOWED = {
    "known/camera.py": {"inertia * (2 * np.pi * hertz) ** 2"},  # of a mount that is drawn
    "known/fleet.py": {"own['inertia_kg_m2'] *= rng.uniform(0.98, 1.02)", "friction['coulomb_Nm'] * (1 + WORN * worn)",
                       "friction['viscous_Nms_rad'] * (1 + VISCOUS_PER_K * (temperature - REFERENCE_C))"},  # of robots that are drawn
    "diagnosis/torque_terms.py": {"whole - rotor_Nm", "whole + friction_Nm"},
    "diagnosis/effects/asymmetric_friction.py": {"abs(size) / at.coulomb_Nm"},
    "diagnosis/effects/stribeck.py": {"0.02 * at.coulomb_Nm", "1.5 * at.usual_coulomb_Nm"},
    "diagnosis/effects/elasticity.py": {"most / stiffness", "harder * stiffness", "float(x[0]) / stiffness",
                                        "stiffness / stiffest"},
    "diagnosis/effects/backlash.py": {"drag * at.coulomb_Nm", "LEAST_OFFSET * at.coulomb_Nm"},
    "diagnosis/outside/other_joint.py": {"terms.slip[joint] * np.array([q, q * q])"},  # what no entry of the catalogue follows
    "diagnosis/catalogue/place.py": {"terms.drive_Nm[j] * terms.slip[j]"},  # does it drive, or hold back?
}  # fmt: skip


def modules():
    return [path for path in sorted(PACKAGE.rglob("*.py")) if not APART & set(path.relative_to(PACKAGE).parts)]


def names_in(node):
    """Identifiers, attributes and constant keys of an operand that is not itself computed."""
    if isinstance(node, ast.Name):
        return [node.id]
    if isinstance(node, ast.Attribute):
        return [node.attr]
    if isinstance(node, ast.Subscript):
        key = [node.slice.value] if isinstance(node.slice, ast.Constant) and isinstance(node.slice.value, str) else []
        return names_in(node.value) + key
    if isinstance(node, ast.UnaryOp):
        return names_in(node.operand)
    return []


def computed(path):
    """(line, text) of arithmetic on physical quantities."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    for node in ast.walk(tree):
        operands = []
        if isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow, ast.MatMult)):
            operands = [node.left, node.right]
        if isinstance(node, ast.AugAssign):
            operands = [node.target, node.value]
        if any(PHYSICS.search(name) for operand in operands for name in names_in(operand)):
            yield node.lineno, ast.unparse(node)


@pytest.mark.parametrize("path", modules(), ids=lambda path: str(path.relative_to(PACKAGE)))
def test_no_module_computes_mechanics(path):
    allowed, found = ALLOWED.get(str(path.relative_to(PACKAGE)), set()), list(computed(path))
    assert not [f"{line}: {text}" for line, text in found if text not in allowed]
    assert allowed <= {text for _, text in found}, "an exception that nothing needs"


def test_the_search_finds_what_it_looks_for(tmp_path):
    module = tmp_path / "m.py"
    for text in ("x = inertia * a", "y = self.gravity * s", "z = coulomb_Nm[j] * slip", "w = tree['AB_m'] ** 2", "v += stiffness * q"):
        module.write_text(text)
        assert list(computed(module)), text
    module.write_text("n = rows * step_s")
    assert not list(computed(module))
