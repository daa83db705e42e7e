"""Fingers that press the moving link, each with a force of its own that MuJoCo's contact passes on."""

from dataclasses import dataclass

import numpy as np

from .arm import FINGER_MASS_KG, FINGER_RADIUS_M, N_FINGERS
from .motion import minimum_jerk

# Position control of a finger that is away from the skin or slides along it.
FOLLOW_RAD_S = 2.0 * np.pi * 15.0
# From that far off the skin a finger approaches, that fast.
STANDOFF_M = 0.006
APPROACH_M_S = 0.05
RETREAT_S = 0.06
# A finger on its way keeps off the skin by about that.
DETOUR_M = 0.025
# Between the end of a finger's press and the start of its next.
SHORTEST_TRAVEL_S = 0.28
# A script of `hapdef live --sim` has no weaker presses either.
FORCE_RANGE_N = (2.0, 25.0)
HOLD_RANGE_S = (0.45, 0.55)
RISE_RANGE_S = (0.02, 0.08)
# The fingers press in bouts: in one, each begins while the other still presses, if it gets there in time.
BOUT = 8
OVERLAP_RANGE_S = (0.1, 0.16)
# Between bouts nothing touches: after a second the sensor's zeros are known again (docs/moving.md).
REST_RANGE_S = (1.25, 1.45)
# Two presses in a row are that far apart, so that they are two contacts.
SPACING_M = 0.04


@dataclass
class Press:
    """A planned press: where, along which outward normal, in the link's frame, how hard and when."""

    finger: int
    place_m: np.ndarray
    normal: np.ndarray
    force_n: float
    rise_s: float
    start_s: float
    hold_s: float

    def push_n(self, since_s):
        """The force that the finger is driven with, `since_s` after it touched: up, hold, down."""
        up, _ = minimum_jerk(since_s / self.rise_s)
        down, _ = minimum_jerk((self.hold_s - since_s) / self.rise_s)
        return self.force_n * min(up, down)


class Places:
    """Places of a link's surface that a finger reaches."""

    def __init__(self, surface, axis, axial_range_m, rng):
        self.surface, self.rng = surface, rng
        self.origin_m, self.direction, self.length_m = axis
        centres_m = surface.corners_m.mean(axis=1)
        along, radial = self.split(centres_m)
        outward = radial / np.linalg.norm(radial, axis=1)[:, None]
        is_touchable = (along >= axial_range_m[0]) & (along <= axial_range_m[1])
        is_touchable &= np.einsum("ij,ij->i", surface.normals, outward) > 0.5
        self.candidates = np.flatnonzero(is_touchable)
        areas = surface.areas_m2[self.candidates]
        self.weights = areas / areas.sum()

    def split(self, points_m):
        """Height along the axis and what stands off it."""
        from_origin = points_m - self.origin_m
        along = from_origin @ self.direction
        return along, from_origin - along[..., None] * self.direction

    def draw(self, far_from_m):
        """A place and its normal, at least `SPACING_M` from the places of a list."""
        while True:
            idx = self.rng.choice(self.candidates, p=self.weights)
            shares = self.rng.dirichlet((1.0, 1.0, 1.0))
            place_m = shares @ self.surface.corners_m[idx]
            normal = self.surface.normals[idx]
            is_far = all(np.linalg.norm(place_m - other) >= SPACING_M for other in far_from_m)
            if is_far and self.is_clear(place_m, normal):
                return place_m, normal

    def is_clear(self, place_m, normal):
        """A finger comes straight down on the place without touching anything before."""
        for gap_m in (1e-4, 0.3 * STANDOFF_M, STANDOFF_M):
            _, distance_m, _ = self.surface.nearest(place_m + (FINGER_RADIUS_M + gap_m) * normal)
            if distance_m < FINGER_RADIUS_M + 0.5 * gap_m:
                return False
        return True

    def way(self, begin_m, end_m, share):
        """From one place beside the link to another, around it."""
        position, _ = minimum_jerk(share)
        heights, ends = [], []
        for point_m in (begin_m, end_m):
            along, radial = self.split(point_m)
            heights.append(along)
            ends.append(radial)
        radii = [np.linalg.norm(radial) for radial in ends]
        units = [radial / radius for radial, radius in zip(ends, radii)]
        angle = np.arctan2(np.cross(units[0], units[1]) @ self.direction, units[0] @ units[1])
        angle *= position
        turned = np.cos(angle) * units[0] + np.sin(angle) * np.cross(self.direction, units[0])
        radius = radii[0] + position * (radii[1] - radii[0]) + DETOUR_M * np.sin(np.pi * position)
        height = heights[0] + position * (heights[1] - heights[0])
        return self.origin_m + height * self.direction + radius * turned


def plan(places, rng, start_s, end_s):
    """Presses by the fingers in turn until the end."""
    presses, free_s, start = [], [start_s] * N_FINGERS, start_s
    while True:
        idx = len(presses) % N_FINGERS
        start = max(start, free_s[idx] + SHORTEST_TRAVEL_S)
        place_m, normal = places.draw([press.place_m for press in presses[-(N_FINGERS - 1) :]])
        low, high = np.log(FORCE_RANGE_N)
        press = Press(
            finger=idx,
            place_m=place_m,
            normal=normal,
            force_n=float(np.exp(rng.uniform(low, high))),
            rise_s=rng.uniform(*RISE_RANGE_S),
            start_s=start,
            hold_s=rng.uniform(*HOLD_RANGE_S),
        )
        end = start + press.hold_s
        if end + RETREAT_S > end_s:
            return presses
        presses.append(press)
        free_s[idx] = end
        is_last = len(presses) % BOUT == 0
        start = end + rng.uniform(*REST_RANGE_S) if is_last else end - rng.uniform(*OVERLAP_RANGE_S)


class Finger:
    """One finger through its presses: travel, approach, press, retreat."""

    def __init__(self, arm, idx, presses, places):
        self.dofs, self.motors, self.geom = arm.finger_dofs(idx)
        self.presses = [press for press in presses if press.finger == idx]
        self.places = places
        self.done = 0
        self.left_s, self.touched_s, self.ended_s = 0.0, None, None
        # In the link's frame, where it is and where it set out.
        self.aim_m = self.begin_m = self.parking_m(idx)

    def parking_m(self, idx):
        """Beside the link, each finger on a side of its own."""
        side = np.cross(self.places.direction, np.eye(3)[np.argmin(np.abs(self.places.direction))])
        side *= (-1.0) ** idx * 0.15 / np.linalg.norm(side)
        return self.places.origin_m + 0.5 * self.places.length_m * self.places.direction + side

    def put(self, data, link):
        """Sets the finger at rest where it is to be."""
        data.qpos[self.dofs] = link.to_world(self.aim_m)
        data.qvel[self.dofs] = 0.0

    def drive(self, data, link, time_s, is_touching):
        """Sets the finger's motors for one step."""
        push_n = self.advance(time_s, is_touching)
        target_m, velocity_m_s = link.to_world(self.aim_m), link.velocity_at(self.aim_m)
        error_m = target_m - data.qpos[self.dofs]
        error_m_s = velocity_m_s - data.qvel[self.dofs]
        follow_n = FINGER_MASS_KG * FOLLOW_RAD_S * (FOLLOW_RAD_S * error_m + 2.0 * error_m_s)
        if push_n is not None:
            # Along the normal a force and damping alone, so that the contact carries what is pushed.
            normal = link.rotation @ self.presses[self.done].normal
            damping_n = 2.0 * FINGER_MASS_KG * FOLLOW_RAD_S * error_m_s @ normal
            follow_n += (damping_n - push_n - follow_n @ normal) * normal
        data.ctrl[self.motors] = follow_n

    def advance(self, time_s, is_touching):
        """Moves the aim; the push, N, while the finger presses, else none."""
        if self.done == len(self.presses):
            self.aim_m = self.begin_m
            return None
        press = self.presses[self.done]
        rest_m = press.place_m + (FINGER_RADIUS_M + STANDOFF_M) * press.normal
        approach_s = press.start_s - STANDOFF_M / APPROACH_M_S
        if self.touched_s is None:
            if time_s < approach_s:
                share = (time_s - self.left_s) / (approach_s - self.left_s)
                self.aim_m = self.places.way(self.begin_m, rest_m, share)
                return None
            self.aim_m = rest_m - APPROACH_M_S * (time_s - approach_s) * press.normal
            if is_touching:
                self.touched_s = time_s
            return None
        since_s = time_s - self.touched_s
        if since_s < press.hold_s:
            self.aim_m = press.place_m + FINGER_RADIUS_M * press.normal
            return press.push_n(since_s)
        share, _ = minimum_jerk((since_s - press.hold_s) / RETREAT_S)
        self.aim_m = rest_m - (1.0 - share) * STANDOFF_M * press.normal
        if since_s >= press.hold_s + RETREAT_S:
            self.done += 1
            self.left_s, self.touched_s, self.begin_m = time_s, None, rest_m
        return None
