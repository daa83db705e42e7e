//! From a limb to contacts: scene file, plan, pipeline, scoring, command line.
