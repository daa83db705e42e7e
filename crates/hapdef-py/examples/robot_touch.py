"""A robot in MuJoCo with a hapdef skin on its forearm: touch, estimated live, beside MuJoCo's own contacts.

    pip install mujoco pillow
    python robot_touch.py                         the bundled arm
    python robot_touch.py --urdf arm.urdf --link forearm --touch-range-m 0.06 0.18
    python robot_touch.py --balance               only check by mechanics what MuJoCo says of the link

An arm of a URDF moves by smooth random ways, its joints position-controlled; two force-controlled fingers press its
forearm. What MuJoCo says of contacts, motion and wrist goes into the simulated hardware, and what the sensor finds is
compared with MuJoCo's contacts.
"""

import argparse
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BUNDLED = ROOT / "fixtures/arm/arm.urdf"
# The bundled limb is touchable there, and not within a wall of its wrist.
BUNDLED_RANGE_M = (0.058, 0.15)


def arguments():
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--urdf", type=Path, default=BUNDLED, help="the robot (the bundled arm)")
    parser.add_argument("--link", default="forearm", help="the touched link")
    parser.add_argument(
        "--touch-range-m",
        type=float,
        nargs=2,
        default=BUNDLED_RANGE_M,
        help="where along the way from the link's joint to the next it is touched",
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the touched run")
    parser.add_argument("--seed", type=int, default=1, help="of motion and presses")
    parser.add_argument("--balance", action="store_true", help="only check the mechanics of the run")
    parser.add_argument("--video", type=Path, help="animated WebP")
    parser.add_argument("--picture", type=Path, help="one picture, of the strongest moment of the video")
    return parser.parse_args()


def main():
    """Runs what was asked for."""
    args = arguments()
    try:
        import mujoco  # noqa: F401
    except ImportError:
        print("this example needs MuJoCo: pip install mujoco pillow", file=sys.stderr)
        sys.exit(2)
    from robot_sim.arm import Arm
    from robot_sim.balance import ALLOWED, check
    from robot_sim.world import World

    arm = Arm(args.urdf, args.link)
    world = World(arm, args.seed, args.seconds, args.touch_range_m)
    ticks = list(world.ticks())
    print(f"{len(world.presses)} presses in {args.seconds:g} s")
    for name, error in check(arm, ticks).items():
        print(f"METRIC:robot.balance_{name}:{error:.2e}:")
        if not error <= ALLOWED[name]:
            sys.exit(f"the law {name} is off by {error:.2e}, more than {ALLOWED[name]:.0e}")


if __name__ == "__main__":
    main()
