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

/// The parts of a pipeline.
const PARTS: [&str; 5] =
    ["the limb's compliance", "the simulated rig", "datasets", "nets", "scores"];

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
        Self::run_telling(run, limb, until, |_| {})
    }

    /// The same; each part is announced with the expected time of what is still to be run, s, as
    /// [`crate::plan::pipeline_parts_s`] has it.
    ///
    /// # Errors
    /// What the first stage that fails returns.
    pub fn run_timed(
        run: &Run,
        limb: &Limb,
        until: Until,
        parts_s: &[f64; 4],
    ) -> Result<Self, HapdefError> {
        let n_parts = match until {
            Until::Simulate => 2,
            Until::Dataset => 3,
            Until::Train => 4,
            Until::Eval => 5,
        };
        Self::run_telling(run, limb, until, |part| {
            let ahead_s = parts_s[..n_parts.min(4)].iter().skip(part).sum();
            let left = left_text(ahead_s, until == Until::Eval);
            let name = PARTS[part];
            run.say(&format!("part {} of {n_parts}: {name}; {left}", part + 1));
        })
    }

    fn run_telling(
        run: &Run,
        limb: &Limb,
        until: Until,
        begins: impl Fn(usize),
    ) -> Result<Self, HapdefError> {
        begins(0);
        let compliance = compliance(run, limb)?;
        begins(1);
        let rig = rig(run, limb, &compliance)?;
        let mut done = Self { compliance, rig, data: None, nets: None, eval: None };
        if until < Until::Dataset {
            return Ok(done);
        }
        begins(2);
        let data = datasets(run, limb, &done.compliance, &done.rig)?;
        if until >= Until::Train {
            begins(3);
            let nets = train(run, limb, &done.compliance, &data)?;
            if until >= Until::Eval {
                begins(4);
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

/// An expected time for people; that of scores is not known before.
fn left_text(seconds: f64, has_scores: bool) -> String {
    let more = if has_scores { ", then minutes for the scores" } else { "" };
    match seconds {
        s if s < 1.0 => format!("nothing to solve or train any more{more}"),
        s if s < 90.0 => format!("about {s:.0} s left{more}"),
        s if s < 5400.0 => format!("about {:.0} min left{more}", s / 60.0),
        s => format!("about {:.1} h left{more}", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::left_text;

    #[test]
    fn times_are_told_in_round_units() {
        assert_eq!(left_text(0.2, false), "nothing to solve or train any more");
        assert_eq!(left_text(41.6, true), "about 42 s left, then minutes for the scores");
        assert_eq!(left_text(600.0, false), "about 10 min left");
        assert_eq!(left_text(9000.0, false), "about 2.5 h left");
    }
}
