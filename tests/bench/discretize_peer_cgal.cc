#ifdef INTAGLIO_HAS_CGAL
#include <CGAL/AABB_halfedge_graph_segment_primitive.h>
#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/Polygon_mesh_slicer.h>
#include <CGAL/Simple_cartesian.h>
#include <CGAL/Surface_mesh.h>
#endif

#include <vector>

#include "tests/bench/discretize_peers.h"

namespace intaglio::bench {

#ifdef INTAGLIO_HAS_CGAL
std::optional<PeerRun> CgalSlices(const mesh::TriangleMesh& mesh, double first_mm,
                                  double layer_mm, std::size_t count) {
  using Kernel = CGAL::Simple_cartesian<double>;
  using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
  Mesh surface;
  for (const Vec3& v : mesh.vertices) {
    surface.add_vertex(Kernel::Point_3(v.x(), v.y(), v.z()));
  }
  for (const auto& [a, b, c] : mesh.triangles) {
    surface.add_face(Mesh::Vertex_index(a), Mesh::Vertex_index(b), Mesh::Vertex_index(c));
  }
  PeerRun run;
  run.ms = BestMs(3, [&] {
    const CGAL::Polygon_mesh_slicer<Mesh, Kernel> slicer(surface);
    std::size_t contours = 0;
    for (std::size_t k = 0; k < count; ++k) {
      std::vector<std::vector<Kernel::Point_3>> polylines;
      const double height_mm = first_mm + static_cast<double>(k) * layer_mm;
      slicer(Kernel::Plane_3(0, 0, 1, -height_mm), std::back_inserter(polylines));
      contours += polylines.size();
    }
    run.count = static_cast<double>(contours);
  });
  return run;
}
#else
std::optional<PeerRun> CgalSlices(const mesh::TriangleMesh&, double, double,
                                  std::size_t) {
  return std::nullopt;
}
#endif

}  // namespace intaglio::bench
