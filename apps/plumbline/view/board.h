// The newest state of a run, from which each page takes what it lacks.
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "map/brick_mirror.h"

namespace plumbline::app {

using Message = std::shared_ptr<const std::string>;

/// Holds one of everything, however many pages watch and however slow they are: a page that lags leaves out what has
/// been replaced meanwhile. All calls from any thread; the frame loop makes none of them.
class Board {
 public:
  using Json = nlohmann::ordered_json;

  /// How far one page is.
  struct Cursor {
    std::uint64_t scene = 0, surfaces = 0, pictures = 0, state = 0;
    std::uint64_t number = 0;  ///< of the latest update that was taken
  };

  /// Of the run as a whole; sent to a page first.
  void set_scene(Json scene);
  /// Members that replace those of the state with the same names.
  void set_state(const Json& members);
  /// What comes of an earlier map is ignored, here and below.
  void add_path(const std::vector<std::array<float, 3>>& positions, int epoch);
  /// Goes out with the next state.
  void set_picture(const std::string& kind, std::string message);
  /// Goes out with the next state, or see below.
  void set_surface(const MapBlock& block, std::string message, int epoch);
  /// Tells pages of surfaces that no state has followed. False while one may be expected soon, which is to take them
  /// along, so that a page draws once.
  bool announce_surfaces();
  /// A new map, by its number: path and surface are gone, and pages drop theirs.
  void clear_map(int epoch);

  /// Called, from any thread, when there is something new; it must return at once and call nothing of this. To be set
  /// before anything else is.
  void set_listener(std::function<void()> listener) { listener_ = std::move(listener); }
  /// What a page lacks: surfaces up to about 150 kB at a time, and then the state under the cursor's new number.
  std::vector<Message> next(Cursor* cursor) const;

 private:
  struct Entry {
    std::uint64_t version = 0;
    Message message;
  };
  bool has_news(const Cursor& cursor) const;
  void add_surfaces(Cursor* cursor, std::vector<Message>* messages) const;
  void add_pictures(Cursor* cursor, std::vector<Message>* messages) const;
  Message hello() const;

  mutable std::mutex mutex_;
  std::function<void()> listener_ = [] {};
  Json scene_ = Json::object(), state_ = Json::object();
  int epoch_ = 0;
  std::uint64_t version_ = 0, scene_version_ = 0, state_version_ = 0;
  std::chrono::steady_clock::time_point state_time_;
  std::vector<std::array<float, 3>> path_;
  int path_step_ = 1, path_skipped_ = 0;
  std::map<std::string, Entry> pictures_;
  std::map<MapBlock, std::uint64_t> surface_versions_;
  std::map<std::uint64_t, Message> surfaces_;  ///< by version, so that what changed first is sent first
};

}  // namespace plumbline::app
