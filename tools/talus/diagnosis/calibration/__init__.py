"""What these very recordings tell of how far a diagnosis can be trusted.

    replicates.py   the recordings once more, with nothing hidden       gains.py       what a search finds in them
    lowpass.py      the fastest low-pass that leaves the inertia alone   stability.py   does a verdict survive half of it?
"""
