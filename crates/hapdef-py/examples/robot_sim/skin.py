"""The skin on the touched link: its scene with what the motion needs, its calibration, and a step of its sensor."""

import json
from pathlib import Path

import hapdef
import numpy as np

from .arm import FRICTION
from .score import Report

# Presses that calibrate the map, as `hapdef demo` has them, and where their places and forces come from.
N_PRESSES = 300
PRESS_SEED = 36
# The flange's nodes lie within that of the limb's far end.
FLANGE_M = 0.004
# Loads take most of a converter's range. Steps of 12 bits were 4 µε then, four times the noise, and what readings were off
# by them was taken for drift: 69 % of the contacts were found instead of all.
ADC_BITS = 16
# A scene's paths are relative to it; this one is written elsewhere.
PATHS = ("solid_deck", "skin")


class Skin:
    """A scene in a folder of its own, with the loads that the motion of a robot puts on its limb."""

    def __init__(self, base, folder, untouched):
        self.folder = Path(folder)
        self.folder.mkdir(parents=True, exist_ok=True)
        self.spec = json.loads(Path(base).read_text())
        geometry = self.spec["geometry"]
        for name in PATHS:
            if name in geometry:
                geometry[name] = str((Path(base).parent / geometry[name]).resolve())
        self.spec["name"] = "robot"
        # Fingers drag along the skin: without it the drag of a press is taken for further contacts.
        self.spec.setdefault("estimator", {"kind": "superposition"})["friction"] = FRICTION
        rig = self.spec.setdefault("rig", {})
        rig.setdefault("electronics", {})["adc_bits"] = ADC_BITS
        rig["live"] = {"load_sensors": {}}
        axis = geometry["axis"]
        self.axis_point_m, direction = np.array(axis["point_m"]), np.array(axis["direction"])
        self.axis_direction = direction / np.linalg.norm(direction)
        self.spec.pop("loads", None)
        self.flange_m = self.flange_middle(self.write("limb").surface_m)
        self.spec["loads"] = self.loads(untouched)
        self.scene = self.write("scene")

    def write(self, name):
        """Writes the scene and opens it."""
        path = self.folder / f"{name}.json"
        path.write_text(json.dumps(self.spec, indent=1))
        return hapdef.Scene(path, results=self.folder / "cache")

    def flange_middle(self, surface_m):
        """The middle of the limb's far end, where the next link is fixed."""
        along = (surface_m - self.axis_point_m) @ self.axis_direction
        return surface_m[along > along.max() - FLANGE_M].mean(axis=0)

    def loads(self, ticks):
        """The scene's loads, as strong as in an untouched motion: they set the range of the converters."""

        def rms(values):
            return float(np.sqrt(np.mean(np.square(values), axis=0)).max())

        motion = [self.motion(tick) for tick in ticks]
        of = {name: rms([each[name] for each in motion]) for name in motion[0]}
        return {
            "flange": {
                "at": {"kind": "end", "end": "high", "length_m": FLANGE_M},
                "force_sd_n": of["flange_force_n"],
                "moment_sd_nm": of["flange_moment_nm"],
            },
            "specific_force_sd_m_s2": of["specific_force_m_s2"],
            "angular_rate_sd_rad_s": of["angular_rate_rad_s"],
            "angular_acceleration_sd_rad_s2": of["angular_acceleration_rad_s2"],
        }

    def motion(self, tick):
        """How the link is loaded as a whole, by the names that a step has for it."""
        return {
            "specific_force_m_s2": tick.specific_force_m_s2,
            "angular_rate_rad_s": tick.angular_rate_rad_s,
            "angular_acceleration_rad_s2": tick.angular_acceleration_rad_s2,
            "flange_force_n": tick.wrist_force_n,
            "flange_moment_nm": tick.wrist_moment_nm - np.cross(self.flange_m, tick.wrist_force_n),
        }

    def calibrate(self, is_coarse=False):
        """Corrects the map by presses of the rig that stands still; its relative error before and after.

        A coarse one starts from the limb's own mesh, which is sooner solved than the refined one.
        """
        if is_coarse:
            self.spec["estimator"]["map_refinements"] = 0
            self.scene = self.write("scene")
        rng = np.random.default_rng(PRESS_SEED)
        places_m = self.scene.surface_m[rng.integers(len(self.scene.surface_m), size=N_PRESSES)]
        forces_n = rng.uniform(5.0, 30.0, N_PRESSES)
        readings_ue = self.scene.rig().press(places_m, forces_n, seed=PRESS_SEED)
        calibration = self.scene.calibrate(places_m, forces_n, readings_ue)
        calibration.write(self.folder / "calibration.json.gz")
        self.spec["estimator"]["calibration"] = "calibration.json.gz"
        self.scene = self.write("scene")
        return calibration.relative_error_before, calibration.relative_error

    def learn(self, ticks, still_s):
        """Learns what motion does to the gauges from an untouched run; how much of each load is left, µε."""
        sensor = hapdef.TouchSensor(self.scene)
        frames = [sensor.step(**self.motion(tick)) for tick in ticks]
        n_still = sum(tick.time_s < still_s for tick in ticks)
        left_ue = self.scene.learn_loads(frames, self.folder / "loads.json", still=n_still)
        self.spec["loads"]["learned"] = "loads.json"
        self.scene = self.write("scene")
        return left_ue

    def step(self, sensor, tick):
        """What the sensor finds in a moment of MuJoCo's."""
        is_there = tick.touching()
        return sensor.step(tick.positions_m[is_there], tick.forces_n[is_there], **self.motion(tick))


def reports(frame):
    """The contacts that a controller may act on."""
    if frame.phase != "touched" or frame.is_stale:
        return []
    return [Report(each.id, each.position_m, each.force_n) for each in frame.contacts]
