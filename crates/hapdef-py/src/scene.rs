//! A scene with its limb.

use std::path::PathBuf;
use std::sync::Arc;

use hapdef::scene::{EstimatorSpec, GaugeEntry, SuperpositionSpec};
use hapdef::stages::compliance_table;
use hapdef::touch::{
    LayoutParams, LearnedLoads, SearchPlace, TouchAssumptions, response_map, study_layouts,
};
use hapdef::{OpenParams, OpenScene, Pipeline, Progress, RigPlay, Until, write_json};
use nalgebra::Point3;
use numpy::{PyArray2, PyArray3};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::{Value, json};

use crate::array::{Numbers, Table, numbers, positions, rows, three, triples, two, vectors};
use crate::calibration::{PressTable, PyCalibration};
use crate::error::to_python;
use crate::estimator::{PyEstimator, kind_of};
use crate::layout::PyLayout;
use crate::live::{LiveRequest, PyLive};
use crate::live_frame::PyLiveFrame;
use crate::profile;
use crate::recalibration::{TouchTable, recalibrate, undo_touches};
use crate::response::PyResponse;
use crate::rig::PyRig;
use crate::work::work;

/// A limb with its gauges, as a scene file says it; see `hapdef.pyi` for every argument.
#[pyclass(frozen, module = "hapdef", name = "Scene")]
pub struct PyScene {
    scene: OpenScene,
}

#[pymethods]
impl PyScene {
    /// Reads a scene file and the limb that it names, and checks both.
    #[new]
    #[pyo3(signature = (path, *, results = None, threads = None, seed = None, profile = "quick", amounts = None, verbose = false))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn new(
        py: Python<'_>,
        path: PathBuf,
        results: Option<PathBuf>,
        threads: Option<usize>,
        seed: Option<u64>,
        profile: &str,
        amounts: Option<&Bound<'_, PyDict>>,
        verbose: bool,
    ) -> PyResult<Self> {
        let defaults = OpenParams::default();
        let params = OpenParams {
            profile: profile::profile_of(profile, amounts)?,
            results: results.unwrap_or(defaults.results),
            threads: threads.unwrap_or(defaults.threads).max(1),
            seed,
            progress: if verbose { Progress::lines() } else { Progress::silent() },
        };
        let open = || OpenScene::with_params(&path, params);
        Ok(Self { scene: py.detach(open).map_err(to_python)? })
    }

    /// Name of the scene.
    #[getter]
    fn name(&self) -> &str {
        &self.scene.scene().name
    }

    /// Number of gauges.
    #[getter]
    fn n_gauges(&self) -> usize {
        self.scene.limb().gauges.len()
    }

    /// Number of surface nodes, at which contacts may be.
    #[getter]
    fn n_surface_nodes(&self) -> usize {
        self.scene.limb().n_surface_nodes()
    }

    /// Names of the gauges, in channel order.
    #[getter]
    fn gauge_names(&self) -> Vec<String> {
        let sites = self.scene.scene().gauges.sites.iter();
        sites.map(|site| site.name.clone()).collect()
    }

    /// Centres of the gauges, m, `[n_gauges, 3]`.
    #[getter]
    fn gauge_positions_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let sites = self.scene.limb().sites.iter();
        positions(py, &sites.map(|site| site.position).collect::<Vec<_>>())
    }

    /// Measuring directions of the gauges, unit length, `[n_gauges, 3]`.
    #[getter]
    fn gauge_axes(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        let gauges = self.scene.limb().gauges.iter();
        vectors(py, &gauges.map(|gauge| gauge.axis()).collect::<Vec<_>>())
    }

    /// Positions of the surface nodes, m, `[n_surface_nodes, 3]`.
    #[getter]
    fn surface_m(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        positions(py, &self.scene.limb().surface_points())
    }

    /// Direction of a press at each surface node, unit length, into the limb, `[n_surface_nodes, 3]`.
    #[getter]
    fn directions(&self, py: Python<'_>) -> PyResult<Py<PyArray2<f64>>> {
        vectors(py, &self.scene.limb().directions)
    }

    /// Six-node faces of the skin: three corners, then the middles of their sides; `[n_faces, 6]`.
    #[getter]
    fn faces(&self, py: Python<'_>) -> PyResult<Py<PyArray2<u32>>> {
        let skin = &self.scene.limb().skin;
        let place = |node| skin.nodes.partition_point(|other| *other < node) as u32;
        let faces: Vec<[u32; 6]> = skin.faces.iter().map(|f| f.nodes.map(place)).collect();
        let n_faces = faces.len();
        two(py, faces.into_flattened(), [n_faces, 6])
    }

    /// The scene as JSON text, ready for a file.
    fn json(&self) -> PyResult<String> {
        serde_json::to_string_pretty(self.scene.scene())
            .map_err(|error| PyValueError::new_err(error.to_string()))
    }

    /// Writes the scene to a file; its paths stay relative to the folder of the first one.
    fn write(&self, path: PathBuf) -> PyResult<()> {
        write_json(&path, self.scene.scene()).map_err(to_python)
    }

    /// The same limb with other gauges.
    #[pyo3(signature = (positions_m, axes, *, names = None, name = None))]
    fn with_gauges(
        &self,
        py: Python<'_>,
        positions_m: Table<'_>,
        axes: Table<'_>,
        names: Option<Vec<String>>,
        name: Option<String>,
    ) -> PyResult<Self> {
        let places = triples("positions_m", &positions_m)?;
        let axes = triples("axes", &axes)?;
        let names = names.unwrap_or_else(|| (0..places.len()).map(|i| format!("g{i}")).collect());
        if places.len() != axes.len() || places.len() != names.len() {
            return Err(PyValueError::new_err(format!(
                "expected one axis and one name for each gauge, found {} positions, {} axes, {} \
                 names",
                places.len(),
                axes.len(),
                names.len()
            )));
        }
        let sites = names.into_iter().zip(places.into_iter().zip(axes));
        let entry = |(name, (position_m, axis))| GaugeEntry { name, position_m, axis };
        let sites = sites.map(entry).collect();
        let mut scene = self.scene.scene().clone();
        scene.gauges.sites = sites;
        scene.name = name.unwrap_or(scene.name);
        let load = || self.scene.with_scene(scene);
        Ok(Self { scene: py.detach(load).map_err(to_python)? })
    }

    /// The same scene, its contacts found by superposition, with these settings in place of its own.
    #[pyo3(signature = (*, noise_ue = None, map_error = None, map_refinements = None, friction = None, widest_tip_m = None, palm_radius_m = None, n_sites = None, calibration = None))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn with_superposition(
        &self,
        noise_ue: Option<f64>,
        map_error: Option<f64>,
        map_refinements: Option<u32>,
        friction: Option<f64>,
        widest_tip_m: Option<f64>,
        palm_radius_m: Option<f64>,
        n_sites: Option<usize>,
        calibration: Option<PathBuf>,
    ) -> PyResult<Self> {
        let own = self.scene.scene().estimator.superposition();
        // The scene's paths are relative to its folder.
        let calibration = calibration.map(std::path::absolute).transpose()?;
        let spec = SuperpositionSpec {
            noise_ue: noise_ue.unwrap_or(own.noise_ue),
            map_error: map_error.unwrap_or(own.map_error),
            map_refinements: map_refinements.unwrap_or(own.map_refinements),
            friction: friction.unwrap_or(own.friction),
            widest_tip_m: widest_tip_m.unwrap_or(own.widest_tip_m),
            palm_radius_m: palm_radius_m.unwrap_or(own.palm_radius_m),
            calibration: calibration.or(own.calibration),
            n_sites: n_sites.unwrap_or(own.n_sites),
        };
        let scene = self.scene.with_estimator(EstimatorSpec::Superposition(spec));
        Ok(Self { scene: scene.map_err(to_python)? })
    }

    /// Layouts of gauges on the inner wall, by several methods, the recommended one last.
    #[pyo3(signature = (n_gauges = 10, *, noise_ue = 1.0, force_n = 10.0, n_positions = 160, n_axes = 4, n_sites = 400, n_mounted = 0, min_spacing_m = 0.01, margin_m = 0.001, keep_out = None, compare = false, seed = None))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn place(
        &self,
        py: Python<'_>,
        n_gauges: usize,
        noise_ue: f64,
        force_n: f64,
        n_positions: usize,
        n_axes: usize,
        n_sites: usize,
        n_mounted: usize,
        min_spacing_m: f64,
        margin_m: f64,
        keep_out: Option<Table<'_>>,
        compare: bool,
        seed: Option<u64>,
    ) -> PyResult<Vec<PyLayout>> {
        let balls = keep_out.map_or(Ok(Vec::new()), |table| rows("keep_out", &table, 4))?;
        let balls = balls.as_chunks::<4>().0;
        let params = LayoutParams {
            n_gauges,
            n_mounted,
            n_positions,
            n_axes,
            n_sites,
            keep_out: balls.iter().map(|[x, y, z, r]| (Point3::new(*x, *y, *z), *r)).collect(),
            min_spacing_m,
            margin_m,
            noise_ue,
            force_n,
            compares: compare,
            other_counts: Vec::new(),
            seed: seed.unwrap_or(self.scene.scene().seed),
            ..LayoutParams::default()
        };
        let study =
            work(py, &self.scene, move |scene| study_layouts(scene.run(), scene.limb(), &params))?;
        Ok(study.layouts.into_iter().map(PyLayout::new).collect())
    }

    /// What every gauge reads for a newton anywhere on the skin, by one adjoint solve for each gauge.
    fn response(&self, py: Python<'_>) -> PyResult<PyResponse> {
        let map = work(py, &self.scene, |scene| {
            let tip_radius_m = scene.scene().contact.tip_radius_m;
            response_map(scene.limb(), tip_radius_m, scene.run().threads)
        })?;
        Ok(PyResponse::new(map))
    }

    /// Displacements per newton at each surface node, m/N, 32 bits,
    /// `[n_surface_nodes, n_surface_nodes + n_virtual_gauges, 3]`.
    fn compliance(&self, py: Python<'_>) -> PyResult<Py<PyArray3<f32>>> {
        let table = work(py, &self.scene, |s| compliance_table(s.run(), s.limb()))?;
        let (n_loads, n_wanted) = (table.n_surface(), table.n_surface() + table.n_virtual());
        three(py, table.into_rows(), [n_loads, n_wanted, 3])
    }

    /// The simulated hardware.
    fn rig(&self, py: Python<'_>) -> PyResult<PyRig> {
        let limb = work(py, &self.scene, OpenScene::rig)?;
        Ok(PyRig::new(Arc::new(limb), self.scene.scene()))
    }

    /// Corrects the response by presses of known place and force.
    #[pyo3(signature = (positions_m, forces_n, readings_ue, *, noise_ue = 1.0, position_sd_m = 0.0, force_sd_n = 0.0, off_skin_m = 2e-3, n_sites = 800))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn calibrate(
        &self,
        py: Python<'_>,
        positions_m: Table<'_>,
        forces_n: Numbers<'_>,
        readings_ue: Table<'_>,
        noise_ue: f64,
        position_sd_m: f64,
        force_sd_n: f64,
        off_skin_m: f64,
        n_sites: usize,
    ) -> PyResult<PyCalibration> {
        let positions_m = triples("positions_m", &positions_m)?;
        let n = positions_m.len();
        let readings_ue = rows("readings_ue", &readings_ue, self.n_gauges())?;
        let table = PressTable {
            forces_n: numbers("forces_n", &forces_n, n)?,
            positions_m,
            readings_ue,
            quality: hapdef::touch::PressQuality { noise_ue, position_sd_m, force_sd_n },
            off_skin_m,
            n_sites,
        };
        PyCalibration::fit(py, self.scene.clone(), table)
    }

    /// Brings the scene's calibration up to date by known touches; what became of each, as the journal has it.
    #[pyo3(signature = (positions_m, forces_n, readings_ue, *, times_s = None, noise_ue = 1.0, position_sd_m = 5e-4, force_sd_n = 0.1, off_skin_m = 2e-3))]
    #[expect(clippy::too_many_arguments, reason = "named in Python")]
    fn recalibrate<'py>(
        &self,
        py: Python<'py>,
        positions_m: Table<'py>,
        forces_n: Table<'py>,
        readings_ue: Table<'py>,
        times_s: Option<Numbers<'py>>,
        noise_ue: f64,
        position_sd_m: f64,
        force_sd_n: f64,
        off_skin_m: f64,
    ) -> PyResult<Bound<'py, PyAny>> {
        let positions_m = triples("positions_m", &positions_m)?;
        let n = positions_m.len();
        let table = TouchTable {
            forces_n: triples("forces_n", &forces_n)?,
            readings_ue: rows("readings_ue", &readings_ue, self.n_gauges())?,
            times_s: times_s.map(|times| numbers("times_s", &times, n)).transpose()?,
            positions_m,
            position_sd_m,
            force_sd_n,
        };
        let assumed = TouchAssumptions { noise_ue, off_skin_m, ..TouchAssumptions::default() };
        recalibrate(py, &self.scene, table, assumed)
    }

    /// Undoes the last `n` known touches that were taken, or all; returns how many.
    #[pyo3(signature = (n = None))]
    fn undo_touches(&self, py: Python<'_>, n: Option<usize>) -> PyResult<usize> {
        undo_touches(py, &self.scene, n)
    }

    /// Runs the pipeline up to `until` ('simulate', 'dataset', 'train' or 'eval') and returns the
    /// records of its stages.
    #[pyo3(signature = (until = "train"))]
    fn train<'py>(&self, py: Python<'py>, until: &str) -> PyResult<Bound<'py, PyAny>> {
        let until = match until {
            "simulate" => Until::Simulate,
            "dataset" => Until::Dataset,
            "train" => Until::Train,
            "eval" => Until::Eval,
            _ => {
                return Err(PyValueError::new_err(format!(
                    "until: expected 'simulate', 'dataset', 'train' or 'eval', found {until:?}"
                )));
            }
        };
        let done = work(py, &self.scene, move |s| Pipeline::run(s.run(), s.limb(), until))?;
        let record = |stage: &&hapdef::Stage| {
            json!({
                "stage": stage.record.stage,
                "cached": stage.cached,
                "elapsed_s": stage.record.elapsed_s,
                "folder": stage.dir,
                "info": stage.record.info,
            })
        };
        let records: Vec<Value> = done.stages().iter().map(record).collect();
        profile::to_python(py, &Value::from(records))
    }

    /// What finds contacts in arrays of frames: the scene's own way, or 'superposition', 'tracking' or
    /// 'hapdefx' (the paper's nets, trained where they are not).
    #[pyo3(signature = (kind = None))]
    fn estimator(&self, py: Python<'_>, kind: Option<&str>) -> PyResult<PyEstimator> {
        let kind = kind.map(kind_of).transpose()?;
        // Searches in the same thread: the same frames always give the same contacts.
        let estimator =
            work(py, &self.scene, move |scene| scene.estimator(kind, SearchPlace::Here))?;
        Ok(PyEstimator::new(estimator))
    }

    /// Live contacts, frame by frame: from a source, or from the simulated rig pressed at random.
    #[pyo3(signature = (source = None, *, kind = "tracking", seconds = None, tare_s = 1.0, seed = 1,
        topic = None))]
    #[expect(clippy::too_many_arguments, reason = "keywords of Python")]
    fn live(
        &self,
        py: Python<'_>,
        source: Option<&str>,
        kind: &str,
        seconds: Option<f64>,
        tare_s: f64,
        seed: u64,
        topic: Option<String>,
    ) -> PyResult<PyLive> {
        let play = RigPlay { seconds, seed };
        let request = LiveRequest { kind: kind_of(kind)?, play, tare_s, topic };
        PyLive::start(py, &self.scene, source, request)
    }

    /// Learns the loads on the whole limb that are no contacts from frames in which nothing touches, the first `still` of
    /// them of a robot that stands still, and writes them to a file for the scene's `loads.learned`.
    #[pyo3(signature = (frames, path, *, still = 200, margin = 2.0))]
    fn learn_loads(
        &self,
        py: Python<'_>,
        frames: Vec<PyRef<'_, PyLiveFrame>>,
        path: PathBuf,
        still: usize,
        margin: f64,
    ) -> PyResult<Vec<f64>> {
        let frames: Vec<_> = frames.iter().map(|frame| frame.raw()).collect();
        work(py, &self.scene, move |scene| {
            let noise_ue = scene.scene().estimator.superposition().noise_ue;
            let learned = LearnedLoads::learn(scene.scene(), &frames, still, noise_ue, margin)?;
            learned.write(&path)?;
            Ok(learned.strengths_ue())
        })
    }

    fn __repr__(&self) -> String {
        format!(
            "Scene({:?}, {} gauges, {} surface nodes)",
            self.name(),
            self.n_gauges(),
            self.n_surface_nodes()
        )
    }
}

impl PyScene {
    /// The scene with its limb.
    pub(crate) fn open(&self) -> &OpenScene {
        &self.scene
    }
}
