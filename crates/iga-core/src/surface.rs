//! Faces of patches: normals, areas, collocation points, closest points.
