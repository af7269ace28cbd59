"""What makes the small scenes smooth while they are loaded: 1550 kg a grain; a step within what is known to be stable."""

from nappe_driver import sets

_push = {"stages__push__solver__method": "cundall", "stages__push__solver__h": 1e-4}
_laws = {f"laws__{k}__{key}": value for k in (0, 1) for key, value in (("type", "cundall"), ("k_n", 5e7))}
SMOOTH = sets(**_laws, **_push, materials__rock__damping=100)
