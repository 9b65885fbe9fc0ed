"""The colours of a character's surfaces at its points, from its textures; pictures are decoded by Pillow."""

from __future__ import annotations

import io
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from phonanim.core.decode import DAMAGE
from phonanim.media.glb import Glb

Array = NDArray[np.float64]

LARGEST = 8192 * 8192  # pixels of a texture
SIDE = 1024  # pixels to which a texture is reduced: points are farther apart


def texture_colors(glb: Glb, primitive: dict[str, Any], count: int) -> Array | None:
    """(count, 3) linear: the base colour of a primitive's texture at its points.

    None without a texture, where it is outside the file or damaged, or without Pillow.
    """
    try:
        material = glb.tree["materials"][primitive["material"]]
        surface = material.get("pbrMetallicRoughness", {})
        texture = surface["baseColorTexture"]
        picture = _picture(glb, glb.tree["textures"][texture["index"]]["source"])
        places = glb.accessor(primitive["attributes"][f"TEXCOORD_{texture.get('texCoord', 0)}"])
        if picture is None or places.shape != (count, 2) or not np.isfinite(places).all():
            return None
        size = np.array(picture.shape[1::-1])
        across, down = np.minimum((places % 1.0) * size, size - 1).astype(int).T
        return picture[down, across] * np.asarray(surface.get("baseColorFactor", (1.0, 1.0, 1.0)), float)[:3]
    except DAMAGE:
        return None


def _picture(glb: Glb, number: int) -> Array | None:
    """A picture of the file as linear light, (height, width, 3)."""
    image = glb.tree["images"][number]
    if "bufferView" not in image:
        return None
    view = glb.tree["bufferViews"][image["bufferView"]]
    if view.get("buffer", 0) != 0:
        return None
    first = view.get("byteOffset", 0)
    return decode_picture(glb.binary[first : first + view["byteLength"]])


@lru_cache(maxsize=8)
def decode_picture(data: bytes) -> Array | None:
    """A PNG, JPEG or WebP as linear light, (height, width, 3), reduced to SIDE; None if it cannot be read."""
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        return None
    try:
        with Image.open(io.BytesIO(data), formats=("PNG", "JPEG", "WEBP")) as picture:
            if picture.width * picture.height > LARGEST:
                return None
            picture.draft("RGB", (SIDE, SIDE))
            small = picture.convert("RGB")
        small.thumbnail((SIDE, SIDE))
    except (UnidentifiedImageError, OSError, SyntaxError, Image.DecompressionBombError, *DAMAGE):
        return None
    light = np.asarray(small, float) / 255
    return np.where(light <= 0.04045, light / 12.92, ((light + 0.055) / 1.055) ** 2.4)
