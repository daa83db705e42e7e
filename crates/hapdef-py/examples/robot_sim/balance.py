"""Checks by mechanics of what a run says, from the recorded numbers alone."""

import numpy as np

# The first two are identities of the solver's own numbers; the others compare with differences over 2 ms.
ALLOWED = {"joint": 1e-5, "fingers": 1e-5, "origin": 0.03, "turning": 0.03}


def check(arm, ticks):
    """Relative error of each of the laws below, by name; `ALLOWED` has what it may be."""
    return {
        "joint": joint_moment(arm, ticks),
        "fingers": finger_forces(ticks),
        "origin": origin_acceleration(ticks),
        "turning": turning(ticks),
    }


def stack(ticks, name):
    """One field of all ticks."""
    return np.array([getattr(tick, name) for tick in ticks])


def rms(values):
    """Root mean square of vectors or numbers."""
    return float(np.sqrt(np.mean(np.sum(np.atleast_2d(values.T) ** 2, axis=0))))


def joint_moment(arm, ticks):
    """Euler's law about the link's joint: contacts, wrist, weight and motion against the torque of the joint's motor.

    I ω̇ + ω × I ω − m c × s = M_contacts + M_wrist + M_parent about the origin, s being gravity less acceleration;
    along the joint's axis M_parent is the motor's torque. RMS of what is left over that of M_contacts.
    """
    model, body = arm.model, arm.body
    axis = model.jnt_axis[model.body_jntadr[body]]
    mass_kg, centre_m = model.body_mass[body], model.body_ipos[body]
    inertia = inertia_about_origin(model, body)
    omega, alpha = stack(ticks, "angular_rate_rad_s"), stack(ticks, "angular_acceleration_rad_s2")
    turning_nm = alpha @ inertia.T + np.cross(omega, omega @ inertia.T)
    weight_nm = mass_kg * np.cross(centre_m, stack(ticks, "specific_force_m_s2"))
    contact_nm = np.array(
        [sum((np.cross(place_m, force_n) for _, place_m, force_n in tick.contacts), np.zeros(3)) for tick in ticks]
    )
    left_nm = turning_nm - weight_nm - contact_nm - stack(ticks, "wrist_moment_nm")
    left_nm = left_nm @ axis - stack(ticks, "joint_torque_nm")
    return rms(left_nm) / rms(contact_nm @ axis)


def inertia_about_origin(model, body):
    """Inertia of a body about its frame's origin, in its frame."""
    w, x, y, z = model.body_iquat[body]
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew
    inertia = rotation @ np.diag(model.body_inertia[body]) @ rotation.T
    centre_m = model.body_ipos[body]
    steiner = centre_m @ centre_m * np.eye(3) - np.outer(centre_m, centre_m)
    return inertia + model.body_mass[body] * steiner


def finger_forces(ticks):
    """Newton's law of the fingers: what pushes one, less m a, is what the contact passes on to the link."""
    forces_n = stack(ticks, "forces_n").reshape(len(ticks), -1)
    pushes_n = stack(ticks, "finger_push_n").reshape(len(ticks), -1)
    return rms(forces_n - pushes_n) / rms(forces_n)


def origin_acceleration(ticks):
    """The specific force against the second difference of the origin's path, while nothing touches."""
    dt_s = ticks[1].time_s - ticks[0].time_s
    path_m = stack(ticks, "origin_m")
    gravity = np.array([0.0, 0.0, -9.81])
    seen = (path_m[2:] - 2.0 * path_m[1:-1] + path_m[:-2]) / dt_s**2
    world_from_link = stack(ticks, "world_from_link")[1:-1]
    said = gravity - np.einsum("tij,tj->ti", world_from_link, stack(ticks, "specific_force_m_s2")[1:-1])
    is_calm = calm(ticks)[1:-1]
    return rms((seen - said)[is_calm]) / rms(said[is_calm])


def turning(ticks):
    """The angular acceleration against the difference of the rates."""
    dt_s = ticks[1].time_s - ticks[0].time_s
    omega = stack(ticks, "angular_rate_rad_s")
    # In a turning frame the rate's own derivative is that of its components: ω × ω is 0.
    seen = (omega[2:] - omega[:-2]) / (2.0 * dt_s)
    said = stack(ticks, "angular_acceleration_rad_s2")[1:-1]
    is_calm = calm(ticks)[1:-1]
    return rms((seen - said)[is_calm]) / rms(said[is_calm])


def calm(ticks, around=5):
    """Ticks near which nothing touches: where forces jump, differences of motion mean little."""
    is_touched = np.array([tick.touching().any() for tick in ticks])
    return np.convolve(is_touched, np.ones(2 * around + 1), mode="same") == 0.0
