"""The numbers that decide a verdict, each with its reason; docs/diagnosis.md says how each of them was tried. What only steers
how shapes are searched, or what is printed, stands where it is used."""

import math

# ---- what is there anyhow --------------------------------------------------------------

TOLERATED_PER_FREEDOM = 0.10  # excess for each degree of freedom, before replicates say it: smoothed reversals, quantisation
TIMES_AS_MUCH = 2.5
"""An effect must gain so many times what the best of the columns tried gains by chance, 2 ln n of n columns: the least step. Without
replicates, an excess of so many times the tolerance is as likely `unknown` as `none`. While the tolerance alone explains the excess,
and of a further effect, a gain must be worth so many least steps."""
DEVIATIONS = 2.0
"""Of the gain over blocks, which one block alone must not carry; and widths above the replicates' gains: what gains less would
lie among them in every twentieth recording. Of a strength through another low-pass: a law moves no farther. Of a stiffness: a spring's is not so far below 0."""
MISFIT = 0.6  # of the logarithm: how far gains of simulated replicates are off those of recordings with nothing hidden
RANGE = math.log(1000.0)  # of an effect's gain over the least that shows, before the data
LASTS = 3.5  # standard errors of what lasts, from nothing: by chance in one of 500 recordings, of eight looks at each

# ---- this effect, or another, or none of the catalogue -------------------------------------

OPEN = 1 / 3  # of the gap: where a cause leaves as much, half of what it closes, `unknown` is as likely
HALF = 0.5
"""Of probabilities: what is likelier to be nothing than not is not taken. Of what effects leave open, that a cause outside the catalogue
closes: then it is as likely. Of the replicates' width: so near to their largest gain the readings alone may have done it. Of the
inertia: where the sensors take more than they leave, no cause is sure; and where the model leaves more than half of the torque as well, no
verdict is. Of what a drive's law tells: what a replicate must show of it. Of the noise: where a model leaves less, it was motion. Of an
effect's size, by which a half of the motion may show another. Of the range: where a spring pushes away over more, it is none."""
NEARLY_HALF = 0.45
"""Of what stands open, that a further effect must close: an approximate form of the first one leaves what a wrong second one fits. Of
probabilities, at most: of what another low-pass does not show, or the sensors may have done."""
PART = 0.2
"""Least share that counts as a part: of what one order or mode leaves, for a second one; of the whole, for a verdict on one joint
alone; of what differs between periods, about one frequency, where noise of any colour has below 0.1. Of inertia and gravity, what a
drawing is off by. Of what an effect does to the readings, by which another low-pass may show another size of it: true ones move by a
twentieth."""
LOGIT_WIDTH = 0.35  # of the logarithm of such a share
REST_AS_NOISE = 0.1  # of what is left, so much counts as noise of the odds: forms are approximate
RIGHT_TO = 0.02
"""Of its size, that a form's torque and the inertia may be off. Of the gap the square of it is noise of the odds, for a fine encoder
shows what no form has exactly. Of what an effect explains another form of it may well leave as much. Of what an effect does to the
readings, by which half and twice of a slow low-pass may show another size of it. Of the inertia, beyond it springs and losses repair
what the sensors did, and the low-pass goes down."""
OF_NESTED = 0.3  # of that noise, where one form holds the other: then both err alike

# ---- what the sensors may have done -----------------------------------------------------

GIVES_UP = 0.1  # of the inertia: then these recordings cannot fix it
