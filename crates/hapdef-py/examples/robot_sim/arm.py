"""A robot of a URDF in MuJoCo: position-controlled joints, and one link whose drawn surface is touched by fingers.

MuJoCo takes a mesh for its convex hull. Here the touched link's own triangles collide, as a rigid two-dimensional flex,
so that contacts lie on the drawn surface. Nothing else collides.
"""

import xml.etree.ElementTree as ElementTree
from pathlib import Path

import mujoco
import numpy as np

from .meshes import Surface, as_obj, read

TIMESTEP_S = 0.5e-3
# Bandwidth of the joints' position control, as of an industrial arm, and the inertia of a geared motor.
SERVO_RAD_S = 2.0 * np.pi * 8.0
ARMATURE_KG_M2 = 0.1
FINGER_RADIUS_M = 0.008
FINGER_MASS_KG = 0.1
FRICTION = 0.4
# Contacts as stiff as a hard rubber tip: 25 N press a finger about 0.1 mm in.
SOLREF = (0.006, 1.0)
SOLIMP = (0.99, 0.99, 0.001, 0.5, 2.0)
# The flex's triangles are that thick on both sides; MuJoCo wants more than 0.
SKIN_RADIUS_M = 1e-5
N_FINGERS = 2
SKIN_RGBA = (0.55, 0.66, 0.8, 1.0)


class Arm:
    """The compiled model with what the rest needs to know of it."""

    def __init__(self, urdf, link):
        self.urdf, self.link = Path(urdf), link
        text, assets, surfaces = with_meshes(self.urdf)
        if link not in surfaces:
            raise ValueError(f"{urdf}: link {link} has no mesh; links with one: {', '.join(surfaces)}")
        self.surface = surfaces[link]
        spec = mujoco.MjSpec.from_string(text, assets=assets)
        self.limits_rad, self.speeds_rad_s = joint_limits(self.urdf, spec)
        add_scene(spec)
        add_skin(spec, link, self.surface)
        for idx in range(N_FINGERS):
            add_finger(spec, idx)
        add_servos(spec)
        self.model = spec.compile()
        gear(self.model)
        self.body = self.model.body(link).id
        self.model.geom_rgba[self.model.geom_bodyid == self.body] = SKIN_RGBA
        self.n_joints = len(self.limits_rad)
        self.hand = self.next_body()

    def next_body(self):
        """The body that is fixed to the link by the next joint."""
        children = np.flatnonzero(self.model.body_parentid == self.body)
        if len(children) != 1:
            raise ValueError(f"{self.link}: expected one joint to a next link, found {len(children)}")
        return int(children[0])

    def joint_dofs(self):
        """Degree of freedom and actuator of each of the robot's joints, in the URDF's order."""
        joints = [self.model.joint(idx) for idx in range(self.model.njnt)]
        ours = [joint for joint in joints if is_robots(joint.name)]
        dofs = np.array([joint.dofadr[0] for joint in ours])
        return dofs, np.array([self.model.actuator(joint.name).id for joint in ours])

    def finger_dofs(self, idx):
        """Degrees of freedom and actuators of a finger's three slides, and its ball."""
        names = [slide(idx, axis) for axis in "xyz"]
        dofs = np.array([self.model.joint(name).dofadr[0] for name in names])
        motors = np.array([self.model.actuator(name).id for name in names])
        return dofs, motors, int(self.model.body(f"finger{idx}").geomadr[0])

    def axis(self):
        """From the link's joint to the next: origin and direction in the link's frame, and the length, m."""
        end_m = self.model.body_pos[self.hand]
        length_m = float(np.linalg.norm(end_m))
        return np.zeros(3), end_m / length_m, length_m


def with_meshes(urdf):
    """The URDF with OBJ meshes that MuJoCo can read, those meshes, and the first drawn surface of each link."""
    root = ElementTree.parse(urdf).getroot()
    assets, surfaces, names = {}, {}, {}
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            link.remove(collision)
        for visual in link.findall("visual"):
            mesh = visual.find("geometry/mesh")
            if mesh is None:
                continue
            path = found(mesh.get("filename"), urdf)
            scale = np.array(mesh.get("scale", "1 1 1").split(), float)
            vertices_m, triangles = read(path)
            key = (path, tuple(scale))
            names.setdefault(key, f"{path.stem}_{len(names)}.obj")
            assets[names[key]] = as_obj(vertices_m * scale, triangles)
            mesh.set("filename", names[key])
            mesh.attrib.pop("scale", None)
            rotation, shift_m = pose(visual.find("origin"))
            surfaces.setdefault(
                link.get("name"),
                Surface((vertices_m * scale) @ rotation.T + shift_m, triangles),
            )
    settings = ElementTree.SubElement(root, "mujoco")
    options = {"discardvisual": "false", "strippath": "true", "balanceinertia": "true"}
    ElementTree.SubElement(settings, "compiler", options)
    return ElementTree.tostring(root, encoding="unicode"), assets, surfaces


def found(name, urdf):
    """The file that a URDF means: relative to it, or for package:// below one of the folders above it."""
    if not name.startswith("package://"):
        return (Path(urdf).parent / name.removeprefix("file://")).resolve()
    tail = name.removeprefix("package://")
    # A package's folder needn't have its name.
    shorter = tail.partition("/")[2]
    for folder in Path(urdf).resolve().parents:
        for path in (folder / tail, folder / shorter):
            if path.is_file():
                return path
    raise ValueError(f"{urdf}: {name} is in none of the folders above")


def pose(origin):
    """Rotation and shift of a URDF's origin."""
    if origin is None:
        return np.eye(3), np.zeros(3)
    roll, pitch, yaw = (float(angle) for angle in origin.get("rpy", "0 0 0").split())
    turns = [rotation_about(axis, angle) for axis, angle in ((2, yaw), (1, pitch), (0, roll))]
    return turns[0] @ turns[1] @ turns[2], np.array(origin.get("xyz", "0 0 0").split(), float)


def rotation_about(axis, angle_rad):
    """Rotation about one of the axes 0, 1, 2."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    rotation = np.eye(3)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    rotation[j, j], rotation[j, k], rotation[k, j], rotation[k, k] = cos, -sin, sin, cos
    return rotation


def joint_limits(urdf, spec):
    """Range `[n, 2]`, rad, and largest speed `[n]`, rad/s, of each joint that MuJoCo has."""
    stated = {joint.get("name"): joint for joint in ElementTree.parse(urdf).getroot().findall("joint")}
    ranges, speeds = [], []
    for joint in filter(lambda each: is_robots(each.name), spec.joints):
        element = stated[joint.name]
        limit = element.find("limit")
        is_endless = element.get("type") == "continuous" or limit is None
        lower, upper = (-np.pi, np.pi) if is_endless else (float(limit.get("lower")), float(limit.get("upper")))
        ranges.append((lower, upper))
        speeds.append(1.0 if limit is None else float(limit.get("velocity", 1.0)))
    return np.array(ranges), np.array(speeds)


def add_scene(spec):
    """Time step, light, floor; explicit Euler so that the accelerations are those of the solver."""
    spec.option.timestep = TIMESTEP_S
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.tolerance = 1e-12
    spec.option.iterations = 200
    spec.visual.headlight.ambient = (0.35, 0.35, 0.35)
    spec.visual.global_.offwidth, spec.visual.global_.offheight = 1280, 960
    for geom in spec.geoms:
        geom.contype, geom.conaffinity = 0, 0
    sky = spec.add_texture(name="sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=64, height=384)
    sky.builtin, sky.rgb1, sky.rgb2 = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT, (0.93, 0.95, 0.98), (0.62, 0.7, 0.8)
    spec.worldbody.add_light(pos=(0.5, -1.0, 2.0), dir=(-0.25, 0.5, -1.0))
    spec.worldbody.add_geom(
        type=mujoco.mjtGeom.mjGEOM_PLANE,
        size=(1.5, 1.5, 0.1),
        rgba=(0.85, 0.87, 0.9, 1.0),
        contype=0,
        conaffinity=0,
    )


def add_skin(spec, link, surface):
    """The link's surface as a rigid flex that fingers collide with."""
    spec.add_flex(
        name="skin",
        dim=2,
        radius=SKIN_RADIUS_M,
        vertbody=[link],
        vert=surface.vertices_m.reshape(-1),
        elem=surface.triangles.reshape(-1),
        contype=1,
        conaffinity=2,
        selfcollide=mujoco.mjtFlexSelf.mjFLEXSELF_NONE,
        friction=(FRICTION, 0.0, 0.0),
        solref=SOLREF,
        solimp=SOLIMP,
        rgba=(0.3, 0.3, 0.32, 0.0),
    )


def add_finger(spec, idx):
    """A ball on three slides, without weight, moved by three force motors."""
    body = spec.worldbody.add_body(name=f"finger{idx}", gravcomp=1.0)
    for axis, name in zip(np.eye(3), "xyz"):
        joint = slide(idx, name)
        body.add_joint(name=joint, type=mujoco.mjtJoint.mjJNT_SLIDE, axis=axis)
        motor = spec.add_actuator(name=joint, target=joint)
        motor.trntype = mujoco.mjtTrn.mjTRN_JOINT
    body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=(FINGER_RADIUS_M, 0.0, 0.0),
        mass=FINGER_MASS_KG,
        contype=2,
        conaffinity=1,
        friction=(FRICTION, 0.0, 0.0),
        solref=SOLREF,
        solimp=SOLIMP,
        rgba=(0.95, 0.75, 0.6, 0.55),
    )


def add_servos(spec):
    """One torque motor for each joint of the robot; `Servos` has their control law."""
    for joint in spec.joints:
        if is_robots(joint.name):
            motor = spec.add_actuator(name=joint.name, target=joint.name)
            motor.trntype = mujoco.mjtTrn.mjTRN_JOINT


def slide(finger_idx, axis):
    """Name of a finger's slide along an axis, and of its motor."""
    return f"finger_slide_{finger_idx}{axis}"


def is_robots(joint_name):
    """Not a finger's slide."""
    return not joint_name.startswith("finger_slide")


def gear(model):
    """The gears' inertia; without limits, damping and friction, whose forces nothing else accounts for."""
    for idx in range(model.njnt):
        joint = model.joint(idx)
        model.jnt_limited[idx] = 0
        joint.damping[:], joint.frictionloss[:] = 0.0, 0.0
        joint.armature[:] = ARMATURE_KG_M2 if is_robots(joint.name) else 0.0
