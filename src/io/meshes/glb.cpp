// glTF 2.0 in one binary file (Khronos Group, "glTF 2.0 Specification", 2021), as browsers and viewers open it.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/atomic_file.h"
#include "io/mesh.h"
#include "plumbline/error.h"
#include "plumbline/mesh.h"

namespace plumbline {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little, "the writer copies values as they lie in memory");

// Names of the specification, §5.
constexpr std::uint32_t kMagic = 0x46546C67, kVersion = 2, kJsonChunk = 0x4E4F534A, kBinaryChunk = 0x004E4942;
constexpr int kFloat = 5126, kUnsignedInt = 5125, kUnsignedShort = 5123, kVertices = 34962, kIndices = 34963;

using Rgba16 = std::array<std::uint16_t, 4>;

/// Colours of images are sRGB, those of glTF's vertices are linear (IEC 61966-2-1); 16 bits keep what is dark apart.
std::array<std::uint16_t, 256> linear_table() {
  std::array<std::uint16_t, 256> table{};
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double c = static_cast<double>(i) / 255;
    const double linear = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
    table[i] = static_cast<std::uint16_t>(std::lround(65535 * linear));
  }
  return table;
}

std::vector<Rgba16> linear_colors(const Mesh& mesh) {
  const std::array<std::uint16_t, 256> table = linear_table();
  std::vector<Rgba16> colors;
  colors.reserve(mesh.colors.size());
  for (const Mesh::Rgb& c : mesh.colors) colors.push_back({table[c.r], table[c.g], table[c.b], 65535});
  return colors;
}

/// The parts of the binary chunk, and what the JSON says of them.
class Buffer {
 public:
  /// Returns the accessor's number. The parts are not copied; their sizes are multiples of four.
  template <class T>
  int add(const std::vector<T>& values, std::size_t count, int component, const char* type, int target) {
    const std::size_t bytes = values.size() * sizeof(T);
    views_.push_back({{"buffer", 0}, {"byteOffset", bytes_}, {"byteLength", bytes}, {"target", target}});
    accessors_.push_back(
        {{"bufferView", views_.size() - 1}, {"componentType", component}, {"count", count}, {"type", type}});
    parts_.emplace_back(reinterpret_cast<const char*>(values.data()), bytes);
    bytes_ += bytes;
    return static_cast<int>(accessors_.size()) - 1;
  }
  Json& accessor(int number) { return accessors_[static_cast<std::size_t>(number)]; }

  std::size_t bytes() const { return bytes_; }
  const std::vector<std::string_view>& parts() const { return parts_; }
  void describe(Json* json) const {
    (*json)["buffers"] = Json::array({{{"byteLength", bytes_}}});
    (*json)["bufferViews"] = views_;
    (*json)["accessors"] = accessors_;
  }

 private:
  std::vector<std::string_view> parts_;
  std::size_t bytes_ = 0;
  Json views_ = Json::array(), accessors_ = Json::array();
};

/// Which the specification wants of positions.
void add_bounds(const Mesh& mesh, Json* accessor) {
  Mesh::Float3 low = mesh.positions.front(), high = low;
  for (const Mesh::Float3& p : mesh.positions) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  (*accessor)["min"] = {low.x, low.y, low.z};
  (*accessor)["max"] = {high.x, high.y, high.z};
}

Json scene_of(const Json& primitive, const Buffer& buffer) {
  Json json;
  json["asset"] = {{"version", "2.0"}, {"generator", "plumbline"}};
  json["scene"] = 0;
  json["scenes"] = Json::array({{{"nodes", {0}}}});
  // The world is that of the first camera, y down and z forward; glTF has y up and z towards the viewer.
  json["nodes"] = Json::array({{{"mesh", 0}, {"rotation", {1, 0, 0, 0}}}});
  json["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
  json["materials"] =
      Json::array({{{"pbrMetallicRoughness", {{"metallicFactor", 0}, {"roughnessFactor", 1}}}, {"doubleSided", true}}});
  buffer.describe(&json);
  return json;
}

void write_words(AtomicFile* file, const std::vector<std::uint32_t>& words) {
  file->write(words.data(), words.size() * sizeof(std::uint32_t));
}

void write_file_of(const std::string& path, std::string json, const Buffer& buffer) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  const std::size_t total = 12 + 8 + json.size() + 8 + buffer.bytes();
  if (total > std::numeric_limits<std::uint32_t>::max())
    throw Error("the mesh is larger than the format's 4 GB", path, "write it as .ply, or simplify it");
  const auto word = [](std::size_t value) { return static_cast<std::uint32_t>(value); };
  AtomicFile file(path);
  write_words(&file, {kMagic, kVersion, word(total), word(json.size()), kJsonChunk});
  file.write(json);
  write_words(&file, {word(buffer.bytes()), kBinaryChunk});
  for (const std::string_view part : buffer.parts()) file.write(part);
  file.commit();
}

}  // namespace

void write_glb(const std::string& path, const Mesh& mesh) {
  check_mesh(mesh, path);
  if (mesh.triangles.empty())
    throw Error("the mesh has no triangles, which the format needs", path, "write it as .ply");
  const std::vector<Rgba16> colors = linear_colors(mesh);
  const std::size_t vertices = mesh.positions.size();
  Buffer buffer;
  Json attributes;
  const int positions = buffer.add(mesh.positions, vertices, kFloat, "VEC3", kVertices);
  add_bounds(mesh, &buffer.accessor(positions));
  attributes["POSITION"] = positions;
  if (!mesh.normals.empty()) attributes["NORMAL"] = buffer.add(mesh.normals, vertices, kFloat, "VEC3", kVertices);
  if (!colors.empty()) {
    const int accessor = buffer.add(colors, vertices, kUnsignedShort, "VEC4", kVertices);
    buffer.accessor(accessor)["normalized"] = true;
    attributes["COLOR_0"] = accessor;
  }
  const int indices = buffer.add(mesh.triangles, 3 * mesh.triangles.size(), kUnsignedInt, "SCALAR", kIndices);
  const Json primitive = {{"attributes", attributes}, {"indices", indices}, {"material", 0}};
  write_file_of(path, scene_of(primitive, buffer).dump(), buffer);
}

}  // namespace plumbline
