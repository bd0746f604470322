#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Runs the commands of the documents, block by block, from the repository's root:
    python3 tests/adopt/documents.py [--run-by FILE] [FILE.md...]

A block is a fenced one of ```sh, or, but for docs/, an indented one. Each runs in a shell of its own, which ends at the first
command that fails. A comment right before it tells what isn't run here:

    <!-- not run: why -->              the whole block
    <!-- not run "COMMAND": why -->    its lines that begin so
    <!-- run by FILE -->               FILE runs it, by --run-by

A part in brackets may be left out: the line is run without it, then once for each of its alternatives, [--json | --blocks 20].
SMALLER are sizes that would take too long here; documents.sh lists the files that stand in for placeholders."""
import argparse
import os
import re
import subprocess
import sys
import time
from pathlib import Path

# In this order: training replaces weights, the new material the sources.
LAST = ("denoise/train/README.md", "guide/train/README.md", "docs/adding-a-material.md")
LIMIT = 900  # seconds for a block, on a busy machine

SMALLER = [
    (r"--frames 0\.\.47\b", "--frames 0..1"),
    (r"--time \d+s", "--time 1s"),
    (r"--spp 1024\b", "--spp 64"),
    (r"--minutes \d+", "--minutes 0.05"),
    (r"--count \d+", "--count 3"),
    (r"--maps \d+", "--maps 20"),
    (r"--samples 64\b", "--samples 4"),
    (r"--width 384\b", "--width 128"),
    (r"--views 12\b", "--views 2"),
    (r"--size 350x200\b", "--size 32x32 --spp 2,4 --seeds 1"),
    (r"train/make_data\.py", "train/make_data.py --width 160 --height 128 --reference-spp 16"),
    (r"denoise/train/train\.py", "denoise/train/train.py --batch 2"),
    (r"study_table\.py", "study_table.py --seeds 1"),
    (r"=REFERENCE\.exr ?\.\.\.", "=REFERENCE.exr"),  # and more such pairs
]

ENVIRONMENT = {
    "FIGURE_SAMPLES": "16",
    "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1", "OMPI_MCA_rmaps_base_oversubscribe": "1",
}


class Block:
    def __init__(self, path, line, lines, comments):
        self.path, self.line, self.lines = path, line, lines
        self.why, self.skipped, self.by = None, [], None
        for comment in comments:
            if match := re.fullmatch(r'not run: (.+)', comment):
                self.why = match[1]
            elif match := re.fullmatch(r'not run "([^"]+)": (.+)', comment):
                self.skipped.append((match[1], match[2]))
            elif match := re.fullmatch(r'run by (\S+)', comment):
                self.by = match[1]

    def name(self):
        return f"{self.path}:{self.line}"

    def reason(self, line):
        return next((why for prefix, why in self.skipped if line.startswith(prefix)), None)

    def script(self):
        """The commands as they are run here."""
        lines = []
        for line in self.lines:
            if self.reason(line):
                continue
            optional = re.search(r" \[(-[^\]]*)\]", line)
            if not optional:
                lines.append(line)
                continue
            for choice in ["", *optional[1].split("|")]:
                lines.append((line[:optional.start()] + " " + choice.strip() + line[optional.end():]).rstrip())
        text = "\n".join(lines)
        for pattern, smaller in SMALLER:
            text = re.sub(pattern, smaller, text)
        return text


def blocks_of(path):
    """The blocks of a document in their order."""
    blocks, comments, current, start, fence, blank = [], [], None, 0, None, True
    indented = not str(path).startswith("docs/")

    def close():
        nonlocal current, comments
        if current and any(line.strip() for line in current):
            blocks.append(Block(path, start, [line for line in current], comments))
        current, comments = None, []

    for number, line in enumerate(path.read_text().splitlines(), 1):
        if fence is not None:
            if line.strip() == "```":
                if fence != "sh":
                    current = None
                close()
                fence = None
            else:
                current.append(line)
            continue
        if current is not None:  # an indented one
            if line.startswith("    ") or not line.strip():
                current.append(line[4:])
                continue
            close()
        if match := re.fullmatch(r"\s*```(\w*)", line):
            fence, current, start = match[1], [], number + 1
        elif match := re.fullmatch(r"<!-- (.+) -->", line.strip()):
            comments.append(match[1])
        elif indented and blank and line.startswith("    "):
            current, start = [line[4:]], number
        elif line.strip():
            comments = []
        blank = not line.strip() or line.strip().startswith("<!--")
    close()
    return blocks


def documents():
    found = [Path("README.md"), *sorted(Path("docs").glob("*.md")), *sorted(Path("examples").glob("*/README.md")),
             *sorted(Path("tests").rglob("README.md")), *(Path(p) for p in LAST[:2])]
    return sorted(found, key=lambda p: LAST.index(str(p)) if str(p) in LAST else -1)


def run(block):
    """True where all its commands worked."""
    start = time.monotonic()
    environment = {**os.environ, **ENVIRONMENT}
    try:
        done = subprocess.run(["sh", "-eu", "-c", block.script()], env=environment, timeout=LIMIT, stdin=subprocess.DEVNULL,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace")
        output, status = done.stdout, f"exit code {done.returncode}" if done.returncode else None
    except subprocess.TimeoutExpired as late:
        output, status = (late.stdout or b"").decode(errors="replace"), f"longer than {LIMIT} s"
    if status:
        print(f"FAILED  {block.name()}: {status}\n{block.script()}\n-- its last lines:")
        print("\n".join(output.splitlines()[-25:]), flush=True)
        return False
    print(f"ok      {block.name()}  {time.monotonic() - start:.1f} s", flush=True)
    for line in block.lines:
        if block.reason(line):
            print(f"not run {block.name()} \"{line.split('#')[0].strip()}\": {block.reason(line)}")
    return True


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--run-by", metavar="FILE", help="only the blocks that FILE is to run")
    p.add_argument("documents", nargs="*", type=Path, metavar="FILE.md")
    a = p.parse_args()
    failed = count = 0
    for path in a.documents or documents():
        for block in blocks_of(path):
            if block.why and not a.run_by:
                print(f"not run {block.name()}: {block.why}")
            elif block.by != a.run_by:
                if block.by and not Path(block.by).exists():
                    print(f"FAILED  {block.name()}: no {block.by} runs it")
                    failed += 1
                elif block.by:
                    print(f"not run {block.name()}: {block.by} does")
            elif not block.why:
                count += 1
                failed += not run(block)
    print(f"{count} blocks run, {failed} failed")
    if a.run_by and not count:
        sys.exit(f"no block is run by {a.run_by}")
    sys.exit(bool(failed))


if __name__ == "__main__":
    main()
