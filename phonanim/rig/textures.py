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
Picture = NDArray[np.uint8]

LARGEST = 8192 * 8192  # pixels of a texture; of WebP, which takes twice the memory, half
AT_FULL_SIZE, MOST = 12, 64  # pictures that may have so many, where there are more each fewer; pictures
SOLID = 0.5  # alpha from which a surface is drawn
SIDE = 1024  # pixels to which a texture is reduced: points are farther apart


def texture_colors(glb: Glb, primitive: dict[str, Any], count: int) -> Array | None:
    """(count, 3) linear: the base colour of a primitive's texture at its points.

    None without a texture, where it is outside the file or damaged, or without Pillow.
    """
    try:
        surface = glb.tree["materials"][primitive["material"]].get("pbrMetallicRoughness", {})
        found = _texture(glb, primitive, count)
        if found is None:
            return None
        picture, places = found
        factor = np.asarray(surface.get("baseColorFactor", (1.0, 1.0, 1.0)), float)[:3]
        return _sampled(picture, places)[:, :3] * factor
    except DAMAGE:
        return None


def seen_faces(
    glb: Glb, primitive: dict[str, Any], faces: NDArray[np.int64], count: int
) -> NDArray[np.bool_]:
    """Which triangles are more solid than clear, (t,): glass and the empty parts of textures are not.

    Those of a material that is opaque, or whose texture cannot be read, are.
    """
    all_seen = np.ones(len(faces), bool)
    try:
        material = glb.tree["materials"][primitive["material"]] if "material" in primitive else {}
        mode = material.get("alphaMode", "OPAQUE")
        if mode not in ("BLEND", "MASK"):
            return all_seen
        least = float(material.get("alphaCutoff", SOLID)) if mode == "MASK" else SOLID
        factor = material.get("pbrMetallicRoughness", {}).get("baseColorFactor", (1.0,) * 4)[3]
        found = _texture(glb, primitive, count)
        if found is None:
            return all_seen & (factor >= least)
        picture, places = found
        corners = places[faces]
        spots = np.concatenate([corners, corners.mean(axis=1, keepdims=True)], axis=1)
        alpha = _sampled(picture, spots.reshape(-1, 2))[:, 3].reshape(len(faces), 4)
        return np.asarray(alpha.mean(axis=1) * factor >= least)
    except DAMAGE:
        return all_seen


def _texture(glb: Glb, primitive: dict[str, Any], count: int) -> tuple[Picture, Array] | None:
    """The picture of a primitive's base colour and the places of its points in it, (count, 2); or None."""
    surface = glb.tree["materials"][primitive["material"]].get("pbrMetallicRoughness", {})
    if "baseColorTexture" not in surface:
        return None
    texture = surface["baseColorTexture"]
    entry = glb.tree["textures"][texture["index"]]
    number = entry.get("extensions", {}).get("EXT_texture_webp", entry).get("source", entry.get("source"))
    picture = None if number is None else _picture(glb, number)
    places = glb.accessor(primitive["attributes"][f"TEXCOORD_{texture.get('texCoord', 0)}"])
    if picture is None or places.shape != (count, 2) or not np.isfinite(places).all():
        return None
    return picture, places


def _sampled(picture: Picture, places: Array) -> Array:
    """Linear light and alpha of a picture at places, (n, 2) -> (n, 4)."""
    size = np.array(picture.shape[1::-1])
    across, down = np.minimum((places % 1.0) * size, size - 1).astype(int).T
    return linear_light(picture[down, across])


def _picture(glb: Glb, number: int) -> Picture | None:
    """A picture of the file as sRGB and alpha, (height, width, 4)."""
    images = glb.tree["images"]
    image = images[number]
    if not 0 <= number < MOST or "bufferView" not in image:
        return None
    view = glb.tree["bufferViews"][image["bufferView"]]
    if view.get("buffer", 0) != 0:
        return None
    first = view.get("byteOffset", 0)
    most = LARGEST * AT_FULL_SIZE // max(len(images), AT_FULL_SIZE)
    return decode_picture(glb.binary[first : first + view["byteLength"]], most)


@lru_cache(maxsize=MOST)
def decode_picture(data: bytes, most: int = LARGEST) -> Picture | None:
    """A PNG, JPEG or WebP as sRGB and alpha, (height, width, 4), reduced to SIDE.

    None if it is damaged, or has more than `most` pixels.
    """
    try:
        from PIL import Image, UnidentifiedImageError
    except ImportError:
        return None
    try:
        with Image.open(io.BytesIO(data), formats=("PNG", "JPEG", "WEBP")) as picture:
            if picture.width * picture.height * (2 if picture.format == "WEBP" else 1) > most:
                return None
            picture.draft("RGB", (SIDE, SIDE))
            small = picture.convert("RGBA")
        small.thumbnail((SIDE, SIDE))
    except (UnidentifiedImageError, OSError, SyntaxError, Image.DecompressionBombError, *DAMAGE):
        return None
    return np.asarray(small, np.uint8)


def linear_light(pixels: Picture) -> Array:
    """Pixels of sRGB and alpha, (..., 4), as linear light and alpha."""
    light = pixels / 255.0
    light[..., :3] = np.where(
        light[..., :3] <= 0.04045, light[..., :3] / 12.92, ((light[..., :3] + 0.055) / 1.055) ** 2.4
    )
    return light
