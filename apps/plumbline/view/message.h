// What a page is sent: one binary message is a JSON object and the buffers that it names.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "map/brick_mirror.h"
#include "view/crop_box.h"

namespace plumbline::app {

/// 4 bytes, little-endian: length of the JSON; the JSON, whose `buffers` gives name and length of each buffer, in their
/// order; the buffers, each from the next multiple of 4 bytes on.
std::string encode_message(nlohmann::ordered_json json,
                           const std::vector<std::pair<std::string, std::string_view>>& buffers = {});

/// Middle, turn (quaternion x y z w) and sides, metres; null for none.
nlohmann::ordered_json box_json(const std::optional<CropBox>& box);

/// A block's surface, which replaces what the page has of that block. Blocks of a region have the same origin and step,
/// so that a page draws them as one. `stamp`: see MapChange, 0 if nothing is new; `epoch`: of the map, see `Board`.
std::string surface_message(const MapBlock& block, const BrickMirror& map, double stamp, int epoch);

}  // namespace plumbline::app
