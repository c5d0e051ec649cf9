#include "view/message.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "view/packed_mesh.h"

namespace plumbline::app {
namespace {

constexpr double kWellSeen = 60;  ///< frames: two seconds of looking at it; more change little

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

std::string surface_message(const MapBlock& block, const BlockSurface& surface, int epoch) {
  const PackedMesh packed = pack_mesh(surface.mesh, surface.weights, kWellSeen);
  nlohmann::ordered_json json = {{"type", "surface"},
                                 {"epoch", epoch},
                                 {"block", {block.x, block.y, block.z}},
                                 {"vertices", packed.vertices},
                                 {"triangles", packed.triangles},
                                 {"origin", {packed.origin.x(), packed.origin.y(), packed.origin.z()}},
                                 {"step", packed.step}};
  return encode_message(std::move(json), {{"positions", packed.positions},
                                          {"normals", packed.normals},
                                          {"colors", packed.colors},
                                          {"seen", packed.errors},
                                          {"indices", packed.indices}});
}

}  // namespace plumbline::app
