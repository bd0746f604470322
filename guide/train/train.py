# SPDX-License-Identifier: Apache-2.0
"""Trains the ODIS network on records of fewray-odis-data. See README.md."""
import argparse
import copy
import json
import math
import os
import time

import torch

import dataset
import losses
from model import COSINE, PLANE_NAMES, Discriminator, Odis, range_compress

LEGEND = """\
Printed for the validation maps; unless said otherwise means of log excess (losses.py): the log of
the noise that sampling from a map causes relative to the least possible, 0.1 = 10 % more.
  network            the network's map and its own BSDF fraction a
  network, a 0.25    the same map, a fixed
  fill only, cosine only, perfect map, perfect mean map
                     the gathered fill, no guide, the true second-moment map, the true mean map
  worse than cosine  share of maps (0..1) for which the network's log excess is above cosine only's
  a mean, a spread   of the network's BSDF fraction over the maps (spread: standard deviation)
  radiance l1        error of the second output, range-compressed
  training           mean loss since the last line
"""


def arguments():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("data", nargs="+", help="files of fewray-odis-data")
    p.add_argument("--validation", nargs="+", default=[],
                   help="files for validation alone (default: every tenth scene)")
    p.add_argument("-o", "--output", required=True, help="folder for checkpoints and log.json")
    p.add_argument("--minutes", type=float, default=10,
                   help="of training; the learning rate falls to zero over them")
    p.add_argument("--loss", choices=("variance", "l1"), default="variance")
    p.add_argument("--gan", action="store_true", help="adds the paper's discriminator")
    p.add_argument("--gan-weight", type=float, default=4e-3)
    p.add_argument("--radiance-weight", type=float, default=0.1,
                   help="of L1 on mean radiance beside the variance loss")
    p.add_argument("--bsdf-fraction", type=float,
                   help="fixed, instead of the network's own for each map; with --loss l1 0.25 "
                        "unless given")
    p.add_argument("--drop", type=lambda text: text.split(","), default=[], metavar="NAME,NAME",
                   help="input planes to leave out: " + ", ".join(PLANE_NAMES))
    p.add_argument("--batch", type=int, default=64)
    p.add_argument("--rate", type=float, default=2e-3)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--start", help="checkpoint whose weights to start from")
    p.add_argument("--resume", action="store_true",
                   help="go on from the output folder's checkpoint, if there is one")
    p.add_argument("--validate-every", type=float, default=180,
                   help="seconds; then a checkpoint is written too")
    args = p.parse_args()
    unknown = set(args.drop) - set(PLANE_NAMES)
    if unknown:
        p.error(f"--drop: no plane is called {', '.join(sorted(unknown))}")
    if args.loss == "l1" and args.bsdf_fraction is None:
        args.bsdf_fraction = 0.25  # nothing in this loss teaches the network's own
    return args


def fraction_of(own, args):
    return own if args.bsdf_fraction is None else args.bsdf_fraction


@torch.no_grad()
def validate(model, records, args):
    """The figures that LEGEND explains."""
    columns = {}

    def add(name, values):
        columns.setdefault(name, []).append(values)

    for inputs, targets in records.batches(256):
        inputs = dataset.drop_planes(inputs, args.drop)
        output, own = model(inputs)
        shares, fraction = losses.map_of(output, inputs, args.loss), fraction_of(own, args)
        maps = {"network": (shares, fraction), "network, a 0.25": (shares, 0.25)}
        maps.update(losses.reference_maps(inputs, targets))
        excess = {name: losses.log_excess(m, inputs, targets, a) for name, (m, a) in maps.items()}
        for name, values in excess.items():
            add(name, values)
        add("worse than cosine", (excess["network"] > excess["cosine only"]).float())
        add("a", torch.as_tensor(fraction).expand(len(inputs)))
        add("radiance l1", losses.radiance_l1(output, inputs, targets).expand(len(inputs)))
    columns = {name: torch.cat(values) for name, values in columns.items()}
    a = columns.pop("a")
    figures = {name: values.mean().item() for name, values in columns.items()}
    return {**figures, "a mean": a.mean().item(), "a spread": a.std(correction=0).item()}


class Trainer:
    def __init__(self, args):
        self.args = args
        self.generator = torch.Generator().manual_seed(args.seed)
        self.model = Odis()
        if args.start:
            self.model.load_state_dict(torch.load(args.start, weights_only=True)["average"])
        self.average = copy.deepcopy(self.model).eval()
        self.optimizer = torch.optim.Adam(self.model.parameters(), args.rate, betas=(0.9, 0.99))
        self.judge = Discriminator() if args.gan else None
        if self.judge:
            self.judge_optimizer = torch.optim.Adam(self.judge.parameters(), 1e-4)
        self.steps, self.seconds = 0, 0.0

    def judged(self, radiance, inputs):
        return self.judge((radiance * (inputs[:, COSINE] > 0))[:, None])

    def step(self, inputs, targets, rate):
        args = self.args
        output, own = self.model(inputs)
        radiance_loss = losses.radiance_l1(output, inputs, targets)
        if args.loss == "variance":
            shares = losses.map_of(output, inputs, args.loss)
            excess = losses.log_excess(shares, inputs, targets, fraction_of(own, args))
            loss = excess.mean() + args.radiance_weight * radiance_loss
        else:
            loss = radiance_loss
        if self.judge:
            fooled = losses.adversarial(self.judged(output[:, 1], inputs), True)
            loss = loss + args.gan_weight * fooled
        if not torch.isfinite(loss):
            raise SystemExit("the loss isn't finite: lower --rate")
        self.optimizer.param_groups[0]["lr"] = rate
        self.optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimizer.step()
        if self.judge:
            self.step_judge(output[:, 1].detach(), range_compress(targets[:, 0]), inputs)
        self.steps += 1
        keep = min(0.999, (1 + self.steps) / (10 + self.steps))
        with torch.no_grad():
            for mean, now in zip(self.average.parameters(), self.model.parameters()):
                mean.lerp_(now, 1 - keep)
        return loss.item()

    def step_judge(self, made, true, inputs):
        loss = (losses.adversarial(self.judged(true, inputs), True)
                + losses.adversarial(self.judged(made, inputs), False)) / 2
        self.judge_optimizer.zero_grad()
        loss.backward()
        self.judge_optimizer.step()

    def path(self):
        return os.path.join(self.args.output, "odis.pt")

    def save(self, figures, log):
        """The checkpoint: what export.py reads, and what resume() needs besides."""
        files = ("data", "validation", "output", "start", "resume")
        settings = {k: v for k, v in vars(self.args).items() if k not in files}
        state = {"average": self.average.state_dict(), "model": self.model.state_dict(),
                 "optimizer": self.optimizer.state_dict(), "steps": self.steps,
                 "seconds": self.seconds, "figures": figures, "log": log, "settings": settings}
        if self.judge:
            state["judge"] = self.judge.state_dict()
            state["judge_optimizer"] = self.judge_optimizer.state_dict()
        torch.save(state, self.path() + ".part")
        os.replace(self.path() + ".part", self.path())

    def resume(self):
        """Returns the log so far. The records come in another order than without the break."""
        state = torch.load(self.path(), weights_only=True)
        parts = ("average", "model", "optimizer")
        if self.judge:
            parts += ("judge", "judge_optimizer")
        for name in parts:
            getattr(self, name).load_state_dict(state[name])
        self.steps, self.seconds = state["steps"], state["seconds"]
        self.generator.manual_seed(self.args.seed + self.steps)
        return state["log"]


def learning_rate(args, share, steps):
    return args.rate * min(1, (steps + 1) / 200) * 0.5 * (1 + math.cos(math.pi * min(1, share)))


def main():
    args = arguments()
    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    os.makedirs(args.output, exist_ok=True)
    trainer, log = Trainer(args), []
    if args.resume and os.path.exists(trainer.path()):
        log = trainer.resume()
    training, validation = dataset.load(args.data, args.validation, args.batch,
                                        args.seed + trainer.steps)
    print(LEGEND + f"{len(training)} maps to train on, {len(validation)} to validate", flush=True)
    if not len(training) or not len(validation):
        raise SystemExit("both need maps of at least one scene: give more scenes or --validation")
    training.start()
    before, start = trainer.seconds, time.monotonic()
    last, recent, batches = start, 0.0, 0
    while True:
        trainer.seconds = before + time.monotonic() - start
        share = trainer.seconds / (args.minutes * 60)
        if share >= 1 or time.monotonic() - last > args.validate_every:
            figures = validate(trainer.average, validation, args)
            figures.update(steps=trainer.steps, maps=trainer.steps * args.batch,
                           seconds=trainer.seconds, training=recent / max(batches, 1))
            log.append(figures)
            print("  ".join(f"{k} {v:.4g}" for k, v in figures.items()), flush=True)
            trainer.save(figures, log)
            with open(os.path.join(args.output, "log.json"), "w") as file:
                json.dump(log, file, indent=1)
            last, recent, batches = time.monotonic(), 0.0, 0
            if share >= 1:
                break
        inputs, targets = training.next()
        inputs, targets = dataset.augment(inputs, targets, trainer.generator)
        inputs = dataset.drop_planes(inputs, args.drop)
        recent += trainer.step(inputs, targets, learning_rate(args, share, trainer.steps))
        batches += 1


if __name__ == "__main__":
    main()
