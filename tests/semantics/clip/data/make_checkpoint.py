#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes the random numbers of tiny_clip as OpenCLIP's files, into
tiny_checkpoint beside this file. scripts/export_clip.py made tiny_clip of the
same numbers. Needs PyTorch."""
import json
import struct
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
sys.path.insert(0, str(FOLDER.parents[3] / "scripts"))
from clip_checkpoint import Architecture, random_checkpoint  # noqa: E402

state = random_checkpoint(
    Architecture(image_size=16, patch=8, width=16, layers=2, heads=2,
                 embedding_dim=8, text_width=16, text_layers=1, text_heads=2,
                 context_length=77, vocab_size=525), seed=1)
header = {}
data = b""
for name, tensor in state.items():
    numbers = tensor.contiguous().numpy().tobytes()
    header[name] = {"dtype": "F32", "shape": list(tensor.shape),
                    "data_offsets": [len(data), len(data) + len(numbers)]}
    data += numbers
text = json.dumps(header).encode()
out = FOLDER / "tiny_checkpoint"
out.mkdir(exist_ok=True)
(out / "open_clip_model.safetensors").write_bytes(
    struct.pack("<Q", len(text)) + text + data)
(out / "open_clip_config.json").write_text(json.dumps({"model_cfg": {
    "embed_dim": 8, "quick_gelu": True, "vision_cfg": {"head_width": 8},
    "text_cfg": {"heads": 2}}}) + "\n")
