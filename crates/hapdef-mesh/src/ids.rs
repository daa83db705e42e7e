//! One newtype per index space, so that a gauge can't index a node.

macro_rules! index_newtype {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub u32);

        impl $name {
            /// The position in the array this index belongs to.
            #[must_use]
            pub fn index(self) -> usize {
                self.0 as usize
            }

            /// The index of array position `index`.
            ///
            /// # Panics
            /// If `index` does not fit in 32 bits; meshes of that size are refused on reading.
            #[must_use]
            pub fn from_index(index: usize) -> Self {
                assert!(u32::try_from(index).is_ok(), "index {index} exceeds 32 bits");
                Self(index as u32)
            }
        }
    };
}

index_newtype! {
    /// A node of the finite-element mesh, counted from 0 in deck order.
    FeNodeId
}
index_newtype! {
    /// A node of the contact surface, counted from 0 in the order of the deformation map.
    SurfaceNodeId
}
index_newtype! {
    /// A physical strain gauge, counted from 0 in scene order.
    GaugeId
}
index_newtype! {
    /// A virtual gauge: one FE node of a gauge's patch, counted from 0 over all patches.
    VirtualGaugeId
}
