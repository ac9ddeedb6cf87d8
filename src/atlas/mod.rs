//! Packing charts into atlas pages with gutters that survive mip-maps.
