"""A robot in MuJoCo with a hapdef skin on its forearm: touch, estimated live, beside MuJoCo's own contacts.

    pip install mujoco pillow
    python robot_touch.py                         the bundled arm
    python robot_touch.py --urdf robot.urdf --link forearm --touch-range-m 0.06 0.18 --scene my-forearm/scene.json
    python robot_touch.py --video touch.webp --picture touch.png
    python robot_touch.py --check                 shorter; fails if it is worse than it should be
    python robot_touch.py --balance               only check by mechanics what MuJoCo says of the link

An arm of a URDF moves by smooth random ways, its joints position-controlled. First nothing touches it, somebody shakes its
hand, and the sensor learns what motion does to its gauges. Then two force-controlled fingers press its forearm. What
MuJoCo says of contacts, motion and wrist goes into the simulated hardware, which has an inertial unit and a sensor of
force at its flange; what is found is compared with MuJoCo's contacts.
"""

import argparse
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]
BUNDLED = ROOT / "fixtures/arm/arm.urdf"
BUNDLED_SCENE = ROOT / "fixtures/shin/moving.json"
# The bundled limb is touchable there, and not within a wall of its wrist.
BUNDLED_RANGE_M = (0.058, 0.15)
# The untouched run is another one than the touched of the same seed.
UNTOUCHED_SEED = 1000
# Seconds of the touched run that the video shows, and its frames per second.
VIDEO_S, VIDEO_HZ, VIDEO_SIZE = (1.5, 11.5), 25, (640, 480)
# A short run, two minutes of one core in all: untouched and touched, s, and its seed, that of development.
CHECK_S, CHECK_SEED = (12.0, 12.0), 5
# What it must reach: the coarse map is off by a fifth, and 12 s are too short to judge how often nothing is felt.
BOUNDS = {
    "found_pct": (90.0, 100.0),
    "position_median_mm": (0.0, 2.0),
    "onset_p50_ms": (0.0, 10.0),
}


def arguments():
    """What the command line says."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--urdf", type=Path, default=BUNDLED, help="the robot (the bundled arm)")
    parser.add_argument("--link", default="forearm", help="the touched link")
    parser.add_argument("--scene", type=Path, default=BUNDLED_SCENE, help="the link's scene, in the link's frame")
    parser.add_argument(
        "--touch-range-m",
        type=float,
        nargs=2,
        default=BUNDLED_RANGE_M,
        help="where along the way from the link's joint to the next it is touched",
    )
    parser.add_argument("--seconds", type=float, default=60.0, help="length of the touched run")
    parser.add_argument("--learn-seconds", type=float, default=30.0, help="length of the untouched run")
    parser.add_argument("--seed", type=int, default=1, help="of motion and presses")
    parser.add_argument("--folder", type=Path, default=Path("target/robot"), help="for the scene and what it learns")
    parser.add_argument("--check", action="store_true", help="a short run that must reach some figures")
    parser.add_argument("--balance", action="store_true", help="only check the mechanics of the run")
    parser.add_argument("--video", type=Path, help="animated WebP")
    parser.add_argument("--picture", type=Path, help="one picture, of the strongest moment of the video")
    args = parser.parse_args()
    if args.check:
        (args.learn_seconds, args.seconds), args.seed = CHECK_S, CHECK_SEED
    return args


def main():
    """Runs what was asked for."""
    args = arguments()
    # Without a screen MuJoCo draws by EGL, or where there is none, by OSMesa: MUJOCO_GL=osmesa. It looks when imported.
    os.environ.setdefault("MUJOCO_GL", "egl" if args.video or args.picture else "disable")
    try:
        import mujoco  # noqa: F401
    except ImportError:
        print("this example needs MuJoCo: pip install mujoco pillow", file=sys.stderr)
        sys.exit(2)
    from robot_sim.arm import Arm
    from robot_sim.world import World

    arm = Arm(args.urdf, args.link)
    world = World(arm, args.seed, args.seconds, args.touch_range_m)
    print(f"{len(world.presses)} presses in {args.seconds:g} s")
    if args.balance:
        balance(arm, list(world.ticks()))
        return
    skin = prepared(arm, args)
    ticks, reported = touched(skin, world, args)
    balance(arm, ticks)
    judge(ticks, reported, args.check)


def balance(arm, ticks):
    """Checks a run by the laws of mechanics."""
    from robot_sim.balance import ALLOWED, check

    for name, error in check(arm, ticks).items():
        print(f"METRIC:robot.balance_{name}:{error:.2e}:")
        if not error <= ALLOWED[name]:
            sys.exit(f"the law {name} is off by {error:.2e}, more than {ALLOWED[name]:.0e}")


def prepared(arm, args):
    """The skin after calibration and an untouched run."""
    from robot_sim.skin import Skin
    from robot_sim.world import STILL_S, World

    untouched = World(arm, UNTOUCHED_SEED + args.seed, args.learn_seconds, args.touch_range_m, is_touched=False)
    ticks = list(untouched.ticks())
    skin = Skin(args.scene, args.folder, ticks)
    before, after = skin.calibrate(is_coarse=args.check)
    print(f"calibrated: relative error of the map {before:.3f}, then {after:.3f}")
    left_ue = skin.learn(ticks, STILL_S)
    print("loads that the signals leave, µε:", ", ".join(f"{each:.1f}" for each in left_ue) or "none")
    return skin


def touched(skin, world, args):
    """Runs the world and the sensor side by side: what was and what was found, frame by frame."""
    import hapdef
    from robot_sim.skin import reports
    from robot_sim.world import RATE_HZ

    film = Film(world, args) if args.video or args.picture else None
    sensor = hapdef.TouchSensor(skin.scene, rate_hz=RATE_HZ)
    ticks, reported = [], []
    for tick in world.ticks():
        frame = skin.step(sensor, tick)
        ticks.append(tick)
        reported.append(reports(frame))
        if film:
            film.take(tick, frame)
    if film:
        film.save()
    return ticks, reported


class Film:
    """Pictures of a part of the run, with true and estimated contacts."""

    def __init__(self, world, args):
        from robot_sim.picture import Camera

        self.camera, self.args = Camera(world, *VIDEO_SIZE), args
        self.pictures, self.strengths_n = [], []

    def take(self, tick, frame):
        """A picture, if it is time."""
        n_before = len(self.pictures)
        if not VIDEO_S[0] + n_before / VIDEO_HZ <= tick.time_s < VIDEO_S[1]:
            return
        known = [each for each in frame.contacts if each.direction is not None]
        estimated = [(each.position_m, each.force_n * each.direction) for each in known]
        self.pictures.append(self.camera.picture(tick, estimated))
        shown = min(len(estimated), int(tick.touching().sum()))
        self.strengths_n.append((shown, float(abs(tick.forces_n).sum())))

    def save(self):
        """Writes what was asked for."""
        from robot_sim.picture import save_picture, save_video

        self.camera.close()
        if self.args.video:
            save_video(self.args.video, self.pictures, VIDEO_HZ)
        if self.args.picture:
            save_picture(self.args.picture, self.pictures[self.strengths_n.index(max(self.strengths_n))])


def judge(ticks, reported, is_checked):
    """Prints the figures; a checked run fails where they are out of bounds."""
    from robot_sim.score import score

    missed = []
    for name, value, unit in score(ticks, reported):
        print(f"METRIC:robot.{name}:{value:.4g}:{unit}")
        low, high = BOUNDS.get(name, (-float("inf"), float("inf")))
        if not low <= value <= high:
            missed.append(f"{name} is {value:.4g}, expected {low:g} to {high:g}")
    if is_checked and missed:
        sys.exit("; ".join(missed))


if __name__ == "__main__":
    main()
