"""What the paper prints; nothing else on the page is typed in.

'Dynamic parameter identification of ankle-knee prostheses based on Coulomb-viscous friction', J. Dynamics and
Control 22(2), 2024.
"""

DOI = "10.6052/1672-6553-2023-031"
RATIO_ERROR = 2.43e-3  # of its 8th-order series
RMSE_NM = {"knee": (0.0076, 0.00049), "ankle": (0.0012, 0.00023)}  # CAD, identified
REDUCTION_PERCENT = {"knee": 93.55, "ankle": 80.83}  # Chinese abstract, and what RMSE_NM give
REDUCTION_ENGLISH_PERCENT = {"knee": 99.07, "ankle": 83.33}  # English abstract
WINDOW = (20, 1.0)  # order and length [s] of its smoothing
SAMPLE_HZ = 200.0
RECORDINGS = 3
SECONDS = 120.0

# its name of each parameter, and what it calls it
SYMBOLS = {
    "ankle_motor_com_m": ("d<sub>ma</sub>", "ankle motor, centre of mass"),
    "foot_com_m": ("d<sub>f</sub>", "foot, centre of mass"),
    "shank_com_m": ("d<sub>s</sub>", "shank, centre of mass"),
    "shank_inertia_kg_m2": ("I<sub>1</sub>", "shank, inertia"),
    "ankle_rotor_inertia_kg_m2": ("I<sub>ma</sub>", "ankle rotor, inertia"),
    "foot_inertia_kg_m2": ("I<sub>f</sub>", "foot, inertia"),
    "knee_coulomb_Nm": ("f<sub>cs</sub>", "knee, Coulomb friction"),
    "knee_viscous_Nms_rad": ("f<sub>vs</sub>", "knee, viscous friction"),
    "ankle_coulomb_Nm": ("f<sub>cf</sub>", "ankle, Coulomb friction"),
    "ankle_viscous_Nms_rad": ("f<sub>vf</sub>", "ankle, viscous friction"),
}
