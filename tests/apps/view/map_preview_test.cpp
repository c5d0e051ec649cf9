// What changes of the map become: surfaces on the board, by a thread that the board does not wait for.
#include "view/map_preview.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>
#include <vector>

namespace plumbline::app {
namespace {

using namespace std::chrono_literals;

/// A floor through the middle of a brick.
std::unique_ptr<MapChange> floor_in_brick(int x, int weight, double stamp, int epoch = 0) {
  auto change = std::make_unique<MapChange>();
  change->epoch = epoch;
  change->stamp = stamp;
  change->update.voxel_size = 0.01;
  change->update.truncation = 0.05;
  change->update.bricks = {{8 * x, 0, 0}};
  for (int i = 0; i < Map::kBrickVoxels; ++i) {
    const double distance = ((i >> 6) - 3.5) * 0.01 / 0.05;
    const auto low = static_cast<std::uint16_t>(static_cast<std::int16_t>(32767 * distance));
    change->update.voxels.push_back(static_cast<std::int32_t>(static_cast<std::uint32_t>(weight) << 16 | low));
  }
  return change;
}

/// The surfaces that a page gets until it has so many.
std::vector<nlohmann::json> surfaces(const Board& board, Board::Cursor* cursor, std::size_t count) {
  std::vector<nlohmann::json> list;
  for (const auto end = std::chrono::steady_clock::now() + 20s; std::chrono::steady_clock::now() < end;) {
    for (const Message& message : board.next(cursor)) {
      std::uint32_t length = 0;
      std::memcpy(&length, message->data(), sizeof length);
      nlohmann::json json = nlohmann::json::parse(message->substr(4, length));
      if (json["type"] == "surface" && !json["levels"].empty()) list.push_back(std::move(json));
    }
    if (list.size() >= count) break;
    std::this_thread::sleep_for(2ms);
  }
  return list;
}

TEST(MapPreview, MeshesWhatIsNewAndThenWhatIsSeenAgain) {
  Board board;
  Board::Cursor cursor;
  MapPreview preview(&board, [](const std::string& why) { ADD_FAILURE() << why; });
  preview.hand(floor_in_brick(0, 2, 1000));
  const auto first = surfaces(board, &cursor, 1);
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0]["stamp"], 1000);
  EXPECT_EQ(first[0]["levels"][0], 98);  // 7² cells
  preview.hand(floor_in_brick(0, 3, 2000));
  const auto again = surfaces(board, &cursor, 1);
  ASSERT_EQ(again.size(), 1U);
  EXPECT_EQ(again[0]["stamp"], 0) << "nothing new";
  preview.hand(floor_in_brick(1, 2, 3000));
  const auto wider = surfaces(board, &cursor, 1);
  ASSERT_EQ(wider.size(), 1U);
  EXPECT_EQ(wider[0]["stamp"], 3000);
  EXPECT_EQ(wider[0]["levels"][0], 210);  // 15 × 7 cells
}

TEST(MapPreview, LeavesOutWhatFewFramesSaw) {
  Board board;
  Board::Cursor cursor;
  MapPreview preview(&board, [](const std::string& why) { ADD_FAILURE() << why; });
  preview.hand(floor_in_brick(0, 1, 1000));
  preview.hand(floor_in_brick(20, 2, 2000));
  const auto list = surfaces(board, &cursor, 1);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["block"][0], 5);
}

TEST(MapPreview, BeginsAnewWithAnotherMap) {
  Board board;
  Board::Cursor cursor;
  MapPreview preview(&board, [](const std::string& why) { ADD_FAILURE() << why; });
  preview.hand(floor_in_brick(0, 2, 1000));
  ASSERT_EQ(surfaces(board, &cursor, 1).size(), 1U);
  board.clear_map(1);
  preview.hand(floor_in_brick(1, 2, 2000, 1));
  const auto list = surfaces(board, &cursor, 1);
  ASSERT_EQ(list.size(), 1U);
  EXPECT_EQ(list[0]["levels"][0], 98) << "the other brick is of the earlier map";
}

struct Numbers {
  std::vector<int> list;
  void follow(Numbers&& older) { list.insert(list.begin(), older.list.begin(), older.list.end()); }
};

TEST(Mailbox, LosesNothingAndWaitsForNobody) {
  Mailbox<Numbers> mailbox;
  EXPECT_EQ(mailbox.take(), nullptr);
  constexpr int kCount = 20'000;
  std::thread writer([&] {
    for (int i = 0; i < kCount; ++i) mailbox.put(std::make_unique<Numbers>(Numbers{{i}}));
  });
  std::vector<int> read;
  while (static_cast<int>(read.size()) < kCount) {
    const unsigned rung = mailbox.rung();
    if (const auto numbers = mailbox.take())
      read.insert(read.end(), numbers->list.begin(), numbers->list.end());
    else
      mailbox.wait(rung);
  }
  writer.join();
  for (int i = 0; i < kCount; ++i) ASSERT_EQ(read[static_cast<std::size_t>(i)], i);
}

}  // namespace
}  // namespace plumbline::app
