# SPDX-License-Identifier: BSD-3-Clause
"""What a model knows without having been asked before: accuracies on drawings
that training never saw."""
import numpy as np
import torch
import torch.nn.functional as F

from . import drawings
from .drawings import Library
from .network import normalised, pad
from .solids import SHAPES
from .vocabulary import (COLOUR_NAMES, MATERIALS, NATURAL, NOTHING, Label,
                         choose_label, shape_name)

HELD_OUT = 1000003  # added to the seed: other views, backgrounds, drawings


def embed_texts(model, tokenizer, texts):
    ids, ends = pad([tokenizer(text, model.arch.context_length)
                     for text in texts])
    return torch.cat([model.encode_text(ids[i:i + 64], ends[i:i + 64])
                      for i in range(0, len(ids), 64)])


def embed_names(model, tokenizer, names, forms):
    """A vector for each name: the mean over the forms of words."""
    parts = torch.stack([embed_texts(model, tokenizer, [
        form.format(("an " if name[0] in "aeiou" else "a ") + name)
        for name in names]) for form in forms])
    return F.normalize(parts.mean(0), dim=-1)


FORMS = ["{}", "a photo of {}"]


def best_of(features, vectors):
    return (features @ vectors.t()).argmax(1).numpy()


def embed_drawings(model, drawn):
    return torch.cat([model.encode_image(normalised(np.stack(
        [image for image, _ in drawn[i:i + 50]])))
        for i in range(0, len(drawn), 50)])


def held_out_phrases(seed):
    """50 different phrases of colour or material and shape."""
    rng = np.random.default_rng((seed + HELD_OUT, 50))
    phrases = {}
    while len(phrases) < 50:
        label = choose_label(rng)
        material = MATERIALS[label.material]
        if material == "plain" and label.colour >= 0:
            first = COLOUR_NAMES[label.colour]
        elif material not in ("plain", "metal"):
            first, label = material, Label(
                -1, label.material, label.shape)
        else:
            continue
        phrases[f"{first} {shape_name(label.shape)}"] = label
    return phrases


def draw_phrase(library, label, phrases, seed, k):
    """A drawing of a phrase; its colour, where it says none, is any that
    makes none of the other phrases right."""
    rng = np.random.default_rng((seed, k, 1))
    material = MATERIALS[label.material]
    if label.colour < 0 and material not in NATURAL and (
            material != "striped" or rng.random() < 0.5):
        free = [i for i in range(8) if f"{COLOUR_NAMES[i]} "
                f"{shape_name(label.shape)}" not in phrases]
        label = Label(int(rng.choice(free)), label.material, label.shape)
    return drawings.draw(library, seed, k, 224, label)


def worst(right, names, index):
    """The three names that are recognised least."""
    rates = [(np.mean(right[index == i]), name)
             for i, name in enumerate(names) if (index == i).any()]
    return [f"{name} {100 * rate:.0f} %" for rate, name in sorted(rates)[:3]]


def evaluate(model, tokenizer, arguments):
    """Zero-shot accuracies on drawings that training never saw."""
    model.eval()
    seed = arguments.seed + HELD_OUT
    library = Library(arguments.cache, seed, max(2, arguments.views // 6),
                      max(8, arguments.backgrounds // 6))
    result = {}
    drawn = [drawings.draw(library, seed, k, 224)
             for k in range(arguments.test_images)]
    drawn = [(image, label) for image, label in drawn
             if label.shape != NOTHING]
    features = embed_drawings(model, drawn)
    questions = {
        "colour": ([f"{name} object" for name in COLOUR_NAMES], COLOUR_NAMES),
        "material": ([f"{name} object" for name in MATERIALS], MATERIALS),
        "shape": ([shape_name(i) for i in range(len(SHAPES))], SHAPES)}
    for what, (texts, names) in questions.items():
        truth = np.array([getattr(label, what) for _, label in drawn])
        vectors = embed_names(model, tokenizer, texts, FORMS)
        chosen = best_of(features, vectors)
        use = truth >= 0
        right = chosen == truth
        result[what] = {"accuracy": float(right[use].mean()),
                        "images": int(use.sum()),
                        "worst": worst(right[use], names, truth[use])}
        if what == "colour":
            plain = use & np.array([MATERIALS[label.material] == "plain"
                                    for _, label in drawn])
            result["colour of plain things"] = {
                "accuracy": float(right[plain].mean()),
                "images": int(plain.sum()),
                "worst": worst(right[plain], names, truth[plain])}
    phrases = held_out_phrases(arguments.seed)
    each = max(1, arguments.test_images // 100)
    drawn = [draw_phrase(library, label, phrases, seed + 1, i * each + j)
             for i, label in enumerate(phrases.values()) for j in range(each)]
    truth = np.repeat(np.arange(50), each)
    vectors = embed_names(model, tokenizer, list(phrases), FORMS)
    right = best_of(embed_drawings(model, drawn), vectors) == truth
    result["one of 50 phrases"] = {
        "accuracy": float(right.mean()), "images": len(drawn),
        "worst": worst(right, list(phrases), truth)}
    return result
