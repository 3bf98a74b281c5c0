//! Shared pieces of the tests between the parts.
