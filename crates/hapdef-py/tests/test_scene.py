"""Scenes, their arrays and what is refused; layouts and shells."""

import json
import tempfile
import unittest
from pathlib import Path

import numpy as np

import hapdef
from support import PLACED, SKIN, THREADS, placed


class Scenes(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.scene = placed()

    def test_arrays_have_their_shapes(self):
        scene = self.scene
        n = scene.n_surface_nodes
        self.assertEqual((scene.name, scene.n_gauges, n), ("shin-placed", 10, 3385))
        self.assertEqual(scene.surface_m.shape, (n, 3))
        self.assertEqual(scene.faces.shape[1], 6)
        self.assertLess(scene.faces.max(), n)
        np.testing.assert_allclose(np.linalg.norm(scene.directions, axis=1), 1.0, rtol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(scene.gauge_axes, axis=1), 1.0, rtol=1e-12)
        sites = json.loads(PLACED.read_text())["gauges"]["sites"]
        positions = np.array([site["position_m"] for site in sites])
        np.testing.assert_array_equal(scene.gauge_positions_m, positions)
        self.assertEqual(scene.gauge_names, [site["name"] for site in sites])

    def test_a_scene_that_is_refused_names_the_field(self):
        scene = json.loads(PLACED.read_text())
        scene["contact"]["tip_radius_m"] = -1.0
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "scene.json"
            path.write_text(json.dumps(scene))
            with self.assertRaisesRegex(hapdef.SceneError, "tip_radius_m.*expected"):
                hapdef.Scene(path)
            with self.assertRaisesRegex(hapdef.SceneError, "nowhere.json.*check the path"):
                hapdef.Scene(Path(folder) / "nowhere.json")
        self.assertTrue(issubclass(hapdef.SceneError, hapdef.HapdefError))

    def test_arguments_that_are_refused_say_what_is_expected(self):
        scene = self.scene
        with self.assertRaisesRegex(ValueError, r"positions_m.*\[n, 3\]"):
            scene.with_gauges([[0.0, 1.0]], [[0.0, 1.0, 0.0]])
        with self.assertRaisesRegex(ValueError, "one axis and one name"):
            scene.with_gauges(scene.gauge_positions_m, scene.gauge_axes[:3])
        with self.assertRaisesRegex(hapdef.HapdefError, r"gauges.sites\[0\].*far"):
            scene.with_gauges([[1.0, 1.0, 1.0]], [[0.0, 1.0, 0.0]], names=["far"])
        with self.assertRaisesRegex(ValueError, "quick.*full"):
            hapdef.Scene(PLACED, profile="slow")
        with self.assertRaisesRegex(ValueError, "amounts.*n_singles"):
            hapdef.Scene(PLACED, amounts={"n_singles": 3})
        with self.assertRaisesRegex(ValueError, "superposition"):
            scene.estimator("guess")
        with self.assertRaisesRegex(ValueError, "source.*tcp:HOST:PORT"):
            scene.live("usb:3")

    def test_a_layout_is_better_than_random_ones_and_can_be_mounted(self):
        layouts = self.scene.place(8, n_positions=40, n_axes=2, n_sites=150)
        best, random = layouts[-1], layouts[0]
        self.assertLess(best.single_mean_m, random.single_mean_m)
        self.assertEqual(best.positions_m.shape, (8, 3))
        mounted = self.scene.with_gauges(best.positions_m, best.axes, name="eight")
        self.assertEqual((mounted.name, mounted.n_gauges), ("eight", 8))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "eight.json"
            mounted.write(path)
            self.assertEqual(json.loads(path.read_text()), json.loads(mounted.json()))

    def test_a_thinner_shell_reads_more(self):
        thick, thin = (
            hapdef.Shell(SKIN, wall_m=wall_m, threads=THREADS)
            for wall_m in (2e-3, 1e-3)
        )
        self.assertGreater(thin.median_best_ue_per_n, 1.5 * thick.median_best_ue_per_n)
        response = thin.response()
        self.assertEqual(response.nodal_ue_per_n.shape, (len(thin.nodes_m), 10, 3))
        fine, coarse = (response.bounds(noise_ue=noise, n_sites=100) for noise in (1.0, 2.0))
        seen = np.isfinite(fine.single_m)
        self.assertGreater(seen.mean(), 0.5)
        np.testing.assert_allclose(coarse.single_m[seen], 2.0 * fine.single_m[seen], rtol=1e-6)

    def test_the_stub_names_what_there_is(self):
        stub = (Path(hapdef.__file__).parent / "__init__.pyi").read_text()
        for name in hapdef.__all__:
            self.assertIn(f"class {name}" if name[0].isupper() else f"{name}:", stub)
            if name[0].isupper() and not name.endswith("Error"):
                block = stub.split(f"class {name}:")[1].split("\n@final")[0]
                for member in vars(getattr(hapdef, name)):
                    if not member.startswith("_"):
                        self.assertIn(f"def {member}(", block, name)
        self.assertTrue((Path(hapdef.__file__).parent / "py.typed").exists())


if __name__ == "__main__":
    unittest.main()
