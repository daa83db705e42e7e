"""ONNX Runtime and PyTorch on the weights that `hapdef-repro bench-nets` wrote.

    python nets_peers.py FOLDER

Reads FOLDER/nets.json and FOLDER/weights.f32, prepares every row that the installed packages
allow, prints one JSON line about them, then answers each line "round" on its input with one JSON
line of times in microseconds, and "frames ROW" with "done" after it has sent each frame of
FOLDER/frames.f32 through the row, to FOLDER/outputs.f32. One thread, one core, batch one.
"""

import json
import os
import sys
import time
from pathlib import Path

for name in ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS"):
    os.environ[name] = "1"
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})

WARM_UP = 4
TIMED = 25


def read(folder):
    import numpy as np

    about = json.loads((folder / "nets.json").read_text())
    flat = np.fromfile(folder / "weights.f32", dtype="<f4")
    layers, at = [], 0
    for layer in about["layers"]:
        n_in, n_out = layer["inputs"], layer["outputs"]
        weights = flat[at : at + n_in * n_out].reshape(n_out, n_in)
        at += n_in * n_out
        layers.append((weights, flat[at : at + n_out], layer["activation"]))
        at += n_out
    x = np.array(about["x"], dtype=np.float32)[None, :]
    return layers, x, np.array(about["y"], dtype=np.float32)


def onnx_file(folder, layers):
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    nodes, constants, current = [], [], "x"
    for i, (weights, bias, activation) in enumerate(layers):
        constants.append(numpy_helper.from_array(weights.T.copy(), f"w{i}"))
        constants.append(numpy_helper.from_array(bias.copy(), f"b{i}"))
        nodes.append(helper.make_node("MatMul", [current, f"w{i}"], [f"m{i}"]))
        nodes.append(helper.make_node("Add", [f"m{i}", f"b{i}"], [f"z{i}"]))
        current = f"z{i}"
        if activation:
            kind = {"relu": "Relu", "tanh": "Tanh"}[activation]
            nodes.append(helper.make_node(kind, [current], [f"a{i}"]))
            current = f"a{i}"
    shape = lambda name, n: helper.make_tensor_value_info(name, TensorProto.FLOAT, [1, n])
    graph = helper.make_graph(
        nodes,
        "nets",
        [shape("x", layers[0][0].shape[1])],
        [shape(current, layers[-1][0].shape[0])],
        constants,
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)])
    model.ir_version = 8
    path = folder / "nets.onnx"
    onnx.save(model, path)
    return path


def onnx_runtime(path):
    import onnxruntime as ort

    options = ort.SessionOptions()
    options.intra_op_num_threads = 1
    options.inter_op_num_threads = 1
    session = ort.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    return as_it_is, lambda x: session.run(None, {"x": x})[0]


def as_it_is(x):
    return x


def onnx_f32(folder, layers):
    return onnx_runtime(onnx_file(folder, layers))


def onnx_int8(folder, layers):
    from onnxruntime.quantization import QuantType, quantize_dynamic

    path = folder / "nets-int8.onnx"
    quantize_dynamic(
        onnx_file(folder, layers), path, per_channel=True, weight_type=QuantType.QInt8
    )
    return onnx_runtime(path)


def torch_modules(layers):
    import torch

    modules = []
    for weights, bias, activation in layers:
        linear = torch.nn.Linear(weights.shape[1], weights.shape[0])
        with torch.no_grad():
            linear.weight.copy_(torch.from_numpy(weights.copy()))
            linear.bias.copy_(torch.from_numpy(bias.copy()))
        modules.append(linear)
        if activation:
            modules.append({"relu": torch.nn.ReLU, "tanh": torch.nn.Tanh}[activation]())
    return torch.nn.Sequential(*modules).eval()


def torch_call(net):
    import torch

    def call(x):
        with torch.inference_mode():
            return net(x)

    return call


def torch_f32(folder, layers):
    import torch

    return torch.from_numpy, torch_call(torch_modules(layers))


def torch_int8(folder, layers):
    import torch

    net = torch.ao.quantization.quantize_dynamic(
        torch_modules(layers), {torch.nn.Linear}, dtype=torch.qint8
    )
    return torch.from_numpy, torch_call(net)


ROWS = {
    "ort f32": ("onnxruntime", onnx_f32),
    "ort int8": ("onnxruntime", onnx_int8),
    "torch f32": ("torch", torch_f32),
    "torch int8": ("torch", torch_int8),
}


def as_numpy(out):
    return out.float().numpy() if hasattr(out, "float") else out


def error_of(out, expected):
    import numpy as np

    return float(np.abs(out[0] - expected).max() / np.abs(expected).max())


def prepare(folder):
    layers, x, expected = read(folder)
    ways, rows, missing = {}, {}, {}
    for name, (package, make) in ROWS.items():
        try:
            module = __import__(package)
            if package == "torch":
                module.set_num_threads(1)
            to_own, call = make(folder, layers)
            out = as_numpy(call(to_own(x)))
            ways[name] = (to_own, call, to_own(x))
            program = f"{package} {module.__version__}"
            rows[name] = {"program": program, "relative_error": error_of(out, expected)}
        except Exception as error:  # a package that is not there, or that cannot do this
            ways.pop(name, None)
            missing[name] = f"{type(error).__name__}: {error}".splitlines()[0]
    return ways, {"rows": rows, "missing": missing}


def timed(call, x):
    for _ in range(WARM_UP):
        call(x)
    micros = []
    for _ in range(TIMED):
        start = time.perf_counter_ns()
        call(x)
        micros.append((time.perf_counter_ns() - start) / 1000)
    return micros


def frames(folder, to_own, call, x):
    import numpy as np

    all_frames = np.fromfile(folder / "frames.f32", dtype="<f4").reshape(-1, *x.shape)
    outputs = [as_numpy(call(to_own(frame)))[0] for frame in all_frames]
    np.concatenate(outputs).astype("<f4").tofile(folder / "outputs.f32")


def main():
    folder = Path(sys.argv[1])
    out = os.fdopen(os.dup(1), "w", buffering=1)
    os.dup2(2, 1)  # what libraries print must not mix with the answers
    ways, about = prepare(folder)
    print(json.dumps(about), file=out)
    for line in sys.stdin:
        word, _, name = line.strip().partition(" ")
        if word == "round":
            times = {name: timed(call, x) for name, (_, call, x) in ways.items()}
            print(json.dumps(times), file=out)
        elif word == "frames" and name in ways:
            to_own, call, x = ways[name]
            frames(folder, to_own, call, x)
            print("done", file=out)
        else:
            break


if __name__ == "__main__":
    main()
