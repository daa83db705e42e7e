"""The limb's skin in a simulator of robots, and what its contacts do together."""

import unittest

import numpy as np

import hapdef
from support import placed


class TouchSensor(unittest.TestCase):
    def test_what_presses_is_found_with_its_wrench(self):
        scene = placed()
        sensor = hapdef.TouchSensor(scene, tare_s=0.3)
        node = scene.surface_m.shape[0] // 2
        place, direction = scene.surface_m[node], scene.directions[node]
        for _ in range(400):
            frame = sensor.step()
        self.assertEqual((frame.phase, frame.known_contacts()), ("untouched", []))
        for force_n in np.minimum(np.arange(200) / 40, 1.0) * 20.0:
            frame = sensor.step([place], [direction * force_n])
        (contact,) = frame.known_contacts()
        self.assertLess(np.linalg.norm(contact.position_m - place), 5e-3)

        net = frame.wrench()
        force_n = contact.force_n * contact.direction
        np.testing.assert_allclose(net.force_n, force_n)
        np.testing.assert_allclose(net.moment_nm, np.cross(contact.position_m, force_n), atol=1e-12)
        self.assertEqual(net.covariance.shape, (6, 6))
        moved = net.about([0.0, 0.1, 0.0])
        np.testing.assert_allclose(frame.wrench([0.0, 0.1, 0.0]).moment_nm, moved.moment_nm)
        hinge = np.array([[0.0], [0.0], [0.0], [1.0], [0.0], [0.0]])
        joint = moved.joint_torques(hinge)
        np.testing.assert_allclose(joint.torques, moved.moment_nm[:1])
        np.testing.assert_allclose(joint.covariance, moved.covariance[3:4, 3:4])

    def test_shapes_are_checked(self):
        sensor = hapdef.TouchSensor(placed(), tare_s=0.3)
        with self.assertRaisesRegex(ValueError, "forces_n: expected 1 rows"):
            sensor.step([[0.0, 0.0, 0.0]], [[0.0] * 3] * 2)
        with self.assertRaisesRegex(ValueError, "flange_force_n: expected 3"):
            sensor.step(flange_force_n=[1.0])
        with self.assertRaisesRegex(ValueError, r"expected an array of shape \[6, n_joints\]"):
            sensor.step().wrench().joint_torques([[1.0]])


if __name__ == "__main__":
    unittest.main()
