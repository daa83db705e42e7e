"""The run: an arm that moves and fingers that press it, and what MuJoCo says of the touched link every millisecond."""

from dataclasses import dataclass

import mujoco
import numpy as np

from .arm import N_FINGERS, TIMESTEP_S
from .fingers import Finger, Places, plan
from .motion import Motion, Servos, Shaking

RATE_HZ = 1000.0
STEPS = round(1.0 / (RATE_HZ * TIMESTEP_S))
# The arm stands still that long, for the tare, before it moves and is touched.
STILL_S = 1.5


@dataclass
class Tick:
    """MuJoCo's truth of one millisecond, in the touched link's frame."""

    time_s: float
    # Of each finger: force-weighted middle of its contacts (NaN without) and their forces on the link, `[n_fingers, 3]`.
    positions_m: np.ndarray
    forces_n: np.ndarray
    # Every contact in MuJoCo's list: finger, place and force.
    contacts: list
    # Gravity less the acceleration of the link's origin; rate and acceleration of its turning.
    specific_force_m_s2: np.ndarray
    angular_rate_rad_s: np.ndarray
    angular_acceleration_rad_s2: np.ndarray
    # What the next link does to this one, its moment about this link's origin.
    wrist_force_n: np.ndarray
    wrist_moment_nm: np.ndarray
    # For checks: torque that drives the link's joint less what its gears' inertia takes, the link's place and attitude
    # in the world, and what pushes each finger less its mass times its acceleration, in the link's frame.
    joint_torque_nm: float
    origin_m: np.ndarray
    world_from_link: np.ndarray
    finger_push_n: np.ndarray

    def touching(self, least_n=0.0):
        """Which fingers' forces on the link are above a limit."""
        return np.linalg.norm(self.forces_n, axis=1) > least_n


class Link:
    """Where the touched link is and how it moves, of the positions and rates that MuJoCo has now."""

    def __init__(self, model, data, body):
        self.model, self.data, self.body = model, data, body
        self.twist = np.zeros(6)

    def update(self):
        """Reads place, attitude and motion."""
        self.origin_m = self.data.xpos[self.body]
        self.rotation = self.data.xmat[self.body].reshape(3, 3)
        kind = mujoco.mjtObj.mjOBJ_XBODY
        mujoco.mj_objectVelocity(self.model, self.data, kind, self.body, self.twist, 0)

    def to_world(self, point_m):
        """A point of the link's frame in the world."""
        return self.origin_m + self.rotation @ point_m

    def velocity_at(self, point_m):
        """The world's velocity of a point that the link carries."""
        return self.twist[3:] + np.cross(self.twist[:3], self.rotation @ point_m)


class World:
    """A seeded run of an arm: touched by fingers, or untouched with a hand that is shaken."""

    def __init__(self, arm, seed, seconds, axial_range_m, is_touched=True):
        self.arm, self.seconds = arm, seconds
        self.model, self.data = arm.model, mujoco.MjData(arm.model)
        self.link = Link(self.model, self.data, arm.body)
        self.motion = Motion(arm.limits_rad, arm.speeds_rad_s, (seed, 1), STILL_S)
        self.shaking = None if is_touched else Shaking((seed, 3), STILL_S)
        rng = np.random.default_rng((seed, 2))
        places = Places(arm.surface, arm.axis(), axial_range_m, rng)
        self.presses = plan(places, rng, STILL_S, seconds) if is_touched else []
        self.fingers = [Finger(arm, idx, self.presses, places) for idx in range(N_FINGERS)]
        self.reset()

    def reset(self):
        """Everything at rest in the first pose."""
        dofs, _ = self.arm.joint_dofs()
        self.data.qpos[dofs], _ = self.motion.at(0.0)
        mujoco.mj_forward(self.model, self.data)
        self.servos = Servos(self.arm, self.data)
        self.link.update()
        for finger in self.fingers:
            finger.put(self.data, self.link)

    def ticks(self):
        """One `Tick` a millisecond."""
        for step in range(round(self.seconds / TIMESTEP_S)):
            # Forces and accelerations are read before the step that they cause, at the positions that they belong to.
            mujoco.mj_step1(self.model, self.data)
            self.link.update()
            self.drive(step * TIMESTEP_S)
            mujoco.mj_fwdActuation(self.model, self.data)
            mujoco.mj_fwdAcceleration(self.model, self.data)
            mujoco.mj_fwdConstraint(self.model, self.data)
            if step % STEPS == 0:
                yield self.tick()
            mujoco.mj_Euler(self.model, self.data)

    def drive(self, time_s):
        """Sets all motors."""
        self.servos.drive(self.data, *self.motion.at(time_s))
        if self.shaking:
            self.data.xfrc_applied[self.arm.hand] = self.shaking.at(time_s)
        touching = set(self.data.contact.geom.reshape(-1))
        for finger in self.fingers:
            finger.drive(self.data, self.link, time_s, finger.geom in touching)

    def tick(self):
        """What MuJoCo says now."""
        model, data, arm = self.model, self.data, self.arm
        mujoco.mj_rnePostConstraint(model, data)
        rotation = self.link.rotation.copy()
        acceleration = np.zeros(6)
        kind = mujoco.mjtObj.mjOBJ_XBODY
        # Its linear part has gravity taken off already, as an accelerometer has.
        mujoco.mj_objectAcceleration(model, data, kind, arm.body, acceleration, 1)
        wrist_force_n, wrist_moment_nm = self.wrist()
        contacts = self.contacts(rotation)
        positions_m, forces_n = self.summed(contacts)
        dofs, _ = arm.joint_dofs()
        joint = dofs[self.model.body_dofadr[arm.body] == dofs][0]
        return Tick(
            time_s=data.time,
            positions_m=positions_m,
            forces_n=forces_n,
            contacts=contacts,
            specific_force_m_s2=-acceleration[3:],
            angular_rate_rad_s=rotation.T @ self.link.twist[:3],
            angular_acceleration_rad_s2=acceleration[:3].copy(),
            wrist_force_n=rotation.T @ wrist_force_n,
            wrist_moment_nm=rotation.T @ wrist_moment_nm,
            joint_torque_nm=float(data.qfrc_actuator[joint] - model.dof_armature[joint] * data.qacc[joint]),
            origin_m=self.link.origin_m.copy(),
            world_from_link=rotation,
            finger_push_n=self.finger_push(rotation),
        )

    def contacts(self, rotation):
        """MuJoCo's contact list: finger, place and force on the link, in the link's frame."""
        found, wrench = [], np.zeros(6)
        for idx, contact in enumerate(self.data.contact):
            mujoco.mj_contactForce(self.model, self.data, idx, wrench)
            # In the contact's frame, on the second of the two; the normal leads from the first to the second.
            sign = 1.0 if contact.geom[1] < 0 else -1.0
            force_n = sign * contact.frame.reshape(3, 3).T @ wrench[:3]
            geom = contact.geom[0] if contact.geom[1] < 0 else contact.geom[1]
            finger = next(each for each, one in enumerate(self.fingers) if one.geom == geom)
            place_m = rotation.T @ (contact.pos - self.link.origin_m)
            found.append((finger, place_m, rotation.T @ force_n))
        return found

    def summed(self, contacts):
        """Each finger's contacts as one: force-weighted middle and sum of forces."""
        positions_m, forces_n = np.full((N_FINGERS, 3), np.nan), np.zeros((N_FINGERS, 3))
        for finger in range(N_FINGERS):
            own = [(place_m, force_n) for each, place_m, force_n in contacts if each == finger]
            weights = np.array([np.linalg.norm(force_n) for _, force_n in own])
            if weights.sum() > 0.0:
                positions_m[finger] = weights @ np.array([place_m for place_m, _ in own]) / weights.sum()
                forces_n[finger] = np.sum([force_n for _, force_n in own], axis=0)
        return positions_m, forces_n

    def wrist(self):
        """Force of the next link on this one, and its moment about this link's origin, in the world's axes."""
        # MuJoCo's cfrc_int: from the parent on the body, moment before force, about the tree's centre of mass.
        moment_nm, force_n = -self.data.cfrc_int[self.arm.hand, :3], -self.data.cfrc_int[self.arm.hand, 3:]
        centre_m = self.data.subtree_com[self.model.body_rootid[self.arm.hand]]
        return force_n, moment_nm + np.cross(centre_m - self.link.origin_m, force_n)

    def finger_push(self, rotation):
        """What pushes each finger less its mass times its acceleration: what it passes on to the link."""
        pushed = []
        for finger in self.fingers:
            mass_kg = self.model.body_mass[self.model.geom_bodyid[finger.geom]]
            push_n = self.data.qfrc_actuator[finger.dofs] - mass_kg * self.data.qacc[finger.dofs]
            pushed.append(rotation.T @ push_n)
        return np.array(pushed)
