"""Triangles of the mesh files that URDFs name: DAE, glTF binary and STL, in metres. MuJoCo itself reads no DAE or GLB."""

import json
import struct
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import numpy as np

# glTF's numbers by their code: type and size in bytes.
COMPONENTS = {5121: "u1", 5123: "<u2", 5125: "<u4", 5126: "<f4"}


def read(path):
    """Vertices `[n, 3]`, m, and triangles `[m, 3]` of a mesh file; vertices at one place are one."""
    path = Path(path)
    readers = {".dae": read_dae, ".glb": read_glb, ".stl": read_stl}
    if path.suffix.lower() not in readers:
        raise ValueError(f"{path}: expected one of {', '.join(readers)}")
    vertices, triangles = readers[path.suffix.lower()](path)
    return joined(vertices, triangles)


def joined(vertices_m, triangles):
    """Equal vertices made one, triangles without area left out."""
    vertices_m, place = np.unique(vertices_m, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles]
    a, b, c = (vertices_m[triangles[:, k]] for k in range(3))
    has_area = np.linalg.norm(np.cross(b - a, c - a), axis=1) > 1e-14
    return vertices_m, triangles[has_area]


def read_dae(path):
    """COLLADA: every geometry that the visual scene shows, moved by its nodes' matrices."""
    root = ElementTree.parse(path).getroot()
    namespace = root.tag[: root.tag.index("}") + 1]
    unit = root.find(f"{namespace}asset/{namespace}unit")
    metre = 1.0 if unit is None else float(unit.get("meter", 1.0))
    geometries = {mesh.get("id"): mesh for mesh in root.iter(f"{namespace}geometry")}
    parts = []

    def walk(node, outer):
        matrix = node.find(f"{namespace}matrix")
        inner = outer
        if matrix is not None:
            inner = outer @ np.array(matrix.text.split(), float).reshape(4, 4)
        for shown in node.findall(f"{namespace}instance_geometry"):
            mesh = geometries[shown.get("url")[1:]].find(f"{namespace}mesh")
            for points, triangles in dae_triangles(mesh, namespace):
                parts.append(((points @ inner[:3, :3].T + inner[:3, 3]) * metre, triangles))
        for child in node.findall(f"{namespace}node"):
            walk(child, inner)

    for scene in root.iter(f"{namespace}visual_scene"):
        for node in scene.findall(f"{namespace}node"):
            walk(node, np.eye(4))
    return stacked(parts, path)


def dae_triangles(mesh, namespace):
    """Points and triangles of each list of triangles or polygons of a mesh."""
    sources = {
        source.get("id"): source.find(f"{namespace}float_array")
        for source in mesh.findall(f"{namespace}source")
    }
    for kind in ("triangles", "polylist"):
        for listed in mesh.findall(f"{namespace}{kind}"):
            inputs = listed.findall(f"{namespace}input")
            stride = 1 + max(int(each.get("offset")) for each in inputs)
            vertex = next(each for each in inputs if each.get("semantic") == "VERTEX")
            positions = mesh.find(f"{namespace}vertices/{namespace}input[@semantic='POSITION']")
            points = np.array(sources[positions.get("source")[1:]].text.split(), float)
            corners = np.array(listed.find(f"{namespace}p").text.split(), int)
            corners = corners.reshape(-1, stride)[:, int(vertex.get("offset"))]
            counts = listed.find(f"{namespace}vcount")
            sizes = None if counts is None else np.array(counts.text.split(), int)
            yield points.reshape(-1, 3), fans(corners, sizes)


def fans(corners, sizes):
    """Triangles of polygons with `sizes` corners each; of triangles if there are no sizes."""
    if sizes is None:
        return corners.reshape(-1, 3)
    triangles, start = [], 0
    for size in sizes:
        polygon = corners[start : start + size]
        triangles += [(polygon[0], polygon[k], polygon[k + 1]) for k in range(1, size - 1)]
        start += size
    return np.array(triangles, int).reshape(-1, 3)


def read_glb(path):
    """glTF binary: the triangles of all meshes; nodes that move them are refused."""
    data = Path(path).read_bytes()
    (length,) = struct.unpack_from("<I", data, 12)
    text, blob = json.loads(data[20 : 20 + length]), data[28 + length :]
    moved = ("matrix", "translation", "rotation", "scale")
    if any(key in node for node in text.get("nodes", []) for key in moved):
        raise ValueError(f"{path}: a node moves its mesh; save it with the motion applied")

    def numbers(accessor_idx, width):
        accessor = text["accessors"][accessor_idx]
        view = text["bufferViews"][accessor["bufferView"]]
        if "byteStride" in view:
            raise ValueError(f"{path}: interleaved buffers are not read")
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        kind = COMPONENTS[accessor["componentType"]]
        return np.frombuffer(blob, kind, accessor["count"] * width, start)

    parts = []
    for mesh in text["meshes"]:
        for primitive in mesh["primitives"]:
            points = numbers(primitive["attributes"]["POSITION"], 3).reshape(-1, 3)
            triangles = numbers(primitive["indices"], 1).reshape(-1, 3)
            parts.append((points.astype(float), triangles.astype(int)))
    return stacked(parts, path)


def read_stl(path):
    """Binary STL."""
    data = Path(path).read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    if len(data) != 84 + 50 * count:
        raise ValueError(f"{path}: expected a binary STL of {count} triangles")
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
    corners = np.frombuffer(data, record, count, 84)["corners"].reshape(-1, 3)
    return corners.astype(float), np.arange(3 * count).reshape(-1, 3)


def stacked(parts, path):
    """One list of vertices and triangles of several."""
    if not parts:
        raise ValueError(f"{path}: no triangles")
    firsts = np.cumsum([0] + [len(points) for points, _ in parts[:-1]])
    triangles = [triangles + first for (_, triangles), first in zip(parts, firsts)]
    return np.vstack([points for points, _ in parts]), np.vstack(triangles)


def as_obj(vertices_m, triangles):
    """The text of an OBJ file, which MuJoCo reads."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices_m]
    lines += [f"f {a} {b} {c}" for a, b, c in triangles + 1]
    return ("\n".join(lines) + "\n").encode()


class Surface:
    """Triangles with their normals and areas, and the nearest place on them."""

    def __init__(self, vertices_m, triangles):
        self.vertices_m, self.triangles = vertices_m, triangles
        self.corners_m = vertices_m[triangles]
        crossed = np.cross(
            self.corners_m[:, 1] - self.corners_m[:, 0], self.corners_m[:, 2] - self.corners_m[:, 0]
        )
        double_area = np.linalg.norm(crossed, axis=1)
        self.areas_m2 = 0.5 * double_area
        self.normals = crossed / double_area[:, None]

    def nearest(self, point_m):
        """The nearest place on the surface, its distance, m, and the triangle's index."""
        places = nearest_on_triangles(self.corners_m, np.asarray(point_m, float))
        distances = np.linalg.norm(places - point_m, axis=1)
        idx = int(np.argmin(distances))
        return places[idx], float(distances[idx]), idx


def nearest_on_triangles(corners_m, point_m):
    """The place of each triangle `[n, 3, 3]` that is nearest to a point.

    Ericson, Real-Time Collision Detection (2005), section 5.1.5, with all regions computed for all triangles.
    """
    a, b, c = corners_m[:, 0], corners_m[:, 1], corners_m[:, 2]
    best = on_segments(a, b, point_m)
    for other in (on_segments(b, c, point_m), on_segments(c, a, point_m)):
        is_nearer = squared(other - point_m) < squared(best - point_m)
        best = np.where(is_nearer[:, None], other, best)
    normal = np.cross(b - a, c - a)
    share = np.einsum("ij,ij->i", point_m - a, normal) / squared(normal)
    foot = point_m - share[:, None] * normal
    inside = np.ones(len(foot), bool)
    for start, end in ((a, b), (b, c), (c, a)):
        side = np.einsum("ij,ij->i", np.cross(end - start, foot - start), normal)
        inside &= side >= 0.0
    return np.where(inside[:, None], foot, best)


def on_segments(start, end, point_m):
    """The place of each segment that is nearest to a point."""
    along = end - start
    share = np.einsum("ij,ij->i", point_m - start, along) / squared(along)
    return start + np.clip(share, 0.0, 1.0)[:, None] * along


def squared(rows):
    """Squared length of each row."""
    return np.einsum("ij,ij->i", rows, rows)
