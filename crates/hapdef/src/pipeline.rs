//! All stages of a scene in order.

use crate::cache::Stage;
use crate::error::HapdefError;
use crate::limb::Limb;
use crate::run::Run;
use crate::stages::{Datasets, EvalReport, TrainedNets, compliance, datasets, eval, rig, train};

/// The last stage to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Until {
    /// Compliance and the rig's response.
    Simulate,
    /// Datasets.
    Dataset,
    /// Trained nets.
    Train,
    /// Scores.
    Eval,
}

/// What the stages of a scene left.
#[derive(Clone, Debug)]
pub struct Pipeline {
    /// The limb's compliance.
    pub compliance: Stage,
    /// The rig's response.
    pub rig: Stage,
    /// The datasets.
    pub data: Option<Datasets>,
    /// The trained nets.
    pub nets: Option<TrainedNets>,
    /// The scores.
    pub eval: Option<(Stage, EvalReport)>,
}

impl Pipeline {
    /// Runs every stage up to `until`; finished ones come from the cache.
    ///
    /// # Errors
    /// What the first stage that fails returns.
    pub fn run(run: &Run, limb: &Limb, until: Until) -> Result<Self, HapdefError> {
        let compliance = compliance(run, limb)?;
        let rig = rig(run, limb, &compliance)?;
        let mut done = Self {
            compliance,
            rig,
            data: None,
            nets: None,
            eval: None,
        };
        if until < Until::Dataset {
            return Ok(done);
        }
        let data = datasets(run, limb, &done.compliance, &done.rig)?;
        if until >= Until::Train {
            let nets = train(run, limb, &done.compliance, &data)?;
            if until >= Until::Eval {
                done.eval = Some(eval(run, limb, &data, &nets)?);
            }
            done.nets = Some(nets);
        }
        done.data = Some(data);
        Ok(done)
    }

    /// Every stage that ran or was found, in order.
    #[must_use]
    pub fn stages(&self) -> Vec<&Stage> {
        let mut stages = vec![&self.compliance, &self.rig];
        if let Some(data) = &self.data {
            stages.extend(&data.simulated);
            stages.push(&data.rig_single);
            stages.extend(&data.rig_double);
        }
        if let Some(nets) = &self.nets {
            stages.extend(nets.nets.iter().map(|net| &net.stage));
        }
        stages.extend(self.eval.iter().map(|(stage, _)| stage));
        stages
    }
}
