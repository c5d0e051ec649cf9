// Binary STL (3D Systems, "StereoLithography Interface Specification", 1989): triangles alone, for printing and CAD.
#include <Eigen/Geometry>
#include <array>
#include <bit>
#include <cstring>
#include <limits>

#include "io/atomic_file.h"
#include "io/mesh.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline {
namespace {

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

constexpr std::size_t kHeader = 80, kBytes = 50;  // of a triangle: normal, three corners, two bytes without meaning

Mesh::Float3 normal_of(const Mesh::Float3& a, const Mesh::Float3& b, const Mesh::Float3& c) {
  const Eigen::Vector3f origin(a.x, a.y, a.z);
  const Eigen::Vector3f n =
      (Eigen::Vector3f(b.x, b.y, b.z) - origin).cross(Eigen::Vector3f(c.x, c.y, c.z) - origin).normalized();
  return {n.x(), n.y(), n.z()};
}

}  // namespace

void write_stl(const std::string& path, const Mesh& mesh) {
  check_mesh(mesh, path);
  if (mesh.triangles.size() > std::numeric_limits<std::uint32_t>::max())
    throw Error("the mesh has more triangles than the format can count", path, "write it as .ply");
  AtomicFile file(path);
  std::array<char, kHeader> header{};
  std::memcpy(header.data(), "binary STL, metres", 18);
  file.write(header.data(), kHeader);
  const auto count = static_cast<std::uint32_t>(mesh.triangles.size());
  file.write(&count, sizeof count);
  for (const Mesh::Triangle& t : mesh.triangles) {
    const Mesh::Float3 &a = mesh.positions[t.a], &b = mesh.positions[t.b], &c = mesh.positions[t.c];
    const std::array<Mesh::Float3, 4> values = {normal_of(a, b, c), a, b, c};
    std::array<char, kBytes> bytes{};
    std::memcpy(bytes.data(), values.data(), sizeof values);
    file.write(bytes.data(), kBytes);
  }
  file.commit();
}

}  // namespace plumbline
