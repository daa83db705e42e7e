"""What was found of MuJoCo's contacts, and what was found that is none.

A contact is a stretch of time in which a finger's force on the link doesn't rest for `REST_S`, if it reaches `LEAST_N`.
In every frame the true contacts of `LEAST_N` or more and the reported ones are paired, nearest first, if they are within
`NEAR_M`. A contact is found if it has a pair in half of those frames; its onset counts from the first of them that is
followed by `LASTING_S` of them to its first pair. A reported contact is false if it has no pair, nor any finger touching
within `NEAR_M`, in all its life, and if it reaches `LEAST_N`.
"""

from dataclasses import dataclass, field

import numpy as np

LEAST_N = 1.0
REST_S = 0.03
LASTING_S = 0.005
NEAR_M = 0.02


@dataclass
class Report:
    """A contact that the sensor reports in one frame."""

    name: int
    position_m: np.ndarray
    force_n: float


@dataclass
class Truth:
    """One contact of a finger: its frames, and what was found of it in them."""

    finger: int
    first: int
    last: int
    peak_n: float = 0.0
    onset: int = -1
    loaded: list = field(default_factory=list)
    errors_m: list = field(default_factory=list)
    force_errors: list = field(default_factory=list)
    first_pair: int = -1

    def is_found(self):
        """Has a pair in half of its frames with force."""
        return 2 * len(self.errors_m) >= len(self.loaded) > 0


def true_contacts(ticks):
    """Every finger's contacts in a run."""
    forces_n = np.array([np.linalg.norm(tick.forces_n, axis=1) for tick in ticks])
    dt_s = ticks[1].time_s - ticks[0].time_s
    rest, lasting = round(REST_S / dt_s), round(LASTING_S / dt_s)
    found = []
    for finger in range(forces_n.shape[1]):
        own_n = forces_n[:, finger]
        touching = np.flatnonzero(own_n > 0.0)
        if len(touching) == 0:
            continue
        cuts = np.flatnonzero(np.diff(touching) > rest)
        firsts = touching[np.concatenate(([0], cuts + 1))]
        lasts = touching[np.concatenate((cuts, [len(touching) - 1]))]
        for first, last in zip(firsts, lasts):
            truth = Truth(finger, int(first), int(last), float(own_n[first : last + 1].max()))
            is_loaded = own_n[first : last + 1] >= LEAST_N
            truth.loaded = list(first + np.flatnonzero(is_loaded))
            stays = [k for k in range(len(is_loaded) - lasting + 1) if is_loaded[k : k + lasting].all()]
            # Less than that of force is a graze, which nothing is asked of.
            if stays:
                truth.onset = int(first) + stays[0]
                found.append(truth)
    return sorted(found, key=lambda each: each.first)


def score(ticks, reports):
    """The figures of a run, by name; `reports` has the contacts of each frame."""
    truths = true_contacts(ticks)
    at = {(truth.finger, frame): truth for truth in truths for frame in truth.loaded}
    real, strong = set(), set()
    for frame, (tick, reported) in enumerate(zip(ticks, reports)):
        fingers = [k for k in range(len(tick.forces_n)) if (k, frame) in at]
        for finger, report, distance_m in pairs(tick.positions_m, fingers, reported):
            truth = at[finger, frame]
            strength_n = np.linalg.norm(tick.forces_n[finger])
            truth.errors_m.append(distance_m)
            truth.force_errors.append(abs(report.force_n - strength_n) / strength_n)
            if truth.first_pair < 0 and frame >= truth.onset:
                truth.first_pair = frame
        real.update(report.name for report in reported if is_real(tick, report))
        strong.update(report.name for report in reported if report.force_n >= LEAST_N)
    return figures(truths, strong - real, ticks)


def pairs(positions_m, fingers, reported):
    """Fingers and reported contacts, nearest first, each once."""
    distances = [
        (float(np.linalg.norm(report.position_m - positions_m[finger])), finger, idx)
        for finger in fingers
        for idx, report in enumerate(reported)
    ]
    taken = []
    for distance_m, finger, idx in sorted(distances):
        is_free = all(finger != other and idx != used for other, used, _ in taken)
        if distance_m <= NEAR_M and is_free:
            taken.append((finger, idx, distance_m))
    return [(finger, reported[idx], distance_m) for finger, idx, distance_m in taken]


def is_real(tick, report):
    """Some finger touches near a reported contact, however lightly."""
    distances_m = np.linalg.norm(tick.positions_m - report.position_m, axis=1)
    return bool((distances_m[tick.touching()] <= NEAR_M).any())


def figures(truths, false_names, ticks):
    """Name, value and unit of what counts."""
    found = [truth for truth in truths if truth.is_found()]
    errors_mm = 1e3 * np.concatenate([truth.errors_m for truth in found] or [[np.nan]])
    force_errors = np.concatenate([truth.force_errors for truth in found] or [[np.nan]])
    dt_s = ticks[1].time_s - ticks[0].time_s
    onsets_ms = [1e3 * dt_s * (truth.first_pair - truth.onset) for truth in found if truth.first_pair >= 0]
    minutes = len(ticks) * dt_s / 60.0
    return [
        ("contacts", len(truths), ""),
        ("found_pct", 100.0 * len(found) / max(len(truths), 1), "%"),
        ("false_per_min", len(false_names) / minutes, "1/min"),
        ("position_median_mm", np.median(errors_mm), "mm"),
        ("position_p90_mm", np.quantile(errors_mm, 0.9), "mm"),
        ("force_median_pct", 100.0 * np.median(force_errors), "%"),
        ("onset_p50_ms", np.quantile(onsets_ms or [np.nan], 0.5), "ms"),
        ("onset_p99_ms", np.quantile(onsets_ms or [np.nan], 0.99), "ms"),
    ]
