//! One ellipsoid, all points good.
