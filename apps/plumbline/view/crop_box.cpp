#include "view/crop_box.h"

#include <algorithm>
#include <vector>

#include "map/mesh_of_bricks.h"

namespace plumbline::app {

Mesh cropped(const Mesh& mesh, const CropBox& box) {
  std::vector<bool> inside;
  inside.reserve(mesh.positions.size());
  for (const Mesh::Float3& p : mesh.positions) inside.push_back(box.contains({p.x, p.y, p.z}));
  Mesh kept = mesh;
  std::erase_if(kept.triangles, [&](const Mesh::Triangle& t) { return !inside[t.a] || !inside[t.b] || !inside[t.c]; });
  drop_unused_vertices(&kept);
  return kept;
}

}  // namespace plumbline::app
