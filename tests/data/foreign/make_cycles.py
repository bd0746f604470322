#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Renders two boxes in a room by Cycles with passes, denoising data, Cryptomatte and metadata, as multilayer EXR.

make_cycles.py OUT.exr WIDTH HEIGHT SPP plain|denoised|groups
denoised: by Open Image Denoise, so that the noisy picture stands beside; groups: with a pass for each light group.
"""
import pathlib
import sys

import bpy


def material(name, color, emission=0.0, glossy=False):
    m = bpy.data.materials.new(name)
    m.use_nodes = True
    t = m.node_tree
    t.nodes.clear()
    out = t.nodes.new("ShaderNodeOutputMaterial")
    kind = "ShaderNodeEmission" if emission else "ShaderNodeBsdfPrincipled" if glossy else "ShaderNodeBsdfDiffuse"
    s = t.nodes.new(kind)
    s.inputs["Base Color" if glossy else "Color"].default_value = (*color, 1)
    if emission:
        s.inputs["Strength"].default_value = emission
    if glossy:
        s.inputs["Roughness"].default_value = 0.3
    t.links.new(s.outputs[0], out.inputs["Surface"])
    return m


def box(name, lo, hi, mat):
    v = [(x, y, z) for x in (lo[0], hi[0]) for y in (lo[1], hi[1]) for z in (lo[2], hi[2])]
    f = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(v, [], f)
    mesh.materials.append(mat)
    o = bpy.data.objects.new(name, mesh)
    bpy.context.collection.objects.link(o)
    return o


out, width, height, spp, mode = sys.argv[1], int(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]
bpy.ops.wm.read_factory_settings(use_empty=True)
white, red, green = material("white", (.7, .7, .7)), material("red", (.6, .05, .05)), material("green", (.1, .5, .1))
gloss = material("gloss", (.3, .4, .7), glossy=True)
box("floor", (-1, -1, -.05), (1, 1, 0), white)
box("back", (-1, 1, 0), (1, 1.05, 1.7), white)
box("left", (-1.05, -1, 0), (-1, 1, 2), red)
box("right", (1, -1, 0), (1.05, 1, 2), green)
tall = box("tall", (-.6, .1, 0), (-.05, .65, 1.2), gloss)
box("short", (.1, -.5, 0), (.65, .05, .6), white)
lamp = box("lamp", (-.25, -.25, 1.97), (.25, .25, 1.99), material("lamp", (1, 1, 1), 15))
lamp.lightgroup = "lamp"
cam = bpy.data.cameras.new("cam")
cam.angle = 0.63
o = bpy.data.objects.new("cam", cam)
o.location = (0, -4.8, 1)
o.rotation_euler = (1.5707963, 0, 0)
bpy.context.collection.objects.link(o)
s = bpy.context.scene
s.camera = o
s.render.engine = "CYCLES"
s.render.resolution_x, s.render.resolution_y = width, height
s.render.resolution_percentage = 100
s.world = bpy.data.worlds.new("sky")
s.world.use_nodes = True
s.world.node_tree.nodes["Background"].inputs[0].default_value = (.05, .1, .2, 1)
s.world.lightgroup = "sky"
c = s.cycles
c.device, c.seed, c.samples = "CPU", 1, spp
c.use_adaptive_sampling = False
c.sample_clamp_direct = c.sample_clamp_indirect = 0
c.blur_glossy = 0
c.pixel_filter_type = "BOX"
c.use_denoising = mode == "denoised"
c.max_bounces = 3
layer = bpy.context.view_layer
layer.use_pass_z = layer.use_pass_normal = layer.use_pass_vector = True
layer.use_pass_emit = layer.use_pass_environment = True
layer.cycles.denoising_store_passes = True
for lobe in ("diffuse", "glossy", "transmission"):
    for part in ("direct", "indirect", "color"):
        setattr(layer, f"use_pass_{lobe}_{part}", True)
layer.use_pass_cryptomatte_object = True
layer.pass_cryptomatte_depth = 2
if mode == "groups":
    for name in ("lamp", "sky"):
        with bpy.context.temp_override(scene=s, view_layer=layer):
            bpy.ops.scene.view_layer_add_lightgroup(name=name)
s.render.use_stamp_note = True
s.render.stamp_note_text = "two boxes"
f = s.render.image_settings
if bpy.app.version >= (5, 0, 0):
    f.media_type = "MULTI_LAYER_IMAGE"
f.file_format, f.color_depth, f.exr_codec = "OPEN_EXR_MULTILAYER", "16", "ZIP"
s.render.filepath = str(pathlib.Path(out).absolute())
bpy.ops.render.render(write_still=True)
