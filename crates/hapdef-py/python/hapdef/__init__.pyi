"""A sense of touch for robot limbs from a few strain gauges."""

from os import PathLike
from typing import Any, Iterator, Literal, Mapping, Optional, Sequence, Union, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Path = Union[str, "PathLike[str]"]
_Kind = Literal["superposition", "tracking", "hapdefx"]
_Floats = NDArray[np.float64]

__version__: str

class HapdefError(Exception):
    """hapdef refused or failed; the message says what to do."""

class SceneError(HapdefError):
    """A scene file was refused; the message names the JSON path."""

@final
class Scene:
    """A limb with its gauges, as a scene file says it."""

    def __new__(
        cls,
        path: _Path,
        *,
        results: Optional[_Path] = None,
        threads: Optional[int] = None,
        seed: Optional[int] = None,
        profile: Literal["quick", "full"] = "quick",
        amounts: Optional[Mapping[str, Any]] = None,
        verbose: bool = False,
    ) -> "Scene":
        """Reads a scene file and the limb that it names, and checks both.

        results: folder of the cache, ``target/hapdef`` if None.
        threads: all cores if None; results don't depend on it.
        seed: of the training side, instead of the scene's.
        profile: how much to make and how long to train.
        amounts: what is to differ from the profile, such as
            ``{"n_single": 2000, "reconstruction": {"steps": 100}}``.
        verbose: progress on standard error.
        """
    @property
    def name(self) -> str: ...
    @property
    def n_gauges(self) -> int: ...
    @property
    def n_surface_nodes(self) -> int: ...
    @property
    def gauge_names(self) -> list[str]: ...
    @property
    def gauge_positions_m(self) -> _Floats:
        """Centres of the gauges, m, ``[n_gauges, 3]``."""
    @property
    def gauge_axes(self) -> _Floats:
        """Measuring directions, unit length, ``[n_gauges, 3]``."""
    @property
    def surface_m(self) -> _Floats:
        """Positions of the surface nodes, m, ``[n_surface_nodes, 3]``."""
    @property
    def directions(self) -> _Floats:
        """Direction of a press at each surface node, unit length, into the limb,
        ``[n_surface_nodes, 3]``."""
    @property
    def faces(self) -> NDArray[np.uint32]:
        """Six-node faces of the skin: three corners, then the middles of the sides 0-1, 1-2, 2-0;
        ``[n_faces, 6]``."""
    def json(self) -> str:
        """The scene as JSON text."""
    def write(self, path: _Path) -> None:
        """Writes the scene; its paths stay relative to the folder of the first file."""
    def with_gauges(
        self,
        positions_m: ArrayLike,
        axes: ArrayLike,
        *,
        names: Optional[Sequence[str]] = None,
        name: Optional[str] = None,
    ) -> "Scene":
        """The same limb with other gauges: centres, m, ``[n, 3]``, measuring directions ``[n, 3]``."""
    def with_superposition(
        self,
        *,
        noise_ue: Optional[float] = None,
        map_error: Optional[float] = None,
        map_refinements: Optional[int] = None,
        friction: Optional[float] = None,
        widest_tip_m: Optional[float] = None,
        palm_radius_m: Optional[float] = None,
        n_sites: Optional[int] = None,
        calibration: Optional[_Path] = None,
    ) -> "Scene":
        """The same scene, its contacts found by superposition; what is None stays as it was.

        noise_ue: standard deviation of a reading's noise, µε.
        map_error: relative error of the map; not used with a calibration.
        map_refinements: of the mesh from which a calibration starts.
        friction: largest friction coefficient of what touches.
        widest_tip_m: radius of the widest tip that touches; the scene's tip_radius_m is the map's.
        palm_radius_m: radius of the widest contact that is looked for, in single frames; 0 for none.
        calibration: file that a calibration wrote.
        """
    def place(
        self,
        n_gauges: int = 10,
        *,
        noise_ue: float = 1.0,
        force_n: float = 10.0,
        n_positions: int = 160,
        n_axes: int = 4,
        n_sites: int = 400,
        n_mounted: int = 0,
        min_spacing_m: float = 0.01,
        margin_m: float = 0.001,
        keep_out: Optional[ArrayLike] = None,
        compare: bool = False,
        seed: Optional[int] = None,
    ) -> list["Layout"]:
        """Layouts of gauges on the inner wall, the recommended one last.

        noise_ue: standard deviation of a reading's noise, µε.
        force_n: force of the contacts, N.
        n_positions, n_axes: places on the wall and directions at each that are looked at.
        n_sites: sites of contacts.
        n_mounted: the first so many of the scene's gauges stay.
        margin_m: how far off a gauge may be glued and must still fit on its wall, m.
        keep_out: balls that no gauge's centre may lie in: x, y, z, radius, m, ``[n, 4]``.
        compare: other methods, too.
        """
    def response(self) -> "Response":
        """What every gauge reads for a newton anywhere, by one adjoint solve for each gauge."""
    def compliance(self) -> NDArray[np.float32]:
        """Displacement per newton at each surface node, m/N,
        ``[n_surface_nodes, n_surface_nodes + n_virtual_gauges, 3]``; from the cache where it is."""
    def rig(self) -> "Rig":
        """The simulated hardware; from the cache where it is."""
    def calibrate(
        self,
        positions_m: ArrayLike,
        forces_n: ArrayLike,
        readings_ue: ArrayLike,
        *,
        noise_ue: float = 1.0,
        position_sd_m: float = 0.0,
        force_sd_n: float = 0.0,
        off_skin_m: float = 2e-3,
        n_sites: int = 800,
    ) -> "Calibration":
        """Corrects the response by presses: places, m, ``[n, 3]``; normal forces, N, ``[n]``; tared
        readings, µε, ``[n, n_gauges]``. The standard deviations are of a reading, of a place along
        the skin and of a force."""
    def recalibrate(
        self,
        positions_m: ArrayLike,
        forces_n: ArrayLike,
        readings_ue: ArrayLike,
        *,
        times_s: Optional[ArrayLike] = None,
        noise_ue: float = 1.0,
        position_sd_m: float = 5e-4,
        force_sd_n: float = 0.1,
        off_skin_m: float = 2e-3,
    ) -> list[dict[str, Any]]:
        """Brings the file that the scene names as ``estimator.calibration`` up to date by known touches: places, m,
        ``[n, 3]``; forces on the skin, N, ``[n, 3]``; tared readings, µε, ``[n, n_gauges]``; when, s, ``[n]``. What
        became of each, as the journal beside the file has it: ``is_accepted``, ``chi2``, ``gains_after`` ..."""
    def undo_touches(self, n: Optional[int] = None) -> int:
        """Undoes the last ``n`` known touches that were taken, or all; how many these were."""
    def train(
        self, until: Literal["simulate", "dataset", "train", "eval"] = "train"
    ) -> list[dict[str, Any]]:
        """Runs the paper's pipeline and returns the records of its stages. Finished stages come from
        the cache; a training that was stopped goes on."""
    def estimator(self, kind: Optional[_Kind] = None) -> "Estimator":
        """What finds contacts in arrays of frames: the scene's own estimator if None."""
    def learn_loads(
        self, frames: list["LiveFrame"], path: _Path, *, still: int = 200, margin: float = 2.0
    ) -> list[float]:
        """Learns loads that are no contacts from frames in which nothing touches, the first ``still`` of them of a robot
        that stands still; writes them for the scene's ``loads.learned``. How strongly each unknown one moved the
        gauges, µε rms."""
    def live(
        self,
        source: Optional[str] = None,
        *,
        kind: _Kind = "tracking",
        seconds: Optional[float] = None,
        tare_s: float = 1.0,
        seed: int = 1,
        topic: Optional[str] = None,
    ) -> "Live":
        """Live contacts, frame by frame.

        source: such as ``serial:/dev/ttyACM0``, ``tcp:HOST:PORT``, ``replay:FILE@max``; if None the
            simulated rig, pressed at random, as fast as frames are taken.
        seconds: length of the simulated play, endless if None; a source ends by itself or `close`.
        tare_s: time whose mean is the tare; touch nothing.
        seed: of the simulated presses.
        topic: read the numbers of this topic, µε, of a ``replay:`` of an MCAP file of another program, or of
            ``ros2:0``, a topic of ROS 2 (a module built with zenoh).
        """

@final
class TouchSensor:
    """A simulated skin for a simulator of robots: what presses and loads the limb goes in step by step, gauge readings
    and contacts come out."""

    def __new__(cls, scene: Scene, *, rate_hz: float = 1000.0, tare_s: float = 1.0) -> "TouchSensor":
        """The simulated rig of a scene with the live estimator behind it; nothing may touch for ``tare_s``."""
    def step(
        self,
        positions_m: Optional[ArrayLike] = None,
        forces_n: Optional[ArrayLike] = None,
        *,
        specific_force_m_s2: Optional[ArrayLike] = None,
        angular_rate_rad_s: Optional[ArrayLike] = None,
        angular_acceleration_rad_s2: Optional[ArrayLike] = None,
        flange_force_n: Optional[ArrayLike] = None,
        flange_moment_nm: Optional[ArrayLike] = None,
        warmer_k: float = 0.0,
    ) -> "LiveFrame":
        """The next frame; all in the limb's frame, the rest as far as the scene's ``loads`` have it.

        positions_m, forces_n: ``[n, 3]`` each, forces on the limb at the nearest points of its surface; what pulls is
            left out.
        specific_force_m_s2: gravity less the acceleration of the limb's origin, ``[3]``.
        flange_force_n, flange_moment_nm: of the next joint on the limb, the moment about the middle of the flange.
        """

@final
class Layout:
    """Gauges that a method chose, with their Cramér-Rao bounds."""

    @property
    def name(self) -> str: ...
    @property
    def positions_m(self) -> _Floats:
        """Centres on the wall, m, ``[n_gauges, 3]``; empty for the median of random layouts."""
    @property
    def axes(self) -> _Floats:
        """Measuring directions, unit length, ``[n_gauges, 3]``."""
    @property
    def single_mean_m(self) -> float:
        """Mean over the skin of the bound on one contact's position, m."""
    @property
    def single_p95_m(self) -> float: ...
    @property
    def pair_median_m(self) -> float:
        """Median over pairs of the bound on one of two contacts' position, m."""
    @property
    def pair_p95_m(self) -> float: ...

@final
class Response:
    """Gauge readings per newton, smooth over the skin."""

    @property
    def n_gauges(self) -> int: ...
    @property
    def nodal_ue_per_n(self) -> _Floats:
        """Readings for a newton along x, y and z at each surface node, µε/N,
        ``[n_surface_nodes, n_gauges, 3]``."""
    def readings_ue(self, positions_m: ArrayLike, forces_n: ArrayLike) -> _Floats:
        """Readings of single presses against the normal, µε, ``[n, n_gauges]``: row i for force i, N,
        at the point of the skin nearest to position i, m. Those of several contacts add up."""
    def bounds(
        self,
        *,
        noise_ue: float = 1.0,
        force_n: float = 10.0,
        n_sites: int = 400,
        n_partners: int = 1,
        threads: int = 1,
    ) -> "Bounds":
        """Cramér-Rao bounds at every surface node, which no unbiased estimate beats."""

@final
class Bounds:
    """Cramér-Rao bounds over the skin."""

    @property
    def single_m(self) -> _Floats:
        """Of one contact's position, m, ``[n_surface_nodes]``; infinite at blind spots."""
    @property
    def single_n(self) -> _Floats:
        """Of its force, N."""
    @property
    def pair_m(self) -> _Floats:
        """Of its position while a second contact is somewhere else, m."""
    @property
    def blind_nodes(self) -> NDArray[np.uint64]: ...
    @property
    def n_carried(self) -> int:
        """The most contacts at a time that the layout carries."""

@final
class Rig:
    """The simulated hardware: another mesh, other stiffness, gauges off their place."""

    @property
    def n_gauges(self) -> int: ...
    @property
    def nodal_ue_per_n(self) -> _Floats:
        """Readings for a newton along x, y and z at each surface node, µε/N,
        ``[n_surface_nodes, n_gauges, 3]``."""
    def press(
        self, positions_m: ArrayLike, forces_n: ArrayLike, *, seed: Optional[int] = None
    ) -> _Floats:
        """Tared readings, µε, ``[n, n_gauges]``, of presses against the normal at the points nearest
        to the positions, m, ``[n, 3]``. Without a seed the strains themselves, else what the scene's
        electronics make of them."""

@final
class Calibration:
    """A response corrected by presses, and what it rests on."""

    @property
    def n_presses(self) -> int: ...
    @property
    def n_used(self) -> int: ...
    @property
    def rejected(self) -> NDArray[np.uint64]:
        """Rows of the presses that were left out."""
    @property
    def relative_error(self) -> float:
        """Relative error of the map at presses not used for it, their noise included."""
    @property
    def relative_error_before(self) -> float: ...
    @property
    def curve(self) -> _Floats:
        """Number of presses, relative error with so many; ``[n, 2]``."""
    @property
    def next_positions_m(self) -> _Floats:
        """Places where the next presses help most, best first, m, ``[n, 3]``."""
    def write(self, path: _Path) -> None:
        """Writes the file that a scene names as ``estimator.calibration``."""
    def estimator(self) -> "Estimator":
        """What finds contacts on the corrected map, each frame on its own."""

@final
class Estimator:
    """Finds contacts in arrays of frames."""

    @property
    def name(self) -> str: ...
    @property
    def n_gauges(self) -> int: ...
    def estimate(self, readings_ue: ArrayLike) -> "Estimates":
        """Contacts behind tared readings, µε, ``[n_frames, n_gauges]``, in order; ``tracking`` goes on
        from the frames of the call before."""
    def start_over(self) -> None:
        """Forgets what earlier frames said."""

@final
class Estimates:
    """Contacts of many frames: arrays with one entry a contact, and with one entry a frame."""

    @property
    def frame(self) -> NDArray[np.int64]:
        """Frame of each contact, ``[n_contacts]``."""
    @property
    def position_m(self) -> _Floats:
        """``[n_contacts, 3]``"""
    @property
    def force_n(self) -> _Floats: ...
    @property
    def position_sd_m(self) -> _Floats:
        """Standard deviations, ``[n_contacts]``; NaN where the estimator can't tell."""
    @property
    def force_sd_n(self) -> _Floats: ...
    @property
    def count(self) -> NDArray[np.int64]:
        """Contacts of each frame, ``[n_frames]``."""
    @property
    def is_identified(self) -> NDArray[np.bool_]:
        """Whether the frame decides for these contacts, ``[n_frames]``."""
    @property
    def chi2(self) -> _Floats: ...
    @property
    def p_value(self) -> _Floats: ...
    def __len__(self) -> int:
        """Number of frames."""

@final
class Contact:
    """One contact of a live frame."""

    @property
    def position_m(self) -> _Floats: ...
    @property
    def force_n(self) -> float: ...
    @property
    def direction(self) -> Optional[_Floats]:
        """Direction of the force on the limb, unit length, ``[3]``."""
    @property
    def id(self) -> Optional[int]: ...
    @property
    def phase(self) -> Optional[Literal["born", "held", "sliding"]]: ...
    @property
    def radius_m(self) -> Optional[float]:
        """Where the contact is found to be wider than the map's tip."""
    @property
    def position_sd_m(self) -> Optional[float]: ...
    @property
    def force_sd_n(self) -> Optional[float]: ...
    @property
    def covariance_m2(self) -> Optional[_Floats]:
        """Covariance of the position in space, m², ``[3, 3]``."""

@final
class Quality:
    """Whether a frame decides for its contacts."""

    @property
    def is_identified(self) -> bool: ...
    @property
    def why_not(
        self,
    ) -> Optional[
        Literal["singular_information", "tied_explanations", "misfit", "unchecked", "noise"]
    ]: ...
    @property
    def chi2(self) -> float: ...
    @property
    def n_dof(self) -> int: ...
    @property
    def p_value(self) -> float:
        """The probability of a χ² as large."""
    @property
    def n_alternatives(self) -> int:
        """Other explanations that are nearly as good."""

@final
class LiveFrame:
    """A frame: readings and contacts."""

    @property
    def seq(self) -> int: ...
    @property
    def t_s(self) -> float:
        """Device time of the sample instant, s."""
    @property
    def n_missing_before(self) -> int: ...
    @property
    def phase(self) -> Literal["taring", "untouched", "touched", "unknown"]: ...
    @property
    def why_unknown(
        self,
    ) -> Optional[
        Literal["too_few_gauges", "stream_stalled", "tare_invalid", "misfit", "drift"]
    ]: ...
    @property
    def is_stale(self) -> bool:
        """The contacts are the last ones that were explained, or the frame itself is old."""
    @property
    def smallest_seen_n(self) -> Optional[float]:
        """The smallest force that would show wherever it pressed, N."""
    @property
    def quality(self) -> Optional[Quality]: ...
    def known_contacts(self) -> list[Contact]:
        """The contacts, also none, where a program may act on them; raises HapdefError with the
        reason while taring and where the phase is unknown."""
    @property
    def raw_ue(self) -> _Floats:
        """Readings as they came, µε, ``[n_gauges]``."""
    @property
    def tared_ue(self) -> _Floats:
        """Readings less tare and drift, µε, ``[n_gauges]``."""
    @property
    def signals(self) -> dict[str, float]:
        """What else the device measures of how the whole limb is loaded, such as ``acceleration_0``, as it came."""
    @property
    def contacts(self) -> list[Contact]: ...
    def wrench(self, about_m: Optional[ArrayLike] = None) -> Optional[Wrench]:
        """The net wrench of the contacts about a point of the limb's frame, m, ``[3]``, its origin if None."""
    @property
    def released(self) -> list[int]:
        """Names of contacts that were let go in this frame."""

@final
class Wrench:
    """The force and moment of all contacts together."""

    @property
    def about_m(self) -> _Floats:
        """The point of the limb's frame that the moment is about, m, ``[3]``."""
    @property
    def force_n(self) -> _Floats:
        """The force on the limb, N, ``[3]``."""
    @property
    def moment_nm(self) -> _Floats: ...
    @property
    def covariance(self) -> Optional[_Floats]:
        """Covariance of (force, moment), ``[6, 6]``; errors of contacts are taken as independent."""
    def about(self, point_m: ArrayLike) -> Wrench:
        """The same about another point, m, ``[3]``."""
    def joint_torques(self, jacobian: ArrayLike) -> JointTorques:
        """External torques of joints by the geometric Jacobian ``[6, n_joints]`` of the point ``about_m``, linear
        velocity first, in the limb's axes: the order of KDL and Pinocchio."""

@final
class JointTorques:
    """What a wrench puts on joints."""

    @property
    def torques(self) -> _Floats:
        """N m of joints that turn, N of those that slide, ``[n_joints]``."""
    @property
    def covariance(self) -> Optional[_Floats]:
        """``[n_joints, n_joints]``."""

@final
class Live:
    """A running stream of frames; use it in a ``with`` block and iterate over it."""

    @property
    def source(self) -> str: ...
    def tare(self) -> None:
        """Takes a new tare of the next frames, which must be untouched."""
    @property
    def tare_fault(self) -> Optional[str]:
        """Why the last tare was refused or does not hold, and what to do; None if it holds."""
    def health(self) -> Optional[dict[str, Any]]:
        """Counts since the start; None when it is closed."""
    def close(self) -> None: ...
    def __iter__(self) -> Iterator[LiveFrame]: ...
    def __next__(self) -> LiveFrame: ...
    def __enter__(self) -> "Live": ...
    def __exit__(self, *raised: object) -> None: ...

@final
class Shell:
    """A limb of which there is only a glTF surface, as a shell with gauges on its inner side."""

    def __new__(
        cls,
        path: _Path,
        *,
        wall_m: float,
        unit: Literal["m", "mm", "cm", "in"] = "m",
        n_gauges: int = 10,
        edge_m: Optional[float] = None,
        youngs_modulus_pa: float = 1.7e9,
        poissons_ratio: float = 0.394,
        threads: int = 1,
    ) -> "Shell":
        """Reads the outside of a wall ``wall_m`` thick, remeshes it with edges of ``edge_m`` (a fortieth
        of its extent if None), and solves its shell as that of a scene of the skin."""
    @property
    def nodes_m(self) -> _Floats:
        """Corners of the skin's faces and the middles of their sides."""
    @property
    def triangles(self) -> NDArray[np.uint32]: ...
    @property
    def normals(self) -> _Floats: ...
    @property
    def gauge_positions_m(self) -> _Floats: ...
    @property
    def median_best_ue_per_n(self) -> float:
        """Half of the free nodes have a gauge that reads at least this for a newton, µε/N."""
    def response(self) -> Response: ...
