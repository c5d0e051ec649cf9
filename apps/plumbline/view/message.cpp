#include "view/message.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <nlohmann/json.hpp>

#include "view/packed_mesh.h"

namespace plumbline::app {
namespace {

constexpr double kWellSeen = 40;  ///< frames from a metre away, face on: more change little
constexpr int kRegionBits = 2;    ///< a region is a cube of 4³ blocks

MapBlock region_of(const MapBlock& block) {
  return {block.x >> kRegionBits, block.y >> kRegionBits, block.z >> kRegionBits};
}

/// Around all that the region's blocks can hold, along the world's axes.
MeshGrid grid_of(const MapBlock& region, const BrickMirror& map) {
  const double side = map.block_size() * (1 << kRegionBits);
  const double radius = 0.5 * std::sqrt(3.0) * 1.1 * side;  // cells reach above their block
  const Eigen::Vector3d middle =
      side * (Eigen::Vector3d(region.x, region.y, region.z) + Eigen::Vector3d::Constant(0.5));
  return {map.world_from_map() * middle - Eigen::Vector3d::Constant(radius), 2 * radius / 65535};
}

void pad(std::string* bytes) { bytes->resize((bytes->size() + 3) / 4 * 4, ' '); }

}  // namespace

std::string encode_message(nlohmann::ordered_json json,
                           const std::vector<std::pair<std::string, std::string_view>>& buffers) {
  for (const auto& [name, bytes] : buffers) json["buffers"].push_back({name, bytes.size()});
  const std::string text = json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string message;
  for (int shift = 0; shift < 32; shift += 8) message += static_cast<char>(text.size() >> shift & 0xFF);
  message += text;
  for (const auto& [name, bytes] : buffers) {
    pad(&message);
    message += bytes;
  }
  return message;
}

nlohmann::ordered_json box_json(const std::optional<CropBox>& box) {
  if (!box) return nullptr;
  const Eigen::Vector3d middle = box->world_from_box.translation(), size = 2 * box->half;
  const Eigen::Quaterniond q = box->world_from_box.quaternion();
  return {{"middle", {middle.x(), middle.y(), middle.z()}},
          {"turn", {q.x(), q.y(), q.z(), q.w()}},
          {"size", {size.x(), size.y(), size.z()}}};
}

std::string surface_message(const MapBlock& block, const BrickMirror& map, double stamp, int epoch) {
  const MapBlock region = region_of(block);
  const BlockSurface surface = map.surface(block);
  const PackedMesh packed = pack_levels(surface.mesh, surface.seen, kWellSeen, grid_of(region, map));
  nlohmann::ordered_json json = {{"type", "surface"},
                                 {"epoch", epoch},
                                 {"stamp", stamp},
                                 {"block", {block.x, block.y, block.z}},
                                 {"region", {region.x, region.y, region.z}},
                                 {"vertices", packed.vertices},
                                 {"levels", packed.level_triangles},
                                 {"origin", {packed.origin.x(), packed.origin.y(), packed.origin.z()}},
                                 {"step", packed.step}};
  std::vector<std::pair<std::string, std::string_view>> buffers = {
      {"positions", packed.positions}, {"normals", packed.normals}, {"colors", packed.colors}, {"seen", packed.errors}};
  for (std::size_t i = 0; i < packed.level_indices.size(); ++i)
    buffers.emplace_back(fmt::format("indices{}", i), packed.level_indices[i]);
  return encode_message(std::move(json), buffers);
}

}  // namespace plumbline::app
