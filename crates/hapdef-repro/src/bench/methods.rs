//! From one frame's readings to its map, by a net or a baseline behind F_T.

use anyhow::Result;
use hapdef_nets::infer::{InferScratch, PreparedNet};

use crate::search::Fitted;

/// From virtual gauges `[n_virtual]`, µm, to the map `[n_outputs]`, µm; without F_T from readings.
pub(crate) enum Method {
    /// A prepared net.
    Net(PreparedNet),
    /// A baseline.
    Fitted(Fitted),
}

/// F_T, where there is one, and what follows it, with their buffers.
pub(crate) struct Passes {
    transfer: Option<PreparedNet>,
    method: Method,
    scratch: InferScratch,
    virtual_um: Vec<f32>,
}

impl Passes {
    pub(crate) fn new(transfer: Option<PreparedNet>, method: Method) -> Self {
        let virtual_um = vec![0.0; transfer.as_ref().map_or(0, PreparedNet::n_outputs)];
        Self { transfer, method, scratch: InferScratch::default(), virtual_um }
    }

    /// The map of one frame's readings; bytes of weights that were read.
    pub(crate) fn map(&mut self, readings_ue: &[f32], out: &mut [f32]) -> Result<usize> {
        let Some(transfer) = &self.transfer else {
            return self.method.map(readings_ue, &mut self.scratch, out);
        };
        let first = transfer.forward(readings_ue, &mut self.scratch, &mut self.virtual_um)?;
        let bytes = self.method.map(&self.virtual_um, &mut self.scratch, out)?;
        Ok(first.weight_bytes + bytes)
    }

    /// The map of one frame's virtual gauges.
    pub(super) fn map_of_gauges(&mut self, virtual_um: &[f32], out: &mut [f32]) -> Result<usize> {
        self.method.map(virtual_um, &mut self.scratch, out)
    }

    /// Whether it goes from readings to a contact, without F_T and a map.
    pub(super) fn is_direct(&self) -> bool {
        self.transfer.is_none()
    }

    /// Bytes of what both keep in memory.
    pub(super) fn bytes(&self) -> usize {
        let own = match &self.method {
            Method::Net(net) => net.bytes(),
            Method::Fitted(fitted) => fitted.bytes(),
        };
        self.transfer.as_ref().map_or(0, PreparedNet::bytes) + own
    }
}

impl Method {
    fn map(&self, x: &[f32], scratch: &mut InferScratch, out: &mut [f32]) -> Result<usize> {
        match self {
            Self::Net(net) => Ok(net.forward(x, scratch, out)?.weight_bytes),
            Self::Fitted(fitted) => fitted.predict(x, out).map(|()| 0).map_err(Into::into),
        }
    }
}
