"""apps/model/: model files. What a file says is read independently, by PyYAML."""

import random
import re
import struct
import subprocess

import numpy
import pytest
import yaml
from helper_programs import complaint, helper
from support import BUILD, DATA, REPOSITORY, needs_data

LEG = (REPOSITORY / "models/leg.yaml").read_text()
PENDULUM = (REPOSITORY / "models/pendulum.yaml").read_text()
SLIDER = (REPOSITORY / "models/slider.yaml").read_text()
EXAMPLES = {"leg": LEG, "pendulum": PENDULUM, "slider": SLIDER}

FOURIER = """{type: fourier, omega: 1.7, a: [0.1, -1, 2.5, -3e-1, 4, 5.5e-3, 6, 7, 8],
    b: [900, 1, 0.2, -0.3, 0.04, 0.5, 0.006, -7e-5]}"""


def write(folder, text, name="model.yaml"):
    path = folder / name
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    return path


def numbers(done):
    """{name: value} as model_copy prints it."""
    pairs = [line.split(" ", 1) for line in done.stdout.decode().splitlines()]
    return {name: value if name == "plant" else [float(v) for v in value.split()] for name, value in pairs}


def read(folder, text):
    return numbers(helper("model_copy", write(folder, text)))


def refused(folder, text):
    path = write(folder, text)
    message = complaint("model_copy", path, folder / "never.yaml")
    assert not (folder / "never.yaml").exists()
    assert message.startswith(f"{path}:") or message.startswith(f"{path}: "), message
    return message.removeprefix(str(path)).removeprefix(":").lstrip()


def line_of(text, piece):
    return text[: text.index(piece)].count("\n") + 1


def change(text, piece, replacement):
    assert text.count(piece) == 1, (piece, text.count(piece))
    return text.replace(piece, replacement)


def drive(said, joint):
    """What a joint's mapping must become, in model_copy's names."""
    transmission = said["transmission"]
    expected = {f"{joint}.kind": ["fixed", "screw_linkage", "fourier"].index(transmission["type"])}
    for key in ("ratio", "lead_m", "AB_m", "BO_m", "AC_m", "BOF_deg", "omega"):
        expected[f"{joint}.{key}"] = float(transmission.get(key, 0))
    for i in range(9):
        expected[f"{joint}.a{i}"] = float(transmission.get("a", [0] * 9)[i])
    for i in range(8):
        expected[f"{joint}.b{i}"] = float(transmission.get("b", [0] * 8)[i])
    expected[f"{joint}.torque_constant"] = said["torque_constant_Nm_A"]
    expected[f"{joint}.rotor_inertia"] = said.get("rotor_inertia_kg_m2", 0)
    expected[f"{joint}.coulomb"] = said["friction"]["coulomb_Nm"]
    expected[f"{joint}.viscous"] = said["friction"]["viscous_Nms_rad"]
    return expected


def expected_of(said):
    """Every number of a model as PyYAML reads it, in model_copy's names."""
    plant = said["plant"]
    if plant == "slider":
        friction = said["friction"]
        return {"mass_kg": said["mass_kg"], "force_offset_N": said["force_offset_N"],
                "slider.coulomb": friction["coulomb_N"],
                "slider.viscous": friction["viscous_Ns_m"]}  # fmt: skip
    expected = {"gravity_m_s2": said["gravity_m_s2"]}
    if plant == "pendulum":
        for key in ("inertia_kg_m2", "gravity_moment_kg_m", "gravity_zero_rad"):
            expected[key] = said[key]
        expected["torque_offset_Nm"] = said.get("torque_offset_Nm", 0)
        return expected | drive(said["joint"], "joint")
    for part in ("shank", "foot", "ankle_motor"):
        for key, value in said[part].items():
            expected[f"{part}_{key}"] = value
    return expected | drive(said["knee"], "knee") | drive(said["ankle"], "ankle")


def check_against_yaml(got, text):
    said = yaml.safe_load(text)
    assert got["plant"] == said["plant"]
    for name, value in expected_of(said).items():
        # PyYAML takes 1e-5 (without a point) for text
        assert got[name] == [float(value)], name
    score = {"lowpass_hz": 30, "order": 4, "standstill": 0.008, "guard_s": 0.016, "trim_s": 0.25}
    for name, value in (score | said.get("score", {})).items():
        assert got[name] == [value], name


# ---- what is read ----------------------------------------------------------------


@pytest.mark.parametrize("plant", EXAMPLES)
def test_examples(tmp_path, plant):
    check_against_yaml(read(tmp_path, EXAMPLES[plant]), EXAMPLES[plant])


@needs_data
def test_models_at_hand(tmp_path):
    models = sorted(DATA.glob("**/model.yaml"))
    assert len(models) > 4
    for path in models:
        check_against_yaml(numbers(helper("model_copy", path)), path.read_text())


def test_leg_with_everything(tmp_path):
    text = change(LEG, LEG[LEG.index("{type: screw_linkage") : LEG.index("84.75}") + 6], FOURIER)
    text += """form: paper
score: {order: 2, lowpass_hz: 12.5}
signal: {order: 5, window_s: 0.04}
effects: []
bounds:
  shank.com_m: [0.05, 0.3]
  knee.friction.coulomb_Nm: [0, 10]
  ankle_viscous_Nms_rad: [0.3, 0.3]
"""
    got = read(tmp_path, text)
    check_against_yaml(got, text)
    assert got["form"] == [1] and got["has_score"] == [1]
    assert got["has_window"] == [1] and got["window_order"] == [5] and got["window_s"] == [0.04]
    assert {k: v for k, v in got.items() if k.startswith("bound.")} == {
        "bound.shank_com_m": [0.05, 0.3], "bound.knee_coulomb_Nm": [0, 10],
        "bound.ankle_viscous_Nms_rad": [0.3, 0.3],
    }  # fmt: skip


def test_defaults(tmp_path):
    got = read(tmp_path, LEG)
    assert got["form"] == [0] and got["has_score"] == [0] and got["has_window"] == [0]
    assert not any(name.startswith("bound.") for name in got)
    text = re.sub(r"torque_offset_Nm.*\n", "", PENDULUM)
    assert read(tmp_path, text)["torque_offset_Nm"] == [0]


def test_layout_of_the_text_does_not_matter(tmp_path):
    """Block style, other order, quotes around names, comments, a document marker, \\r\\n."""
    said = yaml.safe_load(PENDULUM)
    block = yaml.safe_dump(said, default_flow_style=False, sort_keys=True)
    for text in (block, "--- # model\n" + block + "...\n", block.replace("\n", "\r\n"), "\ufeff" + block,
                 block.replace("plant: pendulum", "'plant': \"pendulum\""), "{" + ", ".join(
                     f"{k}: {yaml.safe_dump(v, default_flow_style=True).strip().removesuffix('...').strip()}"
                     for k, v in said.items()) + "}"):  # fmt: skip
        check_against_yaml(read(tmp_path, text), PENDULUM)


def test_numbers_are_rounded_as_python_does(tmp_path):
    for text in (
        "1e-5",
        "0.1e1",
        "+3",
        ".5",
        "5.",
        "1.7976931348623157e308",
        "2.2250738585072014E-308",
        "4.9e-324",
    ):
        assert read(tmp_path, change(SLIDER, "mass_kg: 80", f"mass_kg: {text}"))["mass_kg"] == [float(text)]


# ---- what is refused -------------------------------------------------------------


def keys_of(text):
    """Every dotted key of a model, with the piece of text that is its value's first line."""
    found = []

    def walk(node, path):
        for key, value in node.items():
            found.append([*path, key])
            if isinstance(value, dict):
                walk(value, [*path, key])

    walk(yaml.safe_load(text), [])
    return found


def without(said, path):
    copy = yaml.safe_load(yaml.safe_dump(said))
    node = copy
    for key in path[:-1]:
        node = node[key]
    value = node.pop(path[-1])
    return copy, node, value


ALL_KEYS = [(plant, key) for plant, text in EXAMPLES.items() for key in keys_of(text)]


@pytest.mark.parametrize(("plant", "key"), ALL_KEYS, ids=lambda x: x if isinstance(x, str) else ".".join(x))
def test_each_key_missing_misspelt_and_of_another_type(tmp_path, plant, key):
    said = yaml.safe_load(EXAMPLES[plant])
    copy, node, value = without(said, key)
    dotted = ".".join(key)
    if dotted != "torque_offset_Nm":
        assert refused(tmp_path, yaml.safe_dump(copy)).endswith(f"{dotted}: missing key")
    node[key[-1] + "x"] = value
    message = refused(tmp_path, yaml.safe_dump(copy))
    if key[-1] not in ("plant", "type"):
        assert f"{dotted}x: unknown key, expected one of " in message and key[-1] in message
    del node[key[-1] + "x"]
    for wrong in ([1.0], None, True, "text", {} if not isinstance(value, dict) else 1.0):
        node[key[-1]] = wrong
        message = refused(tmp_path, yaml.safe_dump(copy))
        assert re.match(r"\d+: ", message)
        # a mapping in place of a mapping lacks its keys; else the type, or the name, is complained of
        assert f"{dotted}" in message and ("expected" in message)


@pytest.mark.parametrize(("plant", "key", "values"), [
    ("leg", "shank.length_m", [0, -1]), ("leg", "shank.mass_kg", [0, -1]), ("leg", "shank.com_m", [-0.1]),
    ("leg", "shank.inertia_kg_m2", [0, -1]), ("leg", "foot.mass_kg", [0, -2]), ("leg", "foot.com_m", [-1e-9]),
    ("leg", "foot.inertia_kg_m2", [0]), ("leg", "ankle_motor.mass_kg", [0, -1]),
    ("leg", "gravity_m_s2", [-9.81]),
    ("leg", "knee.transmission.ratio", [0]), ("leg", "knee.torque_constant_Nm_A", [0, -0.1]),
    ("leg", "knee.friction.coulomb_Nm", [-0.1]), ("leg", "knee.friction.viscous_Nms_rad", [-1]),
    ("leg", "ankle.transmission.lead_m", [0, -0.002]), ("leg", "ankle.transmission.AB_m", [0, -1]),
    ("leg", "ankle.transmission.BO_m", [0]), ("leg", "ankle.transmission.AC_m", [-0.035]),
    ("leg", "ankle.torque_constant_Nm_A", [0]), ("leg", "ankle.rotor_inertia_kg_m2", [0, -1e-6]),
    ("leg", "ankle.friction.coulomb_Nm", [-0.1]), ("leg", "ankle.friction.viscous_Nms_rad", [-1]),
    ("pendulum", "inertia_kg_m2", [0, -1]), ("pendulum", "gravity_moment_kg_m", [-0.1]),
    ("pendulum", "joint.transmission.ratio", [0]), ("pendulum", "joint.torque_constant_Nm_A", [0]),
    ("pendulum", "joint.friction.coulomb_Nm", [-1]), ("slider", "mass_kg", [0, -80]),
    ("slider", "friction.coulomb_N", [-1]), ("slider", "friction.viscous_Ns_m", [-1]),
])  # fmt: skip
def test_physical_ranges(tmp_path, plant, key, values):
    for value in [*values, ".nan", ".inf", "-.inf", "1e999"]:
        said = yaml.safe_load(EXAMPLES[plant])
        node = said
        for part in key.split(".")[:-1]:
            node = node[part]
        node[key.split(".")[-1]] = "VALUE"
        text = yaml.safe_dump(said)
        message = refused(tmp_path, text.replace("VALUE", str(value)))
        assert message.startswith(f"{line_of(text, 'VALUE')}: {key}: expected ")
        assert message.endswith(f"found '{value}'")


def is_sound(link):
    """Does the nut's travel rise or fall all the way over +-30 degrees? By docs/equations.md, on a grid."""
    phi = numpy.pi - numpy.radians(link["BOF_deg"]) - numpy.radians(numpy.linspace(-30, 30, 6001))
    height = link["AC_m"] - link["BO_m"] * numpy.sin(phi)
    if (link["AB_m"] <= abs(height)).any():
        return False
    travel = numpy.diff(link["BO_m"] * numpy.cos(phi) + numpy.sqrt(link["AB_m"] ** 2 - height**2))
    return bool((travel > 0).all() or (travel < 0).all())


@pytest.mark.parametrize("change_of", [
    ("AB_m: 0.090", "AB_m: 0.004"), ("AC_m: 0.035", "AC_m: 0.2"), ("BOF_deg: 84.75", "BOF_deg: 180"),
])  # fmt: skip
def test_linkage_that_does_not_close(tmp_path, change_of):
    text = change(LEG, *change_of)
    assert not is_sound(yaml.safe_load(text)["ankle"]["transmission"])
    assert is_sound(yaml.safe_load(LEG)["ankle"]["transmission"])
    line = line_of(text, "{type: screw_linkage")
    message = refused(tmp_path, text)
    assert message.startswith(f"{line}: ankle.transmission: this linkage does not close")


def test_series_whose_ratio_changes_sign(tmp_path):
    series = FOURIER.replace("900", "-0.5")
    text = change(LEG, LEG[LEG.index("{type: screw_linkage") : LEG.index("84.75}") + 6], series)
    assert "ankle.transmission: the ratio of this series changes sign" in refused(tmp_path, text)
    for wrong, words in (
        (", 8]", "a list of 9 numbers, found 8"),
        (", 8, 9]", "a list of 9 numbers, found 10"),
    ):
        broken = series.replace("900", "9000").replace(", 7, 8]", ", 7]" if wrong == ", 8]" else ", 7, 8, 9]")
        text = change(LEG, LEG[LEG.index("{type: screw_linkage") : LEG.index("84.75}") + 6], broken)
        assert words in refused(tmp_path, text)


def test_linkage_keys_under_a_fixed_ratio(tmp_path):
    message = refused(tmp_path, change(LEG, "ratio: 51", "ratio: 51, lead_m: 0.002"))
    assert "knee.transmission.lead_m: unknown key, expected one of type, ratio" in message
    assert "knee.transmission.type: expected fixed, screw_linkage or fourier, found 'belt'" in refused(
        tmp_path, change(LEG, "type: fixed", "type: belt")
    )


APPENDED = {
    "form: lagrang": "form: expected lagrange or paper, found 'lagrang'",
    "score: {lowpass_hz: 0}": "score.lowpass_hz: expected a number above 0",
    "score: {order: 0}": "score.order: expected a whole number from 1 to 8, found '0'",
    "score: {order: 2.5}": "score.order: expected a whole number",
    "score: {standstill: -1}": "score.standstill: expected 0 or a number above it",
    "score: {lowpas_hz: 3}": "score.lowpas_hz: unknown key",
    "score: 3": "score: expected a mapping",
    "signal: {order: 5}": "signal.window_s: missing key",
    "signal: {order: 1, window_s: 0.1}": "signal.order: expected a whole number from 2 to 24",
    "signal: {order: 5, window_s: 0}": "signal.window_s: expected a number above 0",
    "bounds: [1, 2]": "bounds: expected a mapping",
    "bounds: {shank.mass_kg: [0, 2]}": "bounds.shank.mass_kg: not a parameter that is identified",
    "bounds: {knee.transmission: [0, 2]}": "bounds.knee.transmission: not a parameter",
    "bounds: {shank.com_m: [0.3, 0.1]}": "bounds.shank.com_m: the lower bound 0.3 is above the upper",
    "bounds: {shank.com_m: [-0.3, 0.2]}": "bounds.shank.com_m: the lower bound -0.3 is below the physical",
    "bounds: {shank.com_m: [0.17, 0.2]}": "bounds.shank.com_m: the model's own value 0.16 lies outside",
    "bounds: {shank.com_m: 0.1}": "bounds.shank.com_m: expected a list of 2 numbers",
    "bounds: {shank.com_m: [0.1]}": "bounds.shank.com_m: expected a list of 2 numbers, found 1",
    "bounds: {shank.com_m: [0.1, x]}": "bounds.shank.com_m: expected a number, found 'x'",
    "bounds: {foot.com_m: [0, 1], foot_com_m: [0, 1]}": "bounds.foot_com_m: this parameter has a bound",
    "effects: {}": "effects: expected a list",
    "effects: [{effect: stribek, joint: ankle}]": "effects: the effect 'stribek' is not known",
    "effects: [3]": "effects: expected {effect: ID, ...}",
    "gravity_m_s2: 9.81": "gravity_m_s2: the key stands twice",
    "plant: leg": "plant: the key stands twice",
    "? [1, 2]\n: 3": "expected a key, found a list",
    "shank_m: 3": "shank_m: unknown key",
}


@pytest.mark.parametrize("line", APPENDED)
def test_faults_beside_the_plants_own_keys(tmp_path, line):
    number = LEG.count("\n") + 1
    assert refused(tmp_path, LEG + line + "\n").startswith(f"{number}: {APPENDED[line]}")


def test_keys_of_another_plant(tmp_path):
    assert "form: only a leg has the form 'paper'" in refused(tmp_path, SLIDER + "form: paper\n")
    assert "gravity_m_s2: unknown key" in refused(tmp_path, SLIDER + "gravity_m_s2: 9.81\n")
    assert read(tmp_path, SLIDER + "form: lagrange\n")["form"] == [0]
    message = refused(tmp_path, change(SLIDER, "plant: slider", "plant: sled"))
    assert message.startswith("2: plant: expected leg, pendulum or slider, found 'sled'")


def test_doubled_key_in_a_section(tmp_path):
    message = refused(tmp_path, change(LEG, "com_m: 0.055", "com_m: 0.055, mass_kg: 0.442"))
    assert message == f"{line_of(LEG, 'foot:')}: foot.mass_kg: the key stands twice"


NO_MODEL = {
    "": "the file is empty, expected a model",
    "# only a comment\n": "the file is empty, expected a model",
    "- a\n- b\n": "1: expected a mapping (key: value), found a list",
    "leg": "1: expected a mapping (key: value), found 'leg'",
    "{}": "1: plant: missing key",
    "plant: [leg\n": "2: not YAML: ",
    "plant: leg\n\tshank: 1\n": "2: not YAML: ",
    "a: b: c\n": "1: not YAML: ",
    "plant: slider\n---\nplant: slider\n": "3: a second document begins here",
    "plant: *other\n": "1: not YAML: ",
    "\x00\x01": "not text: ",
    "a: " + "[" * 10_000: ": not YAML: ",
    "# " + "x" * 400_000: "longer than 262144 bytes",
    "plant: leg\n" + "# x\n" * 100_000: "longer than 262144 bytes",
}


@pytest.mark.parametrize("index", range(len(NO_MODEL)))
def test_files_that_are_no_model(tmp_path, index):
    text, words = list(NO_MODEL.items())[index]
    message = refused(tmp_path, text)
    assert words in message, message


def test_bytes_that_are_no_text(tmp_path):
    assert "not text: " in refused(tmp_path, b"plant: \xff\xfe\xfd leg\n")
    assert complaint("model_copy", tmp_path).endswith(": is a directory, expected a file")
    assert complaint("model_copy", tmp_path / "none").endswith("none: No such file or directory")


def test_aliases_that_hold_themselves(tmp_path):
    for text in ("a: &a [*a]\n", "&a plant: leg\nshank: *a\n", "plant: leg\nshank: &s {mass_kg: *s}\n"):
        refused(tmp_path, text)


def test_random_damage_never_crashes(tmp_path):
    generator = random.Random(5)
    refusals = 0
    for _ in range(300):
        content = bytearray(LEG.encode())
        for _ in range(generator.randint(1, 3)):
            at = generator.randrange(len(content))
            content[at : at + generator.randint(0, 12)] = generator.choice(
                [
                    b"",
                    b"{",
                    b"}",
                    b"- ",
                    b"\n",
                    b"\t",
                    b": ",
                    b"&a ",
                    b"*a",
                    b"'",
                    b"\xff",
                    b"0",
                    b"-",
                    b"#",
                    b"? ",
                ]
            )
        path = write(tmp_path, bytes(content))
        done = subprocess.run([BUILD / "tests" / "model_copy", path], check=False, capture_output=True)
        assert done.returncode in (0, 2), done.stderr
        if done.returncode == 2:
            refusals += 1
            assert len(done.stderr.decode().splitlines()) == 1
    assert refusals > 100


# ---- what is written -------------------------------------------------------------


def random_double(generator, low=-30, high=30):
    return generator.uniform(0.1, 1) * 10.0 ** generator.randint(low, high)


@pytest.mark.parametrize("plant", EXAMPLES)
def test_written_models_read_back_to_the_same_doubles(tmp_path, plant):
    """By this reader and by PyYAML, for numbers of any size."""
    generator = random.Random(plant)
    for _ in range(15):
        said = yaml.safe_load(EXAMPLES[plant])

        def scramble(node):
            for key, value in node.items():
                if isinstance(value, dict):
                    if value.get("type") != "screw_linkage":  # its dimensions depend on each other
                        scramble(value)
                elif isinstance(value, (int, float)):
                    node[key] = random_double(generator)

        scramble(said)
        said["score"] = {"order": 3, "trim_s": random_double(generator)}
        text = yaml.safe_dump(said)
        first = helper("model_copy", write(tmp_path, text), tmp_path / "out.yaml")
        written = (tmp_path / "out.yaml").read_text()
        again = helper("model_copy", tmp_path / "out.yaml", tmp_path / "again.yaml")
        assert again.stdout == first.stdout
        assert (tmp_path / "again.yaml").read_text() == written
        read_by_yaml = expected_of(yaml.safe_load(written))
        for name, value in expected_of(said).items():
            assert isinstance(read_by_yaml[name], (int, float)), (name, read_by_yaml[name])
            assert struct.pack("d", read_by_yaml[name]) == struct.pack("d", value), name


def test_written_leg_with_everything(tmp_path):
    text = change(LEG, LEG[LEG.index("{type: screw_linkage") : LEG.index("84.75}") + 6], FOURIER)
    text += "form: paper\nscore: {guard_s: 0.1}\nsignal: {order: 7, window_s: 1e-2}\n"
    text += "bounds: {shank.com_m: [1e-7, 0.3], ankle_coulomb_Nm: [0.8, 0.8]}\n"
    first = helper("model_copy", write(tmp_path, text), tmp_path / "out.yaml")
    assert helper("model_copy", tmp_path / "out.yaml").stdout == first.stdout
    said = yaml.safe_load((tmp_path / "out.yaml").read_text())
    assert said["bounds"] == {"shank_com_m": [1e-7, 0.3], "ankle_coulomb_Nm": [0.8, 0.8]}
    assert said["form"] == "paper" and said["signal"] == {"order": 7, "window_s": 0.01}


def test_written_text(tmp_path):
    """The comment first, and the keys in the order of the examples."""
    for text in EXAMPLES.values():
        helper("model_copy", write(tmp_path, text), tmp_path / "out.yaml")
        written = (tmp_path / "out.yaml").read_text()
        assert written.startswith("# first line\n# second line\nplant: ")
        assert list(yaml.safe_load(written)) == list(yaml.safe_load(text))
        assert keys_of(written) == keys_of(text)


@pytest.mark.parametrize(("plant", "parameter", "value", "words"), [
    ("leg", "foot_inertia_kg_m2", "0", "foot.inertia_kg_m2 is not a number above 0"),
    ("leg", "ankle_coulomb_Nm", "-1e-9", "ankle.friction.coulomb_Nm is not 0 or a number above it"),
    ("leg", "knee_viscous_Nms_rad", "nan", "knee.friction.viscous_Nms_rad is not a finite number"),
    ("pendulum", "torque_offset_Nm", "inf", "torque_offset_Nm is not a finite number"),
    ("slider", "mass_kg", "0", "mass_kg is not a number above 0"),
])  # fmt: skip
def test_what_could_not_be_read_again_is_not_written(tmp_path, plant, parameter, value, words):
    out = write(tmp_path, "earlier", "out.yaml")
    path = write(tmp_path, EXAMPLES[plant] + "score: {order: 3}\n")
    message = complaint("model_copy", path, out, parameter, value, status=1)
    assert message == f"{out}: not written: {words}"
    assert out.read_text() == "earlier"
    helper("model_copy", path, out, parameter, "0.25")
    assert list(yaml.safe_load(out.read_text())) == [*yaml.safe_load(EXAMPLES[plant]), "score"]


def test_an_earlier_model_survives_a_failed_write(tmp_path):
    path = write(tmp_path, SLIDER)
    folder = tmp_path / "none"
    message = complaint("model_copy", path, folder / "out.yaml", status=1)
    assert message == f"{folder}/out.yaml: cannot be written: No such file or directory"
