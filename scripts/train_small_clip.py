#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Trains the small CLIP that ships with freegs_pipeline, on drawings made
here, and exports it with a model card.

  OMP_WAIT_POLICY=PASSIVE scripts/train_small_clip.py --minutes 600 \\
      --work small_clip.work --out models/small_clip

Needs Debian's python3-torch, python3-numpy and python3-pil; OpenBLAS
(libopenblas0-pthread) doubles its speed. It writes a checkpoint into --work
every few minutes and goes on from there when started again; the time counted
is that of training, over all starts. With --steps instead of --minutes the
schedule does not depend on the clock, and the same seed gives the same
network. When the time is over, or with --evaluate at once, it measures and
exports.
"""
import argparse
import json
import math
import multiprocessing
import os
import signal
import sys
import time
from collections import deque
from pathlib import Path

os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")

from check_clip_export import Tokenizer
from export_clip import ModelCard, export_folder
from small_clip import drawings, vocabulary
from small_clip.drawings import Library
from small_clip.model_card import model_card
from small_clip.network import SmallClip, architecture, learn_merges, \
    normalised, pad, write_merges
from small_clip.solids import SHAPES
from small_clip.vocabulary import COLOUR_NAMES, MATERIALS, NATURAL, NOTHING, \
    shape_name
from small_clip.zero_shot import evaluate

import numpy as np
import torch
import torch.nn.functional as F

SECOND_STAGE = 0.9  # the share of training at 112 pixels
PREFETCH = 6
# Of place, and of caption and property for whole images, then for patches; of
# the patches around things; of place and property in pictures of four.
WEIGHTS = [0.2, 1, 1, 0.3, 0.7, 0.2, 0.2, 0.5]
library = None  # of a worker process


def start_worker(cache, seed, views, backgrounds):
    global library
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    os.nice(2)
    library = Library(cache, seed, views, backgrounds)


def draw_chunk(job):
    """Images first .. first + count of a seed, where the things are in
    them, and their labels. When finishing, every third has a colour that is
    often mistaken."""
    seed, first, count, size, finishing = job
    images = np.empty((count, size, size, 3), np.uint8)
    grid = size // drawings.PATCH
    covers, labels = np.empty((count, grid, grid), np.uint8), []
    for i in range(count):
        label = vocabulary.choose_mistaken_label(np.random.default_rng(
            (seed, 5, first + i))) if finishing and i % 3 == 0 else None
        images[i], label, covers[i] = drawings.draw_and_cover(
            library, seed, first + i, size, label)
        labels.append(label)
    return images, covers, labels


class Ring:
    """The last `capacity` drawings of one size. Every step puts some new ones
    in the place of the oldest and takes a random batch."""

    def __init__(self, pool, arguments, size, capacity, fresh, first):
        self.pool, self.seed, self.size = pool, arguments.seed, size
        self.finishing = bool(arguments.finish)
        self.fresh, self.next_image = fresh, first
        self.images = np.zeros((capacity, size, size, 3), np.uint8)
        grid = size // drawings.PATCH
        self.covers = np.zeros((capacity, grid, grid), np.uint8)
        self.labels = [None] * capacity
        self.filled = self.at = 0
        self.waiting = deque()

    def order(self):
        while len(self.waiting) < PREFETCH:
            job = (self.seed, self.next_image, self.fresh, self.size,
                   self.finishing)
            self.waiting.append((job, self.ask(job)))
            self.next_image += self.fresh

    def ask(self, job):
        return self.pool.apply_async(draw_chunk, (job,))

    def answer(self, job, drawn):
        """Asks again where a worker has died with its job: the pool starts
        another, but never answers the first."""
        while True:
            try:
                return drawn.get(timeout=30)
            except multiprocessing.TimeoutError:
                drawn = self.ask(job)

    def refresh(self):
        self.order()
        for image, cover, label in zip(*self.answer(*self.waiting.popleft())):
            self.images[self.at], self.covers[self.at] = image, cover
            self.labels[self.at] = label
            self.at = (self.at + 1) % len(self.labels)
            self.filled = min(self.filled + 1, len(self.labels))

    def batch(self, rng, count):
        while self.filled < min(2 * count, len(self.labels)):
            self.refresh()
        self.refresh()
        chosen = np.sort(rng.choice(self.filled, count, replace=False))
        images, covers = self.images[chosen], self.covers[chosen]
        if rng.random() < 0.5:
            images, covers = images[:, :, ::-1], covers[:, :, ::-1]
        return images, covers, [self.labels[i] for i in chosen]


def colour_may_be(label):
    """Of each colour whether a caption with it could be right."""
    may = np.zeros(len(COLOUR_NAMES) + 1, bool)
    may[-1] = True  # a caption that says no colour
    if label.shape == NOTHING:
        return may
    if label.colour >= 0:
        may[label.colour] = True
    elif MATERIALS[label.material] in NATURAL:
        for name in NATURAL[MATERIALS[label.material]]:
            may[COLOUR_NAMES.index(name)] = True
    else:
        may[:] = True
    return may


def may_match(labels, said):
    """(images, captions): whether the caption could be said of the image."""
    colour = np.stack([colour_may_be(label) for label in labels])
    colour = colour[:, [text.colour for text in said]]
    result = colour
    for name in ("material", "shape"):
        of_image = np.array([getattr(label, name) for label in labels])
        of_text = np.array([getattr(text, name) for text in said])
        same = of_image[:, None] == of_text[None]
        free = of_text == -1
        if name == "shape":
            same |= free[None] & (of_image != NOTHING)[:, None]
        else:
            same |= free[None]
        result = result & same
    return torch.from_numpy(result)


def contrastive_loss(scale, image_features, text_features, also_right):
    """InfoNCE both ways; other pairs that are right too do not count."""
    logits = scale * (image_features @ text_features.t())
    own = torch.eye(len(logits), dtype=torch.bool)
    logits = logits.masked_fill(also_right & ~own, -1e4)
    target = torch.arange(len(logits))
    return (F.cross_entropy(logits, target) +
            F.cross_entropy(logits.t(), target)) / 2


def prompts(rng):
    """One caption for every colour, material and shape, in random words."""
    def say(names, noun):
        form = ["{}", "a photo of {}", "something {}" if noun else "one {}"][
            rng.integers(3)]
        noun = f" {noun}" if noun and not form.startswith("some") else ""
        return [form.format(str(rng.choice(vocabulary.WORDS.get(n, [n]))) + noun)
                for n in names]
    return {"colour": say(COLOUR_NAMES, "object"),
            "material": say(MATERIALS, "object"), "shape": say(SHAPES, "")}


def prompt_loss(scale, image_features, said, said_features, labels):
    """The contrastive loss of images against one caption for every value of
    each property: the other captions of a batch say several things at once
    and leave open which of them an image failed at."""
    logits = scale * (image_features @ said_features.t())
    loss, first = 0, 0
    for name, texts in said.items():
        truth = torch.tensor([getattr(label, name) for label in labels])
        if name != "shape":
            things = torch.tensor([label.shape != NOTHING for label in labels])
            truth = torch.where(things, truth, -1)
        truth = torch.where(truth < len(texts), truth, -1)
        if (truth >= 0).any():
            loss = loss + F.cross_entropy(
                logits[:, first:first + len(texts)], truth, ignore_index=-1)
        first += len(texts)
    return loss / len(said)


def pooled(patches, covers):
    """The mean vector of the patches that show the thing."""
    weights = covers / covers.sum(1, keepdim=True).clamp_min(1e-6)
    return F.normalize((patches * weights[:, :, None]).sum(1), dim=-1)


def place_loss(scale, patches, covers, text_features):
    """Where a caption is: of all patches of its image, in those that show the
    thing. Minus the logarithm of their share of the softmax."""
    logits = scale * (patches * text_features[:, None]).sum(-1)
    share = (logits + covers.clamp_min(1e-4).log()).logsumexp(1)
    seen = covers.sum(1) > 0
    return (logits.logsumexp(1) - share)[seen].mean() if seen.any() else 0


def around_loss(scale, around, said_features, backdrop):
    """The patches that show no thing are like a word for what is behind
    things, more than like any property: else nothing would keep the sides of
    a picture from being red apples."""
    words = torch.cat([backdrop[None], said_features])
    logits = scale * (around @ words.t())
    return F.cross_entropy(logits, torch.zeros(len(around), dtype=torch.long))


def in_fours(images, covers):
    """Pictures of four images at half their size, and where in its picture
    each image's thing is: (n / 4, 3, S, S) and (n, g, g) of n images."""
    half = F.avg_pool2d(images, 2)
    rows = [torch.cat([half[i::4], half[i + 1::4]], 3) for i in (0, 2)]
    grid = covers.shape[1] // 2
    small = F.avg_pool2d(covers[:, None], 2)[:, 0]
    places = torch.zeros_like(covers)
    for i in range(4):
        y, x = i // 2 * grid, i % 2 * grid
        places[i::4, y:y + grid, x:x + grid] = small[i::4]
    return torch.cat(rows, 2), places


def make_optimizer(model, rate):
    plain = [p for p in model.parameters() if p.ndim < 2]
    decayed = [p for p in model.parameters() if p.ndim >= 2]
    return torch.optim.AdamW([{"params": decayed, "weight_decay": 0.05},
                              {"params": plain, "weight_decay": 0.0}],
                             lr=rate, betas=(0.9, 0.98))


def rate_at(progress, peak):
    """Warm-up over 2 %, then half a cosine."""
    if progress < 0.02:
        return peak * (progress + 1e-4) / 0.02
    return peak * (0.01 + 0.99 * 0.5 * (1 + math.cos(
        math.pi * min(1, progress))))


def caption_samples(seed, count):
    rng = np.random.default_rng((seed, 11))
    extra = ["object", "things", "stuff", "texture", "a photo of an object"]
    return [vocabulary.caption(rng, vocabulary.choose_label(rng))[0]
            for _ in range(count)] + vocabulary.BACKDROPS + extra * 20


class Training:
    """State that a checkpoint keeps."""

    def __init__(self, arguments):
        self.arguments = arguments
        self.work = arguments.work
        self.work.mkdir(parents=True, exist_ok=True)
        self.merges = self.work / "merges.txt"
        if not self.merges.exists():
            write_merges(learn_merges(caption_samples(arguments.seed, 20000),
                                      400), self.merges)
        self.tokenizer = Tokenizer(self.merges)
        self.arch = architecture(arguments, self.tokenizer.start + 2)
        torch.manual_seed(arguments.seed)
        self.model = SmallClip(self.arch)
        self.optimizer = make_optimizer(self.model, arguments.rate)
        self.step, self.images_seen, self.seconds = 0, 0, 0.0
        if self.path.exists():
            self.load()
        self.first = self.step

    @property
    def path(self):
        return self.work / "checkpoint.pt"

    def load(self):
        data = torch.load(self.path)
        self.model.load_state_dict(data["model"])
        self.optimizer.load_state_dict(data["optimizer"])
        self.step, self.seconds = data["step"], data["seconds"]
        self.images_seen = data["images_seen"]
        print(f"going on from step {self.step}", flush=True)

    def save(self):
        part = self.path.with_suffix(".part")
        torch.save({"model": self.model.state_dict(),
                    "optimizer": self.optimizer.state_dict(),
                    "step": self.step, "seconds": self.seconds,
                    "images_seen": self.images_seen,
                    "arch": vars(self.arch)}, part)
        part.replace(self.path)

    def progress(self):
        if self.arguments.finish:
            return SECOND_STAGE + (1 - SECOND_STAGE) * (
                self.step - self.first) / self.arguments.finish
        if self.arguments.steps:
            return self.step / self.arguments.steps
        return self.seconds / (60 * self.arguments.minutes)

    def rate(self):
        if self.arguments.finish:
            left = 1 - (self.step - self.first) / self.arguments.finish
            return self.arguments.rate * (0.005 + 0.195 * left)
        return rate_at(self.progress(), self.arguments.rate)

    def losses(self, rng, images, covers, labels):
        """Of whole images and of the patches that show the thing."""
        model = self.model
        pairs = [vocabulary.caption(rng, label) for label in labels]
        said = prompts(rng)
        said_texts = [text for names in said.values() for text in names]
        backdrop = str(rng.choice(vocabulary.BACKDROPS))
        texts, ends = pad([self.tokenizer(text, self.arch.context_length)
                           for text in [text for text, _ in pairs] +
                           said_texts + [backdrop]])
        words = model.encode_text(texts, ends)
        captions, names = words[:len(pairs)], words[len(pairs):-1]
        also_right = may_match(labels, [label for _, label in pairs])
        images = normalised(images)
        covers = torch.from_numpy(np.ascontiguousarray(covers)).float() / 255
        features, patches = model.encode_patches(images)
        places = covers.flatten(1)
        scale = model.logit_scale.exp()
        parts = [place_loss(scale, patches, places, captions)]
        for vectors in (features, pooled(patches, places)):
            parts += [contrastive_loss(scale, vectors, captions, also_right),
                      prompt_loss(scale, vectors, said, names, labels)]
        parts.append(around_loss(scale, pooled(patches, 1 - places), names,
                                 words[-1]))
        # Where patches of half the size are whole ones again.
        if covers.shape[1] % 2 == 0 and len(images) % 4 == 0:
            fours, places = in_fours(images, covers)
            _, patches = model.encode_patches(fours)
            patches = patches.repeat_interleave(4, 0)
            places = places.flatten(1)
            parts += [place_loss(scale, patches, places, captions),
                      prompt_loss(scale, pooled(patches, places), said, names,
                                  labels)]
        else:
            parts += [0, 0]
        return parts

    def train_step(self, ring, count):
        rng = np.random.default_rng((self.arguments.seed, 3, self.step))
        for group in self.optimizer.param_groups:
            group["lr"] = self.rate()
        parts = self.losses(rng, *ring.batch(rng, count))
        loss = sum(weight * part for weight, part in zip(WEIGHTS, parts))
        self.optimizer.zero_grad(set_to_none=True)
        loss.backward()
        torch.nn.utils.clip_grad_norm_(self.model.parameters(), 1.0)
        self.optimizer.step()
        with torch.no_grad():
            self.model.logit_scale.clamp_(max=math.log(100))
        self.step += 1
        self.images_seen += count
        return [float(part) for part in parts]


def train(state, stop):
    """Until the time or the steps are over or `stop` says so."""
    arguments = state.arguments
    with multiprocessing.Pool(arguments.workers, start_worker, (
            arguments.cache, arguments.seed, arguments.views,
            arguments.backgrounds)) as pool:
        ring, last_save, losses = None, time.time(), []
        mark = time.time(), state.images_seen
        while state.progress() < 1 and not stop:
            started = time.time()
            big = state.progress() >= SECOND_STAGE
            size = 224 if big else 112
            count = arguments.batch // 2 if big else arguments.batch
            if ring is None or ring.size != size:
                ring = Ring(pool, arguments, size,
                            arguments.pool // (4 if big else 1),
                            count if big else max(1, count // arguments.reuse),
                            (10 ** 9 if big else 0) +
                            state.step * arguments.batch)
            losses.append(state.train_step(ring, count))
            state.seconds += time.time() - started
            if state.step % arguments.every == 0:
                now = time.time()
                said = " ".join(f"{x:.3f}" for x in np.mean(losses, 0))
                speed = (state.images_seen - mark[1]) / (now - mark[0])
                print(f"step {state.step}  {100 * state.progress():.1f} %  "
                      f"loss {said}  {speed:.0f} images/s  "
                      f"scale {state.model.logit_scale.exp().item():.1f}",
                      flush=True)
                mark, losses = (now, state.images_seen), []
            if time.time() - last_save > 60 * arguments.save_minutes:
                state.save()
                last_save = time.time()
        state.save()
        pool.terminate()


def export(state, measured):
    out = state.arguments.out
    data = {name: value.detach().clone()
            for name, value in state.model.state_dict().items()}
    card = ModelCard(
        "small_clip", "BSD-3-Clause", "scripts/train_small_clip.py, seed "
        f"{state.arguments.seed}, {state.step} steps",
        vocabulary=[COLOUR_NAMES, MATERIALS[1:],
                    [shape_name(i) for i in range(len(SHAPES))]],
        canonical=vocabulary.CANONICAL,
        min_word_confidence=vocabulary.MIN_WORD_CONFIDENCE)
    export_folder(data, state.arch, state.merges, out, card,
                  dense_sizes=state.arguments.dense_size)
    (out / "README.md").write_text(model_card(state, measured, out))
    sizes = {path.name: path.stat().st_size for path in out.iterdir()}
    for name, size in sorted(sizes.items()):
        print(f"{size / 1e6:8.3f} MB  {name}")
    total = sum(sizes.values()) / 1e6
    print(f"{total:8.3f} MB  in all"
          f"{'  ** more than 12 MB **' if total > 12 else ''}")


def parse():
    parser = argparse.ArgumentParser(
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--work", type=Path, required=True,
                        help="folder of the checkpoint")
    parser.add_argument("--out", type=Path, required=True,
                        help="model folder to write")
    parser.add_argument("--minutes", type=float, default=600)
    parser.add_argument("--steps", type=int, help="instead of --minutes")
    parser.add_argument("--finish", type=int, default=0, metavar="STEPS",
                        help="so many steps more, all at 224 pixels, with "
                        "often mistaken colours more often, at a rate that "
                        "falls from a fifth of --rate")
    parser.add_argument("--evaluate", action="store_true",
                        help="no training: measure and export")
    parser.add_argument("--dense-size", type=int, action="append", default=[],
                        help="a further image size for features of places; "
                        "may be repeated")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cache", type=Path, default=drawings.default_cache())
    for name, value in (("width", 144), ("layers", 3), ("heads", 3),
                        ("text-width", 128), ("text-layers", 2),
                        ("text-heads", 4), ("batch", 256), ("pool", 8192),
                        ("reuse", 4), ("views", 240), ("backgrounds", 400),
                        ("workers", 1), ("threads", 2), ("every", 50),
                        ("test-images", 2000)):
        parser.add_argument("--" + name, type=int, default=value)
    parser.add_argument("--rate", type=float, default=1e-3)
    parser.add_argument("--save-minutes", type=float, default=4)
    return parser.parse_args()


def main():
    arguments = parse()
    torch.set_num_threads(arguments.threads)
    Library(arguments.cache, arguments.seed, arguments.views,
            arguments.backgrounds, quiet=False)
    state = Training(arguments)
    stop = []
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: stop.append(True))
    if not arguments.evaluate:
        train(state, stop)
        if stop:  # It goes on from its checkpoint when it is started again.
            return 130
    with torch.no_grad():
        measured = evaluate(state.model, state.tokenizer, arguments)
    (arguments.work / "measured.json").write_text(json.dumps(measured,
                                                             indent=2))
    for name, values in measured.items():
        print(f"{name}: {100 * values['accuracy']:.1f} % of "
              f"{values['images']}; least: {', '.join(values['worst'])}")
    export(state, measured)
    return 0


if __name__ == "__main__":
    sys.exit(main())
