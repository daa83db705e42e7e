//! Single test presses of the rig and what each method makes of them.

use anyhow::{Context, Result};
use hapdef::stages::NetKind;
use hapdef::{
    ContactPair, ContactStats, ForceBin, FoundContact, Limb, Pipeline, Run, Stage, by_force,
};
use serde::{Deserialize, Serialize};
use serde_json::json;

use super::chain::{MapFrom, candidates, chain, reconstruction};
use super::dataset::{Contact, Part, Rows, blocks, pair, rig_singles};
use super::kept::kept;
use super::svr::SvrScore;
use crate::search::{Learner, forward};

const VERSION: u32 = 1;

/// Presses computed together.
const BLOCK: usize = 512;

/// What a method says of each test press; none where it found nothing.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct MethodAnswers {
    /// For tables and legends.
    pub(crate) name: String,
    /// `[n_test]`.
    pub(crate) found: Vec<Option<Contact>>,
}

/// The test presses and every method's answers.
pub(crate) struct Singles {
    /// `[n_test]`.
    pub(crate) truth: Vec<Contact>,
    /// The methods of figure 4: SVR, k-NN, FNN.
    pub(crate) direct: Vec<MethodAnswers>,
    /// The ablations of figure 8; the whole chain first.
    pub(crate) ablations: Vec<MethodAnswers>,
}

/// Answers of all methods that need no training of their own, or reads them from the cache.
pub(crate) fn singles(
    run: &Run,
    limb: &Limb,
    done: &Pipeline,
    svr: &SvrScore,
) -> Result<(Singles, Stage)> {
    let data = done.data.as_ref().context("no datasets")?;
    let inputs = json!({
        "version": VERSION, "keys": super::keys_of(run, done), "presses": data.rig_single.key,
        "estimator": run.scene.estimator,
    });
    let (answers, stage) = kept(run, "singles", &inputs, |_| {
        run.say("single presses: k-NN, the direct net, the chain and its ablations");
        answer(run, limb, done)
    })?;
    let [knn, fnn, ablations @ ..] = answers;
    let (mut presses, split) = rig_singles(done)?;
    let svr = MethodAnswers {
        name: "SVR".into(),
        found: svr.found.iter().map(|found| Some(*found)).collect(),
    };
    let singles = Singles {
        truth: presses.contacts(split.test)?,
        direct: vec![svr, knn, fnn],
        ablations: ablations.to_vec(),
    };
    Ok((singles, stage))
}

fn answer(run: &Run, limb: &Limb, done: &Pipeline) -> Result<[MethodAnswers; 5]> {
    let (mut presses, split) = rig_singles(done)?;
    let nets = done.nets.as_ref().context("no nets")?;
    let direct = nets.load(NetKind::Direct)?;
    let chain = chain(run, limb, done)?;
    let map_net = reconstruction(done)?;
    let training = Rows::of(&mut presses, [Part::Readings, Part::Contact], split.train)?;
    let knn = Learner::Knn { k: 6 }.fit(&training.samples(), &|| false)?;
    let names = ["k-NN", "direct FNN", "R → S → D → k-Max", "true S → D → k-Max", "true D → k-Max"];
    let mut answers = names.map(|name| MethodAnswers { name: name.into(), found: vec![] });
    for rows in blocks(split.test, BLOCK) {
        run.check_stop("the single presses")?;
        let n_surface = presses.n_surface;
        let readings = presses.readings(rows.clone())?;
        let truth_um = presses.maps(rows.clone())?;
        answers[0].found.extend(contacts(&knn.predictions(&readings, rows.len())?));
        answers[1].found.extend(contacts(&forward(&direct, &readings)?));
        let chained = MapFrom::Readings(&chain).maps(&mut presses, rows.clone())?;
        let from_virtual = MapFrom::Gauges(&map_net).maps(&mut presses, rows)?;
        for (answers, maps) in answers[2..].iter_mut().zip([&chained, &from_virtual, &truth_um]) {
            let found = candidates(&chain, maps, n_surface)?;
            answers.found.extend(found.iter().map(|c| strongest(c)));
        }
    }
    Ok(answers)
}

/// Net outputs `[n, 4]` as contacts.
pub(crate) fn contacts(rows: &[f32]) -> Vec<Option<Contact>> {
    let (rows, _) = rows.as_chunks::<4>();
    rows.iter().map(|row| Some(*row)).collect()
}

/// The candidate of greatest force.
pub(crate) fn strongest(found: &[FoundContact]) -> Option<Contact> {
    let first = found.first()?;
    let [x, y, z] = first.position_m;
    Some([x, y, z, first.force_n].map(|v| v as f32))
}

impl Singles {
    /// A method's errors, press by press; none where it found nothing.
    pub(crate) fn errors(&self, method: &MethodAnswers) -> Vec<Option<ContactPair>> {
        let pairs = self.truth.iter().zip(&method.found);
        pairs.map(|(truth, found)| Some(pair(truth, found.as_ref()?))).collect()
    }

    /// A method's errors in a few numbers.
    pub(crate) fn stats(&self, method: &MethodAnswers) -> ContactStats {
        let pairs: Vec<ContactPair> = self.errors(method).into_iter().flatten().collect();
        ContactStats::of(&pairs, self.truth.len())
    }

    /// A method's mean errors by the press's force, in bins of equal width up to `strongest_n`.
    pub(crate) fn by_force(&self, method: &MethodAnswers, strongest_n: f64) -> Vec<ForceBin> {
        let forces = self.truth.iter().map(|truth| f64::from(truth[3]));
        let all: Vec<_> = forces.zip(self.errors(method)).collect();
        by_force(&all, strongest_n)
    }
}
