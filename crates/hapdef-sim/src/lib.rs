//! Linear-elastic statics of a limb: stiffness, factorisation, compliance, gauge strain.
