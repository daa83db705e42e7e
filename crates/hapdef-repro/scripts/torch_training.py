"""PyTorch's training speed, for `hapdef-repro bench-nets`.

    python torch_training.py THREADS INPUTS WIDTH... OUTPUTS

Builds a fully connected ReLU net, says "ready VERSION" (or "missing REASON") and answers each line
"BATCH STEPS" with the seconds that so many steps took: draw a batch with replacement, forward, root
mean square error, backward, fused Adam; all in 32 bits.
"""

import sys
import time


def prepare(torch, widths):
    layers = []
    for n_in, n_out in zip(widths, widths[1:]):
        layers += [torch.nn.Linear(n_in, n_out), torch.nn.ReLU()]
    net = torch.nn.Sequential(*layers[:-1])
    try:
        adam = torch.optim.Adam(net.parameters(), lr=1e-4, fused=True)
    except RuntimeError:
        adam = torch.optim.Adam(net.parameters(), lr=1e-4, foreach=True)
    n = 2048
    return net, adam, torch.randn(n, widths[0]), torch.randn(n, widths[-1])


def steps(torch, prepared, batch, count):
    net, adam, x, y = prepared
    for _ in range(count):
        rows = torch.randint(len(x), (batch,))
        adam.zero_grad(set_to_none=True)
        loss = (net(x[rows]) - y[rows]).square().mean().sqrt()
        loss.backward()
        adam.step()


def main():
    threads, widths = int(sys.argv[1]), [int(width) for width in sys.argv[2:]]
    try:
        import torch
    except ImportError as error:
        print(f"missing {error}", flush=True)
        return
    torch.set_num_threads(threads)
    prepared = prepare(torch, widths)
    print(f"ready {torch.__version__}", flush=True)
    for line in sys.stdin:
        batch, count = line.split()
        start = time.perf_counter()
        steps(torch, prepared, int(batch), int(count))
        print(time.perf_counter() - start, flush=True)


main()
