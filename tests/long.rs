//! Verification runs of minutes; needs the feature `long-tests`.
