#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes how Mitsuba's emitters light a few points, for tests/unit/test_light_values.c. Needs
mitsuba 3.9 (PyPI) and numpy; a second run writes the same table.

    python3 tests/mitsuba/generate_light_table.py tests/data/mitsuba/lights.json

textures {file: width, height, rgb (8 bits)}; points: position (3), unit normal (3) of each;
directions (3) of rays; configurations: a name, Mitsuba XML elements, irradiance (RGB) at each
point, without shadows, `delta` where all of it comes from points or from one direction, else it is
an average over a grid of samples; radiance (RGB) of the environment, if any, along the rays."""
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

from table import row, unit, write

mi.set_variant("scalar_rgb")

WIDTH, HEIGHT = 16, 8
SIDE = 96  # of the grid of samples
POINTS = [((0, 0, 0), (0, 0, 1)), ((1, 0.5, 0.2), (0.3, -0.2, 0.9)), ((-2, 1, 0.5), (0.8, 0, 0.6)),
          ((0.3, -1.5, 1), (-0.5, 0.5, -0.2)), ((3, 2, -1), (-0.6, -0.5, 0.7))]
DIRECTIONS = [(1, 0.1, 0.1), (-0.5, 0.7, 0.2), (0.1, 0.9, -0.4), (0.2, -0.8, 0.6), (-0.3, -0.2, -0.9),
              (0, 1, 0.01), (-0.9, 0.05, 0.3), (0.5, 0.5, 0.7)]

POINT = ("<emitter type='point'><rgb name='intensity' value='5, 4, 3'/>"
         "<point name='position' x='0.5' y='-0.5' z='2.5'/></emitter>")
SPOT = ("<emitter type='spot'><rgb name='intensity' value='20, 10, 5'/>"
        "<float name='cutoff_angle' value='40'/><float name='beam_width' value='15'/>"
        "<transform name='to_world'><lookat origin='1, 1, 3' target='0.2, 0, 0' up='0, 1, 0'/>"
        "</transform></emitter>")
SPOT_DEFAULT = ("<emitter type='spot'><transform name='to_world'>"
                "<lookat origin='0, 0, 4' target='0, 0.2, 0' up='0, 1, 0'/></transform></emitter>")
DIRECTIONAL = ("<emitter type='directional'><rgb name='irradiance' value='2, 3, 4'/>"
               "<vector name='direction' x='0.2' y='0.1' z='-1'/></emitter>")
CONSTANT = "<emitter type='constant'><rgb name='radiance' value='0.5, 0.7, 0.9'/></emitter>"
ENVMAP = ("<emitter type='envmap'><string name='filename' value='sky.png'/>"
          "<float name='scale' value='2.5'/><transform name='to_world'>"
          "<rotate x='1' angle='90'/><rotate y='0.8' z='0.6' angle='35'/></transform></emitter>")
RECTANGLE = ("<shape type='rectangle'><transform name='to_world'><scale x='0.7' y='0.4'/>"
             "<rotate x='1' angle='170'/><translate x='-0.5' y='0.3' z='2'/></transform>"
             "<emitter type='area'><rgb name='radiance' value='8, 6, 4'/></emitter></shape>")
SPHERE = ("<shape type='sphere'><float name='radius' value='0.6'/>"
          "<point name='center' x='1' y='-1' z='2.5'/>"
          "<emitter type='area'><rgb name='radiance' value='3, 4, 5'/></emitter></shape>")

CONFIGURATIONS = {
    "point": POINT, "spot": SPOT, "spot-default": SPOT_DEFAULT, "directional": DIRECTIONAL,
    "constant": CONSTANT, "envmap": ENVMAP, "rectangle": RECTANGLE, "sphere": SPHERE,
    "many": POINT + SPOT + DIRECTIONAL + CONSTANT + RECTANGLE + RECTANGLE + SPHERE,
}


def interaction(position):
    si = mi.SurfaceInteraction3f()
    si.t = 1
    si.p = position
    return si


def irradiance_of(emitter, position, normal):
    """Mean over a grid of the emitter's own samples."""
    delta = mi.has_flag(emitter.flags(), mi.EmitterFlags.Delta)
    side = 1 if delta else SIDE
    total = np.zeros(3)
    for k in range(side * side):
        sample = [(k % side + 0.5) / side, (k // side + 0.5) / side]
        ds, weight = emitter.sample_direction(interaction(position), sample)
        total += np.array(weight) * max(0, np.dot(normal, np.array(ds.d)))
    return total / side ** 2


def radiance(environment, direction):
    si = interaction([0, 0, 0])
    si.wi = -mi.Vector3f(*direction)
    return np.array(environment.eval(si))


def light_table(folder):
    rng = np.random.default_rng(3)
    sky = rng.integers(20, 200, (HEIGHT, WIDTH, 3))
    sky[2, 5] = 255
    mi.Bitmap(sky.astype(np.uint8)).write(str(Path(folder) / "sky.png"))
    mi.file_resolver().append(str(folder))
    points = [(p, unit(n)) for p, n in POINTS]
    directions = [unit(d) for d in DIRECTIONS]
    out = []
    for name, xml in CONFIGURATIONS.items():
        scene = mi.load_string(f"<scene version='3.0.0'>{xml}</scene>")
        delta = all(mi.has_flag(e.flags(), mi.EmitterFlags.Delta) for e in scene.emitters())
        entry = {"name": name, "xml": xml, "delta": delta,
                 "irradiance": [row(sum(irradiance_of(e, *p) for e in scene.emitters()))
                                for p in points]}
        if scene.environment() is not None:
            entry["radiance"] = [row(radiance(scene.environment(), d)) for d in directions]
        out.append(entry)
    return {"textures": {"sky.png": {"width": WIDTH, "height": HEIGHT, "rgb": sky.ravel().tolist()}},
            "points": [row(*p) for p in points], "directions": [row(d) for d in directions],
            "configurations": out}


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        write(sys.argv[1], light_table(scratch))
