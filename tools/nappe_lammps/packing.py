"""A frame of nappe and the scene it came from, as LAMMPS takes them."""

import math
import tomllib

import h5py
import numpy as np


class Packing:
    """Grains of a frame in one plane, and the springs, dashpots and walls of its scene."""

    def __init__(self, frame, scene):
        with h5py.File(frame) as file:
            data = file["VTKHDF/PointData"]
            self.x = file["VTKHDF/Points"][:, :2]
            self.v = data["velocity"][:, :2]
            self.radius, self.mass, self.spin = (data[name][()] for name in ("radius", "mass", "spin"))
            self.walls = {name: points[()] for name, points in file["walls"].items()}
        keys = tomllib.loads(scene.read_text())
        self.law = keys["laws"][0]
        if any(law[key] != self.law[key] for law in keys["laws"] for key in ("type", "friction", "k_n")):
            raise SystemExit(f"compare-lammps: {scene}: one law for all pairs is needed, found several")
        self.gravity = -keys["world"]["gravity"][1]
        self.damping = next(iter(keys["materials"].values())).get("damping", 0.0)
        self.h = keys["stages"][-1]["solver"]["h"]

    def data(self):
        """LAMMPS's data file: spheres whose density gives them the disks' masses."""
        low, high = self.x.min(axis=0) - 1, self.x.max(axis=0) + 1
        r = self.radius.max()
        lines = ["nappe's settled sample", "", f"{len(self.x)} atoms", "1 atom types", ""]
        for name, a, b in (("x", low[0], high[0]), ("y", low[1], high[1]), ("z", -r, r)):
            lines.append(f"{a:.17g} {b:.17g} {name}lo {name}hi")
        lines += ["", "Atoms # sphere", ""]
        density = self.mass / (4 / 3 * math.pi * self.radius**3)
        for k, (x, r, rho) in enumerate(zip(self.x, self.radius, density), 1):
            lines.append(f"{k} 1 {2 * r:.17g} {rho:.17g} {x[0]:.17g} {x[1]:.17g} 0")
        lines += ["", "Velocities", ""]
        for k, (v, w) in enumerate(zip(self.v, self.spin), 1):
            lines.append(f"{k} {v[0]:.17g} {v[1]:.17g} 0 0 0 {w:.17g}")
        return "\n".join(lines) + "\n"

    def script(self, data, steps, skin, newton, binning, every):
        """LAMMPS's input. Its dashpots are gamma m_eff: critical for the mean of the grains' masses, where nappe's are for
        each pair."""
        k = self.law["k_n"]
        gamma = 2 * math.sqrt(k / (0.5 * float(np.mean(self.mass))))
        force = f"{k} {self.law.get('k_s', k)} {gamma:.17g} {gamma:.17g} {self.law['friction']} 1"
        (left, right), floor = sorted(self.walls[n][0, 0] for n in ("left", "right")), self.walls["slab"][0, 1]
        multi = "comm_modify mode multi vel yes" if binning == "multi" else "comm_modify vel yes"
        return f"""units si
dimension 2
boundary f f p
newton {newton}
atom_style sphere
read_data {data}
neighbor {skin:.6g} {binning}
neigh_modify delay 0 every {every} check yes
{multi}
pair_style gran/hooke/history {force}
pair_coeff * *
timestep {self.h}
fix move all nve/sphere disc
fix weight all gravity {self.gravity} vector 0 -1 0
fix global all viscous {self.damping}
fix sides all wall/gran hooke/history {force} xplane {left:.17g} {right:.17g}
fix slab all wall/gran hooke/history {force} yplane {floor:.17g} NULL
fix plane all enforce2d
thermo 1000000
run {steps}
"""
