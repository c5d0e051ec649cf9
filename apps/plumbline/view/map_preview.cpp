#include "view/map_preview.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "view/message.h"
#include "view/priority.h"

namespace plumbline::app {
namespace {

constexpr std::size_t kMaxBricks = 65536;          ///< 256 MiB
constexpr std::chrono::milliseconds kSettle{350};  ///< what was known is meshed again after so long
constexpr std::chrono::milliseconds kPoll{5};

}  // namespace

void MapPreview::Changes::follow(Changes&& older) {
  std::move(list.begin(), list.end(), std::back_inserter(older.list));
  list = std::move(older.list);
}

MapPreview::MapPreview(Board* board, std::function<void(const std::string&)> fail)
    : board_(*board), fail_(std::move(fail)), mirror_(kMaxBricks), thread_([this] { work(); }) {}

MapPreview::~MapPreview() { stop(); }

void MapPreview::stop() {
  stopping_ = true;
  mailbox_.ring();
  if (thread_.joinable()) thread_.join();
}

void MapPreview::hand(std::unique_ptr<MapChange> change) {
  ++waiting_;
  auto changes = std::make_unique<Changes>();
  changes->list.push_back(std::move(change));
  mailbox_.put(std::move(changes));
}

void MapPreview::work() {
  run_when_idle();
  try {
    while (!stopping_) work_once();
  } catch (const std::exception& error) {
    fail_(error.what());
  }
}

void MapPreview::work_once() {
  const unsigned rung = mailbox_.rung();
  if (const std::unique_ptr<Changes> changes = mailbox_.take()) {
    for (const std::unique_ptr<MapChange>& change : changes->list) apply(*change);
    return;
  }
  if (mesh_one()) return;
  if (has_unannounced_) has_unannounced_ = !board_.announce_surfaces();
  if (dirty_.empty() && !has_unannounced_)
    mailbox_.wait(rung);
  else
    std::this_thread::sleep_for(kPoll);  // until a block is due, or the surfaces have gone out
}

void MapPreview::apply(const MapChange& change) {
  if (epoch_ != change.epoch) {
    epoch_ = change.epoch;
    mirror_.clear();
    dirty_.clear();
  }
  const Clock::time_point now = Clock::now();
  for (const auto& [block, is_new] : mirror_.update(change.update, change.views)) {
    Dirty& dirty = dirty_.try_emplace(block, Dirty{now + kSettle}).first->second;
    if (!is_new || dirty.stamp != 0) continue;
    dirty.stamp = change.stamp;
    dirty.due = now;
  }
  is_full_ = mirror_.is_full();
  --waiting_;
}

/// Of the blocks that are due, the one that has been so for longest. False if there is none.
bool MapPreview::mesh_one() {
  const auto next = std::min_element(dirty_.begin(), dirty_.end(),
                                     [](const auto& a, const auto& b) { return a.second.due < b.second.due; });
  if (next == dirty_.end() || next->second.due > Clock::now()) return false;
  const auto [block, dirty] = *next;
  dirty_.erase(next);
  board_.set_surface(block, surface_message(block, mirror_, dirty.stamp, epoch_), epoch_);
  has_unannounced_ = true;
  return true;
}

}  // namespace plumbline::app
