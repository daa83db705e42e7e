"""A sense of touch for robot limbs from a few strain gauges.

A :class:`Scene` is a limb with its gauges, as a scene file says it. From it come the
:class:`Response` of its gauges, :class:`Layout` s of other gauges, the simulated :class:`Rig`, a
:class:`Calibration` by presses, trained nets, an :class:`Estimator` for arrays of frames and
:class:`Live` contacts. A :class:`TouchSensor` is the limb's skin in a simulator of robots. :class:`Shell` needs no more than a glTF surface.

Units are in the names: ``_m`` metres, ``_n`` newtons, ``_ue`` microstrain, ``_s`` seconds. Arrays
have their shapes in the docstrings. Long work lets other threads run and ends on Ctrl-C.
"""

from ._hapdef import (
    Bounds,
    Calibration,
    Contact,
    Estimates,
    Estimator,
    HapdefError,
    JointTorques,
    Layout,
    Live,
    LiveFrame,
    Quality,
    Response,
    Rig,
    Scene,
    SceneError,
    Shell,
    TouchSensor,
    Wrench,
    __version__,
)

__all__ = [
    "Bounds",
    "Calibration",
    "Contact",
    "Estimates",
    "Estimator",
    "HapdefError",
    "JointTorques",
    "Layout",
    "Live",
    "LiveFrame",
    "Quality",
    "Response",
    "Rig",
    "Scene",
    "SceneError",
    "Shell",
    "TouchSensor",
    "Wrench",
    "__version__",
]
