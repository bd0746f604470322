#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Checks what the documents say against the tree, from its root, with a build in build/: links lead to files and headings, files
named by path exist, options are those of the programs, and docs/file-formats.md has every field that the program writes."""
import json
import re
import subprocess
import sys
import tempfile
from pathlib import Path

# Of programs that aren't ours.
FOREIGN = {"--prefix", "--build", "--target", "--install", "--preset", "--config", "--test-dir", "--output-on-failure", "--array",
           "--version", "--cflags", "--libs", "--static", "--variable", "--oidn-command", "--allow-run-as-root"}
COMMANDS = ("render", "denoise", "compare", "composite", "bench", "info", "merge", "report")

problems = []


def complain(path, line, text):
    problems.append(f"{path}:{line}: {text}")


def slug(heading):
    """The anchor of a heading, as GitHub makes it."""
    text = re.sub(r"[^\w\- ]", "", heading.strip().lower())
    return text.replace(" ", "-")


def anchors(path):
    return {slug(m[1]) for m in re.finditer(r"^#+ +(.+)$", path.read_text(), re.M)}


def check_link(path, line, target):
    if re.match(r"[a-z]+:", target):
        return
    name, _, anchor = target.partition("#")
    file = path.parent / name if name else path
    if not file.exists():
        complain(path, line, f"there is no {target}")
    elif anchor and anchor not in anchors(file):
        complain(path, line, f"{file} has no heading #{anchor}")


def check_path(path, line, name):
    """A file named in the text, from the root or from the document's folder or one above."""
    if not re.fullmatch(r"[\w.-]+(/[\w.-]+)+\.(c|h|cpp|py|sh|md|xml|cmake|txt)", name) or name.startswith(("build", "DIR")):
        return
    roots = [Path("."), *list(path.parents)[:-1]]
    includes = [folder for folder in Path(".").glob("*/include")]
    if not any((root / name).exists() for root in roots + includes):
        complain(path, line, f"there is no {name}")


def help_options():
    found = set()
    for command in COMMANDS:
        done = subprocess.run(["build/fewray", command, "--help"], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        found.update(re.findall(r"--[a-z][\w-]*", done.stdout))
    if len(found) < 40:
        sys.exit("build/fewray COMMAND --help lists no options")
    return found


def tool_options():
    """Those of the tools for training, studies and tests: in their usage texts, parsers or tables of options."""
    found = set()
    for folder in ("guide/train", "denoise/train", "tests", "examples", "docs"):
        for file in Path(folder).rglob("*"):
            if file.suffix in (".c", ".py", ".sh") and file.name != "documents_check.py":
                text = file.read_text(errors="replace")
                found.update(re.findall(r"--[a-z][\w-]*", text))
                if "getopt_long" in text:
                    found.update("--" + name for name in re.findall(r'\{"([a-z][\w-]*)", [012]', text))
    return found


def check_document(path, options):
    text = re.sub(r"^```.*?^```$", lambda block: "\n" * block[0].count("\n"), path.read_text(), flags=re.M | re.S)
    for number, line in enumerate(text.splitlines(), 1):
        for target in re.findall(r"\]\(([^)\s]+)\)", line):
            check_link(path, number, target)
        for code in re.findall(r"`([^`]+)`", line):
            for option in re.findall(r"(?<![\w-])--[a-z][\w-]*", code):
                if option not in options:
                    complain(path, number, f"no program has an option {option}")
            check_path(path, number, code)


def keys(value):
    """All member names of a JSON value."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield name
            yield from keys(inner)
    elif isinstance(value, list):
        for inner in value:
            yield from keys(inner)


def check_fields():
    """Members of JSON, columns of CSV and channels of EXR that the program writes here are described."""
    path = Path("docs/file-formats.md")
    text = re.sub(r"^```.*?^```$", "", path.read_text(), flags=re.M | re.S)
    named = set()
    for name in re.findall(r"`([^`\n]+)`", text):  # albedo.R/G/B: three channels
        layer, dot, channels = name.rpartition(".")
        named.update([name] + [layer + dot + c for c in channels.split("/")])

    def expect(name, where):
        if name not in named and not (name.startswith("noisy.") and "noisy.NAME." + name.rpartition(".")[2] in named):
            complain(path, 1, f"{where} has {name}, which isn't described")

    def output_of(*arguments):
        done = subprocess.run(["build/fewray", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        if done.returncode:
            sys.exit(f"fewray {' '.join(arguments)}: {done.stderr}")
        return done.stdout

    with tempfile.TemporaryDirectory() as folder:
        exr, stats, part = (f"{folder}/{name}" for name in ("out.exr", "stats.json", "part.exr"))
        scene = ("examples/cornell-box.xml", "--width", "48", "--height", "48", "--guide", "odis", "--pilot", "off")
        output_of("render", *scene, "-o", exr, "--stats", stats, "--aovs", "direct,indirect", "--error", "0.5")
        output_of("render", *scene, "-o", part, "--part", "1/2")
        for name in keys(json.loads(Path(stats).read_text())):
            expect(name, "--stats")
        for file in (exr, part):
            channels = re.findall(r"^  (\S+) +\S+ +\S+ +\S+ +\d+$", output_of("info", file), re.M)
            if "R" not in channels:
                complain(path, 1, "fewray info lists no channels any more: documents_check.py can't read it")
            for name in channels:
                expect(name, "an EXR")
        for name in keys(json.loads(output_of("compare", "--json", part, part))):
            expect(name, "compare --json")
        output_of("bench", "scene.xml", "--reference", "reference.exr", "-o", f"{folder}/bench", "--spp", "1,2", "--seeds", "1")
        for name in keys(json.loads(Path(f"{folder}/bench/bench.json").read_text())):
            expect(name, "bench.json")
        for name in Path(f"{folder}/bench/bench.csv").read_text().splitlines()[0].split(","):
            expect(name, "bench.csv")


def main():
    documents = [Path("README.md"), Path("CHANGELOG.md"), *Path("docs").glob("*.md"), *Path(".").glob("*/NOTES.md"),
                 *Path("examples").glob("*/README.md"), *Path("tests").rglob("README.md"), *Path(".").glob("*/train/README.md")]
    options = help_options() | tool_options() | FOREIGN
    for path in documents:
        check_document(path, options)
    check_fields()
    print("\n".join(dict.fromkeys(problems)) or f"{len(documents)} documents: links, files, options and fields are right")
    sys.exit(bool(problems))


if __name__ == "__main__":
    main()
