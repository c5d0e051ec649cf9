// What a page that lags is sent, and what not.
#include "view/board.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>

#include "view/message.h"

namespace plumbline::app {
namespace {

/// The JSON at the beginning of a message.
nlohmann::json json_of(const std::string& message) {
  std::uint32_t length = 0;
  std::memcpy(&length, message.data(), sizeof length);
  return nlohmann::json::parse(message.substr(4, length));
}

std::string note(const char* text) { return encode_message({{"type", text}}); }

std::vector<std::string> types(const std::vector<Message>& messages) {
  std::vector<std::string> names;
  for (const Message& message : messages) names.push_back(json_of(*message)["type"]);
  return names;
}

TEST(Message, HoldsBuffersAtMultiplesOfFour) {
  const std::string message = encode_message({{"type", "x"}}, {{"a", "12345"}, {"b", ""}, {"c", "67"}});
  const nlohmann::json json = json_of(message);
  EXPECT_EQ(json["buffers"].dump(), R"([["a",5],["b",0],["c",2]])");
  std::uint32_t length = 0;
  std::memcpy(&length, message.data(), sizeof length);
  const std::size_t first = (4 + length + 3) / 4 * 4;
  EXPECT_EQ(message.substr(first, 5), "12345");
  EXPECT_EQ(message.substr(first + 8), "67");
}

TEST(Board, BeginsWithTheSceneAndEndsWithTheState) {
  Board board;
  board.set_scene({{"title", "desk"}});
  board.add_path({{1, 2, 3}}, 0);
  board.set_picture("depth", note("picture"));
  board.set_surface({0, 0, 0}, note("surface"), 0);
  board.set_state({{"phase", "running"}});
  Board::Cursor cursor;
  const auto messages = board.next(&cursor);
  EXPECT_EQ(types(messages), (std::vector<std::string>{"scene", "surface", "picture", "state"}));
  EXPECT_EQ(json_of(*messages.front())["buffers"].dump(), R"([["path",12]])");
  EXPECT_EQ(json_of(*messages.back())["number"], 1);
  EXPECT_TRUE(board.next(&cursor).empty()) << "nothing is new";
}

TEST(Board, LeavesOutWhatWasReplaced) {
  Board board;
  Board::Cursor slow;
  board.set_scene({{"title", "desk"}});
  board.next(&slow);
  for (int i = 0; i < 100; ++i) {
    board.set_surface({i % 3, 0, 0}, note("surface"), 0);
    board.set_picture("depth", note("picture"));
    board.set_state({{"frames", i}});
  }
  const auto messages = board.next(&slow);
  EXPECT_EQ(types(messages), (std::vector<std::string>{"surface", "surface", "surface", "picture", "state"}));
  EXPECT_EQ(json_of(*messages.back())["frames"], 99);
}

TEST(Board, SendsALotInParts) {
  Board board;
  Board::Cursor cursor;
  const std::string big = encode_message({{"type", "surface"}}, {{"positions", std::string(60'000, 'x')}});
  for (int i = 0; i < 8; ++i) board.set_surface({i, 0, 0}, big, 0);
  std::size_t parts = 0, surfaces = 0;
  for (auto messages = board.next(&cursor); !messages.empty(); messages = board.next(&cursor), ++parts)
    surfaces += messages.size() - 1;  // one is the state
  EXPECT_EQ(surfaces, 8U);
  EXPECT_EQ(parts, 3U);
}

TEST(Board, ForgetsAnEarlierMap) {
  Board board;
  board.set_surface({0, 0, 0}, note("surface"), 0);
  board.clear_map(1);
  board.set_surface({1, 0, 0}, note("surface"), 0);  // of the earlier one, late
  board.add_path({{1, 2, 3}}, 0);
  Board::Cursor cursor;
  const auto messages = board.next(&cursor);
  EXPECT_EQ(types(messages), (std::vector<std::string>{"scene", "state"}));
  EXPECT_EQ(json_of(*messages.front())["epoch"], 1);
  EXPECT_EQ(json_of(*messages.front())["buffers"].dump(), R"([["path",0]])");
}

TEST(Board, TellsItsListener) {
  Board board;
  int told = 0;
  board.set_listener([&] { ++told; });
  board.set_state({{"frames", 1}});
  board.set_surface({0, 0, 0}, note("surface"), 0);
  EXPECT_EQ(told, 1) << "the next state takes it along";
  while (!board.announce_surfaces()) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(told, 2) << "no state has followed";
  EXPECT_TRUE(board.announce_surfaces());
}

}  // namespace
}  // namespace plumbline::app
