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
from model import COSINE, Discriminator, Odis, range_compress


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
    p.add_argument("--bsdf-fraction", type=float, default=0.25)
    p.add_argument("--batch", type=int, default=64)
    p.add_argument("--rate", type=float, default=2e-3)
    p.add_argument("--threads", type=int, default=2)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--start", help="checkpoint whose weights to start from")
    p.add_argument("--validate-every", type=float, default=60, help="seconds")
    return p.parse_args()


@torch.no_grad()
def validate(model, records, args, limit=4096):
    """Mean log excess of the network's maps and of the reference maps, and L1 of the radiance."""
    sums, l1, count = {}, 0.0, 0
    step = max(1, len(records) // limit)
    order = list(range(0, len(records), step))
    for at in range(0, len(order), 256):
        inputs, targets = records.batch(order[at:at + 256])
        output = model(inputs)
        maps = {"network": losses.map_of(output, inputs, args.loss)}
        maps.update(losses.reference_maps(inputs, targets))
        for name, shares in maps.items():
            excess = losses.log_excess(shares, inputs, targets, args.bsdf_fraction)
            sums[name] = sums.get(name, 0.0) + excess.sum().item()
        l1 += losses.radiance_l1(output, inputs, targets).item() * len(inputs)
        count += len(inputs)
    return {name: s / count for name, s in {**sums, "radiance l1": l1}.items()}


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
        self.steps = 0

    def judged(self, radiance, inputs):
        return self.judge((radiance * (inputs[:, COSINE] > 0))[:, None])

    def step(self, inputs, targets, rate):
        args = self.args
        output = self.model(inputs)
        radiance_loss = losses.radiance_l1(output, inputs, targets)
        if args.loss == "variance":
            shares = losses.map_of(output, inputs, args.loss)
            excess = losses.log_excess(shares, inputs, targets, args.bsdf_fraction)
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

    def save(self, figures):
        files = ("data", "validation", "output", "start")
        settings = {k: v for k, v in vars(self.args).items() if k not in files}
        state = {"average": self.average.state_dict(), "model": self.model.state_dict(),
                 "steps": self.steps, "figures": figures, "settings": settings}
        path = os.path.join(self.args.output, "odis.pt")
        torch.save(state, path + ".part")
        os.replace(path + ".part", path)


def learning_rate(args, share, steps):
    return args.rate * min(1, (steps + 1) / 200) * 0.5 * (1 + math.cos(math.pi * min(1, share)))


def main():
    args = arguments()
    torch.set_num_threads(args.threads)
    torch.manual_seed(args.seed)
    os.makedirs(args.output, exist_ok=True)
    training, validation = dataset.load(args.data, args.validation)
    print(f"{len(training)} maps to train on, {len(validation)} to validate", flush=True)
    if not len(training) or not len(validation):
        raise SystemExit("both need maps of at least one scene: give more scenes or --validation")
    trainer, log = Trainer(args), []
    start = last = time.monotonic()
    total, recent, batches = args.minutes * 60, 0.0, 0
    while True:
        share = (time.monotonic() - start) / total
        if share >= 1 or time.monotonic() - last > args.validate_every:
            figures = validate(trainer.average, validation, args)
            figures.update(steps=trainer.steps, maps=trainer.steps * args.batch,
                           seconds=time.monotonic() - start, training=recent / max(batches, 1))
            log.append(figures)
            print("  ".join(f"{k} {v:.4g}" for k, v in figures.items()), flush=True)
            trainer.save(figures)
            with open(os.path.join(args.output, "log.json"), "w") as file:
                json.dump(log, file, indent=1)
            last, recent, batches = time.monotonic(), 0.0, 0
            if share >= 1:
                break
        order = torch.randint(len(training), (args.batch,), generator=trainer.generator).numpy()
        inputs, targets = dataset.augment(*training.batch(order), trainer.generator)
        recent += trainer.step(inputs, targets, learning_rate(args, share, trainer.steps))
        batches += 1


if __name__ == "__main__":
    main()
