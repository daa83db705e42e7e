"""Responses, presses and contacts: the same numbers as hapdef's own, to the last bit."""

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

from support import OUT, PLACED, THREADS, placed, program, spread, tensor


class Contacts(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = placed()
        cls.response = cls.scene.response()

    def test_gauge_readings_are_those_of_the_bundle_to_the_last_bit(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "shin.hapdef"
            program("bundle", PLACED, "-o", path, "--threads", THREADS)
            np.testing.assert_array_equal(
                self.response.nodal_ue_per_n, tensor(path, "map.ue_per_n")
            )
            np.testing.assert_array_equal(self.scene.surface_m, tensor(path, "skin.nodes_m"))
            np.testing.assert_array_equal(self.scene.faces, tensor(path, "skin.faces"))

    def test_readings_are_linear_in_the_force(self):
        places, forces_n = spread(self.scene, 20, 1)
        once = self.response.readings_ue(places, forces_n)
        np.testing.assert_array_equal(self.response.readings_ue(places, 2.0 * forces_n), 2.0 * once)
        with self.assertRaisesRegex(ValueError, "forces_n: expected 20 numbers"):
            self.response.readings_ue(places, forces_n[:5])
        forces_n[3] = np.nan
        with self.assertRaisesRegex(ValueError, "forces_n: number 3 is NaN"):
            self.response.readings_ue(places, forces_n)

    def test_two_contacts_are_found_where_they_press(self):
        places = self.scene.surface_m[[100, 2000]]
        frame = self.response.readings_ue(places, [20.0, 8.0]).sum(axis=0)
        found = self.scene.estimator().estimate([frame, 0.0 * frame])
        np.testing.assert_array_equal(found.count, [2, 0])
        np.testing.assert_array_equal(found.frame, [0, 0])
        miss_m = np.linalg.norm(found.position_m - places, axis=1)
        self.assertLess(miss_m.max(), 0.1e-3)
        np.testing.assert_allclose(found.force_n, [20.0, 8.0], atol=0.02)
        self.assertTrue(found.is_identified.all())
        self.assertEqual(len(found), 2)

    def test_contacts_are_those_of_the_program_to_the_last_bit(self):
        places, forces_n = spread(self.scene, 12, 2)
        frames = self.response.readings_ue(places, forces_n).reshape(6, 2, -1).sum(axis=1)
        found = self.scene.estimator().estimate(frames)
        with tempfile.TemporaryDirectory() as folder:
            table = Path(folder) / "frames.csv"
            rows = (",".join(repr(float(value)) for value in frame) for frame in frames)
            table.write_text("\n".join(rows))
            lines = program("contacts", PLACED, table, "--json", "--threads", THREADS).splitlines()
        contacts = [contact for line in lines for contact in json.loads(line)["contacts"]]
        for name, values in (
            ("position_m", found.position_m),
            ("force_n", found.force_n),
            ("position_sd_m", found.position_sd_m),
        ):
            np.testing.assert_array_equal(values, np.array([c[name] for c in contacts]), name)

    def test_tracking_follows_a_contact(self):
        place = self.scene.surface_m[[1500]]
        forces_n = np.concatenate([np.zeros(20), np.linspace(0.5, 15.0, 30), np.full(50, 15.0)])
        frames = self.response.readings_ue(np.repeat(place, 100, axis=0), forces_n)
        tracker = self.scene.estimator("tracking")
        found = tracker.estimate(frames)
        self.assertEqual(found.count[-1], 1)
        self.assertLess(np.linalg.norm(found.position_m[-1] - place[0]), 0.2e-3)
        self.assertAlmostEqual(found.force_n[-1], 15.0, delta=0.1)
        tracker.start_over()
        np.testing.assert_array_equal(tracker.estimate(frames).force_n, found.force_n)


class Presses(unittest.TestCase):
    """The simulated rig, and a calibration by its presses."""

    @classmethod
    def setUpClass(cls):
        # A calibration that starts from the limb's own mesh takes seconds.
        cls.scene = placed().with_superposition(map_refinements=0)
        cls.rig = cls.scene.rig()

    def test_the_rig_is_the_one_of_the_programs(self):
        nodal = self.rig.nodal_ue_per_n
        columns = [tensor(path, "columns") for path in OUT.glob("cache/rig-live-*/columns.safetensors")]
        same = [np.array_equal(nodal, c.reshape(nodal.shape)) for c in columns if c.size == nodal.size]
        self.assertIn(True, same)

    def test_a_press_is_the_columns_along_its_direction(self):
        nodes = [10, 700, 3000]
        direct = np.einsum("ngk,nk->ng", self.rig.nodal_ue_per_n[nodes], self.scene.directions[nodes])
        pressed = self.rig.press(self.scene.surface_m[nodes], [1.0, 1.0, 1.0])
        np.testing.assert_allclose(pressed, direct, rtol=1e-6, atol=1e-6)
        noisy = self.rig.press(self.scene.surface_m[nodes], [20.0] * 3, seed=1)
        again = self.rig.press(self.scene.surface_m[nodes], [20.0] * 3, seed=1)
        np.testing.assert_array_equal(noisy, again)
        self.assertFalse(np.array_equal(noisy, 20.0 * pressed))

    def test_presses_correct_the_map(self):
        places, forces_n = spread(self.scene, 100, 3)
        readings_ue = self.rig.press(places, forces_n, seed=1)
        calibration = self.scene.calibrate(places, forces_n, readings_ue, noise_ue=1.2, n_sites=400)
        self.assertEqual(calibration.n_presses, 100)
        self.assertLess(calibration.relative_error, calibration.relative_error_before)
        self.assertLess(calibration.curve[-1, 1], calibration.curve[0, 1])
        others, others_n = spread(self.scene, 60, 4)
        frames = self.rig.press(others, others_n, seed=2)
        before = self.miss_mm(self.scene.estimator(), frames, others)
        after = self.miss_mm(calibration.estimator(), frames, others)
        # As it was when this was written: 3.56 mm from the computed map.
        self.assertAlmostEqual(before, 3.56, delta=0.1)
        self.assertAlmostEqual(after, 0.447, delta=0.05)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "calibration.json"
            calibration.write(path)
            calibrated = self.scene.with_superposition(calibration=path)
            self.assertEqual(self.miss_mm(calibrated.estimator(), frames, others), after)
            self.known_touches_bring_gains_back(calibrated)

    def known_touches_bring_gains_back(self, scene):
        """Gains off by 4 %, and the same places pressed again."""
        places, forces_n = spread(scene, 20, 5)
        readings_ue = 1.04 * self.rig.press(places, forces_n, seed=3)
        gaps = np.linalg.norm(scene.surface_m[None] - places[:, None], axis=2)
        forces = scene.directions[np.argmin(gaps, axis=1)] * forces_n[:, None]
        taken = scene.recalibrate(places, forces, readings_ue)
        self.assertEqual(len(taken), 20)
        self.assertGreater(sum(touch["is_accepted"] for touch in taken), 15)
        self.assertAlmostEqual(np.mean(taken[-1]["gains_after"]), 0.04, delta=0.015)
        self.assertEqual(scene.undo_touches(), sum(touch["is_accepted"] for touch in taken))

    @staticmethod
    def miss_mm(estimator, frames, places):
        """Median over the frames of the distance of the strongest contact found, mm."""
        found = estimator.estimate(frames)
        first = np.searchsorted(found.frame, np.flatnonzero(found.count))
        frame = found.frame[first]
        return 1e3 * np.median(np.linalg.norm(found.position_m[first] - places[frame], axis=1))


if __name__ == "__main__":
    unittest.main()
