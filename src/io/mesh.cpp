#include "io/mesh.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <limits>

#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline {
namespace {

std::string lower_extension(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

struct Writer {
  const char* extension;
  void (*write)(const std::string& path, const Mesh& mesh);
};
constexpr Writer kWriters[] = {{".ply", write_ply}, {".obj", write_obj}, {".stl", write_stl}, {".glb", write_glb}};

[[noreturn]] void fail_unknown(const std::string& path, const char* known) {
  throw Error("the mesh format is not known by the file's ending", path,
              std::string("use a name that ends in ") + known);
}

const Writer& writer_of(const std::string& path) {
  const std::string extension = lower_extension(path);
  for (const Writer& writer : kWriters)
    if (extension == writer.extension) return writer;
  fail_unknown(path, ".ply, .obj, .stl or .glb");
}

}  // namespace

void check_mesh(const Mesh& mesh, const std::string& path) {
  const std::size_t n = mesh.positions.size();
  const std::string advice = "give one for each vertex, or none";
  if (!mesh.normals.empty() && mesh.normals.size() != n)
    throw Error("the mesh's normals are not as many as its vertices", path, advice);
  if (!mesh.colors.empty() && mesh.colors.size() != n)
    throw Error("the mesh's colours are not as many as its vertices", path, advice);
  if (n > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
    throw Error("the mesh has more vertices than the format can number", path, "write it in parts");
  for (const Mesh::Triangle& t : mesh.triangles)
    if (t.a >= n || t.b >= n || t.c >= n)
      throw Error("a triangle names a vertex that the mesh does not have", path, "check the mesh's indices");
}

void check_mesh_format(const std::string& path) { writer_of(path); }

void write_mesh(const std::string& path, const Mesh& mesh) { writer_of(path).write(path, mesh); }

Mesh read_mesh(const std::string& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".ply") return read_ply(path);
  if (extension == ".obj") return read_obj(path);
  fail_unknown(path, ".ply or .obj");
}

}  // namespace plumbline
