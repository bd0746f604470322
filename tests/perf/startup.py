#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Start-up, file and memory figures of `fewray denoise` and `fewray render`, as Markdown tables.

    tests/perf/startup.py [--fewray build/fewray]... [--runs 10] [--sizes 1x1,175x100,...] [SCENE.xml ...]

Several --fewray are measured in turn, so that load of the machine hits all alike. Seconds are the least of all runs; memory is the largest resident
size. The pictures to denoise are path traced examples/cornell-box.xml with all layers. The scenes
are rendered 4 samples a pixel, at --render-size. A benchmark, never a test."""

import argparse
import json
import os
import pathlib
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
PHASES = ["load_s", "bvh_s", "initial_s", "guide_s", "render_s", "denoise_s", "write_s"]
RENDERS = {
    "path traced": ["--guide", "off", "--denoise", "off"],
    "guided": ["--pilot", "off", "--denoise", "off"],
    "guided, denoised": ["--pilot", "off"],
}


def run(command):
    """Wall and CPU seconds, and peak resident bytes of a command."""
    start = time.perf_counter()
    quiet = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)]
    pid = os.posix_spawn(command[0], command, os.environ, file_actions=quiet)
    _, status, usage = os.wait4(pid, 0)
    wall = time.perf_counter() - start
    if status:
        raise SystemExit("failed: " + " ".join(command))
    return {"wall": wall, "cpu": usage.ru_utime + usage.ru_stime, "peak": usage.ru_maxrss * 1024}


def measure(programs, arguments, runs, stats=None):
    """Least of each figure, for each program."""
    least = [{} for _ in programs]
    for _ in range(runs):
        for best, program in zip(least, programs):
            got = run([program] + arguments)
            if stats:
                got.update(json.loads(pathlib.Path(stats).read_text()))
            for key, value in got.items():
                if isinstance(value, (int, float)):
                    best[key] = max(best.get(key, 0), value) if key == "peak" else min(best.get(key, value), value)
    return least


def table(header, rows):
    print("| " + " | ".join(header) + " |")
    print("|" + "---|" * len(header))
    for row in rows:
        print("| " + " | ".join(row) + " |")
    print()


def changes(figures, key, unit=1.0, digits=1):
    return " -> ".join(f"{f[key] * unit:.{digits}f}" for f in figures)


def threads_option(count):
    return ["--threads", str(count)] if count else []


def denoise_rows(programs, sizes, runs, threads, folder):
    stats = f"{folder}/stats.json"
    rows = []
    for size in sizes:
        width, height = size.split("x")
        noisy = f"{folder}/{size}.exr"
        run([programs[-1], "render", str(ROOT / "examples/cornell-box.xml"), "-o", noisy, "--width", width, "--height", height, "--spp", "2",
             "--guide", "off", "--denoise", "off"])
        for count in threads:
            f = measure(programs, ["denoise", noisy, "-o", f"{folder}/out.exr", "--stats", stats] + threads_option(count), runs, stats)
            rows.append([size, str(count or "all"), changes(f, "wall", 1e3), changes(f, "cpu", 1e3), changes(f, "load_s", 1e3),
                         changes(f, "denoise_s", 1e3), changes(f, "write_s", 1e3), changes(f, "peak", 1e-6, 0)])
    return rows


def render_rows(programs, scenes, size, runs, threads, folder):
    width, height = size.split("x")
    stats = f"{folder}/stats.json"
    rows = []
    for scene in scenes:
        for name, options in RENDERS.items():
            for count in threads:
                f = measure(programs, ["render", scene, "-o", f"{folder}/out.exr", "--spp", "4", "--width", width, "--height", height,
                                       "--stats", stats] + threads_option(count) + options, runs, stats)
                rows.append([f"{pathlib.Path(scene).parent.name}, {name}", str(count or "all")] + [changes(f, p, 1e3, 0) for p in PHASES]
                            + [changes(f, "peak", 1e-6, 0)])
    return rows


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="*", metavar="SCENE.xml")
    parser.add_argument("--fewray", action="append", help="several: before, after")
    parser.add_argument("--runs", type=int, default=10)
    parser.add_argument("--sizes", default="1x1,175x100,700x400,1920x1080")
    parser.add_argument("--render-size", default="700x400")
    parser.add_argument("--threads", default="1,0", help="0: without --threads")
    args = parser.parse_args()
    programs = [os.path.abspath(p) for p in args.fewray or [ROOT / "build/fewray"]]
    threads = [int(t) for t in args.threads.split(",")]
    with tempfile.TemporaryDirectory() as folder:
        print("`fewray --version`: " + changes(measure(programs, ["--version"], args.runs), "wall", 1e3) + " ms\n")
        if args.sizes:
            table(["denoise", "threads", "whole command, ms", "CPU, ms", "read, ms", "denoise, ms", "write, ms", "peak, MB"],
                  denoise_rows(programs, args.sizes.split(","), args.runs, threads, folder))
        if args.scenes:
            table([f"render {args.render_size}", "threads"] + [p[:-2] + ", ms" for p in PHASES] + ["peak, MB"],
                  render_rows(programs, args.scenes, args.render_size, max(1, args.runs // 3), threads, folder))


if __name__ == "__main__":
    main()
