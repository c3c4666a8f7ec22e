# SPDX-License-Identifier: BSD-3-Clause
"""The photo sets of sfm_stability.py, and what may be said about each."""
import os
import random
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Callable

OK, DEGRADED, FAILED = "ok", "degraded", "failed"
FOREIGN = "other_"  # Begins the names of photos of another scene.


@dataclass
class PhotoSet:
    what: str
    allowed: set
    # (data, freegs_make_scene, folder): fills folder/images; returns the file
    # with the true poses, or None.
    build: Callable


def photos_of(data, scene):
    photos = sorted(path for path in Path(data, scene, "images").iterdir()
                    if path.suffix.lower() in (".jpg", ".jpeg", ".png"))
    if not photos:
        sys.exit(f"no photos in {data}/{scene}/images")
    return photos


def truth_of(data, scene):
    for name in ("gt/cameras.json", "transforms.json"):
        if Path(data, scene, name).is_file():
            return Path(data, scene, name)
    return None


def scene(name, every=1, first=None, foreign=None, foreign_count=10):
    """Photos of a scene as they are, and evenly spread ones of another."""

    def build(data, _, folder):
        photos = photos_of(data, name)[::every][:first]
        for photo in photos:
            shutil.copy(photo, folder / "images" / photo.name)
        if foreign:
            others = photos_of(data, foreign)
            for i in range(foreign_count):
                photo = others[i * len(others) // foreign_count]
                shutil.copy(photo, folder / "images" / (FOREIGN + photo.name))
        return truth_of(data, name)

    return build


def changed(name, change, every=1):
    """Every so many-th photo goes through change(image, random)."""

    def build(data, _, folder):
        try:
            from PIL import Image
        except ImportError:
            sys.exit("this set needs Pillow (Debian: python3-pil, "
                     "/usr/bin/python3)")
        numbers = random.Random(1)
        for i, photo in enumerate(photos_of(data, name)):
            target = folder / "images" / photo.name
            if i % every != 0:
                shutil.copy(photo, target)
                continue
            with Image.open(photo) as image:
                extra = {"exif": image.info["exif"]} if (
                    "exif" in image.info) else {}
                change(image.convert("RGB"), numbers).save(target, quality=95,
                                                           **extra)
        return truth_of(data, name)

    return build


def blurred(sigma):
    def change(image, _):
        from PIL import ImageFilter
        return image.filter(ImageFilter.GaussianBlur(sigma))
    return change


def regraded(image, numbers):
    """Gamma between 0.5 and 2, both sides of 1 equally likely."""
    gamma = 2 ** numbers.uniform(-1, 1)
    return image.point([round(255 * (i / 255) ** gamma)
                        for i in range(256)] * 3)


def made(*options, truth=True):
    """Photos by freegs_make_scene."""

    def build(_, maker, folder):
        done = subprocess.run(
            [maker, "--out", str(folder / "scene"), "--test_views", "0",
             *options], text=True, capture_output=True, check=False)
        if done.returncode != 0:
            sys.exit(f"{maker}: {done.stderr[-500:]}")
        os.rmdir(folder / "images")
        os.rename(folder / "scene" / "images", folder / "images")
        return folder / "scene" / "gt" / "cameras.json" if truth else None

    return build


ANY = {OK, DEGRADED, FAILED}  # As long as it is true.
SETS = {
    "plainwall": PhotoSet("40 photos, untextured walls and floor",
                          {OK, DEGRADED}, scene("plainwall")),
    "tabletop": PhotoSet("60 photos, a table whose grain repeats",
                         {OK, DEGRADED}, scene("tabletop")),
    "every_2nd": PhotoSet("every 2nd photo of tabletop", {OK, DEGRADED},
                          scene("tabletop", every=2)),
    "every_4th": PhotoSet("every 4th photo of tabletop", ANY,
                          scene("tabletop", every=4)),
    "every_8th": PhotoSet("every 8th photo of tabletop", ANY,
                          scene("tabletop", every=8)),
    "blur_2": PhotoSet("fox, all blurred with sigma 2 px", {OK, DEGRADED},
                       changed("fox", blurred(2))),
    "blur_5": PhotoSet("fox, all blurred with sigma 5 px", ANY,
                       changed("fox", blurred(5))),
    "blur_12": PhotoSet("fox, all blurred with sigma 12 px", ANY,
                        changed("fox", blurred(12))),
    "third_2": PhotoSet("fox, every 3rd blurred with sigma 2 px",
                        {OK, DEGRADED}, changed("fox", blurred(2), every=3)),
    "third_5": PhotoSet("fox, every 3rd blurred with sigma 5 px",
                        {OK, DEGRADED}, changed("fox", blurred(5), every=3)),
    "third_12": PhotoSet("fox, every 3rd blurred with sigma 12 px",
                         {OK, DEGRADED}, changed("fox", blurred(12), every=3)),
    "gamma": PhotoSet("fox, each with a random gamma of 0.5 to 2",
                      {OK, DEGRADED}, changed("fox", regraded)),
    "tabletop_fox": PhotoSet("tabletop with 10 photos of fox",
                             {DEGRADED, FAILED},
                             scene("tabletop", foreign="fox")),
    "playroom_tabletop": PhotoSet("playroom with 10 photos of tabletop",
                                  {DEGRADED, FAILED},
                                  scene("playroom", foreign="tabletop")),
    "rotation": PhotoSet("40 photos, turning on the spot", {FAILED},
                         made("--motion", "rotation", truth=False)),
    "rotation_12": PhotoSet("12 photos, turning on the spot", {FAILED},
                            made("--motion", "rotation", "--views", "12",
                                 truth=False)),
    "textureless": PhotoSet("40 photos, all surfaces plain", {FAILED},
                            made("--texture", "none")),
    "textureless_12": PhotoSet("12 photos, all surfaces plain", {FAILED},
                               made("--texture", "none", "--views", "12")),
    "three": PhotoSet("3 neighbouring photos of tabletop", ANY,
                      scene("tabletop", first=3)),
    "three_apart": PhotoSet("3 photos of tabletop, a third of a turn apart",
                            {FAILED}, scene("tabletop", every=20)),
    "chairs": PhotoSet("30 made photos of two equal chairs", ANY,
                       made("--scene", "chairs", "--views", "30")),
    "tiles": PhotoSet("30 made photos of a wall of equal tiles", ANY,
                      made("--scene", "tiles", "--views", "30")),
    "bonsai": PhotoSet("292 photos, six of which COLMAP alone misplaces",
                       {OK, DEGRADED}, scene("bonsai")),
    "views_300": PhotoSet("300 made photos", {OK},
                          made("--views", "300")),
}
# Few photos of real scenes, so far apart that the plain way may lose some.
for _name, _steps in (("fox", (3, 5, 8)), ("real/desk", (2, 4)),
                      ("real/fruit", (6, 12)), ("real/kumamon", (6, 12)),
                      ("real/flower", (3, 6)), ("bonsai", (12, 24))):
    for _step in _steps:
        SETS[f"{_name.removeprefix('real/')}_by_{_step}"] = PhotoSet(
            f"photos 1, {1 + _step}, {1 + 2 * _step} ... of {_name}", ANY,
            scene(_name, every=_step))
