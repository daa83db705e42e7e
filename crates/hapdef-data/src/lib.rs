//! What is written to a file between steps: contacts, datasets, splits, standardisers, manifests.
