#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of scripts/export_clip.py; exits with 77, which means skipped, where
PyTorch, PIL or the xxHash library is missing."""
import json
import sys
import tempfile
import unittest
from ctypes.util import find_library
from pathlib import Path

SCRIPTS = Path(__file__).resolve().parents[2] / "scripts"
sys.path.insert(0, str(SCRIPTS))
try:
    import torch
except ImportError:
    print("skipped: python3-torch is not installed")
    sys.exit(77)
try:
    import PIL.Image  # noqa: F401
except ImportError:
    print("skipped: python3-pil is not installed")
    sys.exit(77)
if find_library("xxhash") is None:
    print("skipped: libxxhash0 is not installed")
    sys.exit(77)

import check_clip_export as reference  # noqa: E402
import export_clip  # noqa: E402
from clip_checkpoint import (Architecture, CheckpointError,  # noqa: E402
                             architecture_of, random_checkpoint,
                             read_checkpoint)
from small_clip.network import SmallClip  # noqa: E402

MERGES = "#version: 0.2\nr e\nre d</w>\n"
ARCH = Architecture(image_size=16, patch=8, width=16, layers=2, heads=2,
                    embedding_dim=8, text_width=12, text_layers=2,
                    text_heads=3, context_length=77, vocab_size=516)


class Node(torch.nn.Module):
    """A part of a model that only holds parameters."""

    def forward(self, x):
        return x


class ExportClipTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "merges.txt").write_text(MERGES)
        self.state = random_checkpoint(ARCH, seed=3)

    def assert_same(self, state):
        self.assertEqual(set(state), set(self.state))
        for name, tensor in self.state.items():
            self.assertTrue(torch.equal(state[name], tensor), name)

    def export(self, out, **options):
        export_clip.export_folder(self.state, ARCH,
                                  self.folder / "merges.txt", out,
                                  export_clip.ModelCard("a", "b", "c"),
                                  **options)

    def test_reads_a_state_dict(self):
        torch.save(self.state, self.folder / "model.pt")
        state, arch = read_checkpoint(self.folder / "model.pt")
        self.assert_same(state)
        self.assertEqual((arch.width, arch.layers, arch.grid), (16, 2, 2))

    def test_reads_torch_script(self):
        root = Node()
        for name, tensor in self.state.items():
            *path, last = name.split(".")
            node = root
            for part in path:
                if not hasattr(node, part):
                    node.add_module(part, Node())
                node = getattr(node, part)
            # OpenAI's archives are in half precision.
            node.register_parameter(last, torch.nn.Parameter(tensor.half()))
        torch.jit.script(root).save(str(self.folder / "model.pt"))
        self.state = {name: tensor.half().float()
                      for name, tensor in self.state.items()}
        self.assert_same(read_checkpoint(self.folder / "model.pt")[0])

    def test_says_what_reads_other_files(self):
        for name in ("x.safetensors", "."):
            with self.assertRaisesRegex(CheckpointError, "freegs_pipeline"):
                read_checkpoint(self.folder / name)
        with self.assertRaisesRegex(CheckpointError, "no such file"):
            read_checkpoint(self.folder / "missing.pt")

    def test_refuses_other_architectures(self):
        del self.state["visual.proj"]
        with self.assertRaisesRegex(CheckpointError, "visual.proj"):
            architecture_of(self.state)

    def test_networks_are_what_they_stand_for(self):
        for activation in ("quick_gelu", "gelu"):
            arch = Architecture(**{**vars(ARCH), "activation": activation})
            with torch.no_grad():
                for size, dense in ((16, False), (16, True), (40, True)):
                    image = torch.randn(1, 3, size, size)
                    network = export_clip.Visual(self.state, arch, size, dense)
                    wanted = reference.encode_image(self.state, arch, image[0],
                                                    dense)
                    result = network.eval()(image)[0]
                    result = result.flatten(1).t() if dense else result
                    torch.testing.assert_close(result, wanted, rtol=1e-3,
                                               atol=1e-4)
                ids = [514, 3, 77, 512, 515]
                padded = ids + [0] * (77 - len(ids))
                vectors = self.state["token_embedding.weight"][padded][None]
                result = export_clip.Text(self.state, arch).eval()(vectors)
                torch.testing.assert_close(
                    result[0, 4], reference.encode_text(self.state, arch, ids),
                    rtol=1e-3, atol=1e-4)

    def test_small_network_is_exported_as_it_was_trained(self):
        arch = Architecture(image_size=32, patch=16, width=24, layers=2,
                            heads=2, embedding_dim=8, text_width=12,
                            text_layers=1, text_heads=3, context_length=32,
                            vocab_size=516)
        model = SmallClip(arch).eval()
        for parameter in model.parameters():
            torch.nn.init.normal_(parameter, std=0.2)
        state = {name: value.detach()
                 for name, value in model.state_dict().items()}
        with torch.no_grad():
            for size in (32, 64):
                images = torch.randn(1, 3, size, size)
                whole, patches = model.visual(images)
                result = export_clip.Visual(state, arch, size, dense=False)
                torch.testing.assert_close(result.eval()(images), whole,
                                           rtol=1e-3, atol=1e-4)
                result = export_clip.Visual(state, arch, size, dense=True)
                torch.testing.assert_close(
                    result.eval()(images).flatten(2).transpose(1, 2), patches,
                    rtol=1e-3, atol=1e-4)

    def test_equal_parameters_are_told_apart(self):
        for name, tensor in self.state.items():
            if name.endswith("bias"):
                tensor.zero_()
        text = export_clip.Text(self.state, ARCH)
        export_clip.make_distinct(text)
        values = [(tuple(p.shape), p.data.numpy().tobytes())
                  for p in text.parameters()]
        self.assertEqual(len(values), len(set(values)))

    def test_writes_the_folder(self):
        out = self.folder / "out"
        self.export(out, dense_sizes=[32])
        info = json.loads((out / "model.json").read_text())
        self.assertEqual(info["dense"][1],
                         {"file": "dense32.onnx", "image_size": 32, "grid": 4})
        self.assertEqual(info["vocab_size"], 516)
        self.assertEqual(
            set(info["files"]) | {"model.json"},
            {path.name for path in out.iterdir()})
        for name, file in info["files"].items():
            self.assertEqual(file["bytes"], (out / name).stat().st_size)
            self.assertEqual(len(file["hash"]), 32)
        # What an export that was killed has left.
        (self.folder / "out.part").mkdir()
        (self.folder / "out.part/visual.onnx").write_text("")
        self.export(out)  # A model folder may be replaced.
        self.assertFalse((out / "dense32.onnx").exists())
        self.assertEqual([path.name for path in self.folder.iterdir()
                          if path.name.endswith(".part")], [])

    def test_refuses_what_does_not_fit(self):
        out = self.folder / "out"
        with self.assertRaisesRegex(CheckpointError, "multiple of"):
            self.export(out, dense_sizes=[30])
        (self.folder / "merges.txt").write_text(MERGES + "a b\n")
        with self.assertRaisesRegex(CheckpointError, "517 tokens"):
            self.export(out)
        self.assertFalse(out.exists())
        (self.folder / "merges.txt").write_text(MERGES)
        with self.assertRaisesRegex(CheckpointError, "not a model folder"):
            self.export(self.folder)
        self.assertTrue((self.folder / "merges.txt").exists())

    def test_leaves_what_is_not_its_own(self):
        out = self.folder / "out"
        out.mkdir()
        (out / "model.json").write_text('{"modelTopology": {}}')
        with self.assertRaisesRegex(CheckpointError, "not a model folder"):
            self.export(out)
        self.assertTrue((out / "model.json").exists())
        part = self.folder / "new.part"
        part.mkdir()
        (part / "mine").write_text("")
        with self.assertRaisesRegex(CheckpointError, "in the way"):
            self.export(self.folder / "new")
        self.assertTrue((part / "mine").exists())

    def test_names_damaged_files(self):
        (self.folder / "merges.txt").write_bytes(b"\x1f\x8b\x08\x00")
        with self.assertRaisesRegex(CheckpointError, "merges.txt: damaged"):
            self.export(self.folder / "out")
        page = self.folder / "page.pt"
        page.write_text("<html>not found</html>")
        with self.assertRaisesRegex(CheckpointError, "page.pt: damaged"):
            read_checkpoint(page)


if __name__ == "__main__":
    unittest.main()
