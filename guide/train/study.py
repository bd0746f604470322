# SPDX-License-Identifier: Apache-2.0
"""What the studies share: renders by the fewray command, judged by it, kept as JSON."""
import argparse
import json
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent
NOGAN = HERE / "weights/paper-l1.bin"
# Columns of the paper's table 1, and ours.
METHODS = {
    "Path": ["--guide", "off"],
    "NoGAN": ["--guide", "paper", "--guide-weights", str(NOGAN)],
    "ODIS": ["--guide", "paper"],
    "PPG": ["--guide", "ppg"],
    "ours": ["--guide", "odis"],
}
METRICS = ("mrse_trimmed", "mrse", "ssim_loss")


def parser(text, spp, seeds, output, resumable=True):
    p = argparse.ArgumentParser(description=text,
                                formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("scenes", nargs="+", metavar="SCENE.xml=REFERENCE.exr")
    p.add_argument("-o", "--output", default=output,
                   help=f"name of the results without .json, .md, .png ({output})")
    p.add_argument("--spp", type=lambda s: [int(n) for n in s.split(",")],
                   default=spp, metavar="N,N", help=f"({','.join(map(str, spp))})")
    p.add_argument("--seeds", type=int, default=seeds, help=f"renders of each kind ({seeds})")
    p.add_argument("--size", metavar="WxH",
                   help="a fraction of the references' size; they are averaged accordingly")
    p.add_argument("--threads", type=int, help="of the renders (all)")
    p.add_argument("--build", type=Path, default=HERE.parents[1] / "build",
                   help="folder with fewray and, for --size, fewray-shrink (build)")
    if resumable:
        p.add_argument("--resume", action="store_true",
                       help="keep what OUTPUT.json has, of the same programs and scenes")
    return p


def call(*words):
    """Runs a command; its output. A failure's text is the command's last line."""
    done = subprocess.run([str(w) for w in words], capture_output=True, text=True)
    if done.returncode:
        lines = done.stderr.strip().splitlines() or [f"exit code {done.returncode}"]
        raise RuntimeError(lines[-1])
    return done.stdout


class Scene:
    def __init__(self, pair, args, folder):
        self.xml, _, reference = pair.partition("=")
        self.name, self.reference = scene_name(self.xml), reference
        if args.size:
            self.reference = folder / f"{self.name}-{args.size}.exr"
            call(args.build / "fewray-shrink", reference, args.size, self.reference)
        # "FILE: EXR, WxH pixels, ..."
        first = call(args.build / "fewray", "info", self.reference).splitlines()[0]
        self.width, self.height = first.rsplit("EXR, ", 1)[1].split(" ")[0].split("x")


def scene_name(xml):
    return Path(xml).parent.name or Path(xml).stem


class Study:
    """Measures; results[kind][scene][spp] is a list of one dictionary a seed."""

    def __init__(self, args):
        self.args, self.results, self.failures = args, {}, []
        self.json = Path(f"{args.output}.json")
        self.json.parent.mkdir(parents=True, exist_ok=True)
        if args.resume and self.json.exists():
            self.results = json.loads(self.json.read_text())["results"]

    def render(self, scene, options, spp, seed, folder):
        args, picture, stats = self.args, folder / "picture.exr", folder / "stats.json"
        threads = ["--threads", args.threads] if args.threads else []
        call(args.build / "fewray", "render", scene.xml, "-o", picture, "--float",
             "--stats", stats, "--denoise", "off", "--spp", spp, "--seed", seed,
             "--width", scene.width, "--height", scene.height, *threads, *options)
        told = json.loads(stats.read_text())
        judged = json.loads(call(args.build / "fewray", "compare", picture, scene.reference,
                                 "--json"))
        return {**{m: judged[m] for m in METRICS},
                "seconds": told["initial_s"] + told["guide_s"] + told["render_s"]}

    def run(self, kinds):
        """kinds: name -> options. All kinds take turns, so that other load hits all alike."""
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            for pair in self.args.scenes:
                scene = Scene(pair, self.args, folder)
                for spp in self.args.spp:
                    for seed in range(1, self.args.seeds + 1):
                        for kind, options in kinds.items():
                            self.measure(kind, scene, options, spp, seed, folder)

    def measure(self, kind, scene, options, spp, seed, folder):
        runs = self.results.setdefault(kind, {}).setdefault(scene.name, {}).setdefault(str(spp), [])
        if len(runs) >= seed:
            return
        try:
            runs.append(self.render(scene, options, spp, seed, folder))
        except RuntimeError as error:
            self.failures.append(f"{kind}, {scene.name}, {spp} spp, seed {seed}: {error}")
            print(self.failures[-1], file=sys.stderr, flush=True)
            return
        print(f"{kind}, {scene.name}, {spp} spp, seed {seed}: "
              + ", ".join(f"{k} {v:.4g}" for k, v in runs[-1].items()), flush=True)
        self.save()

    def save(self):
        settings = {k: str(v) for k, v in vars(self.args).items()}
        text = json.dumps({"settings": settings, "results": self.results}, indent=1)
        self.json.with_suffix(".part").write_text(text)
        self.json.with_suffix(".part").replace(self.json)

    def median(self, kind, scene, spp, metric):
        """Over the seeds; the least of seconds. None where nothing was measured."""
        runs = self.results.get(kind, {}).get(scene, {}).get(str(spp), [])
        values = [r[metric] for r in runs if r[metric] is not None]
        if not values:
            return None
        return min(values) if metric == "seconds" else statistics.median(values)

    def finish(self, text):
        """Writes the Markdown; the exit status."""
        if self.failures:
            text += "\nFailed:\n" + "".join(f"- {f}\n" for f in self.failures)
        Path(f"{self.args.output}.md").write_text(text)
        print(text)
        return 1 if self.failures else 0


def start(main):
    try:
        sys.exit(main())
    except RuntimeError as error:
        sys.exit(f"{Path(sys.argv[0]).name}: {error}")


def number(value):
    return "-" if value is None else f"{value:.3g}"


def row(*cells):
    return "| " + " | ".join(cells) + " |\n"


def head(*cells):
    return row(*cells) + "|" + "---|" * len(cells) + "\n"


def plot(path, panels, x_label):
    """Log-log curves as a PNG, where matplotlib is there. panels: (y label, {name: (xs, ys)})."""
    try:
        import matplotlib
    except ImportError:
        print("no matplotlib: no picture", file=sys.stderr)
        return
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(1, len(panels), figsize=(6 * len(panels), 4.5), squeeze=False)
    for axis, (y_label, curves) in zip(axes[0], panels):
        for name, (xs, ys) in curves.items():
            axis.plot(xs, ys, marker="o", markersize=3, label=name)
        axis.set_xscale("log", base=2)
        axis.set_yscale("log")
        axis.set_xlabel(x_label)
        axis.set_ylabel(y_label)
        axis.grid(True, which="both", alpha=0.3)
        axis.legend()
    figure.tight_layout()
    figure.savefig(path, dpi=130)
    plt.close(figure)
