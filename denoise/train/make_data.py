#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders training data: for each view of each scene some noisy pictures of different seeds and a reference, as records
of fewray-kpn-data. Can be stopped and started again, and run by several at once on the same folder.

    OUT/SCENE--VIEW/SPP-GUIDE-SEED.npy and OUT/SCENE--VIEW/ref.npy

View 0 is the scene's own camera; the others turn it, tilt it and move it forward, from a seed. Everything follows from
the scenes' names and the seed: --part 2/5 makes the second fifth of the views that the whole command would make, and the
folders of five machines, copied together, are its result. With --halves each picture of N samples a pixel also comes as
two independent ones of N/2, N/2-GUIDE-SEEDa.npy and ...b.npy: more inputs, and pairs for estimates of error."""
import argparse
import fcntl
import random
import re
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

import numpy as np


BUDGETS = (1, 2, 4, 8, 16)  # samples a pixel


def scene_name(path):
    """living-room-2/scene-diffuse.xml -> living-room-2; rooms/0012.xml -> rooms-0012"""
    return path.parent.name if path.stem.startswith("scene") else f"{path.parent.name}-{path.stem}"


def moved_camera(scene, turn, tilt, forward):
    """The scene's text with another camera and absolute file names; camera space looks along +z, y up."""
    text = scene.read_text()
    steps = (f'<translate x="0" y="0" z="{forward:.6g}"/><rotate x="1" y="0" z="0" angle="{tilt:.4g}"/>'
             f'<rotate x="0" y="1" z="0" angle="{turn:.4g}"/>')
    start = text.index("<sensor")
    match = re.search(r'<transform\s+name="(to_world|toWorld)"\s*>', text[start:])
    text = text[:start + match.end()] + steps + text[start + match.end():]
    return re.sub(r'name="filename"(\s+)value="([^"]+)"',
                  lambda m: f'name="filename"{m[1]}value="{(scene.parent / m[2]).resolve()}"', text)


def part(text):
    """'2/5' -> (1, 5)"""
    index, count = (int(n) for n in text.split("/"))
    if not 1 <= index <= count:
        raise ValueError
    return index - 1, count


class Maker:
    def __init__(self, arguments):
        self.a = arguments
        self.depths = {}

    def typical_depth(self, scene):
        """The median distance that the scene's own camera sees, 0 where it sees nothing."""
        if scene not in self.depths:
            depth = np.zeros(1)
            with tempfile.TemporaryDirectory() as folder:
                probe = Path(folder) / "probe.npy"
                if self.render(scene, probe, 1, "off", 1):
                    depth = np.load(probe)[..., 15].astype(np.float32)
            self.depths[scene] = float(np.median(depth[depth > 0])) if (depth > 0).any() else 0.0
        return self.depths[scene]

    def render(self, xml, record, spp, guide, seed, reference=False):
        """One render to one record; True where it worked."""
        a = self.a
        with tempfile.TemporaryDirectory() as folder:
            exr = Path(folder) / "x.exr"
            command = [a.fewray, "render", xml, "-o", exr, "--spp", spp, "--guide", guide, "--denoise", "off", "--float",
                       "--seed", seed, "--width", a.width, "--height", a.height, "--threads", a.threads]
            convert = [a.tool, exr, "-o", record] + (["--reference"] if reference else [])
            for step in (command, convert):
                result = subprocess.run([str(s) for s in step], capture_output=True, text=True)
                if result.returncode:
                    print(f"{xml}: {result.stderr.strip()[-300:]}", file=sys.stderr, flush=True)
                    return False
        return True

    def camera(self, scene, folder, rng, typical_depth):
        """Writes a scene with a camera that sees something lit and not too near; None after some tries."""
        for _ in range(5):
            turn, tilt = rng.uniform(-40, 40), rng.uniform(-12, 12)
            xml, probe = folder / "scene.xml", folder / "probe.npy"
            xml.write_text(moved_camera(scene, turn, tilt, typical_depth * rng.uniform(0, 0.3)))
            if not self.render(xml, probe, 1, "off", 1):
                return None
            picture = np.load(probe).astype(np.float32)
            probe.unlink()
            depth = picture[..., 15]
            if ((picture[..., 0:3].sum(2) > 0).mean() > 0.15 and (depth > 0).mean() > 0.4
                    and np.median(depth[depth > 0]) > 0.25 * typical_depth):
                return xml
        return None

    def view(self, scene, index):
        a = self.a
        folder = a.out / f"{scene_name(scene)}--{index}"
        if (folder / "ref.npy").exists() or (folder / "useless").exists():
            return
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / ".lock", "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                return
            if not (folder / "ref.npy").exists():
                self.fill(scene, index, folder)
        (folder / ".lock").unlink(missing_ok=True)

    def noisy_pictures(self, rng, seed):
        """File name, samples a pixel, guide and seed of each noisy picture of a view."""
        if self.a.every_budget:
            wanted = [(spp, guide) for spp in BUDGETS for guide in ("odis", "off")]
        else:
            wanted = [(4, "odis"), (4, "off"), (rng.choice([1, 2]), "odis"), (rng.choice([8, 16]), rng.choice(["odis", "off"]))]
        wanted = list(dict.fromkeys((spp, guide if self.a.guide and spp > 1 else "off") for spp, guide in wanted))
        pictures = []
        for i, (spp, guide) in enumerate(wanted):
            pictures.append((f"{spp}-{guide}-{seed + i}.npy", spp, guide, seed + i))
            if self.a.halves and spp > 1:
                half_guide = guide if spp > 2 else "off"
                for letter, more in (("a", 2000003), ("b", 3000017)):
                    pictures.append((f"{spp // 2}-{half_guide}-{seed + i}{letter}.npy", spp // 2, half_guide, seed + i + more))
        return pictures

    def fill(self, scene, index, folder):
        a = self.a
        base = zlib.crc32(f"{scene_name(scene)} {index} {a.seed}".encode())
        rng = random.Random(base)
        xml = scene
        if index > 0:
            xml = self.camera(scene, folder, rng, self.typical_depth(scene))
            if xml is None:
                (folder / "useless").touch()
                return
        for record, spp, guide, seed in self.noisy_pictures(rng, base % 1000000):
            if not (folder / record).exists() and not self.render(xml, folder / record, spp, guide, seed):
                (folder / "useless").touch()
                return
        guide = "odis" if a.guide_reference else "off"
        self.render(xml, folder / "ref.npy", a.reference_spp, guide, base % 1000000 + 1000003, True)
        if index > 0:
            (folder / "scene.xml").unlink(missing_ok=True)
        print(folder.name, flush=True)


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", type=Path, help="Mitsuba XML files")
    p.add_argument("-o", "--out", required=True, type=Path)
    p.add_argument("--fewray", default="build/fewray")
    p.add_argument("--tool", default="build/fewray-kpn-data")
    p.add_argument("--views", type=int, default=1, help="cameras a scene")
    p.add_argument("--width", type=int, default=320)
    p.add_argument("--height", type=int, default=224)
    p.add_argument("--reference-spp", type=int, default=128)
    p.add_argument("--guide", action="store_true", help="about half of the noisy pictures with --guide odis")
    p.add_argument("--every-budget", action="store_true", help="1, 2, 4, 8 and 16 samples a pixel, each with the guide and "
                   "without, instead of four pictures")
    p.add_argument("--halves", action="store_true", help="also two independent pictures of half as many samples")
    p.add_argument("--guide-reference", action="store_true")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--part", type=part, default=(0, 1), metavar="I/N", help="only this part of the views, for N machines")
    a = p.parse_args()
    maker = Maker(a)
    views = [(scene, index) for index in range(a.views) for scene in a.scenes]
    for scene, index in views[a.part[0]::a.part[1]]:
        maker.view(scene, index)


if __name__ == "__main__":
    main()
