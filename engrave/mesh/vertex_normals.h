#pragma once

#include "engrave/mesh/mesh.h"

namespace intaglio::mesh {

/// Each vertex's normal as the mean of its triangles', weighted by their angles there
/// (Thuermer and Wuethrich 1998), of unit length; zero where there is none.
PointList VertexNormals(const TriangleMesh& mesh);

/// The angles of a triangle at its corners, rad; zero without area.
Vec3 AnglesOf(const Vec3& a, const Vec3& b, const Vec3& c);

/// Weights of the corners that give p, which lies in the triangle's plane: 0..1, sum 1.
Vec3 WeightsAt(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace intaglio::mesh
