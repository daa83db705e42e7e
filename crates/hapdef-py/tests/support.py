"""What the tests have in common: the bundled limb, the program `hapdef`, its files."""

import json
import os
import struct
import subprocess
from pathlib import Path

import numpy as np

import hapdef

ROOT = Path(__file__).resolve().parents[3]
PLACED = ROOT / "fixtures/shin/placed.json"
SHIN = ROOT / "fixtures/shin/scene.json"
SKIN = ROOT / "fixtures/shin/shin_skin.glb"
# What the demo and the docs' commands have solved already is taken from there.
OUT = Path(os.environ.get("HAPDEF_OUT", ROOT / "target/hapdef"))
PROGRAM = os.environ.get("HAPDEF_BIN", str(ROOT / "target/release/hapdef"))
THREADS = 2


def placed(**more):
    """The bundled limb with its gauges placed, contacts by superposition."""
    return hapdef.Scene(PLACED, results=OUT, threads=THREADS, **more)


def program(*words):
    """What the program `hapdef` prints."""
    done = subprocess.run([PROGRAM, *map(str, words)], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr)
    return done.stdout


def tensor(path, name):
    """A tensor of a safetensors file."""
    data = Path(path).read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    entry = json.loads(data[8 : 8 + length])[name]
    begin, end = entry["data_offsets"]
    dtype = {"F64": "<f8", "F32": "<f4", "U32": "<u4"}[entry["dtype"]]
    part = data[8 + length + begin : 8 + length + end]
    return np.frombuffer(part, dtype).reshape(entry["shape"])


def spread(scene, n, seed):
    """Random surface nodes' positions, m, and forces from 5 to 30 N."""
    rng = np.random.default_rng(seed)
    nodes = rng.choice(scene.n_surface_nodes, n, replace=False)
    return scene.surface_m[nodes], rng.uniform(5.0, 30.0, n)
