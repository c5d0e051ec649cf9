// The TOML files that `plumbline calibrate` leaves, read with errors that name the line.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "io/text_file.h"
#include "plumbline/error.h"

namespace plumbline {

class CalibrationFile {
 public:
  static constexpr const char* kAdvice = "Let `plumbline calibrate` write it anew.";

  explicit CalibrationFile(const std::string& path) : path_(path) {
    try {
      root_ = toml::parse(read_file(path), path);
    } catch (const toml::parse_error& error) {
      throw Error(std::string(error.description()), fmt::format("{}:{}", path, error.source().begin.line), kAdvice);
    }
  }

  /// `count` numbers of at most `largest`.
  std::vector<double> numbers(const char* key, std::size_t count, double largest) const {
    const toml::node* node = find(key);
    const toml::array* array = node->as_array();
    std::vector<double> values;
    if (array != nullptr)
      for (const toml::node& item : *array) values.push_back(item.value<double>().value_or(kNone));
    else
      values.push_back(node->value<double>().value_or(kNone));
    const bool good = values.size() == count && std::all_of(values.begin(), values.end(), [&](double v) {
                        return std::abs(v) <= largest;  // false for NaN
                      });
    if (!good) fail(*node, fmt::format("{} is not {}", key, count == 1 ? "a number in range" : "a list of numbers"));
    return values;
  }

  template <class E>
  E choice(const char* key) const {
    const toml::node* node = find(key);
    const auto known = names(E{});
    const auto found = std::find(known.begin(), known.end(), node->value_or(std::string_view()));
    if (found == known.end()) fail(*node, fmt::format("{} has no such value", key));
    return static_cast<E>(found - known.begin());
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

  const toml::node* find(const char* key) const {
    const toml::node* node = root_.at_path(key).node();
    if (node == nullptr) throw Error(fmt::format("there is no {}", key), path_, kAdvice);
    return node;
  }
  [[noreturn]] void fail(const toml::node& node, const std::string& what) const {
    throw Error(what, fmt::format("{}:{}", path_, node.source().begin.line), kAdvice);
  }

  std::string path_;
  toml::table root_;
};

}  // namespace plumbline
