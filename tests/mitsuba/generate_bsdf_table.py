#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Writes what Mitsuba's BSDFs evaluate to, for tests/unit/test_bsdf_*.c. Needs mitsuba 3.9 (PyPI)
and numpy; the seed is fixed, so that a second run writes the same table.

    python3 tests/mitsuba/generate_bsdf_table.py tests/data/mitsuba/bsdf.json

textures {file: width, height, rgb (8 bits)}; dp_du, dp_dv of all points; points: outgoing (3,
local), incident (3), u, v of each; configurations: a name, a Mitsuba XML element, values (f |cos|
as RGB, pdf) at each point, specular (point, incident (3), weight (3), discrete pdf, eta; each
direction once), whether Mitsuba's values are reciprocal (see reciprocity()), and whether the
material loses nothing."""
import sys
import tempfile
from pathlib import Path

import mitsuba as mi
import numpy as np

from table import row, text, unit, write

mi.set_variant("scalar_rgb")

DP_DU, DP_DV = (1.5, 0, 0), (0, 0.7, 0)
CONTEXT = mi.BSDFContext()
TEXTURE_SIZE = 4


def refracted(wi, eta):
    """Through a flat surface whose inside has the index eta."""
    ratio = 1 / eta if wi[2] > 0 else eta
    sine = ratio * np.hypot(wi[0], wi[1])
    if sine >= 1:
        return wi * [-1, -1, 1]
    return np.array([-ratio * wi[0], -ratio * wi[1], -np.sign(wi[2]) * np.sqrt(1 - sine ** 2)])


def make_points(rng):
    """Random pairs, and pairs about the mirrored and the refracted direction, from both sides."""
    def upper():
        v = unit(rng.normal(size=3))
        return unit([v[0], v[1], abs(v[2]) + 0.05])

    def near(v, spread):
        return unit(v + spread * rng.normal(size=3))

    points = []
    for i in range(26):
        wi = upper()
        if i < 7:
            wo = upper()
        elif i < 12:
            wo = near(wi * [-1, -1, 1], (0.02, 0.05, 0.1, 0.2, 0.3)[i - 7])
        elif i < 17:
            wo = near(refracted(wi, 1.5), (0.02, 0.05, 0.1, 0.2, 0.3)[i - 12])
        else:
            wi = wi * [1, 1, -1]
            wo = (upper() * [1, 1, -1], near(wi * [-1, -1, 1], 0.1), near(refracted(wi, 1.5), 0.1),
                  near(refracted(wi, 1.5), 0.3), upper())[i % 5]
        points.append((wi, wo, *rng.random(2)))
    points.append((unit([0.9, 0.3, 0.05]), unit([-0.9, 0.2, 0.08]), 0.3, 0.6))  # grazing
    points.append((unit([0, 0, 1]), unit([0, 0, 1]), 0.1, 0.2))
    return points


def interaction(wi, u, v):
    si = mi.SurfaceInteraction3f()
    si.t = 1
    si.n = [0, 0, 1]
    si.uv = [u, v]
    si.dp_du, si.dp_dv = DP_DU, DP_DV
    si.sh_frame = mi.Frame3f([0, 0, 1])
    si.initialize_sh_frame()
    si.wi = wi
    return si


def bsdf(kind, *parts):
    return f"<bsdf type='{kind}'>{''.join(parts)}</bsdf>"


def number(name, value):
    return f"<float name='{name}' value='{value}'/>"


def rgb(name, r, g, b):
    return f"<rgb name='{name}' value='{r}, {g}, {b}'/>"


def string(name, value):
    return f"<string name='{name}' value='{value}'/>"


def flag(name, value):
    return f"<boolean name='{name}' value='{str(value).lower()}'/>"


def bitmap(name, file):
    return (f"<texture type='bitmap' name='{name}'><string name='filename' value='{file}'/>"
            "<boolean name='raw' value='true'/></texture>")


def numbers(**values):
    return "".join(number(name, value) for name, value in values.items())


RED = rgb("reflectance", 0.7, 0.3, 0.1)
BASE = rgb("base_color", 0.8, 0.4, 0.2)
DIFFUSE_RED = rgb("diffuse_reflectance", 0.7, 0.3, 0.1)
NO_LOSS = {"white", "mirror", "dielectric", "dielectric-ratio", "thin"}


def principled(**values):
    return bsdf("principled", BASE, numbers(**values))


def configurations():
    copper = string("material", "Cu")
    for distribution in ("beckmann", "ggx"):
        d = string("distribution", distribution)
        for alpha in (0.05, 0.2, 0.6):
            yield (f"roughconductor-{distribution}-{alpha}",
                   bsdf("roughconductor", copper, d, number("alpha", alpha)))
        yield (f"roughconductor-{distribution}-anisotropic",
               bsdf("roughconductor", copper, d, numbers(alpha_u=0.1, alpha_v=0.4)))
        for alpha in (0.1, 0.4):
            yield (f"roughdielectric-{distribution}-{alpha}",
                   bsdf("roughdielectric", d, number("alpha", alpha), numbers(int_ior=1.5)))
        yield (f"roughplastic-{distribution}",
               bsdf("roughplastic", d, number("alpha", 0.15), DIFFUSE_RED))
    yield "white", bsdf("diffuse", rgb("reflectance", 1, 1, 1))
    yield "red", bsdf("diffuse", RED)
    yield "twosided", bsdf("twosided", bsdf("diffuse", RED))
    yield ("twosided-two", bsdf("twosided", bsdf("diffuse", RED), bsdf(
        "roughconductor", numbers(alpha_u=0.2, alpha_v=0.5))))
    yield "plastic", bsdf("plastic", DIFFUSE_RED)
    yield ("plastic-nonlinear", bsdf("plastic", DIFFUSE_RED, flag("nonlinear", True),
                                     number("int_ior", 1.9), rgb("specular_reflectance", .9, .8, 1)))
    yield ("roughplastic-nonlinear", bsdf("roughplastic", DIFFUSE_RED, flag("nonlinear", True),
                                          number("alpha", 0.3), number("int_ior", 1.3)))
    yield "mirror", bsdf("conductor", string("material", "none"))
    yield "copper", bsdf("conductor", copper)
    yield ("conductor-eta-k", bsdf("conductor", rgb("eta", 0.2, 0.9, 1.1), rgb("k", 3.9, 2.4, 2.1),
                                   rgb("specular_reflectance", 0.5, 1, 0.7)))
    yield "dielectric", bsdf("dielectric")
    yield "dielectric-ratio", bsdf("dielectric", numbers(int_ior=1.33, ext_ior=1.5))
    yield ("dielectric-tinted", bsdf("dielectric", string("int_ior", "diamond"),
                                     rgb("specular_reflectance", 0.9, 0.5, 0.2),
                                     rgb("specular_transmittance", 0.3, 0.6, 0.9)))
    yield "thin", bsdf("thindielectric")
    yield ("roughdielectric-ratio", bsdf(
        "roughdielectric", string("distribution", "ggx"), numbers(alpha=0.25, int_ior=1, ext_ior=1.4),
        rgb("specular_transmittance", 0.3, 0.6, 0.9)))
    yield "mask", bsdf("mask", number("opacity", 0.3), bsdf("diffuse", RED))
    yield "mask-mirror", bsdf("mask", number("opacity", 0.6), bsdf("conductor"))
    yield ("blend", bsdf("blendbsdf", number("weight", 0.4), bsdf("diffuse", RED),
                         bsdf("roughconductor", number("alpha", 0.3))))
    yield ("blend-plastic", bsdf("blendbsdf", number("weight", 0.7), bsdf("diffuse", RED),
                                 bsdf("roughplastic", DIFFUSE_RED, number("alpha", 0.2))))
    height, normal = bitmap("height", "height.png"), bitmap("normalmap", "normal.png")
    rough = bsdf("roughconductor", numbers(alpha_u=0.3, alpha_v=0.5))
    plain = flag("flip_invalid_normals", False) + flag("use_shadowing_function", False)
    for name, inside in (("diffuse", bsdf("diffuse", RED)), ("rough", rough),
                         ("glass", bsdf("roughdielectric", number("alpha", 0.4))),
                         ("twosided", bsdf("twosided", bsdf("diffuse", RED)))):
        yield f"bumpmap-{name}", bsdf("bumpmap", height, number("scale", 0.4), inside)
        yield f"normalmap-{name}", bsdf("normalmap", normal, inside)
    yield "twosided-bumpmap", bsdf("twosided", bsdf("bumpmap", height, number("scale", 0.4), rough))
    yield "twosided-normalmap", bsdf("twosided", bsdf("normalmap", normal, rough))
    yield "bumpmap-plain", bsdf("bumpmap", height, number("scale", 0.4), plain, rough)
    yield "normalmap-plain", bsdf("normalmap", normal, plain, rough)
    yield "normalmap-mirror", bsdf("normalmap", normal, bsdf("conductor"))
    yield "principled", principled()
    yield "principled-metal", principled(metallic=1, roughness=0.3)
    yield "principled-anisotropic", principled(metallic=0.7, roughness=0.4, anisotropic=0.8)
    yield "principled-glass", principled(spec_trans=1, roughness=0.3, eta=1.5)
    yield "principled-half-glass", principled(spec_trans=0.5, roughness=0.4, eta=1.33, metallic=0.2)
    yield "principled-clearcoat", principled(clearcoat=0.8, clearcoat_gloss=0.6, roughness=0.6)
    yield "principled-sheen", principled(sheen=0.9, sheen_tint=0.4, roughness=0.8)
    yield "principled-flat", principled(flatness=0.7, roughness=0.5, specular=0.8)
    yield "principled-tint", principled(spec_tint=0.9, specular=0.7, roughness=0.2)
    yield ("principled-all", principled(
        metallic=0.3, roughness=0.35, anisotropic=0.5, spec_trans=0.4, spec_tint=0.3, sheen=0.5,
        sheen_tint=0.6, clearcoat=0.7, clearcoat_gloss=0.3, flatness=0.4, eta=1.6))
    yield "twosided-principled", bsdf("twosided", principled(roughness=0.3, clearcoat=0.5))


def specular_samples(material, points):
    """Perfectly specular directions that sample() draws, each once."""
    rows = []
    for index, (wi, _, u, v) in enumerate(points[::4]):
        seen = []
        for choice in np.linspace(0.0005, 0.9995, 64):
            s, weight = material.sample(CONTEXT, interaction(wi, u, v), choice, [0.3, 0.6])
            if not mi.has_flag(s.sampled_type, mi.BSDFFlags.Delta) and not mi.has_flag(
                    s.sampled_type, mi.BSDFFlags.Null):
                continue
            wo = np.array(s.wo)
            if max(weight) > 0 and all(np.abs(wo - other).max() > 1e-4 for other in seen):
                seen.append(wo)
                rows.append(row(4 * index, wo, weight, s.pdf, s.eta))
    return rows


def reciprocity(material, rng):
    """Whether f(a, b) = f(b, a) on one side of the surface, and the ratio of f from in front to f
    from behind across it, which is to be the squared relative index of refraction (Veach 1997,
    equation 5.14): 0 without transmission, None where it isn't constant."""
    ratios = []
    for _ in range(60):
        a, b, (u, v) = unit(rng.normal(size=3)), unit(rng.normal(size=3)), rng.random(2)
        a = a if a[2] > 0 else -a
        ab = np.array(material.eval(CONTEXT, interaction(a, u, v), b)) / abs(b[2])
        ba = np.array(material.eval(CONTEXT, interaction(b, u, v), a)) / abs(a[2])
        if b[2] > 0 and np.abs(ab - ba).max() > 1e-3 * max(ab.max(), 1e-2):
            return False, None
        if b[2] < 0 and max(ab.max(), ba.max()) > 1e-3:
            ratios.append(ab[0] / ba[0] if ba[0] > 0 else np.inf)
    if not ratios:
        return True, 0
    return True, text(np.median(ratios)) if np.ptp(ratios) < 1e-2 * np.median(ratios) else None


def bsdf_table(folder):
    rng = np.random.default_rng(1)
    height = np.repeat(rng.integers(0, 256, (TEXTURE_SIZE, TEXTURE_SIZE, 1)), 3, 2)
    normal = rng.integers(40, 216, (TEXTURE_SIZE, TEXTURE_SIZE, 3))
    normal[..., 2] = rng.integers(160, 256, (TEXTURE_SIZE, TEXTURE_SIZE))
    textures = {"height.png": height, "normal.png": normal}
    for name, pixels in textures.items():
        mi.Bitmap(pixels.astype(np.uint8)).write(str(Path(folder) / name))
    mi.file_resolver().append(str(folder))
    points = make_points(rng)
    out = []
    for name, xml in configurations():
        material = mi.load_string(xml.replace("<bsdf ", "<bsdf version='3.0.0' ", 1))
        values = []
        for wi, wo, u, v in points:
            value, pdf = material.eval_pdf(CONTEXT, interaction(wi, u, v), wo)
            values.append(row(value, pdf))
        entry = {"name": name, "xml": xml, "values": values}
        if not name.startswith("blend"):  # whose sample() leaves the share out of the pdf
            specular = specular_samples(material, points)
            if specular:
                entry["specular"] = specular
        entry["reciprocal"], ratio = reciprocity(material, np.random.default_rng(2))
        if ratio is not None:
            entry["transmission_ratio"] = ratio
        entry["lossless"] = name in NO_LOSS
        out.append(entry)
    return {"textures": {name: {"width": TEXTURE_SIZE, "height": TEXTURE_SIZE,
                                "rgb": pixels.ravel().tolist()} for name, pixels in textures.items()},
            "dp_du": DP_DU, "dp_dv": DP_DV, "points": [row(*p) for p in points],
            "configurations": out}


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as scratch:
        write(sys.argv[1], bsdf_table(scratch))
