"""A design sweep as Dask tasks: walls and numbers of gauges of the bundled skin, by what they can tell.

    python scale_out.py                 on a local cluster, two processes
    python scale_out.py --check         the same, and serially; fails if a number differs
    python scale_out.py --shard 1/4     every fourth design from the first, for a job array
    python scale_out.py --scheduler tcp://HOST:8786

Each design is one task: a shell is solved, and the Cramér-Rao bound on a contact's position taken over its
skin. A design is a few numbers and so is its result, so that nothing large travels. One line of JSON each.
"""

import argparse
import itertools
import json
import subprocess
import sys
import time
from pathlib import Path

import numpy as np

SKIN = Path(__file__).resolve().parents[3] / "fixtures/shin/shin_skin.glb"
WALLS_M = (0.8e-3, 1.0e-3, 1.5e-3, 2.0e-3)
N_GAUGES = (6, 10)
NOISE_UE = 1.0
FORCE_N = 10.0


def designs():
    """Wall, m, and number of gauges of every design."""
    return list(itertools.product(WALLS_M, N_GAUGES))


def of_shard(part, parts):
    """The designs of shard `part` of `parts`, from 1."""
    return designs()[part - 1 :: parts]


def judge(design):
    """What a design can tell; runs anywhere the skin's file is."""
    import hapdef

    wall_m, n_gauges = design
    shell = hapdef.Shell(SKIN, wall_m=wall_m, n_gauges=n_gauges, threads=1)
    bounds = shell.response().bounds(noise_ue=NOISE_UE, force_n=FORCE_N, n_sites=200)
    # The held end is blind: infinite bounds sort last.
    return {
        "wall_mm": 1e3 * wall_m,
        "n_gauges": n_gauges,
        "median_best_ue_per_n": shell.median_best_ue_per_n,
        "single_median_mm": 1e3 * float(np.quantile(bounds.single_m, 0.5, method="lower")),
        "blind_share": len(bounds.blind_nodes) / len(bounds.single_m),
        "n_carried": bounds.n_carried,
    }


def in_parallel(todo, scheduler):
    """Results in the order of the designs, from a cluster that is there or a local one."""
    from dask.distributed import Client, LocalCluster

    if scheduler:
        with Client(scheduler) as client:
            return client.gather(client.map(judge, todo))
    cluster = LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, Client(cluster) as client:
        return client.gather(client.map(judge, todo))


def shard(text):
    """`i/n` as two numbers."""
    part, _, parts = text.partition("/")
    if not (part.isdigit() and parts.isdigit() and 1 <= int(part) <= int(parts)):
        raise argparse.ArgumentTypeError(f"expected i/n with i from 1 to n, found {text!r}")
    return int(part), int(parts)


def check_shards(results, parts=4):
    """All shards are all designs, each once, and one started by itself gives the whole's lines."""
    together = [design for part in range(1, parts + 1) for design in of_shard(part, parts)]
    assert sorted(together) == sorted(designs()), f"shards of {parts} are not the whole: {together}"
    command = [sys.executable, __file__, "--shard", f"2/{parts}"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    alone = [json.loads(line) for line in done.stdout.splitlines()]
    assert alone == results[1::parts], f"shard 2/{parts} alone differs: {alone}"


def main():
    """Runs the designs and prints a line each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true", help="also serially; both must be equal")
    parser.add_argument("--shard", type=shard, help="i/n: serially, every n-th design from the i-th")
    parser.add_argument("--scheduler", help="address of a Dask scheduler")
    args = parser.parse_args()
    if args.shard:
        part, parts = args.shard
        for design in of_shard(part, parts):
            print(json.dumps(judge(design)))
        return
    start = time.monotonic()
    results = in_parallel(designs(), args.scheduler)
    parallel_s = time.monotonic() - start
    for result in results:
        print(json.dumps(result))
    if args.check:
        start = time.monotonic()
        serial = [judge(design) for design in designs()]
        serial_s = time.monotonic() - start
        if serial != results:
            sys.exit("the cluster's results differ from the serial ones")
        check_shards(results)
        print(
            f"equal to the serial run, to the last bit: {len(serial)} designs, {parallel_s:.1f} s "
            f"on the cluster, {serial_s:.1f} s serially",
            file=sys.stderr,
        )


if __name__ == "__main__":
    main()
