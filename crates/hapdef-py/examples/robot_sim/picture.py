"""Pictures of a run without a screen: MuJoCo's own renderer, with sticks for true and estimated contacts."""

import mujoco
import numpy as np

TRUE_RGBA = (0.15, 0.65, 0.3, 0.9)
ESTIMATED_RGBA = (0.9, 0.2, 0.15, 0.9)
STICK_M_PER_N = 0.006
LEAST_STICK_M = 0.03


class Camera:
    """Looks at the touched link from the side, near it."""

    def __init__(self, world, width, height, distance_m=0.7):
        self.world = world
        self.renderer = mujoco.Renderer(world.model, height, width)
        self.camera = mujoco.MjvCamera()
        self.camera.distance, self.camera.elevation = distance_m, -15.0
        self.camera.azimuth = 130.0

    def picture(self, tick, estimated=()):
        """Pixels `[height, width, 3]` of the moment that the world is at; `estimated`: pairs of place and force."""
        world = self.world
        middle = 0.5 * world.arm.axis()[2] * world.arm.axis()[1]
        self.camera.lookat[:] = tick.origin_m + tick.world_from_link @ middle
        self.renderer.update_scene(world.data, self.camera)
        for place_m, force_n in zip(tick.positions_m, tick.forces_n):
            if np.linalg.norm(force_n) > 0.0:
                self.stick(tick, place_m, force_n, TRUE_RGBA, 0.003)
        for place_m, force_n in estimated:
            self.stick(tick, np.asarray(place_m), np.asarray(force_n), ESTIMATED_RGBA, 0.002)
        return self.renderer.render()

    def stick(self, tick, place_m, force_n, rgba, radius_m):
        """A stick that is longer the larger the force, with a ball where the force acts."""
        strength_n = np.linalg.norm(force_n)
        if strength_n == 0.0:
            return
        tail_m = place_m - force_n / strength_n * (LEAST_STICK_M + STICK_M_PER_N * strength_n)
        tip, tail = (tick.origin_m + tick.world_from_link @ each for each in (place_m, tail_m))
        self.shape(mujoco.mjtGeom.mjGEOM_CAPSULE, radius_m, tail, tip, rgba)
        self.shape(mujoco.mjtGeom.mjGEOM_SPHERE, 2.0 * radius_m, tip, None, rgba)

    def shape(self, kind, radius_m, begin_m, end_m, rgba):
        """A ball, or what leads from one point to another."""
        scene = self.renderer.scene
        if scene.ngeom == scene.maxgeom:
            return
        geom = scene.geoms[scene.ngeom]
        size, rgba = np.full(3, radius_m), np.array(rgba, np.float32)
        mujoco.mjv_initGeom(geom, kind, size, begin_m, np.eye(3).reshape(-1), rgba)
        if end_m is not None:
            mujoco.mjv_connector(geom, kind, radius_m, begin_m, end_m)
        scene.ngeom += 1

    def close(self):
        """Frees the renderer."""
        self.renderer.close()


def save_picture(path, pixels):
    """One picture; the ending says how."""
    from PIL import Image

    Image.fromarray(pixels).save(path)


def save_video(path, pictures, frames_per_s):
    """An animated WebP, which browsers show."""
    from PIL import Image

    first, *rest = [Image.fromarray(pixels) for pixels in pictures]
    duration_ms = round(1000.0 / frames_per_s)
    first.save(path, save_all=True, append_images=rest, duration=duration_ms, loop=0, quality=60, method=3)
