//! The page of a robot, which its limbs' pages are part of.

use std::path::Path;

use anyhow::Result;
use hapdef::Robot;
use hapdef_view::{LimbPicture, Offers, RobotView, ViewHandle, ViewServer};

use super::ViewArgs;
use super::opener::PageOpener;

/// The page of a robot.
pub(crate) struct RobotPage {
    view: RobotView,
    name: String,
    _opener: Option<PageOpener>,
}

impl RobotPage {
    /// Serves the page; its limbs' pages wait until [`Self::limb`]. What leads to it is kept below `out`.
    pub(crate) fn start(args: &ViewArgs, robot: &Robot, out: &Path) -> Result<Self> {
        let limbs: Vec<String> = robot.limbs.iter().map(|limb| limb.name.clone()).collect();
        let view = ViewServer::start_robot(args.params(Offers::default()), &robot.name, &limbs)?;
        let opener = args.tell(view.url(), &out.join(&robot.name))?;
        Ok(Self { view, name: robot.name.clone(), _opener: opener })
    }

    /// The robot's name.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Begins a limb's page.
    pub(super) fn limb(
        &self,
        name: &str,
        offers: Offers,
        picture: LimbPicture,
    ) -> Result<ViewHandle> {
        Ok(self.view.limb(name, offers, picture)?)
    }
}
