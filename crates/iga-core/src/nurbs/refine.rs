//! Degree elevation and knot insertion: finer spaces, same geometry.
