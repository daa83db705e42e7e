//! A link of a URDF: its mesh in the link's frame, and where it is joined to others.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use hapdef_mesh::{GltfParams, SurfaceMesh, read_surface};
use nalgebra::{Isometry3, Matrix4, Point3, Translation3, UnitQuaternion, Vector3};
use roxmltree::{Document, Node};

use super::collada::Asset;
use crate::error::HapdefError;

/// Joints of a link.
#[derive(Clone, Debug)]
pub(super) struct Joints {
    /// The joint to the link's parent; it is at the link's origin.
    pub(super) parent: Option<String>,
    /// The joints to its children, and where they are in the link's frame, m.
    pub(super) children: Vec<(String, Point3<f64>)>,
}

impl Joints {
    /// The joint to a child that is farthest from the link's origin, if one is off it.
    pub(super) fn farthest_child(&self) -> Option<&(String, Point3<f64>)> {
        let off = self.children.iter().filter(|(_, place)| place.coords.norm() > 0.0);
        off.max_by(|(_, a), (_, b)| a.coords.norm().total_cmp(&b.coords.norm()))
    }

    /// Where a joint of the link is in its frame, m.
    pub(super) fn place(&self, name: &str) -> Option<Point3<f64>> {
        if self.parent.as_deref() == Some(name) {
            return Some(Point3::origin());
        }
        self.children.iter().find(|(child, _)| child == name).map(|(_, place)| *place)
    }

    /// The names of them all.
    pub(super) fn names(&self) -> String {
        let children = self.children.iter().map(|(name, _)| name);
        let names: Vec<&str> = self.parent.iter().chain(children).map(String::as_str).collect();
        if names.is_empty() { "none".to_owned() } else { names.join(", ") }
    }
}

/// A link as it is drawn.
#[derive(Debug)]
pub(super) struct Link {
    /// In the link's frame, m.
    pub(super) mesh: SurfaceMesh,
    pub(super) joints: Joints,
    /// What was read, in words.
    pub(super) said: String,
    /// What a mesh in COLLADA says of itself.
    pub(super) asset: Option<Asset>,
}

/// Reads a link by its name; that may be left out where only one has a mesh.
pub(super) fn read(path: &Path, name: Option<&str>) -> Result<Link, HapdefError> {
    let refused = |what: String| HapdefError::NewLimb { path: path.into(), what };
    let text = std::fs::read_to_string(path).map_err(|error| refused(error.to_string()))?;
    let document = Document::parse(&text).map_err(|error| refused(error.to_string()))?;
    let robot = document.root_element();
    let links = || children(robot, "link").filter(|link| drawn(*link).is_some());
    let names: Vec<&str> = links().filter_map(|link| link.attribute("name")).collect();
    let chosen = match (name, &names[..]) {
        (Some(name), _) => links().find(|link| link.attribute("name") == Some(name)),
        (None, [_]) => links().next(),
        (None, _) => None,
    };
    let Some(link) = chosen else {
        let known = names.join(", ");
        let asked = name.map_or("a --link".to_owned(), |name| format!("--link {name:?}"));
        return Err(refused(format!("{asked} is none of the links with a mesh: {known}")));
    };
    let name = link.attribute("name").unwrap_or_default();
    let Some((mesh, kind)) = drawn(link) else {
        return Err(refused(format!("the link {name} has no mesh")));
    };
    let file = mesh.attribute("filename").unwrap_or_default();
    let file = mesh_file(path, file)
        .ok_or_else(|| refused(format!("the mesh {file} of the link {name} is not there")))?;
    let scale = numbers::<3>(mesh.attribute("scale"), [1.0; 3]).map_err(refused)?;
    let holder = mesh.ancestors().find(|node| node.has_tag_name(kind));
    let link_from_mesh = origin(holder).map_err(refused)?.to_homogeneous()
        * Matrix4::new_nonuniform_scaling(&scale.into());
    let surface = read_surface(&file, &GltfParams::default())?.mesh;
    let is_collada = file.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("dae"));
    let asset = is_collada.then(|| Asset::read(&file)).transpose()?;
    let mass = children(link, "inertial").flat_map(|i| children(i, "mass")).next();
    let mass = mass.and_then(|mass| mass.attribute("value"));
    let said = format!(
        "link {name}, its {kind} mesh{}",
        mass.map_or(String::new(), |kg| format!(", {kg} kg with all that is in it"))
    );
    let joints = joints(robot, name).map_err(refused)?;
    Ok(Link { mesh: surface.transformed(&link_from_mesh)?, joints, said, asset })
}

/// The first mesh that a link is drawn with, or else collides with.
fn drawn<'a>(link: Node<'a, 'a>) -> Option<(Node<'a, 'a>, &'static str)> {
    ["visual", "collision"].into_iter().find_map(|kind| {
        let mut geometry = children(link, kind).flat_map(|node| children(node, "geometry"));
        let mesh = geometry.find_map(|node| children(node, "mesh").next())?;
        Some((mesh, kind))
    })
}

fn joints(robot: Node<'_, '_>, link: &str) -> Result<Joints, String> {
    let mut joints = Joints { parent: None, children: Vec::new() };
    for joint in children(robot, "joint") {
        let end = |kind| children(joint, kind).next().and_then(|node| node.attribute("link"));
        let name = joint.attribute("name").unwrap_or("without a name").to_owned();
        if end("child") == Some(link) {
            joints.parent = Some(name);
        } else if end("parent") == Some(link) {
            let place = Point3::from(origin(Some(joint))?.translation.vector);
            joints.children.push((name, place));
        }
    }
    Ok(joints)
}

fn children<'a>(node: Node<'a, 'a>, name: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// The pose that an element's `origin` states: turns about the fixed x, y and z, then the shift.
fn origin(node: Option<Node<'_, '_>>) -> Result<Isometry3<f64>, String> {
    let origin = node.and_then(|node| children(node, "origin").next());
    let of = |name| numbers::<3>(origin.and_then(|origin| origin.attribute(name)), [0.0; 3]);
    let ([roll, pitch, yaw], shift) = (of("rpy")?, of("xyz")?);
    let turn = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
    Ok(Isometry3::from_parts(Translation3::from(Vector3::from(shift)), turn))
}

fn numbers<const N: usize>(text: Option<&str>, otherwise: [f64; N]) -> Result<[f64; N], String> {
    let Some(text) = text else { return Ok(otherwise) };
    let found: Result<Vec<f64>, _> = text.split_whitespace().map(f64::from_str).collect();
    let found = found.ok().and_then(|numbers| numbers.try_into().ok());
    found.ok_or_else(|| format!("expected {N} numbers, found {text:?}"))
}

/// A mesh beside the URDF, or in the package it names: the folder of that name above the URDF, or what
/// of the path is found below one of the folders above it.
fn mesh_file(urdf: &Path, name: &str) -> Option<PathBuf> {
    let name = name.strip_prefix("file://").unwrap_or(name);
    let (package, rest) = match name.strip_prefix("package://") {
        Some(path) => path.split_once('/')?,
        None => ("", name),
    };
    let folder = urdf.parent()?.canonicalize().ok()?;
    let places = folder.ancestors().flat_map(|up| [up.join(package).join(rest), up.join(rest)]);
    places.into_iter().find(|path| path.is_file())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::new_limb::{NewLimb, NewLimbParams};
    use hapdef_mesh::write_glb;

    const ROBOT: &str = r#"<robot name="arm">
      <link name="base"/>
      <link name="forearm">
        <inertial><mass value="0.6"/></inertial>
        <visual>
          <origin xyz="0 0 0.01" rpy="0 0 1.5707963267948966"/>
          <geometry><mesh filename="package://arm/meshes/forearm.glb" scale="0.001 0.001 0.001"/></geometry>
        </visual>
      </link>
      <joint name="elbow" type="revolute">
        <parent link="base"/><child link="forearm"/><origin xyz="1 0 0"/>
      </joint>
      <joint name="wrist" type="revolute">
        <parent link="forearm"/><child link="hand"/><origin xyz="0 0.2 0"/>
      </joint>
    </robot>"#;

    fn robot() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let package = folder.path().join("arm");
        std::fs::create_dir_all(package.join("meshes")).unwrap();
        std::fs::create_dir_all(package.join("urdf")).unwrap();
        let corners = [[0.0, 0.0, 0.0], [100.0, 0.0, 0.0], [0.0, 50.0, 0.0], [0.0, 0.0, 20.0]];
        let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let mesh = SurfaceMesh::new(corners.map(Point3::from).to_vec(), tetrahedron).unwrap();
        write_glb(&package.join("meshes/forearm.glb"), &mesh, None).unwrap();
        let urdf = package.join("urdf/arm.urdf");
        std::fs::write(&urdf, ROBOT).unwrap();
        (folder, urdf)
    }

    #[test]
    fn a_link_lies_in_its_frame_with_its_joints() {
        let (_folder, urdf) = robot();
        for name in [None, Some("forearm")] {
            let link = read(&urdf, name).unwrap();
            let far = link.mesh.vertices()[1] - Point3::new(0.0, 0.1, 0.01);
            assert!(far.norm() < 1e-7, "{far}");
            assert_eq!(link.joints.parent.as_deref(), Some("elbow"));
            let wrist = ("wrist".to_owned(), Point3::new(0.0, 0.2, 0.0));
            assert_eq!(link.joints.farthest_child(), Some(&wrist));
            assert_eq!(link.joints.place("wrist"), Some(wrist.1));
            assert_eq!(link.joints.place("elbow"), Some(Point3::origin()));
            assert_eq!(link.joints.names(), "elbow, wrist");
            assert!(link.said.contains("forearm, its visual mesh, 0.6 kg"), "{}", link.said);
        }
    }

    #[test]
    fn the_joint_that_holds_the_link_is_at_the_end_that_is_held() {
        let (_folder, urdf) = robot();
        let mount = |joint: &str| {
            let params =
                NewLimbParams { mount_joint: Some(joint.into()), ..NewLimbParams::default() };
            let limb = NewLimb::guess(&urdf, &params)?;
            let mount = limb.guesses.iter().find(|guess| guess.what == "mount").unwrap();
            Ok::<_, HapdefError>(mount.value.clone())
        };
        assert!(mount("elbow").unwrap().starts_with("low end"));
        assert!(mount("wrist").unwrap().starts_with("high end"));
        let error = mount("knee").unwrap_err().to_string();
        assert!(error.contains("--mount-joint knee: the link has elbow, wrist"), "{error}");
    }

    #[test]
    fn a_link_that_has_no_mesh_is_refused_with_those_that_have() {
        let (_folder, urdf) = robot();
        let error = read(&urdf, Some("base")).unwrap_err().to_string();
        assert!(error.contains("--link \"base\"") && error.contains(": forearm"), "{error}");
        std::fs::remove_file(urdf.parent().unwrap().join("../meshes/forearm.glb")).unwrap();
        let error = read(&urdf, None).unwrap_err().to_string();
        assert!(error.contains("forearm.glb"), "{error}");
    }
}
