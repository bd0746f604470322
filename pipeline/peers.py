# SPDX-License-Identifier: Apache-2.0
"""The peers of `fewray bench`: renders by Mitsuba 3 and filters by Open Image Denoise on request.

Part of the fewray command, which starts it as `python -c`. argv: one JSON object {scene, defines, width, height, max_depth,
threads}. Says hello by one line of JSON on stdout, then answers each line on stdin by one on stdout:

  {"do": "render", "spp", "seed", "features", "out"}  -> {"seconds"}; out: EXR of R,G,B and, with features, albedo, normal
  {"do": "denoise", "in", "out"}                      -> {"seconds"}; in: such an EXR

Seconds leave out loading, kernel compilation, warm-up and files. A failure is {"error": "one line"}.
"""
import ctypes
import json
import os
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path

AOVS = "albedo:albedo,normal:sh_normal"
# Dr.Jit aborts with LLVM below 16; what a system has by the plain name is often older.
LLVMS = ["libLLVM.so.20.1", "libLLVM.so.19.1", "libLLVM-19.so", "libLLVM.so.18.1", "libLLVM-18.so", "libLLVM-17.so",
         "libLLVM-16.so"]


def find_llvm():
    if "DRJIT_LIBLLVM_PATH" in os.environ:
        return True
    for name in LLVMS:
        try:
            ctypes.CDLL(name)
        except OSError:
            continue
        os.environ["DRJIT_LIBLLVM_PATH"] = name
        return True
    return False


def own_depth(root):
    """The scene's max_depth; an integrator may stand within another."""
    depths = [int(p.get("value")) for node in root.iter("integrator") for p in node.findall("integer")
              if p.get("name") in ("max_depth", "maxDepth")]
    return max(depths, default=-1)


def resolve_defaults(root, defines):
    values = {node.get("name"): node.get("value") for node in root.findall("default")}
    values.update(defines)
    for node in root.findall("default"):
        root.remove(node)
    for node in root.iter():
        for key, text in node.attrib.items():
            for name in sorted(values, key=len, reverse=True):
                text = text.replace("$" + name, values[name])
            node.set(key, text)


class Mitsuba:
    """A scene with the path integrator, a box filter and independent samples, at fewray's size."""

    def __init__(self, wish):
        variant = "llvm_ad_rgb" if find_llvm() else "scalar_rgb"
        import mitsuba
        import drjit
        self.mi, self.dr = mitsuba, drjit
        mitsuba.set_variant(variant)
        if variant != "scalar_rgb":
            drjit.set_thread_count(wish["threads"])
        self.name = f"Mitsuba {mitsuba.__version__} {variant}"
        begin = time.perf_counter()
        self.scene = self.load(wish)
        self.load_s = time.perf_counter() - begin
        self.compile_s = self.warm_up()

    def load(self, wish):
        path = Path(wish["scene"])
        if path.suffix != ".xml":
            raise ValueError("Mitsuba reads XML scenes alone")
        root = ET.parse(path).getroot()
        resolve_defaults(root, wish["defines"])
        depth = wish["max_depth"] or own_depth(root)
        for node in root.findall("integrator"):
            root.remove(node)
        sensor = root.find("sensor")
        for node in sensor.findall("film") + sensor.findall("sampler"):
            sensor.remove(node)
        sensor.append(ET.fromstring(
            f'<film type="hdrfilm"><integer name="width" value="{wish["width"]}"/>'
            f'<integer name="height" value="{wish["height"]}"/><string name="pixel_format" value="rgb"/>'
            '<string name="component_format" value="float32"/><rfilter type="box"/></film>'))
        sensor.append(ET.fromstring('<sampler type="independent"/>'))
        self.mi.Thread.thread().file_resolver().prepend(str(path.resolve().parent))
        scene = self.mi.load_string(ET.tostring(root, encoding="unicode"))
        path_tracer = {"type": "path", "max_depth": depth}
        self.integrators = {False: self.mi.load_dict(path_tracer),
                            True: self.mi.load_dict({"type": "aov", "aovs": AOVS, "nested": path_tracer})}
        return scene

    def warm_up(self):
        """Compiles the kernels, which hold for any number of samples. The second render finds the caches full."""
        begin = time.perf_counter()
        for features in (False, True):
            for spp in (1, 2):
                self.render(spp, 7919, features)
        return time.perf_counter() - begin

    def render(self, spp, seed, features):
        begin = time.perf_counter()
        image = self.mi.render(self.scene, integrator=self.integrators[features], spp=spp, seed=seed)
        self.dr.eval(image)
        self.dr.sync_thread()
        return image, time.perf_counter() - begin

    def write(self, path, image):
        """Picture of 3 or 9 channels (R,G,B, albedo, normal) to EXR."""
        names = ["R", "G", "B"]
        if image.shape[2] >= 9:
            names += ["albedo.R", "albedo.G", "albedo.B", "normal.X", "normal.Y", "normal.Z"]
        self.mi.Bitmap(image[:, :, :len(names)], channel_names=names,
                       pixel_format=self.mi.Bitmap.PixelFormat.MultiChannel).write(path)

    def read(self, path):
        """{"color": array (H, W, 3), "albedo", "normal"} of an EXR."""
        import numpy
        bitmap = self.mi.Bitmap(path)
        pixels = numpy.array(bitmap, dtype=numpy.float32)
        places = {field.name: i for i, field in enumerate(bitmap.struct_())}
        layers = {"color": ("R", "G", "B"), "albedo": ("albedo.R", "albedo.G", "albedo.B"),
                  "normal": ("normal.X", "normal.Y", "normal.Z")}
        found = {layer: numpy.ascontiguousarray(pixels[:, :, [places[n] for n in names]])
                for layer, names in layers.items() if all(n in places for n in names)}
        if "albedo" in found:
            found["albedo"] = found["albedo"].clip(0, 1)
        return found


class Oidn:
    """The RT filter for HDR colour with albedo and normal, quality high."""

    def __init__(self, threads):
        import pyoidn
        self.oidn = pyoidn
        self.device = pyoidn.Device(pyoidn.OIDN_DEVICE_TYPE_CPU)
        self.device.set_int("numThreads", threads)
        self.device.commit()
        self.check()
        version = self.device.get_int("version")
        self.name = f"OIDN {version // 10000}.{version // 100 % 100}.{version % 100}"

    def check(self):
        error = self.device.get_error()
        if error:
            raise RuntimeError(f"OIDN: {error}")

    def denoise(self, layers):
        import numpy
        out = numpy.zeros_like(layers["color"])
        with self.oidn.Filter(self.device, self.oidn.OIDN_FILTER_TYPE_RT) as f:
            for name, image in layers.items():
                f.set_image(name, image, self.oidn.OIDN_FORMAT_FLOAT3)
            f.set_image("output", out, self.oidn.OIDN_FORMAT_FLOAT3)
            f.set_quality(self.oidn.OIDN_QUALITY_HIGH)
            f.set_bool("hdr", True)
            f.commit()
            f.execute()  # unpacks the weights
            begin = time.perf_counter()
            f.execute()
            seconds = time.perf_counter() - begin
        self.check()
        return out, seconds


def answer(mitsuba, oidn, request):
    import numpy
    if request["do"] == "render":
        image, seconds = mitsuba.render(request["spp"], request["seed"], request["features"])
        if request.get("out"):
            mitsuba.write(request["out"], numpy.array(image, dtype=numpy.float32))
    else:
        picture, seconds = oidn.denoise(mitsuba.read(request["in"]))
        mitsuba.write(request["out"], picture)
    return {"seconds": seconds}


def one_line(error):
    return " ".join(f"{type(error).__name__}: {error}".split())[:300]


def main():
    replies = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what libraries print must not mix with the replies
    wish = json.loads(sys.argv[1])
    try:
        mitsuba = Mitsuba(wish)
    except Exception as error:
        print(json.dumps({"error": one_line(error)}), file=replies)
        return
    try:
        oidn = Oidn(wish["threads"])
    except Exception:
        oidn = None
    names = ", ".join(p.name for p in (mitsuba, oidn) if p)
    print(json.dumps({"names": names, "oidn": oidn is not None, "load_s": mitsuba.load_s, "compile_s": mitsuba.compile_s}),
          file=replies)
    for line in sys.stdin:
        try:
            reply = answer(mitsuba, oidn, json.loads(line))
        except Exception as error:
            reply = {"error": one_line(error)}
        print(json.dumps(reply), file=replies)


main()
