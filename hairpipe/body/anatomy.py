"""The anatomy of our own bust, in metres: chin at y = 0.22, crown at 0.45, ear canals at z = 0."""

from functools import partial

from hairpipe.body.blended_shapes import Cone, Ellipsoid, Stroke

pair = partial(Stroke, mirror=True)

SKULL = (
    Stroke(Ellipsoid((0.0, 0.371, -0.024), (0.0765, 0.0785, 0.080)), 0.0),  # braincase
    Stroke(Ellipsoid((0.0, 0.364, 0.028), (0.066, 0.074, 0.062)), 0.05),  # forehead
)
FACE = (
    Stroke(Ellipsoid((0.0, 0.305, 0.038), (0.058, 0.076, 0.051), (-6.0, 0.0, 0.0)), 0.03),  # mid face
    pair(Cone((0.043, 0.276, 0.008), (0.011, 0.239, 0.068), (0.019, 0.016)), 0.035),  # jaw
    pair(Cone((0.044, 0.278, 0.008), (0.052, 0.330, 0.010), (0.018, 0.020)), 0.03),  # jaw's angle
    pair(Ellipsoid((0.038, 0.288, 0.040), (0.018, 0.032, 0.027), (0.0, 0.0, 8.0)), 0.04),  # cheek
    Stroke(Ellipsoid((0.0, 0.239, 0.0765), (0.017, 0.016, 0.012)), 0.025),  # chin
    pair(Ellipsoid((0.042, 0.312, 0.058), (0.019, 0.014, 0.020)), 0.035),  # cheekbone
    pair(Cone((0.0, 0.355, 0.081), (0.043, 0.355, 0.064), (0.009, 0.007)), 0.02),  # brow
    pair(Ellipsoid((0.033, 0.336, 0.100), (0.020, 0.012, 0.020), (0.0, 20.0, 0.0)), 0.018, carve=True),  # eye socket
    pair(Ellipsoid((0.031, 0.335, 0.071), (0.0155, 0.0110, 0.0122)), 0.008),  # eyelids
    Stroke(Cone((0.0, 0.345, 0.083), (0.0, 0.306, 0.1025), (0.006, 0.0090)), 0.014),  # nose
    pair(Ellipsoid((0.0105, 0.3025, 0.0935), (0.0070, 0.0060, 0.009)), 0.012),  # wing of the nose
    pair(Cone((0.0215, 0.2725, 0.0800), (0.0, 0.2768, 0.0900), (0.0040, 0.0055)), 0.009),  # upper lip
    pair(Cone((0.0180, 0.2690, 0.0815), (0.0, 0.2653, 0.0890), (0.0040, 0.0060)), 0.006),  # lower lip
)
EAR_TURN = (-12.0, -20.0, -7.0)  # leaning back, standing off, wider at the top
EARS = (
    pair(Ellipsoid((0.0755, 0.328, -0.012), (0.0090, 0.031, 0.0180), EAR_TURN), 0.014),  # ear
    pair(Ellipsoid((0.0880, 0.331, -0.005), (0.0085, 0.018, 0.0105), EAR_TURN), 0.008, carve=True),  # its hollow
)
NECK = (
    Stroke(Cone((0.0, 0.290, -0.018), (0.0, 0.110, -0.042), (0.049, 0.058)), 0.03),  # neck
    pair(Cone((0.052, 0.288, -0.022), (0.015, 0.138, 0.022), (0.010, 0.010)), 0.028),  # sternomastoid
)
TORSO = (
    pair(Cone((0.022, 0.205, -0.050), (0.150, 0.116, -0.048), (0.028, 0.028)), 0.06),  # trapezius
    Stroke(Ellipsoid((0.0, 0.025, -0.022), (0.155, 0.115, 0.098)), 0.05),  # chest
    pair(Ellipsoid((0.060, 0.090, -0.062), (0.075, 0.075, 0.040)), 0.05),  # shoulder blade
    pair(Cone((0.152, 0.090, -0.036), (0.146, -0.06, -0.030), (0.048, 0.046)), 0.06),  # shoulder and arm
    pair(Cone((0.018, 0.129, 0.022), (0.145, 0.130, -0.014), (0.008, 0.010)), 0.04),  # collar bone
)
BASE = (Stroke(Ellipsoid((0.0, -1e3, 0.0), (1e3, 1e3, 1e3)), 0.03, carve=True),)  # flat foot of the bust

BUST = SKULL + FACE + EARS + NECK + TORSO + BASE
