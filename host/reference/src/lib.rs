//! The float reference: a plain program written from the numeric contract (`core/docs/numerics.md`).
