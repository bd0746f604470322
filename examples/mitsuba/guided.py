# SPDX-License-Identifier: Apache-2.0
"""Mitsuba 3's path tracer, guided by fewray: the integrator `fewray_guided`.

One sample a pixel is a first look whose bounces are uniform over the hemisphere; fewray's network, which was never
trained for Mitsuba, makes sampling maps and probes of it; the other samples follow them. Scenes, materials, emitters
and light sampling stay Mitsuba's own. Use it like `path`, with the same max_depth, rr_depth and hide_emitters:

    import mitsuba as mi
    mi.set_variant("llvm_ad_rgb")                # any vectorised variant of RGB
    import guided                                # registers the integrator
    integrator = mi.load_dict({"type": "fewray_guided", "max_depth": 8})
    image = integrator.render(scene, spp=4)      # a tensor (height, width, 3), linear RGB, box filter

Further parameters: `guided` (True; False: the same path tracer without a guide), `keep_look` (True: the look's sample counts
by the weight that the maps give it; Bako et al. 2019 discard it) and `later` (True: probes guide the second vertex).
"""

import drjit as dr
import fewray
import mitsuba as mi
import numpy as np

LOOK_PDF = 1 / (2 * np.pi)  # solid angle: FEWRAY_LOOK_PDF of fewray/guiding.h


def power_heuristic(pdf, other):
    """Veach 1997, eq. 9.13."""
    return dr.select(pdf > 0, pdf * pdf / (pdf * pdf + other * other), 0)


def rows(vectors):
    """Vectors of Dr.Jit as a numpy array (count, components)."""
    return np.array(dr.ravel(vectors), dtype=np.float32).reshape(-1, len(vectors))


def column(values):
    return np.array(values, dtype=np.float32)


class Vertex:
    """A surface point on a path, and what is asked of Mitsuba there."""

    def __init__(self, scene, si, active):
        self.scene, self.si, self.active = scene, si, active
        self.context = mi.BSDFContext()
        self.bsdf = si.bsdf()
        flags = self.bsdf.flags()
        self.smooth = active & mi.has_flag(flags, mi.BSDFFlags.Smooth)
        # Maps and probes know one side of a surface and no lobes: what is diffuse is guided, half of what also shines.
        diffuse = mi.has_flag(flags, mi.BSDFFlags.DiffuseReflection)
        passes = mi.has_flag(flags, mi.BSDFFlags.Transmission)
        shines = mi.has_flag(flags, mi.BSDFFlags.GlossyReflection) | mi.has_flag(flags, mi.BSDFFlags.DeltaReflection)
        self.breadth = dr.select(self.smooth & diffuse & ~passes, dr.select(shines, mi.Float(0.5), mi.Float(1)), 0)
        self.normal = dr.select(dr.dot(si.sh_frame.n, si.to_world(si.wi)) < 0, -si.sh_frame.n, si.sh_frame.n)

    def evaluate(self, direction, active):
        """f * |cos| and the BSDF's density (solid angle) of a direction in world space."""
        return self.bsdf.eval_pdf(self.context, self.si, self.si.to_local(direction), active)

    def sample_light(self, sampler):
        return self.scene.sample_emitter_direction(self.si, sampler.next_2d(), True, self.smooth)

    def light_pdf(self, hit, active):
        """Density (solid angle) with which sample_light() draws the direction that ended at `hit`."""
        sample = mi.DirectionSample3f(self.scene, hit, self.si)
        return self.scene.pdf_emitter_direction(self.si, sample, active)


class Proposal:
    """What a vertex's next direction is drawn from: its BSDF and the guide (fewray/guiding.h). guide None: the BSDF;
    pixels None: a later vertex."""

    def __init__(self, vertex, guide, pixels, last, sampler):
        self.vertex, self.guide, self.pixels, self.last = vertex, guide, pixels, last
        self.fraction = mi.Float(1)
        u = mi.Point2f(sampler.next_2d())
        if guide is None:
            return
        dr.eval(vertex.si, vertex.normal, vertex.breadth, u)
        self.position, self.normal = rows(vertex.si.p), rows(vertex.normal)
        if pixels is not None:
            direction, _, fraction = guide.first_sample(pixels, self.position, self.normal, rows(u))
        else:
            direction, _, fraction = guide.later_sample(self.position, self.normal, rows(u), last=last)
        self.drawn = dr.unravel(mi.Vector3f, mi.Float(direction.ravel()))
        self.fraction = 1 - (1 - mi.Float(fraction)) * vertex.breadth

    def guide_pdf(self, direction):
        dr.eval(direction)
        if self.pixels is not None:
            pdf, _ = self.guide.first_pdf(self.pixels, self.position, self.normal, rows(direction))
        else:
            pdf, _ = self.guide.later_pdf(self.position, self.normal, rows(direction), last=self.last)
        return mi.Float(pdf)

    def mixture(self, bsdf_pdf, direction):
        if self.guide is None:
            return bsdf_pdf
        return self.fraction * bsdf_pdf + (1 - self.fraction) * self.guide_pdf(direction)

    def light(self, sampler):
        """What light sampling finds, weighed against the mixture."""
        v = self.vertex
        sample, radiance = v.sample_light(sampler)
        active = v.smooth & (sample.pdf != 0)
        value, bsdf_pdf = v.evaluate(sample.d, active)
        other = self.mixture(bsdf_pdf, sample.d)
        weight = dr.select(sample.delta, 1, power_heuristic(sample.pdf, other))
        return dr.select(active, value * radiance * weight, 0)

    def sample(self, sampler):
        """direction (world space), weight, density (solid angle), relative eta and whether it is perfectly specular."""
        v = self.vertex
        choice = sampler.next_1d()
        sample, weight = v.bsdf.sample(v.context, v.si, sampler.next_1d(), sampler.next_2d(), v.active)
        direction = v.si.to_world(sample.wo)
        delta = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta)
        eta, pdf = mi.Float(sample.eta), mi.Float(sample.pdf)
        if self.guide is not None:
            guided = choice >= self.fraction
            direction = dr.select(guided, self.drawn, direction)
            eta, delta = dr.select(guided, 1, eta), delta & ~guided
            value, bsdf_pdf = v.evaluate(direction, v.active & ~delta)
            mixture = self.mixture(bsdf_pdf, direction)
            weight = dr.select(delta, weight / self.fraction,
                               dr.select(mixture > 0, value / mixture, 0))
            pdf = dr.select(delta, pdf, mixture)
        return direction, dr.select(v.active, weight, 0), pdf, eta, delta


class Guided(mi.SamplingIntegrator):
    def __init__(self, props):
        super().__init__(props)
        self.max_depth = props.get("max_depth", -1)
        self.max_depth = 0xffffffff if self.max_depth < 0 else self.max_depth
        self.rr_depth = props.get("rr_depth", 5)
        self.hide_emitters = props.get("hide_emitters", False)
        self.guided = props.get("guided", True)
        self.keep_look = props.get("keep_look", True)
        self.later = props.get("later", True)

    def aov_names(self):
        return []

    def to_string(self):
        return f"fewray_guided[max_depth={self.max_depth}, guided={self.guided}]"

    def render(self, scene, sensor=0, seed=0, spp=0, develop=True, evaluate=True):
        sensor = scene.sensors()[sensor] if isinstance(sensor, int) else sensor
        self.size = sensor.film().crop_size()
        spp = spp or sensor.sampler().sample_count()
        if not self.guided:
            mean = sum(self.trace(scene, sensor, int(seed) * 4096 + k, None) for k in range(spp)) / spp
        elif spp < 2:
            raise ValueError("fewray_guided: give 2 samples a pixel or more: the first one is the look")
        else:
            guide, look = self.look(scene, sensor, int(seed) * 4096)
            mean = sum(self.trace(scene, sensor, int(seed) * 4096 + k, guide) for k in range(1, spp)) / (spp - 1)
            if self.keep_look:
                share = guide.look_weights(spp - 1).reshape(-1, 1)
                mean = share * look + (1 - share) * mean
        return mi.TensorXf(mean.ravel(), (int(self.size.y), int(self.size.x), 3))

    def start(self, scene, sensor, seed):
        """A ray for each pixel: the sampler, pixels (count, 2) and what follow() gives."""
        width, height = int(self.size.x), int(self.size.y)
        sampler = mi.load_dict({"type": "independent"})
        sampler.seed(seed, width * height)
        index = dr.arange(mi.UInt32, width * height)
        place = mi.Vector2f(index % width, index // width)
        ray, weight = sensor.sample_ray(0, sampler.next_1d(), (place + sampler.next_2d()) / mi.Vector2f(width, height),
                                        sampler.next_2d())
        pixels = np.stack([np.arange(width * height) % width, np.arange(width * height) // width], 1).astype(np.int32)
        return (sampler, pixels) + self.follow(scene, sampler, ray, mi.Spectrum(weight))

    @dr.syntax
    def follow(self, scene, sampler, ray, throughput):
        """Follows camera rays past perfectly specular surfaces: what shines there, the first vertex that scatters (if
        any), the throughput, the depth (vertices before it), eta, and the way to it."""
        ray, throughput = mi.Ray3f(ray), mi.Spectrum(throughput)
        radiance, eta, way = mi.Spectrum(0), mi.Float(1), mi.Float(0)
        depth, active, found = mi.UInt32(0), mi.Bool(True), mi.Bool(False)
        last = mi.Ray3f(ray)
        context = mi.BSDFContext()
        while active:
            si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
            last = mi.Ray3f(ray)
            shown = (depth > 0) | (not self.hide_emitters)
            radiance += dr.select(active & shown, throughput * si.emitter(scene).eval(si, active), 0)
            way += dr.select(si.is_valid(), si.t, 0)
            active &= si.is_valid() & (depth + 1 < self.max_depth)
            bsdf = si.bsdf(ray)
            found = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            active &= ~found
            sample, weight = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d(), active)
            throughput = dr.select(active, throughput * weight, throughput)
            eta = dr.select(active, eta * sample.eta, eta)
            ray = si.spawn_ray(si.to_world(sample.wo))
            depth = dr.select(active, depth + 1, depth)
            active &= dr.any(throughput != 0)
        si = scene.ray_intersect(last, mi.RayFlags.All, False, found)
        return radiance, Vertex(scene, si, found & si.is_valid()), throughput, depth, eta, way

    def trace(self, scene, sensor, seed, guide):
        """One sample of each pixel: radiance (count, 3)."""
        sampler, pixels, radiance, vertex, throughput, depth, eta, _ = self.start(scene, sensor, seed)
        guides = [guide, guide if self.later else None]
        for k, here in enumerate(guides if guide else []):
            last = k > 0 and self.max_depth <= 3
            proposal = Proposal(vertex, here, pixels if k == 0 else None, last, sampler)
            radiance += throughput * proposal.light(sampler)
            direction, weight, pdf, step, delta = proposal.sample(sampler)
            ray = vertex.si.spawn_ray(direction)
            throughput, eta = throughput * weight, eta * step
            active = vertex.active & dr.any(throughput != 0)
            hit = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
            emission = hit.emitter(scene).eval(hit, active)
            other = vertex.light_pdf(hit, active & ~delta)
            radiance += dr.select(active, throughput * emission * dr.select(delta, 1, power_heuristic(pdf, other)), 0)
            depth += 1
            vertex = Vertex(scene, hit, active & hit.is_valid() & (depth + 1 < self.max_depth))
            dr.eval(radiance, throughput, eta, depth, vertex.si, vertex.active)
        radiance += throughput * self.reflected(scene, sampler, vertex.si, vertex.active, depth, eta)
        return np.nan_to_num(rows(radiance), nan=0, posinf=0, neginf=0)

    @dr.syntax
    def reflected(self, scene, sampler, si, active, depth, eta):
        """Radiance that surfaces reflect towards where they are seen from, by Mitsuba's own path tracing (as its `path`:
        multiple importance sampling of BSDF and light, Russian roulette from rr_depth on)."""
        si, active = mi.SurfaceInteraction3f(si), mi.Bool(active)
        depth, eta = mi.UInt32(depth), mi.Float(eta)
        radiance, throughput = mi.Spectrum(0), mi.Spectrum(1)
        context = mi.BSDFContext()
        while active:
            bsdf = si.bsdf()
            smooth = active & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth)
            light, incident = scene.sample_emitter_direction(si, sampler.next_2d(), True, smooth)
            smooth &= light.pdf != 0
            value, pdf = bsdf.eval_pdf(context, si, si.to_local(light.d), smooth)
            weight = dr.select(light.delta, 1, power_heuristic(light.pdf, pdf))
            radiance += dr.select(smooth, throughput * value * incident * weight, 0)

            sample, factor = bsdf.sample(context, si, sampler.next_1d(), sampler.next_2d(), active)
            throughput *= factor
            eta *= sample.eta
            active &= dr.any(throughput != 0)
            hit = scene.ray_intersect(si.spawn_ray(si.to_world(sample.wo)), mi.RayFlags.All, False, active)
            delta = mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta)
            other = scene.pdf_emitter_direction(si, mi.DirectionSample3f(scene, hit, si), active & ~delta)
            emission = hit.emitter(scene).eval(hit, active)
            radiance += dr.select(active, throughput * emission *
                                  dr.select(delta, 1, power_heuristic(sample.pdf, other)), 0)
            si = hit
            depth += 1
            active &= hit.is_valid() & (depth + 1 < self.max_depth)

            survival = dr.minimum(dr.max(throughput) * eta * eta, 0.95)
            roulette = depth >= self.rr_depth
            throughput = dr.select(roulette & active, throughput / survival, throughput)
            active &= ~roulette | (sampler.next_1d() < survival)
        return radiance

    def look(self, scene, sensor, seed):
        """The first look: the guide that it makes, and its own sample of each pixel (count, 3)."""
        sampler, pixels, radiance, first, throughput, depth, eta, way = self.start(scene, sensor, seed)
        looked = first.smooth & (first.breadth > 0)
        direction, weight, pdf, step, delta, light = self.look_bounce(first, looked, seed, sampler)
        radiance += throughput * light
        hit = scene.ray_intersect(first.si.spawn_ray(direction), mi.RayFlags.All, False, first.active)
        emission = dr.select(first.active, hit.emitter(scene).eval(hit, first.active), 0)
        other = first.light_pdf(hit, first.active & ~delta)
        second = Vertex(scene, hit, first.active & hit.is_valid() & (depth + 2 < self.max_depth))
        reflected, notes = self.look_on(scene, sampler, second, depth + 1, eta * step)
        radiance += throughput * weight * (emission * dr.select(delta, 1, power_heuristic(pdf, other)) + reflected)
        looked &= ~delta
        there = hit.is_valid()
        dr.eval(radiance, looked, direction, emission, other, reflected, notes, there, second.normal)
        count = len(pixels)
        shape, size = (int(self.size.y), int(self.size.x), 1), (int(self.size.y), int(self.size.x), 1, 3)
        grey = {name: np.broadcast_to(column(v), count).reshape(shape) for name, v in {
            "depth": dr.select(looked, way, 0), "light_pdf": dr.select(delta, 0, other),
            "distance": dr.select(there, hit.t, 0), **{k: v for k, v in notes.items() if "value" in k or "albedo" in k},
        }.items()}
        vectors = {name: rows(v).reshape(size) for name, v in {
            "position": first.si.p, "normal": first.normal, "direction": direction, "emitted": emission,
            "reflected": reflected, "second_normal": second.normal, "second_light": notes["second_light"],
            "second_bounce": notes["second_bounce"]}.items()}
        return fewray.Guide(**grey, **vectors), np.nan_to_num(rows(radiance), nan=0, posinf=0, neginf=0)

    def look_bounce(self, first, looked, seed, sampler):
        """A direction uniform over the hemisphere where the guide is to learn, the BSDF's elsewhere, as Proposal.sample(),
        and what light sampling adds."""
        size = (int(self.size.y), int(self.size.x), 1, 3)
        even = fewray.look_directions(rows(first.normal).reshape(size), seed)
        plain, weight, pdf, eta, delta = Proposal(first, None, None, False, sampler).sample(sampler)
        direction = dr.select(looked, dr.unravel(mi.Vector3f, mi.Float(even.ravel())), plain)
        value, _ = first.evaluate(direction, looked)
        sample, radiance = first.sample_light(sampler)
        lit, bsdf_pdf = first.evaluate(sample.d, first.smooth & (sample.pdf != 0))
        other = dr.select(looked, LOOK_PDF, bsdf_pdf)
        light = lit * radiance * dr.select(sample.delta, 1, power_heuristic(sample.pdf, other))
        light = dr.select(first.smooth & (sample.pdf != 0), light, 0)
        return (direction, dr.select(looked, value / LOOK_PDF, weight), dr.select(looked, LOOK_PDF, pdf),
                dr.select(looked, 1, eta), delta & ~looked, light)

    def look_on(self, scene, sampler, second, depth, eta):
        """One estimate of what the second vertex reflects, and what its own two samples found (struct
        fewray_guide_look)."""
        sample, radiance = second.sample_light(sampler)
        drawn = second.smooth & (sample.pdf != 0)
        value, pdf = second.evaluate(sample.d, drawn)
        weight = dr.select(sample.delta, 1, power_heuristic(sample.pdf, pdf))
        reflected = dr.select(drawn, value * radiance * weight, 0)
        notes = {"second_albedo": dr.select(second.smooth, dr.mean(second.bsdf.eval_diffuse_reflectance(
                     second.si, second.smooth)), 0),
                 "second_light": sample.d, "second_light_value": dr.select(
                     drawn & ~sample.delta, dr.mean(radiance) * sample.pdf / (sample.pdf + pdf), -1)}

        direction, factor, pdf, step, delta = Proposal(second, None, None, False, sampler).sample(sampler)
        active = second.active & dr.any(factor != 0)
        hit = scene.ray_intersect(second.si.spawn_ray(direction), mi.RayFlags.All, False, active)
        emission = dr.select(active, hit.emitter(scene).eval(hit, active), 0)
        other = second.light_pdf(hit, active & ~delta)
        beyond = self.reflected(scene, sampler, hit, active & hit.is_valid() & (depth + 2 < self.max_depth),
                                depth + 1, eta * step)
        reflected += factor * (emission * dr.select(delta, 1, power_heuristic(pdf, other)) + beyond)
        notes["second_bounce"] = direction
        notes["second_bounce_value"] = dr.select(
            active & ~delta, dr.mean(emission) / (other + pdf) + dr.mean(beyond) / pdf, 0)
        return reflected, notes


mi.register_integrator("fewray_guided", lambda props: Guided(props))
