"""The diagnosis behind talus-gap: where the gap between a model and its recordings lies, and what causes it.

One file, one subject, in the order in which a diagnosis runs:

    processed_recording.py  one recording: motion, regressor, and the operator that every column passes through
    noise.py            periods, blocks and the noise floor of each channel
    dataset.py          channels of all recordings as weighted rows
    torque_terms.py     the plain model's torque terms along one recording, which the library computes
    effects/            one file an effect: its words, the shapes that are tried, all else that is known of it
    catalogue/          candidates: one effect at one joint in one shape, as columns
    gram.py             normal equations by block, fits and their error on blocks held out
    search.py           which effects, up to three
    verdict.py          probabilities, none and unknown
    machine/            the machine beside the effects: as it is drawn, in physical parameters, with springs that can be
    figures.py          the gap in the contract's figures
    motion.py           the library's simulation under the recorded torque, against the recorded motion
    tilt_source.py      a tilted bench or an encoder's zero, by a camera
    where.py            maps of the systematic residual
    experiment/         what to record next, and its trajectory
    report.py           GAP.json
    refit.py            effects and physical parameters together, for the model file
    fitted.py           the model with its effects
    words.py            the diagnosis in plain words, figures in readable units
    picture/            the page; its maps and curves
    command.py          the command line

docs/diagnosis.md has the method and the reason of every constant.
"""
