//! The CPU rasteriser: which surfaces a view's pixels see, and how they look there.
//!
//! Coverage is decided in fixed point (vertices snapped to 1/256 px) by the top-left rule; equal depths are ordered
//! by triangle number. Shading is deferred: operations return triangle numbers, `shade` turns them into colour.
