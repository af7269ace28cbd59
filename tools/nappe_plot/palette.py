"""Colours that all pictures share. Plain Python: ParaView's interpreter reads it too."""

# Layers from the bottom up, like a sandbox of coloured sands: dark and pale take turns, so that folds read by lightness
# alone, in grey print and to a colour-blind eye; the hues in between tell the layers apart.
BED = ["#5a3524", "#ecca8d", "#a63d2a", "#f4e6cb", "#2e5a78", "#e2a83c", "#74301f", "#f0dcb4", "#2f7a74", "#cdbfdc"]
ABOVE_BED = "#a39e96"  # the wedge: no sand of the bed is grey

# Okabe and Ito's colours, told apart in every common form of colour blindness; for their yellow, too pale for a line, a brown
# that is as far from each of the others as they are from each other.
LINES = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000", "#6b4423"]

INK = "#222222"
WALL = "#333333"
MUTED = "#8a8a8a"


def rgb(colour):
    """#rrggbb as three numbers in [0, 1]."""
    return tuple(int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))


def layer_colour(layer, n_bed):
    """Of layer 1 … n_bed of the bed; what lies above the bed has one colour; more than nine layers start again."""
    return ABOVE_BED if layer > n_bed else BED[(layer - 1) % len(BED)]
