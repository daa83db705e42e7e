"""Smooth random motion of a robot's joints, and the servos that follow it."""

import mujoco
import numpy as np

from .arm import SERVO_RAD_S

# Share of a joint's largest speed that the motion reaches.
SPEED_SHARE = 0.95
# Joints stay that near to the middle of their ranges, so that the arm stays above the floor.
REACH_RAD = 0.8
# How a hand is shaken: root mean square of each component, and how fast.
SHAKING_N, SHAKING_NM = 6.0, 0.6
SHAKING_HZ = (0.3, 2.0)
N_WAVES = 3


def minimum_jerk(share):
    """Position and rate of the smoothest way from 0 to 1, at a share of its time; its peak rate is 1.875."""
    share = min(max(share, 0.0), 1.0)
    position = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
    return position, 30.0 * share**2 * (1.0 - share) ** 2


class Motion:
    """From one random pose to the next, from `start_s` on; the same poses for the same seed."""

    def __init__(self, limits_rad, speeds_rad_s, seed, start_s):
        self.rng = np.random.default_rng(seed)
        self.middle_rad = limits_rad.mean(axis=1)
        self.reach_rad = np.minimum(0.35 * np.ptp(limits_rad, axis=1), REACH_RAD)
        self.speeds_rad_s = SPEED_SHARE * speeds_rad_s
        self.begin_s, self.begin_rad = 0.0, self.middle_rad
        self.end_s, self.end_rad = start_s, self.middle_rad

    def at(self, time_s):
        """Angles and rates at a time; times must not go back."""
        while time_s >= self.end_s:
            self.begin_s, self.begin_rad = self.end_s, self.end_rad
            self.end_rad = self.middle_rad + self.reach_rad * self.rng.uniform(-1.0, 1.0, len(self.middle_rad))
            way_rad = np.abs(self.end_rad - self.begin_rad)
            self.end_s += float((1.875 * way_rad / self.speeds_rad_s).max())
        duration_s = self.end_s - self.begin_s
        position, rate = minimum_jerk((time_s - self.begin_s) / duration_s)
        way_rad = self.end_rad - self.begin_rad
        return self.begin_rad + position * way_rad, rate * way_rad / duration_s


class Shaking:
    """A hand that somebody takes hold of and shakes: force and moment on it, N and N m, none before `start_s`.

    Weight and what the wrist passes on are one load as long as the hand is the same; only so can they be told apart.
    """

    def __init__(self, seed, start_s):
        rng = np.random.default_rng(seed)
        self.start_s = start_s
        self.rates_rad_s = 2.0 * np.pi * rng.uniform(*SHAKING_HZ, (N_WAVES, 6))
        self.phases = rng.uniform(0.0, 2.0 * np.pi, (N_WAVES, 6))
        self.sizes = np.repeat([SHAKING_N, SHAKING_NM], 3) * np.sqrt(2.0 / N_WAVES)

    def at(self, time_s):
        """Force and moment at a time `[6]`."""
        since_s = time_s - self.start_s
        if since_s < 0.0:
            return np.zeros(6)
        waves = np.sin(self.rates_rad_s * since_s + self.phases).sum(axis=0)
        return min(since_s, 1.0) * self.sizes * waves


class Servos:
    """Position control of each joint with the weight compensated: τ = J ω² (q* − q) + 2 J ω (q̇* − q̇) + bias."""

    def __init__(self, arm, data):
        self.dofs, self.motors = arm.joint_dofs()
        self.inertias = np.array([self.inertia(arm.model, data, dof) for dof in self.dofs])

    @staticmethod
    def inertia(model, data, dof):
        """The mass matrix's diagonal at the pose that the data have."""
        unit, column = np.zeros(model.nv), np.zeros(model.nv)
        unit[dof] = 1.0
        mujoco.mj_mulM(model, data, column, unit)
        return column[dof]

    def drive(self, data, angles_rad, rates_rad_s):
        """Sets the motors' torques."""
        error_rad = angles_rad - data.qpos[self.dofs]
        error_rad_s = rates_rad_s - data.qvel[self.dofs]
        stiff = SERVO_RAD_S**2 * error_rad + 2.0 * SERVO_RAD_S * error_rad_s
        data.ctrl[self.motors] = self.inertias * stiff + data.qfrc_bias[self.dofs]
