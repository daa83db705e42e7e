//! A simulated stand-in for the hardware: a perturbed limb, gauge electronics, a probing robot.
