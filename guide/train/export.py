# SPDX-License-Identifier: Apache-2.0
"""Writes a checkpoint as weights for denoise/nn (nn.h describes the file), and tensors that pin the
C network to this one."""
import argparse
import struct
import sys
from pathlib import Path

import numpy as np
import torch

import dataset
from model import Odis

# The file format is the convolution engine's; last on the path, since both folders have a model.py.
sys.path.append(str(Path(__file__).resolve().parents[2] / "denoise/train"))
from weights_file import container, write_whole  # noqa: E402


def weight_tensors(model):
    """name -> array with four dimensions, a bias as (out, 1, 1, 1)."""
    return {name: value.reshape(value.shape + (1,) * (4 - value.dim())).numpy()
            for name, value in model.state_dict().items()}


@torch.no_grad()
def references(model, inputs, settings):
    """"ODISREFS", uint32 version 2, uint32 maps, uint32 layers; for each map 15x32x32 half floats
    of input, then for each layer 16 bytes of name, int32 channels, height, width and float32 values
    (after the activation; up1 and up0 before they meet the skip), then two 32x32 float32 planes:
    log moment and range-compressed radiance; then one float32: the BSDF fraction that C should
    return. tests/unit/test_odis_network.c reads them."""
    data = b""
    for i in range(len(inputs)):
        data += inputs[i].numpy().astype("<f2").tobytes()
        dataset.drop_planes(inputs[i:i + 1], settings["drop"])
        layers = model.layers(inputs[i:i + 1])
        for name, values in layers.items():
            data += name.encode().ljust(16, b"\0") + struct.pack("<3i", *values.shape[1:])
            data += values[0].numpy().astype("<f4").tobytes()
        output, own = model(inputs[i:i + 1])
        fixed = settings["bsdf_fraction"]
        fraction = own.item() if fixed is None else fixed
        data += output[0].numpy().astype("<f4").tobytes() + struct.pack("<f", fraction)
    return b"ODISREFS" + struct.pack("<III", 2, len(inputs), len(layers)) + data


def main():
    p = argparse.ArgumentParser(description=__doc__)
    p.add_argument("checkpoint", help="odis.pt of train.py")
    p.add_argument("-o", "--output", required=True, help="weights file, e.g. weights/odis.bin")
    p.add_argument("--reference", help="also write reference tensors to this file")
    p.add_argument("--data", help="file of fewray-odis-data, or of synthetic.py, for their inputs")
    p.add_argument("--maps", type=int, default=1, help="in the references")
    args = p.parse_args()
    state = torch.load(args.checkpoint, weights_only=True)
    model = Odis().eval()
    model.load_state_dict({k: v.half().float() for k, v in state["average"].items()})
    settings = state["settings"]
    info = {"network": "odis", "map": "mean" if settings["loss"] == "l1" else "moment",
            "drop": settings["drop"],  # planes that the network was trained without
            "bsdf_fraction": settings["bsdf_fraction"],  # null: the network's own, for each map
            "steps": state["steps"], "settings": settings,
            "validation": {k: round(v, 5) for k, v in state["figures"].items()}}
    write_whole(args.output, container(weight_tensors(model), info))
    if args.reference:
        if not args.data:
            raise SystemExit("--reference needs --data")
        records = dataset.open_records(args.data)
        chosen = records[np.linspace(0, len(records) - 1, args.maps).astype(int)]
        inputs = torch.from_numpy(chosen["input"].astype(np.float32))
        write_whole(args.reference, references(model, inputs, settings))


if __name__ == "__main__":
    main()
