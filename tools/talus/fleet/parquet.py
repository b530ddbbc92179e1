"""The diagnoses as one table, a row each."""

import io
import json

from talus.refused import Refused

from . import series
from .table import days


def table(kept):
    """A Parquet file's bytes, from [(item, ITEM.json's mapping or None)]. Columns of figures are there where any diagnosis has one."""
    pyarrow, writer = _library()
    rows = [_row(item, one) for item, one in kept]
    columns = {name: [row.get(name) for row in rows] for name in dict.fromkeys(name for row in rows for name in row)}
    kinds = {"temperature_C": pyarrow.float64(), "probability": pyarrow.float64(), **dict.fromkeys(("effect", "joint", "effects", "findings"), pyarrow.string())}
    out = io.BytesIO()
    writer.write_table(pyarrow.table({name: pyarrow.array(values, kinds.get(name)) for name, values in columns.items()}), out)
    return out.getvalue()


def _row(item, one):
    """What one diagnosis says; `status` is null where there is none yet. `effects` and `findings` are GAP.json's, as JSON."""
    row = {"name": item.name, "robot": item.robot, "session": item.session, "day": days(item.session), "temperature_C": item.temperature_C,
           "recordings": list(item.recordings), "model": item.model, "status": one and one["status"], "said": one and one["said"]}  # fmt: skip
    row |= dict.fromkeys(("effect", "joint", "probability", "effects", "findings"))
    if one and one["status"] == 0:
        row |= {key: one["verdict"][key] for key in ("effect", "joint", "probability")}
        row |= {key: json.dumps(one[key]) for key in ("effects", "findings")}
        row |= {f"{kind} {name}": value for (kind, name), value in sorted(series.quantities(one).items()) if kind == "parameter"}
        row |= {f"{joint} {key}": gap[key] for joint, gap in one["gap"].items() for key in ("nominal_rms", "identified_rms", "extended_rms", "noise_floor_rms")}
    return row


def _library():
    try:
        import pyarrow
        import pyarrow.parquet as writer
    except ImportError as error:
        raise Refused(1, "report: needs pyarrow: pip install 'talus[fleet]'") from error
    return pyarrow, writer
