"""talus-gap up to its search, in this process.

    evidence, identified = recorded(LEG, folder, folder / "leg.csv")
"""

import os

from support import BUILD

import talus

os.environ.setdefault("TALUS_BUILD", str(BUILD))

from talus.diagnosis import command  # noqa: E402
from talus.diagnosis.dataset import Dataset  # noqa: E402
from talus.diagnosis.processed_recording import ProcessedRecording  # noqa: E402


def recorded(model, folder, *recordings):
    """(evidence of the recordings under the model of a file, the identified model)"""
    options = command.Options(["-m", str(model), "-r", str(folder / "gap.json"), *map(str, recordings)])
    options.check()
    given, names, every, _ = command.read(options)
    with command.identifying(options) as found:
        _, tree = found()
    processed_recordings = [ProcessedRecording(given, one, path) for one, path in zip(every, names)]
    return Dataset(given, processed_recordings, tree), talus.Model.from_tree(tree)
