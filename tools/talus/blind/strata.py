"""Rates of error of the wide protocol, for each plant, rate, resolution, length and kind of motion."""

from statistics import mean, median

from .scores import calibration_error, share


def within(value, edges, unit):
    """The name of the range that a value lies in; `edges` are the ranges' upper ends."""
    low = 0
    for high in edges:
        if value <= high:
            return f"{low:g} to {high:g} {unit}"
        low = high
    return f"above {low:g} {unit}"


def axes(protocol):
    """The strata that a case belongs to, {axis: [name]}: one of each axis, but of motions each that was recorded."""
    bits = protocol["bits"]
    return {
        "plant": [protocol["plant"]],
        "rate": [within(protocol["rate_Hz"], (125, 250, 500), "Hz")],
        "encoder": ["exact" if bits == 0 else within(bits, (13, 16), "bits")],
        "length": [within(protocol["total_s"], (50, 120), "s")],
        "motion": sorted(set(protocol["motions"])),
        "recordings": ["1" if protocol["recordings"] == 1 else "2 to 4"],
        "noise": [protocol["noise"]],
    }


def figures(cases):
    """The rates, {name: (value or None, cases)}."""
    of = lambda kind: [c for c in cases if c["kind"] == kind]  # noqa: E731
    singles, pairs = ([c for c in of(kind) if c["observable"]] for kind in ("single", "pair"))
    both = [c for c in pairs if all(c["each_observable"])]
    known = [c for c in of("single") + of("pair") if c["shrinkage"]]
    closed = [c["shrinkage"]["pooled"] for c in known if c["shrinkage"]["pooled"] is not None]
    return {
        "wrong": share(c["wrong_listed"] for c in cases),
        "none": share(c["verdict"][0] == "none" for c in of("none")),
        "unknown": share(c["exact"] for c in of("unknown")),
        "exact": share(c["exact"] for c in singles),
        "alias": share(c["group"] for c in singles),
        "confusable": share(c["group_reported"] for c in singles),
        "joint": share(c["joint_right"] for c in singles),
        "both": share(all(c["found_group"]) for c in both),
        "no third": share(not c["invented"] for c in pairs),
        "Brier": (mean((c["probability"] - c["group"]) ** 2 for c in cases) if cases else None, len(cases)),
        "ECE": (calibration_error(cases), len(cases)),
        "closed": (median(closed) if closed else None, len(closed)),
        "covered": share(flag for c in known for flag in c["covered"]),
    }


def table(cases):
    """Rows {axis, stratum, cases, figures}: all first, then each axis's strata."""
    groups = {("all", ""): cases}
    for case in cases:
        for axis, names in axes(case["protocol"]).items():
            for name in names:
                groups.setdefault((axis, name), []).append(case)
    order = list(axes(cases[0]["protocol"])) if cases else []
    rank = {"all": -1, **{axis: i for i, axis in enumerate(order)}}
    return [{"axis": axis, "stratum": name, "cases": len(part),
             "figures": {what: {"value": value, "cases": n} for what, (value, n) in figures(part).items()}}
            for (axis, name), part in sorted(groups.items(), key=lambda item: (rank[item[0][0]], item[0][1]))]  # fmt: skip


def shown(entry):
    """A figure with the number of cases that it is of."""
    return "-" if entry["value"] is None else f"{entry['value']:.2f}/{entry['cases']}"


def words(rows):
    """The table for people; behind each stroke the number of cases."""
    names = list(rows[0]["figures"])
    lines = [f"{'':24} {'cases':>5} " + " ".join(f"{name:>10}" for name in names)]
    for row in rows:
        title = f"{row['axis']} {row['stratum']}".strip()
        lines.append(f"{title:24} {row['cases']:>5} " + " ".join(f"{shown(row['figures'][name]):>10}" for name in names))
    return "\n".join(lines)
