#include "graph/consistent_set.h"

#include <algorithm>
#include <numeric>

namespace plumbline {
namespace {

using Adjacency = std::vector<std::vector<char>>;

/// A set about `start`: whoever agrees with all so far, in the given order.
std::vector<std::size_t> grow(const Adjacency& agree, const std::vector<std::size_t>& order, std::size_t start) {
  std::vector<std::size_t> set = {start};
  for (const std::size_t candidate : order) {
    if (candidate == start) continue;
    if (std::all_of(set.begin(), set.end(), [&](std::size_t member) { return agree[candidate][member] != 0; }))
      set.push_back(candidate);
  }
  return set;
}

}  // namespace

std::vector<std::size_t> consistent_set(std::size_t count,
                                        const std::function<bool(std::size_t a, std::size_t b)>& are_consistent) {
  Adjacency agree(count, std::vector<char>(count, 0));
  std::vector<std::size_t> partners(count, 0);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < a; ++b)
      if (are_consistent(a, b)) {
        agree[a][b] = agree[b][a] = 1;
        ++partners[a];
        ++partners[b];
      }
  std::vector<std::size_t> order(count);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return partners[a] > partners[b]; });
  std::vector<std::size_t> best;
  for (const std::size_t start : order) {
    if (partners[start] + 1 <= best.size()) break;  // it, and those after it, cannot have a larger one
    std::vector<std::size_t> set = grow(agree, order, start);
    if (set.size() > best.size()) best = std::move(set);
  }
  std::sort(best.begin(), best.end());
  return best;
}

}  // namespace plumbline
