# SPDX-License-Identifier: Apache-2.0
"""The installed Python package: tests/adopt/python.sh runs it with FEWRAY (the command) and TREE (the sources)."""

import ctypes
import gc
import importlib.util
import multiprocessing
import os
import pathlib
import resource
import signal
import subprocess
import sys
import tarfile
import tempfile
import threading
import time
import unittest

import fewray
import numpy as np
from fewray import _library, _structs

COMMAND, TREE = os.environ["FEWRAY"], os.environ["TREE"]
SCENE = os.path.join(TREE, "examples", "cornell-box.xml")


def noisy(height=40, width=56, seed=1):
    rng = np.random.default_rng(seed)
    return {"color": rng.gamma(0.5, 1, (height, width, 3)).astype(np.float32),
            "albedo": rng.uniform(0.2, 0.8, (height, width, 3)).astype(np.float32),
            "normal": np.broadcast_to(np.float32([0, 0, 1]), (height, width, 3)).copy(),
            "depth": rng.uniform(1, 2, (height, width)).astype(np.float32)}


class Scratch(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = lambda name: os.path.join(folder.name, name)


class Structs(Scratch):
    def test_layout_is_the_compilers(self):
        lines = ["#include <stddef.h>", "#include <fewray/fewray.h>"]
        for name, struct in vars(_structs).items():
            if not isinstance(struct, type) or not issubclass(struct, ctypes.Structure):
                continue
            lines.append(f'_Static_assert(sizeof(struct {name}) == {ctypes.sizeof(struct)}, "{name}");')
            for field, _ in struct._fields_:
                place = getattr(struct, field)
                lines.append(f'_Static_assert(offsetof(struct {name}, {field}) == {place.offset} && '
                             f'sizeof(((struct {name} *)0)->{field}) == {place.size}, "{name}.{field}");')
        self.assertGreater(len(lines), 300)
        with open(self.path("layout.c"), "w", encoding="utf-8") as file:
            file.write("\n".join(lines) + "\n")
        folders = [f"-I{TREE}/{f}/include" for f in ("features", "denoise", "guide", "pipeline")]
        subprocess.run(["gcc", "-fsyntax-only", *folders, self.path("layout.c")], check=True)


class Denoise(Scratch):
    def test_equals_the_command(self):
        layers = noisy()
        frame = fewray.Frame(56, 40)
        for name in ("color", "albedo", "normal"):
            frame.set_layer(name, layers[name])
        frame.add("depth.Z")[:] = layers["depth"]
        fewray.write(self.path("in.exr"), frame, float32=True)
        subprocess.run([COMMAND, "denoise", self.path("in.exr"), "-o", self.path("out.exr"), "--float"], check=True)
        expected = fewray.read(self.path("out.exr")).color
        np.testing.assert_array_equal(fewray.denoise(**layers), expected)
        fewray.Denoiser().frame(frame)
        np.testing.assert_array_equal(frame.color, expected)
        np.testing.assert_array_equal(frame.layer("noisy"), layers["color"])

    def test_any_strides_and_types(self):
        layers = noisy()
        expected = fewray.denoise(**layers)
        wide = np.zeros((40, 56, 4), np.float32)
        wide[:, :, :3] = layers["color"]
        planes = np.ascontiguousarray(layers["color"].transpose(2, 0, 1))
        for color in (wide[:, :, :3], planes.transpose(1, 2, 0), np.asfortranarray(layers["color"]),
                      layers["color"][::-1][::-1], layers["color"].astype(np.float64)):
            np.testing.assert_array_equal(fewray.denoise(**{**layers, "color": color}), expected)
        flipped = fewray.denoise(**{k: v[:, ::-1] for k, v in layers.items()})
        np.testing.assert_array_equal(flipped, fewray.denoise(**{k: v[:, ::-1].copy() for k, v in layers.items()}))

    def test_writes_into_out_and_copies_nothing(self):
        color = np.ones((1500, 2000, 3), np.float32)  # 36 MB
        out = np.empty_like(color)
        fewray.denoise(color, out=out)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        self.assertIs(fewray.denoise(color, out=out), out)
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 18000)  # KB: half a picture
        np.testing.assert_allclose(out, 1, atol=1e-4)

    def test_layers_add_up(self):
        color = noisy()["color"]
        clean, parts = fewray.denoise(color, layers={"a": 0.25 * color, "b": 0.75 * color})
        np.testing.assert_allclose(parts["a"] + parts["b"], clean, rtol=1e-4, atol=1e-5)

    def test_wrong_arguments_are_told(self):
        color = noisy()["color"]
        for arguments, error, text in (
                (dict(color=color[:, :, 0]), ValueError, "(height, width, 3)"),
                (dict(color=color, albedo=color[1:]), ValueError, "albedo has the shape (39, 56, 3), not (40, 56, 3)"),
                (dict(color=color.astype(str)), TypeError, "color holds <U"),
                (dict(color=color, out=color), ValueError, "shares memory"),
                (dict(color=color, out=np.empty((40, 56, 3))), ValueError, "out must be"),
                (dict(color=color, model="best"), ValueError, "there is no model 'best'"),
                (dict(color=color, threads=1 << 32), ValueError, "threads can't be 4294967296"),
                (dict(color=color, weights=pathlib.Path("/nowhere.bin")), fewray.Error, "/nowhere.bin"),
                (dict(color=color, weights="/nowhere.bin"), fewray.Error, "/nowhere.bin")):
            with self.subTest(text), self.assertRaises(error) as raised:
                fewray.denoise(**arguments)
            self.assertIn(text, str(raised.exception))
            self.assertNotIn("\n", str(raised.exception))

    def test_threads_at_once_and_progress(self):
        layers = noisy()
        expected, results, told = fewray.denoise(**layers), [], []
        threads = [threading.Thread(target=lambda: results.append(fewray.denoise(**layers))) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(len(results), 4)
        for result in results:
            np.testing.assert_array_equal(result, expected)
        fewray.denoise(**layers, progress=lambda phase, share: told.append((phase, share)))
        self.assertEqual(told[-1], ("denoise", 1.0))

        def fails(phase, share):
            raise ZeroDivisionError
        with self.assertRaises(ZeroDivisionError):
            fewray.denoise(**layers, progress=fails)

    def test_a_denoiser_goes_on_after_a_failed_progress_function(self):
        layers, calls = noisy(), []

        def fails_once(phase, share):
            calls.append(share)
            if len(calls) == 1:
                raise ZeroDivisionError
        denoiser = fewray.Denoiser(progress=fails_once)
        with self.assertRaises(ZeroDivisionError):
            denoiser(**layers)
        np.testing.assert_array_equal(denoiser(**layers), fewray.denoise(**layers))
        self.assertEqual(calls[-1], 1)

    def test_threads_that_share_a_denoiser_take_turns(self):
        layers, inside, most = noisy(), [], []

        def tell(phase, share):
            inside.append(threading.get_ident())
            most.append(len(set(inside)))
            time.sleep(0.01)
            inside.remove(threading.get_ident())
        denoiser = fewray.Denoiser(progress=tell)
        threads = [threading.Thread(target=lambda: denoiser(**layers)) for _ in range(3)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(max(most), 1)

    def test_a_loop_leaks_nothing(self):
        layers = noisy(200, 300)
        denoiser = fewray.Denoiser()
        for _ in range(3):
            denoiser(**layers)
        gc.collect()
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(60):  # a result has 720 KB: 43 MB if they stayed
            denoiser(**layers)
            frame = fewray.Frame(300, 200)
            frame.add("R")
        self.assertLess(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before, 15000)


class Frames(Scratch):
    def test_planes_are_the_frames_own_memory(self):
        frame = fewray.Frame(8, 4)
        plane = frame.add("albedo.R")
        plane[2, 3] = 0.5
        self.assertEqual(frame["albedo.R"][2, 3], 0.5)
        self.assertTrue(np.shares_memory(plane, frame["albedo.R"]))
        del frame
        gc.collect()
        self.assertEqual(plane[2, 3], 0.5)  # the array keeps the frame

    def test_layers_of_other_renderers_are_found(self):
        path = os.path.join(TREE, "tests", "data", "foreign", "cycles-denoised.exr")
        frame, noisy, raw = fewray.read(path), fewray.read(path, noisy=True), fewray.read(path, adopt=False)
        self.assertEqual(frame.albedo.shape, (frame.height, frame.width, 3))
        self.assertIsNotNone(frame.normal)
        self.assertFalse(np.array_equal(frame.color, noisy.color))
        np.testing.assert_array_equal(noisy.color[:, :, 0], raw["ViewLayer.Noisy Image.R"])
        self.assertNotIn("R", raw)

    def test_files_keep_layers(self):
        color = noisy()["color"]
        fewray.write(self.path("a.exr"), {"color": color, "albedo": color}, float32=True)
        frame = fewray.read(self.path("a.exr"))
        self.assertEqual(sorted(frame), ["B", "G", "R", "albedo.B", "albedo.G", "albedo.R"])
        np.testing.assert_array_equal(frame.albedo, color)
        self.assertIsNone(frame.normal)
        with self.assertRaises(KeyError):
            frame["depth.Z"]
        for wrong in ({}, {"color": 1}, {"color": color, "depth": color}):
            with self.assertRaises(ValueError):
                fewray.write(self.path("wrong.exr"), wrong)
        with self.assertRaises(ValueError):
            fewray.write(self.path("wrong.exr\0.txt"), frame)
        self.assertEqual(os.listdir(self.path("")), ["a.exr"])
        with self.assertRaises(fewray.Error) as raised:
            fewray.read(self.path("none.exr"))
        self.assertEqual(raised.exception.status, -1)
        self.assertIn("none.exr", str(raised.exception))


    def test_depth_is_a_layer(self):
        depth = noisy()["depth"]
        fewray.write(self.path("a.exr"), {"depth": depth, "confidence": depth}, float32=True)
        frame = fewray.read(self.path("a.exr"))
        self.assertEqual(sorted(frame), ["depth.Z", "irradiance.confidence"])
        np.testing.assert_array_equal(frame.layer("depth"), depth)
        np.testing.assert_array_equal(frame.layer("confidence"), depth)


class Processes(unittest.TestCase):
    def test_a_forked_child_works(self):
        color = noisy()["color"]
        expected = fewray.compare(color, color + 1)  # starts OpenMP's threads
        with multiprocessing.get_context("fork").Pool(1) as pool:
            self.assertEqual(pool.apply_async(fewray.compare, (color, color + 1)).get(60).flip, expected.flip)


class Compare(Scratch):
    def test_equals_the_command(self):
        test, reference = noisy()["color"], noisy(seed=2)["color"]
        for name, picture in (("test", test), ("reference", reference)):
            fewray.write(self.path(name + ".exr"), {"color": picture}, float32=True)
        command = subprocess.run([COMMAND, "compare", self.path("test.exr"), self.path("reference.exr"), "--json"], check=True,
                                 stdout=subprocess.PIPE, text=True).stdout
        metrics = fewray.compare(test, reference)
        for name in ("mrse", "psnr", "flip"):
            self.assertIn(f'"{name}": {getattr(metrics, name):.4g}'[:len(name) + 8], command)
        self.assertEqual(fewray.compare(test, test).mrse, 0)
        with self.assertRaises(fewray.Error):
            fewray.compare(test, reference[1:])


class Render(Scratch):
    def test_equals_the_command(self):
        frame = fewray.render(SCENE, spp=2, width=64, height=64, seed=3)
        subprocess.run([COMMAND, "render", SCENE, "-o", self.path("a.exr"), "--spp", "2", "--width", "64", "--height", "64",
                        "--seed", "3", "--float"], check=True)
        expected = fewray.read(self.path("a.exr"))
        self.assertEqual(sorted(frame), sorted(expected))
        for name in expected:
            np.testing.assert_array_equal(frame[name], expected[name], name)
        self.assertEqual(frame.stats["paths"], 2 * 64 * 64)

    def test_progress_and_errors(self):
        told = []
        fewray.render(SCENE, spp=2, width=32, height=32, progress=lambda phase, share: told.append(phase))
        self.assertIn("load", told)
        with self.assertRaises(fewray.Error) as raised:
            fewray.render("/nowhere.xml")
        self.assertIn("/nowhere.xml", str(raised.exception))
        with self.assertRaises(ValueError):
            fewray.render(SCENE, guide="best")
        for name, value in (("spp", 0), ("spp", (1 << 32) + 1), ("initial", 0), ("width", -4), ("threads", -1), ("seed", -1),
                            ("max_depth", -2), ("seconds", -1), ("error", float("nan"))):
            with self.subTest(name), self.assertRaises((ValueError, fewray.Error)) as raised:
                fewray.render(SCENE, **{name: value})
            self.assertIn(f"{name} can't be {value}", str(raised.exception))


class Interrupts(unittest.TestCase):
    def setUp(self):
        class Alarm(Exception):
            pass

        def alarm(*_):
            raise Alarm
        self.Alarm = Alarm
        before = signal.signal(signal.SIGALRM, alarm)
        self.addCleanup(signal.signal, signal.SIGALRM, before)

    def test_what_any_signal_raises_ends_a_render(self):
        signal.setitimer(signal.ITIMER_REAL, 1)
        with self.assertRaises(self.Alarm):
            fewray.render(SCENE, spp=1 << 20, guide=False)

    def test_work_has_ended_when_the_exception_comes(self):
        cancel, ended = ctypes.c_int(0), []

        def work(error):
            while not cancel.value:
                time.sleep(0.01)
            signal.setitimer(signal.ITIMER_REAL, 0.2)  # an impatient user's second
            time.sleep(0.5)  # C goes on to the end of a tile
            ended.append(True)
            return _library.CANCELLED
        signal.setitimer(signal.ITIMER_REAL, 0.2)
        with self.assertRaises(self.Alarm):
            _library.run(work, cancel)
        self.assertEqual(ended, [True])


class Guide(Scratch):
    def look(self):
        rng = np.random.default_rng(1)
        shape = (16, 24, 1)
        direction = rng.normal(size=shape + (3,))
        direction[..., 1] = abs(direction[..., 1])
        direction /= np.linalg.norm(direction, axis=3, keepdims=True)
        up = np.broadcast_to([0, 1, 0], shape + (3,))
        y, x = np.mgrid[:16, :24]
        return {"position": np.stack([x, 0 * x, y], 2)[:, :, None, :] * 0.1, "normal": up, "depth": np.full(shape, 5.0),
                "direction": direction, "emitted": np.where(direction[..., :1] > 0.8, 10.0, 0.1) * np.ones(3),
                "reflected": np.zeros(shape + (3,)), "distance": np.zeros(shape), "second_normal": up}

    def test_samples_have_their_density(self):
        guide = fewray.Guide(**self.look())
        self.assertEqual(guide.stats["records"], 16 * 24)
        rng = np.random.default_rng(2)
        pixel = rng.integers(0, [24, 16], (2000, 2)).astype(np.int32)
        position, normal = np.zeros((2000, 3)), np.broadcast_to([0, 1, 0], (2000, 3))
        position[:, [0, 2]] = pixel * 0.1
        direction, pdf, fraction = guide.first_sample(pixel, position, normal, rng.random((2000, 2)))
        self.assertTrue((fraction < 1).any())
        again, _ = guide.first_pdf(pixel, position, normal, direction)
        np.testing.assert_array_equal(pdf, again)
        self.assertGreater((direction[fraction < 1, 0] > 0.7).mean(), 0.4)  # of the even hemisphere: 0.1
        share = guide.look_weights(3)
        self.assertEqual(share.shape, (16, 24))
        self.assertTrue(((share > 0) & (share < 0.5)).all())
        irradiance, confidence = guide.irradiance(pixel, normal)
        self.assertTrue((irradiance > 0).all() and (confidence <= 1).all())
        self.assertTrue((guide.later_pdf(position, normal, normal)[1] == 1).all())  # no probes

    def test_look_directions_are_above_the_surface(self):
        up = np.zeros((16, 24, 2, 3), np.float32)
        up[..., 1] = 1
        directions = fewray.look_directions(up, seed=5)
        np.testing.assert_allclose(np.linalg.norm(directions, axis=3), 1, atol=1e-5)
        self.assertTrue((directions[..., 1] >= 0).all())
        self.assertAlmostEqual(float(directions[..., 1].mean()), 0.5, delta=0.01)  # spread evenly: far below 1 / sqrt(768)
        with self.assertRaises(ValueError):
            fewray.look_directions(up[0])

    def test_wrong_looks_are_told(self):
        look = self.look()
        for change, error, text in (({"depth": np.zeros((16, 24))}, ValueError, "(height, width, samples)"),
                                    ({"normal": np.zeros((16, 24, 3))}, ValueError, "normal has the shape"),
                                    ({"colour": 1}, TypeError, "colour"),
                                    ({"second_light": look["normal"]}, fewray.Error, "all or none")):
            with self.subTest(text), self.assertRaises(error) as raised:
                fewray.Guide(**{**look, **change})
            self.assertIn(text, str(raised.exception))

    def test_missing_points_are_told(self):
        guide = fewray.Guide(**self.look())
        pixel, up, u = np.zeros((3, 2), np.int32), np.broadcast_to(np.float32([0, 1, 0]), (3, 3)), np.zeros((3, 2))
        for function, arguments in ((guide.first_sample, (pixel, up, up, u)), (guide.first_pdf, (pixel, up, up, up)),
                                    (guide.later_sample, (up, up, u)), (guide.later_pdf, (up, up, up)),
                                    (guide.irradiance, (pixel, up))):
            function(*arguments)
            for missing in range(len(arguments)):
                with self.subTest(function.__name__, missing=missing), self.assertRaisesRegex(ValueError, "is missing"):
                    function(*[None if i == missing else a for i, a in enumerate(arguments)])


PROGRAM = """
import fewray
import numpy as np
color: "np.ndarray[tuple[int, int, int], np.dtype[np.float32]]" = np.ones((8, 8, 3), np.float32)
metrics: fewray.Metrics = fewray.compare(fewray.denoise(color), color)
error: float = metrics.mrse
frame: fewray.Frame = fewray.render("scene.xml", spp=4)
total: float = float(frame.color.sum())
"""


class Source(Scratch):
    @unittest.skipUnless(os.path.exists(os.path.join(TREE, ".git")), "not a clone")
    def test_archive_has_tree_and_metadata(self):
        spec = importlib.util.spec_from_file_location("backend", os.path.join(TREE, "pipeline", "python", "backend.py"))
        backend = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(backend)
        name = f"fewray-{fewray.__version__}"
        self.assertEqual(backend.build_sdist(self.path("")), name + ".tar.gz")
        with tarfile.open(self.path(name + ".tar.gz")) as archive:
            names = archive.getnames()
            metadata = archive.extractfile(f"{name}/PKG-INFO").read().decode()
        self.assertIn(f"{name}/pyproject.toml", names)
        self.assertIn(f"\nName: fewray\nVersion: {fewray.__version__}\n", metadata)


class Types(Scratch):
    @unittest.skipUnless(importlib.util.find_spec("mypy"), "mypy isn't installed")
    def test_a_typed_program_and_the_package_pass_mypy(self):
        with open(self.path("program.py"), "w", encoding="utf-8") as file:
            file.write(PROGRAM)
        run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", self.path("cache"),
                              self.path("program.py")], stdout=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 0, run.stdout)
        with open(self.path("program.py"), "a", encoding="utf-8") as file:
            file.write("wrong: str = metrics.mrse\n")
        run = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--cache-dir", self.path("cache"),
                              self.path("program.py")], stdout=subprocess.PIPE, text=True)
        self.assertEqual(run.returncode, 1, run.stdout)


if __name__ == "__main__":
    unittest.main(verbosity=2)
