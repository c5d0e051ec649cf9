#include "view/board.h"

#include <algorithm>
#include <utility>

#include "view/message.h"

namespace plumbline::app {
namespace {

constexpr std::size_t kMaxSurfaceBytes = 150'000;    ///< an update: a page is to show 15 of them a second
constexpr std::chrono::milliseconds kFrameSoon{60};  ///< after a state, the next one may be expected
constexpr std::size_t kMaxPath = 20'000;             ///< positions

}  // namespace

void Board::set_scene(Json scene) {
  const std::lock_guard lock(mutex_);
  scene_ = std::move(scene);
  scene_version_ = ++version_;
  listener_();
}

void Board::set_state(const Json& members) {
  const std::lock_guard lock(mutex_);
  state_.update(members);
  state_version_ = ++version_;
  state_time_ = std::chrono::steady_clock::now();
  listener_();
}

void Board::add_path(const std::vector<std::array<float, 3>>& positions, int epoch) {
  const std::lock_guard lock(mutex_);
  if (epoch != epoch_) return;
  for (const auto& position : positions) {
    if (++path_skipped_ < path_step_) continue;
    path_skipped_ = 0;
    path_.push_back(position);
    if (path_.size() < kMaxPath) continue;
    for (std::size_t i = 0; 2 * i < path_.size(); ++i) path_[i] = path_[2 * i];
    path_.resize((path_.size() + 1) / 2);
    path_step_ *= 2;
  }
}

void Board::set_picture(const std::string& kind, std::string message) {
  const std::lock_guard lock(mutex_);
  pictures_[kind] = {++version_, std::make_shared<const std::string>(std::move(message))};
}

void Board::set_surface(const MapBlock& block, std::string message, int epoch) {
  const std::lock_guard lock(mutex_);
  if (epoch != epoch_) return;
  std::uint64_t& version = surface_versions_[block];
  surfaces_.erase(version);
  version = ++version_;
  surfaces_[version] = std::make_shared<const std::string>(std::move(message));
}

bool Board::announce_surfaces() {
  const std::lock_guard lock(mutex_);
  if (surfaces_.empty() || state_version_ > surfaces_.rbegin()->first) return true;
  if (std::chrono::steady_clock::now() - state_time_ < kFrameSoon) return false;
  listener_();
  return true;
}

void Board::clear_map(int epoch) {
  const std::lock_guard lock(mutex_);
  epoch_ = epoch;
  scene_version_ = ++version_;
  path_.clear();
  path_step_ = 1;
  surfaces_.clear();
  surface_versions_.clear();
  pictures_.erase("good");
  listener_();
}

bool Board::has_news(const Cursor& cursor) const {
  return cursor.scene < scene_version_ || cursor.state < state_version_ ||
         (!surfaces_.empty() && surfaces_.rbegin()->first > cursor.surfaces) ||
         std::any_of(pictures_.begin(), pictures_.end(),
                     [&](const auto& entry) { return entry.second.version > cursor.pictures; });
}

Message Board::hello() const {
  Json json = {{"type", "scene"}, {"epoch", epoch_}};
  json.update(scene_);
  std::vector<float> path;
  for (const auto& position : path_) path.insert(path.end(), position.begin(), position.end());
  return std::make_shared<const std::string>(encode_message(
      std::move(json), {{"path", {reinterpret_cast<const char*>(path.data()), path.size() * sizeof(float)}}}));
}

void Board::add_surfaces(Cursor* cursor, std::vector<Message>* messages) const {
  std::size_t bytes = 0;
  for (auto surface = surfaces_.upper_bound(cursor->surfaces); surface != surfaces_.end() && bytes < kMaxSurfaceBytes;
       ++surface) {
    messages->push_back(surface->second);
    bytes += surface->second->size();
    cursor->surfaces = surface->first;
  }
}

void Board::add_pictures(Cursor* cursor, std::vector<Message>* messages) const {
  std::uint64_t newest = cursor->pictures;
  for (const auto& [kind, entry] : pictures_) {
    if (entry.version <= cursor->pictures) continue;
    messages->push_back(entry.message);
    newest = std::max(newest, entry.version);
  }
  cursor->pictures = newest;
}

std::vector<Message> Board::next(Cursor* cursor) const {
  std::vector<Message> messages;
  const std::lock_guard lock(mutex_);
  if (!has_news(*cursor)) return messages;
  if (cursor->scene < scene_version_) {
    messages.push_back(hello());
    cursor->scene = scene_version_;
    cursor->surfaces = 0;
  }
  add_surfaces(cursor, &messages);
  add_pictures(cursor, &messages);
  cursor->state = state_version_;
  Json state = {{"type", "state"}, {"epoch", epoch_}, {"number", ++cursor->number}};
  state.update(state_);
  messages.push_back(std::make_shared<const std::string>(encode_message(std::move(state))));
  return messages;
}

}  // namespace plumbline::app
