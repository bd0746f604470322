#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Where the CPU time of `fewray render` goes, as Markdown tables and flame graphs.

    tests/perf/profile.py --fewray BEFORE [--fewray AFTER] [--runs 1] [--flames FOLDER] SCENE.xml...

Needs Linux's `perf` (Debian: linux-perf), `addr2line` (binutils), a kernel.perf_event_paranoid of 2 or less, and programs that were compiled with
debug information, which leaves their code as it is:

    cmake -S . -B build-profile -DCMAKE_BUILD_TYPE=Release -DCMAKE_C_FLAGS=-g

Every program renders every scene on one thread, path traced, and guided and denoised. A sample of the clock belongs to the first group in GROUPS that
its innermost function falls into, inlined ones included, else to that of its caller, and so on. So the page faults of a film
are the film's, and `fmaxf` is whose who called it. What belongs to a phase other than rendering (PHASES) is not split. What no pattern
knows, the dynamic linker and the kernel at start above all, counts as start-up. Some of Embree's packets can't be unwound: in the flame graph they
stand apart. Of several runs the one with the least CPU time counts. A benchmark, never a test."""

import argparse
import collections
import pathlib
import re
import subprocess
import tempfile

from flame import write_flame

VARIANTS = {
    "path traced": ["--guide", "off", "--denoise", "off"],
    "guided, denoised": ["--pilot", "off"],
}

# Patterns of "file:function" for fewray's own functions, of "library:function" for others. Groups are shown in the order of their first pattern.
PHASES = [
    ("denoiser", r"denoise/denoise.*\.c:"),
    ("loading, start-up", r"guide/scene/|guide/trace/world\.c:|light/lights_build|light/light_tree\.c:(build|light_tree_(build|create))"
                          r"|environment_table_create|bsdf_table"),
    ("making maps and probes", r"odis/(gather|irradiance|maps_build|maps_refine|network|probe_build|map_places)\.c:|probes_create|odis_"),
    ("writing", r"features/(exr|png)_write|features/(zip|half)\.|pipeline/outputs"),
]
GROUPS = [
    ("Embree: traversal", r"libembree|guide/trace/embree|guide/trace/sphere\.c:(hit|intersect|occlude|bounds)$|/bundle[^:]*:(trace|trace_lights)$"
                          r"|direct_light\.c:light_visible|surface\.c:surface_trace"),
    ("camera rays", r"guide/trace/camera|guide/trace/edges|:camera_rays$|:trace_camera$|:start_path$|:lane_sampler$|tile_paths"),
    ("surface reconstruction", r"guide/trace/(surface|sphere)\.|:(find_vertices|fetch_corners|blend|is_hit|lane_surface|first_hits|see_first)$"),
    ("materials and textures", r"guide/bsdf/|guide/trace/texture|:(is_plain|diffuse_side|find_reflectance|lane_shading)$"),
    ("environment", r"guide/light/environment|:lights_sky$|:lights_pdf_sky$|:see_sky$|:sample_environment$"),
    ("light sampling", r"guide/light/light|bundle_lights|direct_light|:(add_direct|pick_lights|guide_lights|note_lights|find_emission|add_emission"
                       r"|emitted|light_pdf)$"),
    ("guide: maps and probes looked up", r"guide/odis/|guide/trace/proposal|:find_proposals$"),
    ("bounces", r"guide/trace/(bundle|integrator|vertex_log)|guide/trace/rest\.c:notes_for"),
    ("film", r"guide/trace/(film|rest|look|pilot|tiles)"),
]
OTHER = "loading, start-up"
OUTERMOST = "pipeline/cmd_render.c:cmd_render"  # what lies outside is the same in each sample
STACK = 65528  # bytes kept of a sample's stack, perf's most; Embree's packets need more than 30,000


def record(program, scene, options, size, spp, hertz, folder):
    """CPU profile of one render: a list of (milliseconds, frames from the innermost on)."""
    width, height = size.split("x")
    data = f"{folder}/perf.data"
    output_of(["perf", "record", "-q", "-e", "cpu-clock", "-F", str(hertz), "--call-graph", f"dwarf,{STACK}", "-o", data, "--",
               program, "render", scene, "-o", f"{folder}/out.exr", "--spp", str(spp), "--width", width, "--height", height,
               "--threads", "1"] + options)
    return resolve(program, parse(output_of(["perf", "script", "-i", data, "--no-inline", "-F", "period,ip,sym,dso"])))


def output_of(command, text=None):
    try:
        done = subprocess.run(command, input=text, capture_output=True, text=True, errors="replace")
    except FileNotFoundError:
        raise SystemExit(f"{command[0]} isn't installed") from None
    if done.returncode:
        raise SystemExit(f"failed: {' '.join(command)}\n{done.stderr.strip()}")
    return done.stdout


def parse(script):
    """Samples of `perf script`; a frame is (address within its file, function, library)."""
    frame = re.compile(r"^\s+([0-9a-f]+) (.*) \((.*)\)$")
    samples = []
    for line in script.splitlines():
        if found := frame.match(line):
            address, function, library = found.groups()
            if function != "[unknown]" or library != "[unknown]":
                samples[-1][1].append((int(address, 16), function, pathlib.Path(library).name))
        elif line.strip().isdigit():
            samples.append((int(line) * 1e-6, []))
    return samples


def resolve(program, samples):
    """Names the program's frames by addr2line, so that inlined functions are told apart."""
    name = pathlib.Path(program).name
    wanted = sorted({a for _, frames in samples for a, _, library in frames if library == name})
    told = output_of(["addr2line", "-a", "-f", "-i", "-e", program], "".join(f"{a:#x}\n" for a in wanted)).splitlines()
    inlined, here = {}, None
    lines = iter(told)
    for line in lines:
        if line.startswith("0x"):
            here = inlined.setdefault(int(line, 16), [])
        else:
            here.append(short_path(next(lines)) + ":" + line.split(".")[0])
    if not any("guide/" in f for frames in inlined.values() for f in frames):
        raise SystemExit(f"{program} has no debug information: compile it with -g")
    return [(ms, inner_part([f for a, function, library in frames for f in
                             (inlined[a] if library == name else [f"{library}:{function}"])])) for ms, frames in samples]


def inner_part(frames):
    return frames[:frames.index(OUTERMOST) + 1] if OUTERMOST in frames else frames


def short_path(place):
    found = re.search(r"(?:guide|denoise|pipeline|features)/[^:]*", place)
    return found.group(0) if found else place.split(":")[0]


def group_of(frames):
    for group, pattern in PHASES:
        if any(re.search(pattern, f) for f in frames):
            return group
    for f in frames:
        for group, pattern in GROUPS:
            if re.search(pattern, f):
                return group
    return OTHER


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scenes", nargs="+", metavar="SCENE.xml")
    parser.add_argument("--fewray", action="append", required=True, help="several: before, after")
    parser.add_argument("--runs", type=int, default=1)
    parser.add_argument("--size", default="700x400")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--hertz", type=int, default=500)
    parser.add_argument("--flames", metavar="FOLDER", help="for flame graphs in SVG")
    parser.add_argument("--functions", type=int, default=0, metavar="N", help="also the N costliest functions of each group")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for scene in args.scenes:
            profile_scene(scene, args, folder)


def least(program, scene, options, args, folder):
    runs = [record(program, scene, options, args.size, args.spp, args.hertz, folder) for _ in range(args.runs)]
    return min(runs, key=lambda samples: sum(ms for ms, _ in samples))


def profile_scene(scene, args, folder):
    name = pathlib.Path(scene).resolve().parent.name
    columns = []
    for variant, options in VARIANTS.items():
        for i, program in enumerate(args.fewray):
            samples = least(str(pathlib.Path(program).resolve()), scene, options, args, folder)
            columns.append((variant, i, samples))
            if args.flames:
                label = f"{name}, {variant}" + (f", {'before' if i == 0 else 'after'}" if len(args.fewray) == 2 else "")
                path = pathlib.Path(args.flames) / (re.sub(r"[^\w-]+", "-", label) + ".svg")
                path.parent.mkdir(parents=True, exist_ok=True)
                write_flame(path, label, samples)
    print_table(f"{name}, {args.size}, {args.spp} spp, ms of CPU", columns, args)


def print_table(title, columns, args):
    sums = [collections.defaultdict(float) for _ in columns]
    functions = [collections.defaultdict(lambda: collections.defaultdict(float)) for _ in columns]
    for total, inner, (_, _, samples) in zip(sums, functions, columns):
        for ms, frames in samples:
            group = group_of(frames)
            total[group] += ms
            inner[group][frames[0] if frames else "?"] += ms
    groups = list(dict.fromkeys(g for g, _ in GROUPS + PHASES))
    print("| " + " | ".join([title] + list(VARIANTS)) + " |")
    print("|---|" + "---|" * len(VARIANTS))
    for group in groups + ["all"]:
        cells = []
        for variant in VARIANTS:
            cells.append(" -> ".join(cell(total, group) for total, (v, _, _) in zip(sums, columns) if v == variant))
        print("| " + " | ".join([group] + cells) + " |")
    print()
    if args.functions:
        for inner, (variant, i, _) in zip(functions, columns):
            print(f"{variant}, {args.fewray[i]}:\n")
            for group in groups:
                most = sorted(inner[group].items(), key=lambda item: -item[1])[:args.functions]
                print(f"- {group}: " + ", ".join(f"{f} {ms:.0f}" for f, ms in most))
            print()


def cell(total, group):
    whole = sum(total.values())
    ms = whole if group == "all" else total[group]
    return f"{ms:.0f} ({100 * ms / whole:.0f} %)" if whole and group != "all" else f"{ms:.0f}"


if __name__ == "__main__":
    main()
