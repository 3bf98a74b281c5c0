//! What must hold between the parts of varsac; the tests are in `tests/`, what they share is here.

pub mod golden;
