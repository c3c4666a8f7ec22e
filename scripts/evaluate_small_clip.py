#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""What the small CLIP says of the things of a rendered scene, each cut out by
its true mask: which of the scene's labels fits best.

  scripts/evaluate_small_clip.py --model small_clip.work/checkpoint.pt \\
      --scene SCENE --matrix confusion.png

SCENE holds test/images/VIEW.png and test/masks/VIEW/LABEL.png. Crops are
squares around the mask, made in three ways: `keep` with what is around,
`blank` with grey instead, and `both`, the mean of the two vectors. The merges
(merges.txt) lie beside the checkpoint. These images are for measuring only.
"""
import argparse
import os
import sys
from pathlib import Path

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from check_clip_export import Tokenizer
from clip_checkpoint import Architecture
from small_clip.network import SmallClip, normalised
from small_clip.zero_shot import FORMS, best_of, embed_names

import numpy as np
import torch
import torch.nn.functional as F
from PIL import Image, ImageDraw

GREY = (123, 117, 104)  # CLIP's mean colour


def load_model(path):
    data = torch.load(path)
    model = SmallClip(Architecture(**data["arch"]))
    model.load_state_dict(data["model"])
    return model.eval(), Tokenizer(path.parent / "merges.txt")


def square_around(mask, margin):
    """(left, top, side) of the square around a mask."""
    rows, columns = mask.any(1).nonzero()[0], mask.any(0).nonzero()[0]
    height, width = np.ptp(rows) + 1, np.ptp(columns) + 1
    side = max(8, round(max(height, width) * (1 + 2 * margin)))
    return (int(columns[0] + width / 2 - side / 2),
            int(rows[0] + height / 2 - side / 2), side)


def crop(image, window):
    """A square of the image at 224 pixels, grey outside of it."""
    left, top, side = window
    result = Image.new("RGB", (side, side), GREY)
    result.paste(image, (-left, -top))
    return np.asarray(result.resize((224, 224), Image.BICUBIC))


def crops_of(scene, margin, smallest):
    """(label, crop with surroundings, crop without) of every mask."""
    result = []
    for path in sorted((scene / "test" / "masks").glob("*/*.png")):
        mask = np.asarray(Image.open(path).convert("L")) > 127
        if mask.sum() < smallest:
            continue
        image = Image.open(scene / "test" / "images" /
                           f"{path.parent.name}.png").convert("RGB")
        window = square_around(mask, margin)
        alone = Image.new("RGB", image.size, GREY)
        alone.paste(image, (0, 0), Image.fromarray(mask))
        result.append((path.stem, crop(image, window), crop(alone, window)))
    return result


def embed(model, images):
    return torch.cat([model.encode_image(normalised(np.stack(
        images[i:i + 32]))) for i in range(0, len(images), 32)])


def confusion(truth, chosen, count):
    table = np.zeros((count, count), int)
    np.add.at(table, (truth, chosen), 1)
    return table


def draw_matrix(table, names, path, title):
    """Rows: what it is; columns: what the model says."""
    cell, left, top = 46, 170, 170
    count = len(names)
    image = Image.new("RGB", (left + cell * count + 10,
                              top + cell * count + 10), "white")
    pen = ImageDraw.Draw(image)
    pen.text((8, 8), title, fill="black")
    for i, name in enumerate(names):
        pen.text((8, top + cell * i + 16), name, fill="black")
        upright = Image.new("RGB", (150, 14), "white")
        ImageDraw.Draw(upright).text((0, 1), name, fill="black")
        image.paste(upright.rotate(90, expand=True),
                    (left + cell * i + 16, top - 154))
        for j in range(count):
            share = table[i, j] / max(1, table[i].sum())
            light = int(255 * (1 - share))
            color = (light, 255 - (255 - light) // 3, light) if i == j else (
                255 - (255 - light) // 8, light, light)
            x, y = left + cell * j, top + cell * i
            pen.rectangle((x, y, x + cell - 2, y + cell - 2), fill=color)
            if table[i, j]:
                pen.text((x + 16, y + 16), str(table[i, j]), fill="black")
    image.save(path)


def main():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--model", type=Path, required=True)
    parser.add_argument("--scene", type=Path, required=True)
    parser.add_argument("--matrix", type=Path)
    parser.add_argument("--crop", default="both",
                        choices=("keep", "blank", "both"),
                        help="of which the matrix is")
    parser.add_argument("--margin", type=float, default=0.1)
    parser.add_argument("--smallest", type=int, default=30,
                        help="pixels of the smallest mask")
    parser.add_argument("--threads", type=int, default=2)
    arguments = parser.parse_args()
    torch.set_num_threads(arguments.threads)
    crops = crops_of(arguments.scene, arguments.margin, arguments.smallest)
    if not crops:
        print(f"{arguments.scene}: no test/masks/*/*.png", file=sys.stderr)
        return 3
    names = sorted({label for label, _, _ in crops})
    truth = np.array([names.index(label) for label, _, _ in crops])
    model, tokenizer = load_model(arguments.model)
    with torch.no_grad():
        vectors = embed_names(model, tokenizer, names, FORMS)
        keep = embed(model, [image for _, image, _ in crops])
        blank = embed(model, [image for _, _, image in crops])
    features = {"keep": keep, "blank": blank,
                "both": F.normalize(keep + blank, dim=-1)}
    for way, values in features.items():
        chosen = best_of(values, vectors)
        rate = (chosen == truth).mean()
        print(f"{way}: {100 * rate:.1f} % of {len(truth)} crops")
        if way != arguments.crop:
            continue
        for i, name in enumerate(names):
            own = chosen[truth == i]
            print(f"  {name}: {(own == i).sum()} of {len(own)}")
        if arguments.matrix:
            draw_matrix(confusion(truth, chosen, len(names)), names,
                        arguments.matrix, f"{arguments.scene.name}, crops "
                        f"'{way}': {100 * rate:.1f} %")
    return 0


if __name__ == "__main__":
    sys.exit(main())
