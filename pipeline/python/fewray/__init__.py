# SPDX-License-Identifier: Apache-2.0
"""fewray: pictures of a few paths a pixel, on CPUs.

    fewray.denoise(color, albedo, normal)    noisy arrays -> a clean one
    fewray.render("scene.xml", spp=4)        a scene file -> a Frame of layers
    fewray.compare(test, reference)          error of a picture
    fewray.read(path), fewray.write(...)     EXR files
    fewray.Guide(...)                        sampling maps for another renderer
"""

from ._compare import Metrics, compare
from ._denoise import Denoiser, denoise
from ._frame import Frame, read, write
from ._guide import Guide, look_directions
from ._library import Error
from ._library import version as _version
from ._render import render

__version__ = _version()
__all__ = ["Denoiser", "Error", "Frame", "Guide", "Metrics", "compare", "denoise", "look_directions", "read", "render", "write"]
