"""The numbers that decide a verdict, each with its reason; docs/diagnosis.md says how each of them was tried. What only steers
how shapes are searched, or what is printed, stands where it is used."""

import math

# ---- what reconstruction leaves where nothing is hidden, before replicates say it ------------------------------------

TOLERATED_PER_FREEDOM = 0.10  # excess for each degree of freedom: smoothed reversals, quantisation
TOLERATED_OF_SIGNAL = 0.007  # and of the measured torque
TIMES_TOLERATED = 2.5
"""Without any effect `none` and `unknown` are equally likely at so many times the tolerated excess. While the tolerance alone
explains the excess, and of a further effect, a gain must be worth so many least steps: of 70 benches with two effects none that
was true gained less than 3."""

# ---- an effect at all ------------------------------------------------------------------

LEAST_STEP = 40.0  # chi-square: the best of 1,000 columns gains about 14 in white noise; three times that
LEAST_STEP_PER_FREEDOM = 0.0075  # because the noise itself is known to a percent
DEVIATIONS = 2.0
"""Of the gain over blocks, which one block alone must not carry; and widths above the replicates' gains: what gains less would
lie among them in every twentieth recording."""
MISFIT = 0.6  # of the logarithm: how far gains of simulated replicates are off those of recordings with nothing hidden
RANGE = math.log(1000.0)  # of an effect's gain over the least that shows, before the data
FLOOR = 8.0  # chi-square, added to gains: below it the logarithm tells noise apart from noise

# ---- this effect, or another, or none of the catalogue -------------------------------------

HALF = 0.5
"""Of what stands open: where a cause leaves as much, `unknown` is as likely, and what closes less is no part of a gap, but its
imitation. Of probabilities: what is likelier to be nothing than not is not taken."""
FURTHER_MUST_CLOSE = 0.45  # of what stands open: an approximate form of the first effect leaves what a wrong second one fits
LOGIT_WIDTH = 0.35  # of the logarithm of such a share
COLUMN_PRICE = 2.0  # chi-square for each further column, whose choice the folds do not see
LEFT_BY_A_FORM = 0.02  # of what an effect explains: so much another form of it may well leave
PART = 0.2  # of what one order or mode leaves, for a second one; of the whole, for a verdict on one joint alone
LEFT_OF_ONE_JOINT = 0.82  # of its whole error, noise and all: what takes less away is one of many small causes, not the cause
LEFT_WIDTH = 0.03  # of its logarithm
TEMPERATURE = 15.0  # chi-square: the best of 1,000 columns gains that in white noise
TEMPERATURE_OF_REST = 0.1  # and of what is left: forms are approximate
TEMPERATURE_OF_EXCESS = 0.0005  # and of the gap: a fine encoder shows what no form has exactly
TEMPERATURE_OF_NESTED = 4.0  # where one form holds the other, noise alone decides
TEMPERATURE_OF_REST_OF_NESTED = 0.03  # of all that the torque there shows above noise

# ---- what the sensors may have done -----------------------------------------------------

LEAVES_ALONE = 0.02  # of the inertia: beyond it springs and losses repair what the sensors did, and the low-pass goes down
GIVES_UP = 0.1  # of the inertia: then these recordings cannot fix it
OUTDONE_BELOW = 0.5  # widths of the recordings' largest gain above the replicates': the readings alone may gain as much
UNSTABLE_AT_MOST = 0.45  # of an effect that half the low-pass does not show, or where the sensors may have done it
FARTHEST, FARTHEST_FROM_IDENTIFIED = 1.2, 0.5  # of its value there, that an inertial parameter may be off beside an effect
