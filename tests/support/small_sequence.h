// A small TUM folder of the analytic desk, made once per test program, and copies of it to spoil.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "plumbline/pinhole.h"
#include "support/temp_folder.h"

namespace plumbline::test {

constexpr int kSmallFrames = 10;
constexpr Pinhole kSmallCamera{131.0f, 131.0f, 79.5f, 59.5f, 160, 120};

/// Options that suit the small sequence: a coarse volume that holds the desk.
std::vector<std::string> small_run(const std::string& sequence, const std::string& output,
                                   const std::vector<std::string>& more = {});

/// An empty folder for each test, removed after it, with a fresh copy of the sequence in it.
class SmallSequence : public testing::Test {
 protected:
  SmallSequence();

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string sequence() const { return path("desk"); }
  std::string output() const { return path("out"); }
  /// Depth images of the sequence, in order.
  std::vector<std::string> depth_images() const;
  /// A first, good run into output(); gives the bytes of its files to compare with.
  std::string good_mesh() const;

  TempFolder temp_;
  std::filesystem::path folder_ = temp_.path();
};

}  // namespace plumbline::test
