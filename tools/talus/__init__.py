"""talus from Python: models, recordings, identification, diagnosis; and the C library as it is, with NumPy arrays.

    model, monday, tuesday = talus.read("arm.yaml"), talus.read("monday.csv"), talus.read("tuesday.csv")
    fit = talus.identify(model, [monday])                 # parameters, and how sure each is
    found = talus.compare(fit.model, tuesday)             # measured, predicted, residual, error
    diagnosis = talus.diagnose(model, [monday, tuesday])  # which effect the gap comes from
    print(fit, found, diagnosis, sep="\\n")
    found.to_pandas().to_csv("tuesday_predicted.csv")     # every result: arrays, a data frame, a picture
    diagnosis.plot().savefig("gap.png")

Each name below has an example that runs in a clone of talus. Their arm.csv is a recording of 20 s:

    talus.simulate(talus.read("models/pendulum.yaml"), duration_s=20).write("arm.csv")

All of the C library stands beside them:

    from talus import ffi, lib, check, pointer

    model = ffi.new("tl_model *")
    check(lib.tl_model_init(model, lib.TL_PLANT_LEG))
    torque = numpy.empty((2, n))
    lib.tl_inverse_batch(model, n, pointer(q), pointer(v), pointer(a), ffi.NULL, pointer(torque))

`lib` holds every function and enumerator of the public headers under its C name,
`ffi` makes and reads structs, `constants` the integer, real and text macros
(constants.TL_MAX_JOINTS). The declarations are the headers themselves, passed
through the C preprocessor by `make`: nothing is written twice.

Environment: TALUS_BUILD (build folder, default <repository>/build) and
TALUS_LIBRARY (the shared library, default <TALUS_BUILD>/lib/libtalus.so).
"""

from ._arrays import pointer
from ._library import BUILD, InputError, TalusError, check, constants, ffi, lib
from .identification import Fit, Regression, identify, predict
from .model import Model, plants, score_settings
from .own_effect import Effect, Segment
from .page import Page
from .programs import Diagnosis, diagnose, read, simulate
from .recording import Recording, channel_set, channels
from .scoring import Panel, Prediction, compare, measured, panels, score

__all__ = [
    "BUILD",
    "Diagnosis",
    "Effect",
    "Fit",
    "InputError",
    "Model",
    "Page",
    "Panel",
    "Prediction",
    "Recording",
    "Regression",
    "Segment",
    "TalusError",
    "channel_set",
    "channels",
    "check",
    "compare",
    "constants",
    "diagnose",
    "ffi",
    "identify",
    "lib",
    "measured",
    "panels",
    "plants",
    "pointer",
    "predict",
    "read",
    "score",
    "score_settings",
    "simulate",
]
