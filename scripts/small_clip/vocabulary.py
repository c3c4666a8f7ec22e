# SPDX-License-Identifier: BSD-3-Clause
"""What the drawings show and what is said of them: colours, materials, shapes,
labels and captions."""
from dataclasses import dataclass

import numpy as np

from . import solids
from .solids import SHAPES

# Hue (middle, spread), saturation (from, to), value (from, to).
COLOURS = {
    "red": (0.0, 0.018, 0.75, 1.0, 0.5, 0.95),
    "green": (0.34, 0.06, 0.5, 1.0, 0.32, 0.8),
    "blue": (0.61, 0.04, 0.6, 1.0, 0.4, 0.95),
    "yellow": (0.145, 0.015, 0.7, 1.0, 0.8, 1.0),
    "orange": (0.06, 0.015, 0.82, 1.0, 0.85, 1.0),
    "purple": (0.77, 0.03, 0.45, 0.9, 0.35, 0.75),
    "pink": (0.92, 0.035, 0.3, 0.6, 0.85, 1.0),
    "brown": (0.065, 0.02, 0.5, 0.8, 0.22, 0.48),
    "black": (0.5, 0.5, 0.0, 0.2, 0.02, 0.13),
    "white": (0.5, 0.5, 0.0, 0.07, 0.88, 1.0),
    "grey": (0.5, 0.5, 0.0, 0.08, 0.38, 0.58),
    "golden": (0.125, 0.012, 0.7, 0.92, 0.62, 0.85),
    "silver": (0.5, 0.5, 0.0, 0.06, 0.62, 0.78),
}
COLOUR_NAMES = list(COLOURS)
MIRRORING = {COLOUR_NAMES.index(a): COLOUR_NAMES.index(b) for a, b in (
    ("yellow", "golden"), ("white", "silver"), ("grey", "silver"))}
MATERIALS = ["plain", "striped", "dotted", "checked", "wooden", "brick",
             "marble", "cardboard", "metal"]
# Materials with a colour of their own, and what one might call it: such
# captions are neither right nor wrong.
NATURAL = {"wooden": {"brown", "orange", "yellow", "golden"},
           "brick": {"red", "brown", "orange"},
           "marble": {"white", "grey", "black", "green", "pink", "silver"},
           "cardboard": {"brown", "orange", "golden"}}
WORDS = {"ball": ["ball", "ball", "sphere"],
         "box": ["box", "box", "block", "cube"],
         "donut": ["ring", "donut", "torus"],
         "mug": ["mug", "mug", "cup"], "toy car": ["toy car", "car"],
         "teddy bear": ["teddy bear", "teddy bear", "teddy", "bear"],
         "monkey": ["monkey", "monkey", "monkey head"],
         "capsule": ["capsule", "pill"], "traffic cone": ["traffic cone"],
         "dotted": ["dotted", "spotted", "polka dot"],
         "checked": ["checked", "checkered"], "wooden": ["wooden", "wood"],
         "metal": ["metal", "metallic"], "striped": ["striped", "striped"],
         "golden": ["golden", "golden", "gold"], "grey": ["grey", "gray"],
         "ring": ["flat ring"]}
# (colour, material) pairs that are common for a shape.
TYPICAL = {
    "apple": [("red", "plain"), ("green", "plain"), ("yellow", "plain")],
    "ball": [(None, "striped"), (None, "striped"), ("red", "plain")],
    "box": [(None, "wooden"), (None, "cardboard"), (None, "brick")],
    "chair": [(None, "wooden")], "table": [(None, "wooden")],
    "teddy bear": [("brown", "plain"), ("white", "plain")],
    "traffic cone": [("orange", "plain")],
    "monkey": [("golden", "metal"), ("brown", "plain")],
    "vase": [("white", "plain"), ("blue", "plain"), (None, "marble")],
    "mug": [("blue", "plain"), ("white", "plain"), ("red", "plain")],
    "toy car": [("yellow", "plain"), ("red", "plain"), ("blue", "plain")],
    "stool": [("red", "plain"), ("blue", "plain"), (None, "wooden")],
    "plate": [("white", "plain")], "bowl": [("white", "plain")],
}
NOTHING = len(SHAPES)  # the shape of a background without an object


@dataclass
class Label:
    """What is in an image, or what a caption says; -1: says nothing, and as
    an image's colour: several, or the material's own."""
    colour: int
    material: int
    shape: int


def choose_label(rng):
    """A colour (-1: none to name), material and shape; the shape of typical
    things is often of its typical colour."""
    shape = int(rng.integers(len(SHAPES)))
    typical = TYPICAL.get(SHAPES[shape])
    if typical and rng.random() < 0.35:
        colour, material = typical[rng.integers(len(typical))]
        colour = -1 if colour is None else COLOUR_NAMES.index(colour)
        return Label(colour, MATERIALS.index(material), shape)
    flat = SHAPES[shape] in solids.FLAT
    weights = np.array([4, 2, 2, 2, 2, 1.3, 1.3, 1.3, 1.6])
    if flat:
        weights[4:] *= 0.4
    material = MATERIALS[rng.choice(9, p=weights / weights.sum())]
    colour = int(rng.integers(11))
    if material == "plain" and rng.random() < 0.06:
        material, colour = "metal", int(rng.choice([11, 12]))
    elif material == "metal":
        colour = int(rng.choice([11, 11, 12, 12, 12, rng.integers(11)]))
        # What is yellow, white or grey and mirrors has names of its own.
        colour = MIRRORING.get(colour, colour)
    if material in ("striped", "checked") and colour in (8, 9, 10):
        colour = int(rng.integers(8))  # white is the second one
    if material in NATURAL or (material == "striped" and rng.random() < 0.4):
        colour = -1
    return Label(colour, MATERIALS.index(material), shape)


OFTEN_MISTAKEN = ["silver", "silver", "white", "grey", "golden", "yellow"]


def choose_mistaken_label(rng):
    """A label with a colour that is easily taken for another."""
    colour = COLOUR_NAMES.index(OFTEN_MISTAKEN[rng.integers(
        len(OFTEN_MISTAKEN))])
    while True:
        label = choose_label(rng)
        if label.colour == colour:
            return label


SUFFIXES = ["", "", "", "", " on the floor", " on a table", " in a room",
            " in the corner", " on a rug"]
BACKDROPS = ["a texture", "texture", "stuff", "background", "some stuff",
             "a wall", "a floor", "nothing"]
# Said of nothing in particular: "object" is right for every thing, and as like
# it as what it is; "stuff" is right for none. These lie between.
CANONICAL = ["some stuff, object", "object and stuff"]
# Relevancy of the word of a thing from which on it names the thing; measured
# with the model that comes with the program (docs/clip.md).
MIN_WORD_CONFIDENCE = 0.72
PREFIXES = ["", "", "a photo of ", "a picture of ", "a drawing of "]


def word(rng, name):
    words = WORDS.get(name, [name])
    return words[rng.integers(len(words))]


def with_article(rng, text):
    kind = rng.random()
    if kind < 0.4:
        return text
    if kind < 0.55:
        return "the " + text
    return ("an " if text[0] in "aeiou" else "a ") + text


def caption(rng, label):
    """(text, Label of what it says) for an image."""
    if label.shape == NOTHING:
        return (BACKDROPS[rng.integers(len(BACKDROPS))],
                Label(-1, -1, NOTHING))
    colour, material, shape = label.colour, label.material, label.shape
    kind = rng.random()
    if kind < 0.02:
        return with_article(rng, ["object", "thing"][rng.integers(2)]), Label(
            -1, -1, -1)
    # Which of colour, material and shape it says.
    say = [rng.random() < 0.62, rng.random() < (
        0.12 if MATERIALS[material] == "plain" else 0.6), rng.random() < 0.86]
    if colour < 0:
        say[0] = False
    if not any(say):
        say[2] = True
    words = [word(rng, names[value]) for names, value, said in zip(
        (COLOUR_NAMES, MATERIALS, SHAPES), (colour, material, shape), say)
        if said]
    said = Label(*(value if flag else -1 for value, flag in zip(
        (colour, material, shape), say)))
    if not say[2]:
        if rng.random() < 0.5:
            return ("something " if rng.random() < 0.5 else "") + " ".join(
                words), said
        words.append(["object", "thing"][rng.integers(2)])
    text = with_article(rng, " ".join(words))
    return (PREFIXES[rng.integers(len(PREFIXES))] + text +
            SUFFIXES[rng.integers(len(SUFFIXES))]), said


def shape_name(i):
    return WORDS.get(SHAPES[i], [SHAPES[i]])[0]
