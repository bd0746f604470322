#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders Mitsuba's own Cornell box with AOVs.

make_mitsuba.py OUT.exr SIZE SPP aovs|moments
moments: the aov integrator inside the moment integrator.
"""
import sys
import mitsuba as mi

mi.set_variant("scalar_rgb")
out, size, spp, moments = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), sys.argv[4] == "moments"
scene = mi.cornell_box()
scene["sensor"]["film"].update({"width": size, "height": size, "pixel_format": "rgba"})
scene["sensor"]["film"]["rfilter"] = {"type": "box"}
few = "albedo:albedo,nn:sh_normal,dd.y:depth"
aov = {"type": "aov", "aovs": few if moments else few + ",pos:position,uv:uv,shape:shape_index",
       "img": {"type": "path", "max_depth": 6}}
scene["integrator"] = {"type": "moment", "nested": aov} if moments else aov
film = mi.load_dict(scene)
mi.render(film, spp=spp, seed=1)
film.sensors()[0].film().bitmap().write(out)
